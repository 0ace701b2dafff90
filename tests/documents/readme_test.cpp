#if __has_include(<stb_image.h>)

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "gelight/io/image.hpp"

// The README's program, compiled and run by the README's own line.
namespace {

const std::filesystem::path top =
    std::filesystem::path(__FILE__).parent_path().parent_path().parent_path();

std::string text_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

// The first block of code in a language that holds some words.
std::string block(const std::string& text, const std::string& language, const std::string& words) {
  const std::string fence = "```" + language + "\n";
  for (std::size_t at = text.find(fence); at != std::string::npos; at = text.find(fence, at + 1)) {
    const std::size_t begin = at + fence.size(), end = text.find("```", begin);
    std::string code = text.substr(begin, end - begin);
    if (code.find(words) != std::string::npos) return code;
  }
  return {};
}

}  // namespace

TEST_CASE("the README's program, compiled and run as it says, makes the picture beside it") {
  const std::string readme = text_of(top / "README.md");
  const std::string program = block(readme, "cpp", "int main()");
  const std::string line = block(readme, "sh", "g++ ");
  REQUIRE(!program.empty());
  REQUIRE(line.rfind("g++ ", 0) == 0);

  const auto folder = std::filesystem::temp_directory_path() / "gelight_readme";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::filesystem::create_directory_symlink(top / "include", folder / "include");
  std::ofstream(folder / "tactile.cpp") << program;
  std::ofstream(folder / "line.sh") << "set -e\ncd '" << folder.string() << "'\n" << line;
  REQUIRE(std::system(
              ("sh '" + (folder / "line.sh").string() + "' > '" + (folder / "said").string() + "'")
                  .c_str()) == 0);
  CHECK(text_of(folder / "said").find(" ms a frame") != std::string::npos);

  const auto image = gelight::read_png((folder / "tactile.png").string());
  const auto shown = gelight::read_png((top / "examples/pictures/tactile.png").string());
  REQUIRE(image.width() == shown.width());
  REQUIRE(image.height() == shown.height());
  std::size_t lit = 0, coloured = 0;
  int worst = 0;
  for (std::size_t i = 0; i < image.pixels().size(); ++i) {
    const auto& p = image.pixels()[i];
    const auto [least, most] = std::minmax({p[0], p[1], p[2]});
    lit += most > 40 && least < 250 ? 1 : 0;
    coloured += most - least > 20 ? 1 : 0;
    for (std::size_t c = 0; c < 3; ++c) {
      worst = std::max(worst, std::abs(int{p[c]} - int{shown.pixels()[i][c]}));
    }
  }
  // Neither black nor white nor grey, and the picture that the README shows.
  CHECK(lit > image.pixels().size() * 9 / 10);
  CHECK(coloured > image.pixels().size() / 2);
  CHECK(worst <= 1);
  std::filesystem::remove_all(folder);
}

#endif
