#include "../examples/support/mesh_file.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <locale>
#include <sstream>
#include <streambuf>
#include <string>
#include <vector>

#include "gelight/core/types.hpp"
#include "gelight/views/mesh_view.hpp"
#include "support/refusal.hpp"

using gelight::Index;
using gelight::Mesh;
using gelight::test::contains;
using gelight::test::refusal;

namespace {

const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.5\n";
const std::string mark = "\xef\xbb\xbf";
const std::string ply =
    "ply\nformat ascii 1.0\ncomment of binary_little_endian\nobj_info none\nelement vertex 3\n"
    "property float x\nproperty float y\nproperty float z\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n0.5 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const std::string off = "OFF\n3 1 0\n0.5 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const std::string stl =
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0.5 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    "endloop\nendfacet\nendsolid a\n";

Mesh<double> read(const std::string& kind, const std::string& text) {
  const auto path = std::filesystem::temp_directory_path() / ("gelight_mesh_file_test." + kind);
  std::ofstream(path, std::ios::binary) << text;
  return mesh_of_file(path);
}

std::string said(const std::string& kind, const std::string& text) {
  return refusal([&] { (void)read(kind, text); });
}

/// A valid text in which one part is another.
std::string with(std::string text, const std::string& part, const std::string& other) {
  return text.replace(text.find(part), part.size(), other);
}

/// While it lives, 1.5 is written 1,5 and 1000 is 1.000 in the whole program.
class CommaLocale {
 public:
  CommaLocale() = default;
  ~CommaLocale() { std::locale::global(before_); }
  CommaLocale(const CommaLocale&) = delete;
  CommaLocale& operator=(const CommaLocale&) = delete;

 private:
  struct Comma : std::numpunct<char> {
    [[nodiscard]] char do_decimal_point() const override { return ','; }
    [[nodiscard]] char do_thousands_sep() const override { return '.'; }
    [[nodiscard]] std::string do_grouping() const override { return "\3"; }
  };
  std::locale before_ = std::locale::global(std::locale(std::locale(), new Comma));
};

}  // namespace

TEST_CASE("a PLY file whose head OpenMesh would read for ever is refused with the line") {
  CHECK(read("ply", ply).faces.size() == 1);
  CHECK(read("ply", with(ply, "ply\n", "ply\r\n")).faces.size() == 1);
  CHECK(contains(said("ply", ply.substr(0, ply.find("end_header"))), "has no end_header"));
  CHECK(contains(said("ply", ""), "has no end_header"));
  for (const char* count : {"abc", "-3", "3.5", "+3", "3x"}) {
    CHECK(contains(said("ply", with(ply, "vertex 3", std::string("vertex ") + count)),
                   std::string("line 5: ") + count + " is not a whole number"));
  }
  CHECK(contains(said("ply", with(ply, "face 1", "face -1")), "line 9: -1 is not a whole number"));
  CHECK(contains(said("ply", with(ply, "vertex 3", "vertex " + std::string(50, '9'))),
                 "things are more than the file's"));
  for (const char* format : {"format ascii x", "format ascii 2.0", "format ascii", "format foo 1.0",
                             "format ascii 1.0 x", "comment ascii x"}) {
    CHECK(contains(said("ply", with(ply, "format ascii 1.0", format)),
                   std::string("line 2: \"") + format + "\" is none"));
  }
  for (const char* line : {"element vertex", "property float", "property list uchar int", "bogus",
                           "obj_info element x", "obj_info end_header", "end_header 1"}) {
    CHECK(contains(said("ply", with(ply, "obj_info none", line)),
                   std::string("line 4: \"") + line + "\" is none"));
  }
}

TEST_CASE(
    "a property of a PLY file before its elements, at which OpenMesh breaks down, is refused") {
  CHECK(contains(said("ply", with(ply, "obj_info none", "property float x")),
                 "line 4: a property of no element"));
}

TEST_CASE("a comment of a PLY file does not make it binary") {
  CHECK(contains(said("ply", with(ply, "1 0 0", "1 x 0")), "line 13: \"1 x 0\": not all are"));
}

TEST_CASE("heads of OFF that count what cannot be are refused with the line") {
  CHECK(read("off", off).faces.size() == 1);
  CHECK(contains(said("off", with(off, "3 1 0", "-3 1 0")), "line 2: -3 is not a whole number"));
  CHECK(contains(said("off", with(off, "OFF\n3", "OFF x")), "line 1: x is not a whole number"));
  const std::string many(50, '9'), told = "line 2: " + many;
  CHECK(contains(said("off", with(off, "3 1 0", many + " 1 0")), told + " things are more than"));
}

