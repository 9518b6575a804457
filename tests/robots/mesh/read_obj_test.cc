#include <gtest/gtest.h>

#include "tests/support/mesh_texts.h"

namespace leeway::robots {
namespace {

using Eigen::Vector3d;
using mesh_texts::Corners;
using mesh_texts::cornersOf;
using mesh_texts::expectRefused;
using mesh_texts::readAs;

TEST(ReadObj, VerticesInAllTheirForms) {
  const MeshContents contents = readAs(
      readObj,
      "# v 9 9 9\nv 0.1 -2e-3 +3 # a comment\n\tv  1 2\t3 1\nv 1 2 3 1.0\nv 1 2 3 0.5 0.5 0.5\n"
      "v 1 2 3 1 0 0 1\nvn 0 0 1\nvt 0 0\nvp 0.5\nv \\\n 7 \\\n8 9\nf 1 2 3\n");
  const FileMesh& mesh = contents.meshes.at(0);
  ASSERT_EQ(mesh.vertices.size(), 6U);
  EXPECT_EQ(mesh.vertices[0], Vector3d(0.1, -2e-3, 3));
  for (const std::size_t i : {1U, 2U, 3U, 4U}) EXPECT_EQ(mesh.vertices[i], Vector3d(1, 2, 3)) << i;
  EXPECT_EQ(mesh.vertices[5], Vector3d(7, 8, 9));
  EXPECT_EQ(mesh.faces.at(0).place.text(), ":13");
}

TEST(ReadObj, FacesInAllTheirForms) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  for (const char* face :
       {"f 1 2 3 4", "f 1/1 2/2 3/3 4/4", "f 1//1 2//1 3//1 4//1", "f 1/1/1 2/2/1 3/3/1 4/4/1",
        "f -4 -3 -2 -1", "f -4//-1 2 3/ -1", "  f\t1 2 \\\n 3 \\\r\n 4", "fo 1 2 3 4  # old"}) {
    const MeshContents contents = readAs(readObj, square + face + "\n");
    ASSERT_EQ(contents.meshes[0].faces.size(), 1U) << face;
    EXPECT_EQ(cornersOf(contents.meshes[0], 0), (Corners{0, 1, 2, 3})) << face;
  }
  // Faces may come first, and lines may end in other ways.
  EXPECT_EQ(readAs(readObj,
                   "f 1 2 3\r"
                   "v 0 0 0\r"
                   "v 1 0 0\r"
                   "v 0 1 0")
                .meshes[0]
                .faces.size(),
            1U);
  // Regression: what stood behind a lone carriage return was part of a comment or a name.
  const MeshContents mixed =
      readAs(readObj, "# by hand\rv 9 9 9\r\n" + square + "g two\rf 2 3 4\r\rf 2 3 4 5\n# end\n");
  ASSERT_EQ(mixed.meshes[0].faces.size(), 2U);
  EXPECT_EQ(cornersOf(mixed.meshes[0], 1), (Corners{1, 2, 3, 4}));
  EXPECT_EQ(mixed.meshes[0].faces[1].place.text(), ":10");
  // Negative numbers count from the last vertex so far.
  const MeshContents contents =
      readAs(readObj, square + "f -4 -3 -2\nv 5 5 5\nf -5 -3 -1\nf 1 2 5\n");
  EXPECT_EQ(cornersOf(contents.meshes[0], 0), (Corners{0, 1, 2}));
  EXPECT_EQ(cornersOf(contents.meshes[0], 1), (Corners{0, 2, 4}));
}

TEST(ReadObj, WhatIsLeftOut) {
  const MeshContents contents = readAs(
      readObj,
      "mtllib C:\\models\\\nv 0 0 0\n# a path: C:\\models\\\nv 1 0 0\nv 0 1 0\no a\ng b\\\ns 1\n"
      "usemtl x\nl 1 2 3\np 1\np 2\ncurv 0 1 1 2\nwhatever 1 2\nf 1 2 3\n");
  EXPECT_EQ(contents.meshes[0].vertices.size(), 3U);
  EXPECT_EQ(contents.meshes[0].faces.size(), 1U);
  EXPECT_EQ(contents.not_solid.lines, 1);
  EXPECT_EQ(contents.not_solid.points, 2);
  EXPECT_EQ(contents.not_solid.curves, 1);
  EXPECT_EQ(contents.not_solid.first.text(), ":10");
}

TEST(ReadObj, DamagedFiles) {
  const auto refused = [](const mesh_texts::Damaged& damaged) { expectRefused(readObj, damaged); };
  refused({"v 0 0 0\nv 1 0 0\nv 0 1 0\nF 1 2 3\n", ":4", {"'F' begins the line; f would be"}});
  const MeshContents odd = readAs(readObj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nff 1 2 3\nx\n");
  ASSERT_EQ(odd.notes.size(), 1U);
  EXPECT_NE(odd.notes[0].text.find("'ff' is no statement of the format"), std::string::npos);
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  refused({"v 0 0 0\nv 1 0\n", ":2", {"ends where a coordinate is expected"}});
  refused({"v 0 0 0\nv", ":2", {"ends where a coordinate is expected"}});
  refused({"v 0 0 x\n", ":1", {"'x' stands where a coordinate is expected"}});
  refused({"v 0 0 1.5.5\n", ":1", {"'1.5.5'"}});
  refused({"v 0 0 inf\n", ":1", {"'inf' is not finite"}});
  // A weight is of rational curves, and divides coordinates in some programs only.
  for (const char* weight : {"0", "2", "-1", "nan"})
    refused({std::string("v 0 0 0 ") + weight + "\n", ":1", {"weight", "1 would be accepted"}});
  refused({triangle + "f 1 2 3\ncall other.obj\n", ":5", {"'call' brings in what is not in"}});
  refused({triangle + "f 1 2 3\ncsh -cat other.obj\n", ":5", {"'csh' brings in"}});
  refused({"v 0 0 0 1 2\n", ":1", {"a vertex of 5 numbers", "W or colours"}});
  refused({"v 0 0 0 1 2 red\n", ":1", {"'red' stands where a number is expected"}});
  refused({triangle + "f 1 2\n", ":4", {"a face of 2 corners", "at least three"}});
  refused({triangle + "f", ":4", {"a face of 0 corners"}});
  refused({triangle + "f 1 2 4\n", ":4", {"vertex 4; 1 to 3"}});
  refused({triangle + "f 1 2 -4\n", ":4", {"vertex -4 of the 3 so far; -1 to -3"}});
  refused({triangle + "f 1 2 0\n", ":4", {"'0' stands where a corner is expected"}});
  refused({triangle + "f 1 2 3x\n", ":4", {"'3x'"}});
  refused({triangle + "f 1 2 3/x\n", ":4", {"'3/x'"}});
  refused({triangle + "f 1 2 3.5\n", ":4", {"'3.5'"}});
  refused({triangle + "f 1 2 99999999999\n", ":4", {"'99999999999'"}});
  for (const char* const surface : {"surf 0 1 0 1 1 2 3", "bzp 1 2 3", "bsp 1 2 3", "cdp 1 2 3"})
    refused({triangle + surface + "\n", ":4", {"free-form surface"}});
}

/// `f 1 2 34` that was cut is `f 1 2 3`.
TEST(ReadObj, ALastLineWithoutItsEndIsTold) {
  const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3";
  for (const char* end : {"", " ", "\nvn 0 0 1", "\ng"}) {
    const MeshContents contents = readAs(readObj, text + end);
    ASSERT_EQ(contents.notes.size(), 1U) << end;
    EXPECT_EQ(contents.notes[0].place.text(), *end == '\n' ? ":5" : ":4") << end;
    EXPECT_EQ(contents.notes[0].text.find("the last line does not end; if the file was cut"), 0U);
  }
  for (const char* end : {"\n", "\r\n", " \n", "\n\n  ", "\n# a comment", " # a comment"})
    EXPECT_TRUE(readAs(readObj, text + end).notes.empty()) << end;
}

}  // namespace
}  // namespace leeway::robots
