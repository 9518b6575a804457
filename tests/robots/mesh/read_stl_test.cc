#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tests/support/mesh_texts.h"

namespace leeway::robots {
namespace {

using Eigen::Vector3d;
using mesh_texts::binaryStl;
using mesh_texts::expectRefused;
using mesh_texts::readAs;

const std::string kFacet =
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1.5 0 0\nvertex 0 1e-3 +7\nendloop\n"
    "endfacet\n";

/// One triangle with these corners.
void expectTriangle(const MeshContents& contents) {
  ASSERT_EQ(contents.meshes.size(), 1U);
  const FileMesh& mesh = contents.meshes[0];
  ASSERT_EQ(mesh.faces.size(), 1U);
  ASSERT_EQ(mesh.cornersOf(mesh.faces[0]).size(), 3U);
  EXPECT_EQ(mesh.vertices.at(0), Vector3d(0, 0, 0));
  EXPECT_EQ(mesh.vertices.at(1), Vector3d(1.5, 0, 0));
  EXPECT_EQ(mesh.vertices.at(2), Vector3d(0, 1e-3, 7));
}

TEST(ReadStl, TextInAllItsForms) {
  expectTriangle(readAs(readStl, "solid a name facet\n" + kFacet + "endsolid a name facet\n"));
  expectTriangle(readAs(readStl, "\n\n \t solid\n" + kFacet + "endsolid"));
  expectTriangle(readAs(readStl, "\xEF\xBB\xBFsolid\n" + kFacet + "endsolid\n\n"));
  expectTriangle(
      readAs(readStl,
             "SOLID x\nFACET NORMAL nan nan -nan(ind)\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1.5 0 0\n"
             "VERTEX 0 1E-3 7\nENDLOOP\nENDFACET\nENDSOLID\n"));
  expectTriangle(readAs(readStl,
                        "solid x\r\nfacet\r\nouter loop vertex 0 0 0 vertex 1.5 0 0\r\nvertex 0 "
                        "1e-3 7\r\nend loop\r\nend facet\r\nend solid x\r\n"));
  expectTriangle(
      readAs(readStl,
             "solid x\rfacet\router loop\rvertex 0 0 0\rvertex 1.5 0 0\rvertex 0 1e-3 7\rendloop\r"
             "endfacet\rendsolid x\r"));
}

/// Regression: what stood behind a lone carriage return was part of a name.
TEST(ReadStl, LinesEndInSeveralWaysInOneFile) {
  std::string mac = "solid a\n" + kFacet + "endsolid a\n";
  std::replace(mac.begin(), mac.end(), '\n', '\r');
  const std::string unix = "solid b\n" + kFacet + "endsolid b\n";
  for (const std::string& text :
       {mac + unix, unix + mac, "solid\r\n" + kFacet + "endsolid\r" + mac}) {
    const FileMesh mesh = readAs(readStl, text).meshes.at(0);
    ASSERT_EQ(mesh.faces.size(), 2U);
    EXPECT_EQ(mesh.faces[1].place.text(), ":11");
  }
}

/// Regression: a solid on the line of another's end was part of its name.
TEST(ReadStl, FacetsOnTheLineOfANameAreRefused) {
  std::string line = kFacet;
  std::replace(line.begin(), line.end(), '\n', ' ');
  const std::string accepted = "'vertex'; a new line after the name of a solid would be accepted";
  expectRefused(
      readStl,
      {"solid a\n" + kFacet + "endsolid a solid b " + line + "endsolid b\n", ":9", {accepted}});
  expectRefused(readStl, {"solid a " + line + "\n" + kFacet + "endsolid a\n", ":1", {accepted}});
}

TEST(ReadStl, NamesMayHoldWordsOfTheFormat) {
  for (const char* name : {"vertex", "exported from 3 vertex groups", "Vertex Tools 2.1 facet"})
    EXPECT_EQ(
        readAs(readStl, "solid " + std::string(name) + "\n" + kFacet + "endsolid " + name + "\n")
            .meshes[0]
            .faces.size(),
        1U)
        << name;
}

TEST(ReadStl, SeveralSolidsAndPolygons) {
  const MeshContents contents = readAs(
      readStl, "solid a\n" + kFacet + kFacet + "endsolid a\n\nsolid b\nendsolid b\nsolid c\n" +
                   "facet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\n"
                   "endloop\nendfacet\nendsolid\n");
  const FileMesh& mesh = contents.meshes.at(0);
  ASSERT_EQ(mesh.faces.size(), 3U);
  EXPECT_EQ(mesh.faces[2].count, 4);
  EXPECT_EQ(mesh.faces[0].place.text(), ":2");
  EXPECT_EQ(mesh.faces[2].place.text(), ":21");
}

TEST(ReadStl, BinaryIsWidened) {
  const MeshContents contents =
      readAs(readStl, binaryStl({{0, 0, 0, 0.1F, 0, 0, 0, 16777217.0F, 1e-30F}}, 1));
  const FileMesh& mesh = contents.meshes.at(0);
  ASSERT_EQ(mesh.faces.size(), 1U);
  EXPECT_EQ(mesh.vertices[1], Vector3d(static_cast<double>(0.1F), 0, 0));
  EXPECT_EQ(mesh.vertices[2], Vector3d(0, 16777216, static_cast<double>(1e-30F)));
  EXPECT_TRUE(contents.notes.empty());
}

TEST(ReadStl, BinaryThatBeginsAsText) {
  const std::vector<float> triangle = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  EXPECT_EQ(
      readAs(readStl, binaryStl({triangle}, 1, "solid by a CAD program")).meshes[0].faces.size(),
      1U);
  // Padded with spaces, and with bytes after it.
  EXPECT_EQ(readAs(readStl, binaryStl({triangle}, 1, "solid" + std::string(75, ' ')) + "tail")
                .meshes[0]
                .faces.size(),
            1U);
}

TEST(ReadStl, BytesAfterTheTrianglesAreTold) {
  const std::vector<float> triangle = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  for (const std::size_t size : {1U, 17U, 50U, 64U, 1000U})
    for (const char fill : {'x', '\0', '\1'}) {
      const MeshContents contents =
          readAs(readStl, binaryStl({triangle, triangle}, 2) + std::string(size, fill));
      EXPECT_EQ(contents.meshes[0].faces.size(), 2U);
      ASSERT_EQ(contents.notes.size(), 1U);
      EXPECT_EQ(contents.notes[0].place.text(), ", byte 184");
      EXPECT_EQ(contents.notes[0].text,
                std::to_string(size) + " bytes after the last triangle are not read");
    }
}

TEST(ReadStl, DamagedFiles) {
  const auto refused = [](const mesh_texts::Damaged& damaged) { expectRefused(readStl, damaged); };
  // Whole facets follow, with any normal and size, beside numbers of any kind: the count is wrong.
  const std::vector<float> one = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  for (const float x : {1e-17F, 3.7e-33F, 900.0F, std::numeric_limits<float>::quiet_NaN()}) {
    const std::vector<float> more = {0, 0, 0, x, 0, 0, 0, 1, 0};
    std::string wrong = binaryStl({one, one, one, more}, 2);
    wrong.replace(84 + 2 * 50, 50, 50, 'x');  // the first is none
    wrong[84 + 3 * 50 + 3] = '\x42';          // a normal of 32
    refused({wrong, ", byte 80", {"the count is 2, but more triangles follow"}});
  }
  refused({"solid s\n" + kFacet + '\0' + kFacet + "endsolid\n",
           ", byte " + std::to_string(8 + kFacet.size()),
           {"a byte of value 0 stands in a text file"}});
  const std::string begin = "solid s\n" + kFacet;
  // Truncated anywhere except after the last word.
  const std::string whole = begin + kFacet + "endsolid s";
  const std::size_t last = whole.size() - std::string("endsolid s").size();
  for (std::size_t size = 1; size < last + 7; ++size) {
    if (size < 5) continue;  // "soli" is no STL at all
    static const Stop never;
    const Folder folder;
    const std::string file = folder.write("cut.stl", whole.substr(0, size));
    EXPECT_THROW(readStl(MeshSource(file, "r", 1, never)), InputError) << size;
  }
  refused({begin, ":9", {"the file ends here, within a solid", "endsolid would be accepted"}});
  refused(
      {"solid s\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n", ":6", {"the file ends here"}});
  refused({"solid s\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\nendsolid\n",
           ":6",
           {"a facet of 2 vertices", "at least three"}});
  refused({"solid s\nfacet\nouter loop\nvertex 0 0\nvertex 1 0 0\n",
           ":5",
           {"'vertex' stands where a coordinate is expected"}});
  refused({"solid s\nfacet\nouter loop\nvertex 0 0 1,5\n", ":4", {"'1,5'", "a finite number"}});
  refused({"solid s\nfacet\nouter loop\nvertex 0 0 nan\n", ":4", {"'nan' is not finite"}});
  refused({"solid s\nfacet\nouter loop\nvertex 0 0 1e999\n", ":4", {"'1e999' is not finite"}});
  refused({"solid s\nfacet\nouter loop\nvertex 0 0 1e61\n", ":4", {"'1e61' is too large"}});
  refused({begin + "fact\nendsolid\n", ":9", {"'fact'; facet or endsolid would be accepted"}});
  refused({begin + "endsolid\ngarbage\n", ":10", {"'garbage'; solid, or the file's end,"}});
  refused({"solid s\nfacet\nvertex 0 0 0\n", ":3", {"'vertex'; outer loop would be accepted"}});
  const std::vector<float> triangle = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  refused({binaryStl({triangle, triangle}, 3),
           ", byte 184",
           {"after 2 of 3 triangles", "a file of 234 bytes"}});
  refused({binaryStl({triangle}, 1).substr(0, 133), ", byte 133", {"after 0 of 1 triangles"}});
  refused({binaryStl({triangle, triangle}, 1),
           ", byte 80",
           {"the count is 1, but more triangles follow, up to 2"}});
  refused({binaryStl({triangle, triangle}, 0), ", byte 80", {"the count is 0"}});
  refused({binaryStl({triangle}, 1).substr(0, 60), "", {"is no STL", "84 bytes"}});
  std::vector<float> infinite = triangle;
  infinite[4] = std::numeric_limits<float>::infinity();
  refused({binaryStl({triangle, infinite}, 2), ", byte 162", {"a coordinate is not finite"}});
  refused(
      {"this is a text of more than 84 bytes, as many others are, and no solid of any kind at "
       "all, binary or not",
       ":1",
       {"begins with 'this'", "\"solid\""}});
}

TEST(ReadStl, NoMeshAtAll) {
  const auto refused = [](const mesh_texts::Damaged& damaged) { expectRefused(readStl, damaged); };
  refused({"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 12345\n",
           "",
           {"is a Git LFS pointer", "git lfs pull"}});
  refused({"\n<!DOCTYPE html>\n<html><body>404</body></html>", "", {"is a web page (HTML)"}});
  refused({"<html lang=\"en\">", "", {"is a web page (HTML)"}});
  refused(
      {"<?xml version=\"1.0\"?>\n<!-- -->\n<!DOCTYPE html PUBLIC \"-//W3C//DTD XHTML "
       "1.0\">\n<html>",
       "",
       {"is a web page (HTML)"}});
  refused({"", "", {"is empty"}});
  refused({" \n\n", "", {"is empty"}});
}

}  // namespace
}  // namespace leeway::robots