TEST_CASE("colours, normals and comments change no mesh of OFF, and no face is lost") {
  const std::string head = "4 2 0\n", square = "0.1 0 0\n1 0 0\n0 1 0\n1 1 0.5\n",
                    faces = "3 0 1 2\n3 1 3 2\n";
  const Mesh<double> plain = read("off", "OFF\n" + head + square + faces);
  CHECK(plain.positions[0][0] == 0.1);  // in double
  CHECK(plain.faces.size() == 2);
  const std::string colours = "3 0 1 2 255 0 0 255 # red\n3 1 3 2 0.5 0 0\n";
  const std::string normals = "0.1 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n1 1 0.5 0 0 1\n";
  for (const std::string& text :
       {"OFF\n" + head + square + colours, "NOFF " + head + normals + faces,
        "OFF # of\n\n" + head + square + "3 0 1 2 7\r\n3 1 3 2 #\n"}) {
    CAPTURE(text);
    const Mesh<double> mesh = read("off", text);
    CHECK(mesh.positions == plain.positions);
    CHECK(mesh.faces == plain.faces);
  }
}

TEST_CASE("OFF that is not what its head tells is refused") {
  CHECK(contains(said("off", off + "3 0 2 1\n"), "goes on after all that its head tells of"));
  CHECK(contains(said("off", with(off, "3 1 0", "3 2 0")), "ends before all that its head tells"));
  CHECK(contains(said("off", with(off, "OFF", "OFF BINARY")), "line 1: OFF of the binary kind"));
  for (const char* kind : {"4OFF", "C4OFF", "nOFF", "4nOFF"}) {
    CHECK(contains(said("off", with(off, "OFF", kind)), "line 1: OFF with other points than of"));
  }
  CHECK(contains(said("off", "OFF\n"), "ends before all that its head tells"));
  CHECK(contains(said("off", with(off, "3 1 0", "3")), "line 2: no numbers of vertices and faces"));
  CHECK(contains(said("off", with(off, "1 0 0", "1 0")), "line 4: a point of 2 numbers"));
  for (const char* face : {"3 0 1", "-1 0 1 2", "1e9 0 1 2", "2.5 0 1 2", "3.5 0 1 2 2"}) {
    CHECK(contains(said("off", with(off, "3 0 1 2", face)), "line 6: a face of "));
  }
  CHECK(contains(said("off", with(off, "3 0 1 2", "2 0 1")), "face 0 has 2 corners"));
  CHECK(contains(said("off", with(off, "3 0 1 2", "3 0 1 3")), "face 0 has vertex 3, of 3"));
  CHECK(contains(said("off", with(off, "3 0 1 2", "3 0 1 1")), "face 0 has vertex 1 twice"));
}

TEST_CASE("PLY is read whatever else its vertices and faces have, and of what types") {
  const Mesh<double> plain = read("ply", ply);
  const auto is_plain = [&](const std::string& text) {
    const Mesh<double> mesh = read("ply", text);
    return mesh.positions == plain.positions && mesh.faces == plain.faces;
  };
  for (const char* count : {"char", "int16", "ushort", "int", "uint32"}) {
    CHECK(is_plain(with(ply, "list uchar", std::string("list ") + count)));
  }
  const std::string list = "property list uchar int vertex_indices\n";
  CHECK(is_plain(with(with(ply, list, list + "property list uchar float texcoord\n"), "3 0 1 2",
                      "3 0 1 2 2 0.5 7")));
  CHECK(is_plain(with(with(ply, list, "property int flags\n" + list), "3 0 1 2", "9 3 0 1 2")));
  CHECK(contains(said("ply", with(ply, "float z", "float w")), "vertices without x, y and z"));
  CHECK(contains(said("ply", with(ply, "float z", "float y")), "vertices without x, y and z"));
  CHECK(contains(said("ply", with(ply, "float z", "long z")), "numbers of type long"));
  CHECK(contains(said("ply", with(ply, "3 0 1 2", "3 0 1")), "ends before all that its head"));
  CHECK(contains(said("ply", with(ply, "3 0 1 2", "3 0 1 -2")), "face 0 has vertex -2, of 3"));
  CHECK(contains(said("ply", with(ply, "3 0 1 2", "-3 0 1 2")), "a list of -3 numbers"));
  CHECK(contains(said("ply", with(with(ply, "list uchar", "list float"), "3 0 1 2", "2.5 0 1 2")),
                 "a list of 2.5 numbers"));
}

