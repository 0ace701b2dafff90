#include "gelight/io/presses.hpp"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "support/refusal.hpp"

using namespace gelight;
using gelight::test::contains;
using gelight::test::refusal;

namespace {

const std::string header =
    "image,center_x_px,center_y_px,contact_radius_px,ball_radius_mm,mm_per_px\n";

// A folder with two photographs, which is gone at the end.
class Folder {
 public:
  Folder() {
    std::filesystem::create_directories(path_);
    Image<Rgb8> image(7, 5, {40, 50, 60});
    write_png(path_ + "/background.png", image);
    image(2, 1) = {1, 2, 3};
    write_png(path_ + "/one.png", image);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  void table(const std::string& text) const {
    std::ofstream(path_ + "/presses.csv", std::ios::binary) << text;
  }
  [[nodiscard]] PressFolder read() const { return read_presses(path_); }
  [[nodiscard]] std::string said(const std::string& text) const {
    table(text);
    return refusal([&] { (void)read(); });
  }

 private:
  std::string path_ = (std::filesystem::temp_directory_path() / "gelight_presses_test").string();
};

}  // namespace

TEST_CASE("presses are read by the names of their columns, whatever the order") {
  const Folder folder;
  for (const std::string& text :
       {header + "one.png,3,2,2.5,4,0.5\n\none.png,,,,4,0.5\n",
        "\xef\xbb\xbf" + header + " one.png , 3, 2 ,2.5,4,0.5\r\none.png,,,,4,0.5\r\n  \n",
        std::string(
            "mm_per_px,note,ball_radius_mm,image,contact_radius_px,center_y_px,center_x_px\n"
            "0.5,,4,one.png,2.5,2,3\n0.5,a guess,4,one.png,,,\n")}) {
    CAPTURE(text);
    folder.table(text);
    const PressFolder all = folder.read();
    CHECK(all.background(2, 1) == Rgb8{40, 50, 60});
    REQUIRE(all.presses.size() == 2);
    for (const BallPress& press : all.presses) {
      CHECK(press.name == "one.png");
      CHECK(press.photograph(2, 1) == Rgb8{1, 2, 3});
      CHECK(press.ball_radius == 8);
    }
    CHECK(all.presses[0].contact.x == 3);
    CHECK(all.presses[0].contact.y == 2);
    CHECK(all.presses[0].contact.radius == 2.5);
    CHECK(all.presses[1].contact.x == 0);
    CHECK(all.presses[1].contact.y == 0);
    CHECK(all.presses[1].contact.radius == 0);
  }
}

TEST_CASE("what is wrong with a table of presses is named with its line") {
  const Folder folder;
  CHECK(contains(refusal([&] { (void)folder.read(); }), "presses.csv cannot be opened"));
  CHECK(contains(folder.said(""), "line 1 has no column image"));
  CHECK(contains(folder.said("one.png,3,2,2.5,4,0.5\n"), "line 1 has no column image"));
  CHECK(contains(folder.said("image,center_x_px,center_y_px,contact_radius_px,mm_per_px\n"
                             "one.png,3,2,2.5,0.5\n"),
                 "line 1 has no column ball_radius_mm"));
  CHECK(contains(folder.said(header + "one.png,3,2,2.5,4,0.5\none.png,3,2,2.5,4\n"),
                 "line 3 has 5 values, not 6"));
  CHECK(contains(folder.said(header + "one.png,3,2,2.5,4,0.5,\n"), "line 2 has 7 values, not 6"));
  CHECK(contains(folder.said(header + "one.png,3,x,2.5,4,0.5\n"),
                 "line 2 has x for center_y_px, where a number is wanted"));
  CHECK(contains(folder.said(header + "one.png,3,nan,2.5,4,0.5\n"), "line 2 has nan"));
  CHECK(contains(folder.said(header + "one.png,1e999,3,2.5,4,0.5\n"), "line 2 has 1e999"));
  CHECK(contains(folder.said(header + "one.png,3 4,2,2.5,4,0.5\n"), "line 2 has 3 4"));
  // Half of a circle is not taken for the rest of it to be 0.
  CHECK(contains(folder.said(header + "one.png,,,2.5,4,0.5\n"), "line 2 has no center_x_px"));
  CHECK(contains(folder.said(header + "one.png,3,2,,4,0.5\n"), "line 2 has no contact_radius_px"));
  CHECK(contains(folder.said(header + "one.png,3,2,0,4,0.5\n"),
                 "line 2 has contact_radius_px 0, which is not positive"));
  CHECK(contains(folder.said(header + "one.png,3,2,-2.5,4,0.5\n"), "contact_radius_px -2.5"));
  CHECK(contains(folder.said(header + "one.png,3,2,2.5,,0.5\n"), "line 2 has no ball_radius_mm"));
  CHECK(contains(folder.said(header + "one.png,3,2,2.5,0,0.5\n"),
                 "line 2 has ball_radius_mm 0, which is not positive"));
  CHECK(contains(folder.said(header + "one.png,3,2,2.5,4,0\n"),
                 "line 2 has mm_per_px 0, which is not positive"));
  CHECK(contains(folder.said(header + "one.png,3,2,2.5,4e300,1e-300\n"),
                 "mm_per_px 1e-300: a ball of inf pixels"));
  CHECK(contains(folder.said(header + "one.png,3,2,2.5,1e-300,1e300\n"), "a ball of 0 pixels"));
  CHECK(contains(folder.said(header + ",3,2,2.5,4,0.5\n"), "line 2 names no image"));
  CHECK(contains(folder.said(header + "two.png,3,2,2.5,4,0.5\n"), "two.png"));
}

TEST_CASE("a table of which no press is read is refused, also where lines end as nowhere else") {
  const Folder folder;
  CHECK(contains(folder.said(header), "presses.csv has no line of a press"));
  CHECK(contains(folder.said(header + " \n\n"), "presses.csv has no line of a press"));
  std::string names = header;
  names.back() = ',';
  CHECK(contains(folder.said(names + "note\rone.png,3,2,2.5,4,0.5,a\r"),
                 "presses.csv has no line of a press"));
}
