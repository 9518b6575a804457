#include <gtest/gtest.h>

#include "tests/support/mesh_texts.h"

namespace leeway::robots {
namespace {

using Eigen::Vector3d;
using mesh_texts::Bytes;
using mesh_texts::Corners;
using mesh_texts::cornersOf;
using mesh_texts::expectRefused;
using mesh_texts::readAs;

/// A square, whose corners are (0, 0, 0.1), (1, 0, 0.1), (1, 1, 0.1), (0, 1, 0.1).
void expectSquare(const MeshContents& contents, double z = 0.1) {
  ASSERT_EQ(contents.meshes.size(), 1U);
  const FileMesh& mesh = contents.meshes[0];
  ASSERT_EQ(mesh.vertices.size(), 4U);
  EXPECT_EQ(mesh.vertices[2], Vector3d(1, 1, z));
  ASSERT_EQ(mesh.faces.size(), 1U);
  EXPECT_EQ(cornersOf(mesh, 0), (Corners{0, 1, 2, 3}));
}

const std::string kSquareHeader =
    "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty double x\nproperty float "
    "y\nproperty float64 z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
const std::string kSquare = "0 0 0.1\n1 0 .1\n1 1 +0.1\n0 1 1e-1\n";

TEST(ReadPly, Text) {
  const MeshContents contents = readAs(readPly, kSquareHeader + kSquare + "4 0 1 2 3\n");
  expectSquare(contents);
  EXPECT_EQ(contents.meshes[0].faces[0].place.text(), ":15");
  // Other line ends, empty lines, and no last one.
  std::string other = kSquareHeader + "\n" + kSquare + "\n\n4 0 1 2 3";
  for (std::size_t i = other.find('\n'); i != std::string::npos; i = other.find('\n', i + 2))
    other.replace(i, 1, "\r\n");
  expectSquare(readAs(readPly, other));
  for (std::size_t i = 0; (i = other.find("\r\n", i)) != std::string::npos; i += 3)
    other.replace(i, 2, "\r");  // every second or third
  expectSquare(readAs(readPly, other));
}

TEST(ReadPly, OrdersAndPropertiesOfAllKinds) {
  expectSquare(readAs(
      readPly,
      "ply\nformat ascii 1.0\nobj_info x\nelement edge 1\nproperty int vertex1\nproperty int "
      "vertex2\nelement face 1\nproperty list uchar float texcoord\nproperty list int uint "
      "vertex_index\nproperty uchar red\nelement vertex 4\nproperty list uchar int "
      "extra\nproperty float nx\nproperty double z\nproperty double y\nproperty double "
      "x\nproperty uchar red\nelement material 1\nproperty int n\nend_header\n0 1\n2 0.5 0.5 4 0 1 "
      "2 "
      "3 255\n0 nan 0.1 0 0 1\n1 7 0 0.1 0 1 1\n0 0 0.1 1 1 1\n0 0 0.1 1 0 1\n5\n"));
}

TEST(ReadPly, Binary) {
  for (const bool big : {false, true}) {
    Bytes bytes(big);
    bytes.add(std::string("ply\nformat binary_") + (big ? "big" : "little") +
              "_endian 1.0\nelement vertex 4\nproperty short flags\nproperty float x\nproperty "
              "double y\nproperty double z\nproperty list uchar ushort more\nelement face "
              "1\nproperty list ushort uint vertex_indices\nproperty char c\nend_header\n");
    const double corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (const auto& [x, y] : corner) {
      bytes.add(std::int16_t{-3}).add(static_cast<float>(x)).add(y).add(0.1);
      bytes.add(std::uint8_t{2}).add(std::uint16_t{1}).add(std::uint16_t{2});
    }
    bytes.add(std::uint16_t{4});
    for (const std::uint32_t v : {0U, 1U, 2U, 3U}) bytes.add(v);
    bytes.add(std::int8_t{-1});
    expectSquare(readAs(readPly, bytes.text()));
    expectSquare(readAs(readPly, bytes.text() + "\n"));
    const std::size_t size = bytes.text().size();
    expectRefused(readPly, {bytes.text().substr(0, size - 1),
                            ", byte " + std::to_string(size - 1),
                            {"the file ends here, after 0 of 1 rows of the element 'face'"}});
    expectRefused(readPly, {bytes.text().substr(0, size - 3),
                            ", byte " + std::to_string(size - 19),
                            {"a list of 4 entries does not fit into the file"}});
    expectRefused(readPly, {bytes.text() + "more",
                            ", byte " + std::to_string(size),
                            {"4 bytes follow the last element"}});
  }
}

TEST(ReadPly, Strips) {
  const MeshContents contents = readAs(
      readPly,
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty "
      "float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 "
      "0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 0 1 2 3 -1 2 3 4 -1\n");
  const FileMesh& mesh = contents.meshes[0];
  ASSERT_EQ(mesh.faces.size(), 3U);
  EXPECT_EQ(cornersOf(mesh, 1), (Corners{2, 1, 3}));
}

TEST(ReadPly, WhatHasNoAreaIsCounted) {
  const MeshContents contents = readAs(
      readPly,
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 4\nproperty list int int vertex_indices\nelement edge 3\nproperty int "
      "vertex1\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0 1\n1 0\n0\n0\n1\n2\n");
  EXPECT_EQ(contents.meshes[0].faces.size(), 1U);
  EXPECT_EQ(contents.not_solid.lines, 4);
  EXPECT_EQ(contents.not_solid.points, 2);
}

TEST(ReadPly, DamagedFiles) {
  const auto refused = [](const mesh_texts::Damaged& damaged) { expectRefused(readPly, damaged); };
  refused(
      {"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
       "float z\nelement faces 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 "
       "0\n0 1 0\n3 0 1 2\n",
       ":7",
       {"element 'faces' has vertex_indices; element face would be accepted"}});
  const auto replaced = [](std::string text, const std::string& a, const std::string& b) {
    return text.replace(text.find(a), a.size(), b);
  };
  const std::string whole = kSquareHeader + kSquare + "4 0 1 2 3\n";
  refused({kSquareHeader + kSquare,
           ":15",
           {"the file ends here, after 0 of 1 rows of the element 'face'"}});
  refused({whole + "3 0 1 2\n", ":16", {"'3' follows the last element"}});
  refused({replaced(whole, "1 0 .1\n", "1 0\n"), ":12", {"the line ends too early"}});
  refused({replaced(whole, "1 0 .1\n", "1 0 .1 7\n"), ":12", {"'7' cannot be used here"}});
  refused(
      {replaced(whole, "1 0 .1\n", "1 0 one\n"), ":12", {"'one' cannot be used here", "a number"}});
  refused({replaced(whole, "1 0 .1\n", "1 nan .1\n"), ":12", {"'nan'", "a finite coordinate"}});
  refused({replaced(whole, "4 0 1 2 3", "4 0 1 2"), ":15", {"the line ends too early"}});
  refused({replaced(whole, "4 0 1 2 3", "4 0 1 2 4"), ":15", {"vertex 4; 0 to 3"}});
  refused({replaced(whole, "4 0 1 2 3", "4 0 1 2 -1"), ":15", {"'-1'", "the number of a vertex"}});
  refused({replaced(whole, "4 0 1 2 3", "4 0 1 2 1.5"), ":15", {"'1.5'"}});
  refused({replaced(whole, "4 0 1 2 3", "-4 0 1 2 3"), ":15", {"'-4'"}});
  refused({replaced(whole, "ply", "poly"), ":1", {"begins with 'poly'; \"ply\""}});
  // Regression: of two formats the last counted, and two elements of vertices were one.
  refused({replaced(whole, "element face", "format ascii 1.0\nelement face"),
           ":8",
           {"format stands twice"}});
  refused({replaced(whole, "element face", "element vertex 0\nelement face"),
           ":8",
           {"element vertex stands twice"}});
  refused({replaced(whole, "format ascii 1.0", "format ascii"), ":2", {"a version"}});
  refused({replaced(whole, "element face 1", "element face 1 2"), ":8", {"'2'; the end of the"}});
  refused({replaced(whole, "ascii", "text"), ":2", {"'text'; ascii, binary_little_endian"}});
  refused({replaced(whole, "format ascii 1.0\n", ""), ":9", {"'end_header'; a format before it"}});
  refused({replaced(whole, "vertex 4", "vertex four"), ":4", {"'four'; the number of elements"}});
  refused({replaced(whole, "property double x", "property real x"), ":5", {"'real'; char, uchar"}});
  refused({replaced(whole, "property double x", "property double u"), ":4", {"no property 'x'"}});
  refused({replaced(whole, "property float y", "property float x"), ":4", {"two properties 'x'"}});
  refused({replaced(whole, "property float y", "property float x\nproperty float y"),
           ":4",
           {"two properties 'x'"}});
  refused({replaced(whole, "element face", "elemnt face"), ":8", {"'elemnt'; element would be"}});
  refused({replaced(whole, "vertex_indices", "corners"), ":8", {"no list of its vertices"}});
  refused({kSquareHeader.substr(0, kSquareHeader.find("property float64")),
           ":6",
           {"ends within its header"}});
  refused({replaced(whole, "vertex 4", "vertex 4000000000"), ":15", {"'2' cannot be used here"}});
}

}  // namespace
}  // namespace leeway::robots