TEST_CASE("binary PLY is read in either order of bytes, whole numbers named s and u among them") {
  for (const bool is_big : {false, true}) {
    std::string text =
        with(with(ply, "ascii", is_big ? "binary_big_endian" : "binary_little_endian"), "float x",
             "uchar u\nproperty double x");
    text.resize(text.find("end_header\n") + 11);
    const auto add = [&](auto number) {
      std::array<char, sizeof number> bytes;
      std::memcpy(bytes.data(), &number, sizeof number);
      const bool is_native = is_big == (std::endian::native == std::endian::big);
      if (!is_native) std::reverse(bytes.begin(), bytes.end());
      text.append(bytes.data(), bytes.size());
    };
    for (const std::array<float, 2>& p : {std::array{0.5F, 0.0F}, {1.0F, 0.0F}, {0.0F, 1.0F}}) {
      add(std::uint8_t{200}), add(double{p[0]} + 1e-9), add(p[1]), add(0.0F);
    }
    add(std::uint8_t{3});
    for (const std::int32_t corner : {0, 1, 2}) add(corner);
    const Mesh<double> mesh = read("ply", text);
    REQUIRE(mesh.positions.size() == 3);
    CHECK(mesh.positions[0] == std::array{0.5 + 1e-9, 0.0, 0.0});
    CHECK(mesh.positions[2] == std::array{1e-9, 1.0, 0.0});
    CHECK(mesh.faces == read("ply", ply).faces);
    text.pop_back();
    CHECK(contains(said("ply", text), "ends before all that its head tells of"));
  }
}

TEST_CASE("a byte order mark changes no mesh: it is left out of OBJ and refused elsewhere") {
  const std::string text = points + "f 1 2 3\n";
  const Mesh<double> plain = read("obj", text), marked = read("obj", mark + text);
  CHECK(marked.positions == plain.positions);
  CHECK(marked.faces == plain.faces);
  CHECK(marked.positions.size() == 4);
  CHECK(contains(said("ply", mark + ply), "begins with a byte order mark"));
  CHECK(contains(said("off", mark + off), "begins with a byte order mark"));
  CHECK(contains(said("stl", mark + stl), "begins with a byte order mark"));
}

TEST_CASE("faces of OBJ of which another mesh would be made are refused with the line") {
  const auto refused = [](const std::string& face) {
    return said("obj", points + face + "\nf 2 4 3\n");
  };
  CHECK(contains(refused("f"), "line 5: the face has 0 corners"));
  CHECK(contains(refused("f 1"), "line 5: the face has 1 corners"));
  CHECK(contains(refused("f 1 2"), "line 5: the face has 2 corners"));
  CHECK(contains(refused("f 1 2 # 3"), "line 5: the face has 2 corners"));
  CHECK(contains(said("obj", points + "f 1 2 3\nf 2 4"), "line 6: the face has 2 corners"));
  for (const char* corner : {"1.9", "3x", "x", "0", "-0", "4294967297", "1/1/1/1", "1/x", "1//2x",
                             "1/99999999999", "1/99999999999/1", "\\"}) {
    CHECK(contains(refused(std::string("f 1 2 3 ") + corner),
                   std::string("line 5: the face has the corner \"") + corner));
  }
  CHECK(contains(refused("f 1 2 -3"), "line 5: the face has vertex 2 twice"));
}

TEST_CASE("corners of OBJ may tell more than their vertex, and comments may follow") {
  const Mesh<double> plain = read("obj", points + "f 1 2 3\nf 2 4 3\n");
  for (const char* face :
       {"f 1/ 2/ 3/", "f 1/9/9 2/9/9 3/9/9", "f 1//9 2//9 3//9", "f 1 2 3\r", "f -4 -3 -2",
        "f 1 2 3 # a", "f 1 2 3 #", "f 1 2 3 # 4 and 4", "mtllib invalid\n# 1 2\nf 1 2 3"}) {
    CAPTURE(face);
    const Mesh<double> mesh = read("obj", points + face + "\nf 2 4 3 # 1\n");
    CHECK(mesh.positions == plain.positions);
    CHECK(mesh.faces == plain.faces);
  }
}

TEST_CASE("what is read does not depend on the locale, which stays") {
  const std::string obj = with(points, "v 0", "v 0.5") + "f 1 2 3\nf 2 4 3\n";
  for (const auto& file : std::vector<std::array<std::string, 2>>{
           {"obj", obj}, {"off", off}, {"stl", stl}, {"ply", ply}}) {
    const std::string &kind = file[0], &text = file[1];
    CAPTURE(kind);
    const Mesh<double> mesh = read(kind, text);
    const CommaLocale comma;
    const std::locale set;
    const Mesh<double> again = read(kind, text);
    CHECK(again.positions == mesh.positions);
    CHECK(again.faces == mesh.faces);
    CHECK(std::locale() == set);
  }
}

TEST_CASE(
    "faces that OpenMesh would leave out or tear off are refused, and it says nothing itself") {
  const std::ostringstream words;
  std::streambuf* const before = std::cerr.rdbuf(words.rdbuf());
  const std::string lacking = said("obj", points + "f 1 2 3\nf 2 4 9\n");
  const std::string torn = said("obj", points + "v 1 1 1\nf 1 2 3\nf 2 4 3\nf 2 5 3\n");
  std::cerr.rdbuf(before);
  CHECK(contains(lacking, "would be left out"));
  CHECK(contains(torn, "would be torn off"));
  CHECK(words.str().empty());
}
