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
#include <vector>

#include "gelight/io/image.hpp"
#include "gelight/sensor/presets.hpp"

// Programs in documents, compiled and run by the documents' own lines.
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

// A document without its blocks of code.
std::string prose(std::string text) {
  for (std::size_t at = text.find("```"); at != std::string::npos; at = text.find("```", at)) {
    text.erase(at, text.find("```", at + 3) + 3 - at);
  }
  return text;
}

// A line that compiles a source, but with the compiled library in place of all of gelight anew,
// where there is one; it takes a fraction of the time.
std::string by_library(std::string line, const std::string& source) {
#ifdef GELIGHT_LIBRARY
  const std::string file = " " + source + " ";
  line.replace(line.find(file), file.size(),
               file + "-O1 -DGELIGHT_COMPILED '" GELIGHT_LIBRARY "' ");
#else
  static_cast<void>(source);
#endif
  return line;
}

// Compiles and runs a document's program that holds some words, by the line that names its source
// (in the README to the letter), in a folder; what it prints.
std::string run(const std::filesystem::path& document, const std::filesystem::path& folder,
                const std::string& source, const std::string& words = "int main()") {
  const std::string text = text_of(top / document);
  const std::string program = block(text, "cpp", words);
  const std::string line = block(text, "sh", " " + source + " ");
  REQUIRE(!program.empty());
  REQUIRE(line.rfind("g++ ", 0) == 0);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::filesystem::create_directory_symlink(top / "include", folder / "include");
  std::ofstream(folder / source) << program;
  std::ofstream(folder / "line.sh") << "set -e\ncd '" << folder.string() << "'\n"
                                    << (document == "README.md" ? line : by_library(line, source));
  const std::string said = (folder / "said").string();
  const std::string command = "sh '" + (folder / "line.sh").string() + "' > '" + said + "'";
  REQUIRE(std::system(command.c_str()) == 0);
  return text_of(said);
}

}  // namespace

TEST_CASE("the README's program, compiled and run as it says, makes the picture beside it") {
  const auto folder = std::filesystem::temp_directory_path() / "gelight_readme";
  CHECK(run("README.md", folder, "tactile.cpp").find(" ms a frame") != std::string::npos);

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
  CHECK(coloured > image.pixels().size() / 4);
  CHECK(worst <= 1);

  std::filesystem::remove_all(folder);
}

TEST_CASE("the renderer that its text tells to take for another light") {
  CHECK(text_of(top / "README.md")
            .find("`gelight::tactile_renderer(tip, gelight::gel_light(tip))`") !=
        std::string::npos);
  const auto tip = gelight::geltip(32, 24, 0.004f);
  const auto sensor = gelight::tactile_renderer(tip, gelight::gel_light(tip));
  CHECK(sensor.rest_image() != gelight::tactile_renderer(tip).rest_image());
}

TEST_CASE("what the documents link to is there") {
  std::vector<std::filesystem::path> documents;
  for (const char* folder : {".", "benchmarks/results", "examples", "include", "tests"}) {
    for (const auto& entry : std::filesystem::directory_iterator(top / folder)) {
      if (entry.path().extension() == ".md") documents.push_back(entry.path());
    }
  }
  REQUIRE(documents.size() > 8);
  int links = 0;
  for (const auto& document : documents) {
    const std::string text = prose(text_of(document));
    for (std::size_t at = text.find("]("); at != std::string::npos; at = text.find("](", at + 1)) {
      const std::string link = text.substr(at + 2, text.find_first_of(")#", at) - at - 2);
      if (link.empty() || link.find("://") != std::string::npos) continue;
      CAPTURE(document.string());
      CAPTURE(link);
      CHECK(std::filesystem::exists(document.parent_path() / link));
      ++links;
    }
  }
  CHECK(links > 50);
}

TEST_CASE("the simulator's loop, compiled and run as its page says") {
  const auto folder = std::filesystem::temp_directory_path() / "gelight_simulator";
  const std::string said = run("examples/simulator.md", folder, "simulator.cpp");
  CHECK(said.find("finger 1: ") != std::string::npos);

  // The call that its text tells to put before the rendering.
  const std::string text = text_of(top / "examples/simulator.md");
  const std::size_t at = text.find("`drape_into(") + 1;
  REQUIRE(at > 1);
  std::string program = block(text, "cpp", "int main()");
  program.insert(program.find("    sensor.render_next_into("),
                 "    auto& depth = finger.depth;\n"
                 "    const auto rest = rasterize(tip.membrane, tip.camera).depth;\n"
                 "    const float pixel = 1e-4f;\n    " +
                     text.substr(at, text.find('`', at) - at) + ";\n");
  std::ofstream(folder / "draped.cpp") << program;
  std::string line = block(text, "sh", "g++ ");
  line =
      line.substr(0, line.find(" simulator.cpp")) + " -fsyntax-only -DGELIGHT_COMPILED draped.cpp";
  CHECK(std::system(("cd '" + folder.string() + "' && " + line).c_str()) == 0);
  std::filesystem::remove_all(folder);
}

TEST_CASE(
    "a contact by its force, compiled and run as the simulator's page says, says what stands "
    "there") {
  const auto folder = std::filesystem::temp_directory_path() / "gelight_dragged";
  std::string said = run("examples/simulator.md", folder, "dragged.cpp", "dragged.png");
  REQUIRE(!said.empty());
  said.pop_back();  // the line's end
  CAPTURE(said);
  CHECK(text_of(top / "examples/simulator.md").find("It says `" + said + "`") != std::string::npos);
  const auto image = gelight::read_png((folder / "dragged.png").string());
  CHECK(image.width() == 320);
  CHECK(image.height() == 240);
  std::filesystem::remove_all(folder);
}

TEST_CASE("a membrane that one can see through, compiled and run as the simulator's page says") {
  const auto folder = std::filesystem::temp_directory_path() / "gelight_seen";
  const std::string said = run("examples/simulator.md", folder, "seen.cpp", "seen.png");
  CHECK(said.empty());
  // Beside the contact, of light that the ball beyond reflects: nothing, all of it, a half.
  const auto rim = [&](const char* name) {
    const auto image = gelight::read_png((folder / name).string());
    REQUIRE(image.width() == 480);
    return image(350, 180);
  };
  CHECK(rim("seen.png") == gelight::Rgb8{220, 140, 40});
  const auto felt = rim("felt.png"), both = rim("both.png");
  for (std::size_t c = 0; c < 3; ++c) {
    const int mean = (rim("seen.png")[c] + felt[c]) / 2;
    CHECK(std::abs(both[c] - mean) <= 1);
  }
  std::filesystem::remove_all(folder);
}

#endif
