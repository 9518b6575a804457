#include "robots/plain_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/robots/model.h"
#include "tests/collision/mesh_files.h"
#include "tests/robots/files.h"

namespace leeway::robots {
namespace {

/// What both readers make of an OBJ file: Assimp reads it when a line follows that is no more than
/// unknown.
void expectSameAsAssimp(const std::string& text, const std::string& what) {
  SCOPED_TRACE(what);
  const test::Folder folder;
  const std::string plain = folder.write("plain.obj", text),
                    other = folder.write("other.obj", text + "\nctech unknown\n");
  ASSERT_TRUE(readPlainMesh(plain).has_value());
  ASSERT_FALSE(readPlainMesh(other).has_value());
  const Eigen::Vector3d scale(1, -0.5, 0.001);
  const auto a = loadMesh(plain, scale, "r.urdf", 1), b = loadMesh(other, scale, "r.urdf", 1);
  ASSERT_TRUE(std::equal(a.mesh()->vertices().begin(), a.mesh()->vertices().end(),
                         b.mesh()->vertices().begin(), b.mesh()->vertices().end()));
  ASSERT_TRUE(std::equal(a.mesh()->triangles().begin(), a.mesh()->triangles().end(),
                         b.mesh()->triangles().begin(), b.mesh()->triangles().end()));
}

TEST(PlainMesh, ObjNumbersAreThoseOfAssimp) {
  std::mt19937_64 random(7);
  std::string text = "# numbers\no one\nusemtl none\n";
  const char* const kForms[] = {"%.0f", "%.3f", "%.6f", "%.12f", "%.20f", "%.6e", "%+.9g", "%.17g"};
  int faces = 0;
  for (int i = 0; i < 300; ++i) {
    text += 'v';
    for (int k = 0; k < 3; ++k) {
      const double size = std::pow(10, static_cast<double>(random() % 8) - 5);
      const double number = size * (static_cast<double>(random() >> 11) * 0x1p-52 - 1);
      char word[64];
      std::snprintf(word, sizeof word, kForms[random() % 8], number);
      text += (random() % 4 == 0 ? "  " : " ") + std::string(word);
    }
    text += random() % 4 == 0 ? " \r\n" : "\n";
    if (i < 3 || i % 2 == 0) continue;
    if (faces++ % 7 == 6) text += "s off\nusemtl another\nvn 0 0 1\n";
    const auto vertex = [&] { return std::to_string(1 + random() % static_cast<unsigned>(i)); };
    if (i % 5 == 0) {
      text += "l " + vertex() + " " + vertex() + "\n";
    } else {
      text += "f " + vertex() + " " + vertex() + " " + vertex() + "\n";
    }
  }
  expectSameAsAssimp(text, "numbers");
}

TEST(PlainMesh, RobotsAreThoseOfAssimp) {
  const auto files = collision::testing::meshFiles();
  if (files.empty()) GTEST_SKIP() << "no test data";
  int read = 0;
  for (const auto& file : files) {
    const auto plain = readPlainMesh(file.string());
    ASSERT_TRUE(plain.has_value()) << file;
    const auto soup = collision::testing::readMesh(file);
    if (file.extension() == ".obj") {
      std::ifstream in(file);
      expectSameAsAssimp({std::istreambuf_iterator<char>(in), {}}, file.filename().string());
      ++read;
      continue;
    }
    // (Of binary STL the test's own reader is the twin.)
    ASSERT_EQ(plain->size(), soup.triangles.size()) << file;
    for (std::size_t t = 0; t < plain->size(); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t i = 0; i < 3; ++i)
          ASSERT_EQ(static_cast<double>((*plain)[t][k][i]),
                    soup.vertices[static_cast<std::size_t>(soup.triangles[t][k])]
                                 [static_cast<Eigen::Index>(i)]);
    ++read;
  }
  EXPECT_GT(read, 20);
}

// What is not plain is left to Assimp.
TEST(PlainMesh, TakesNothingElse) {
  const test::Folder folder;
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  ASSERT_TRUE(readPlainMesh(folder.write("good.obj", triangle + "f 1/1/1 2//2 3\n")).has_value());
  int number = 0;
  for (const char* rest : {"f 1 2 3 1\n",
                           "f 1 2\n",
                           "f 1 2 4\n",
                           "f 0 1 2\n",
                           "f -1 -2 -3\n",
                           "f 1 2 3 # last\n",
                           "f 1 2 \\\n3\n",
                           "v 1 2 nan\nf 1 2 3\n",
                           "v 1 2 .5\nf 1 2 3\n",
                           "v 1 2 3 1\nf 1 2 3\n",
                           "v 1 2 1e\nf 1 2 3\n",
                           "v 1 2 0x1\nf 1 2 3\n",
                           "g a\ng b\nf 1 2 3\n",
                           "f 1 2 3\no late\n",
                           "p 1\nf 1 2 3\n",
                           "call x.obj\nf 1 2 3\n",
                           "f 1a 2 3\n",
                           "f 99999999999999999999 2 3\n",
                           "v 12345678901 2 3\nf 1 2 3\n",
                           ""}) {
    const std::string file =
        folder.write("bad" + std::to_string(number++) + ".obj", triangle + rest);
    EXPECT_FALSE(readPlainMesh(file).has_value()) << rest;
  }
  std::string stl(84, ' ');
  stl[80] = 1;
  stl[81] = stl[82] = stl[83] = 0;
  EXPECT_FALSE(readPlainMesh(folder.write("short.stl", stl + std::string(49, '\0'))).has_value());
  EXPECT_TRUE(readPlainMesh(folder.write("whole.STL", stl + std::string(50, '\0'))).has_value());
  EXPECT_FALSE(readPlainMesh(folder.write("long.stl", stl + std::string(51, '\0'))).has_value());
  EXPECT_FALSE(readPlainMesh(folder.write("tiny.stl", "solid")).has_value());
  EXPECT_FALSE(readPlainMesh(folder.write("mesh.dae", triangle + "f 1 2 3\n")).has_value());
  EXPECT_FALSE(readPlainMesh("/nowhere/mesh.obj").has_value());
}

}  // namespace
}  // namespace leeway::robots
