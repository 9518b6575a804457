#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "leeway/collision/distance.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/robots/model.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"
#include "tests/support/sanitized.h"

namespace leeway::robots {
namespace {

const Eigen::Vector3d kOne = Eigen::Vector3d::Ones();

/// A tetrahedron with corners at the origin and at 1, 2, 3 on the axes.
std::string tetrahedronStl() {
  const Eigen::Vector3f corner[] = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  std::string text(80, ' ');
  const auto append = [&](const void* data, std::size_t bytes) {
    text.append(static_cast<const char*>(data), bytes);
  };
  const std::uint32_t count = 4;
  append(&count, 4);
  for (const auto& face : faces) {
    const float normal[3] = {0, 0, 0};
    append(normal, 12);
    for (int k : face) append(corner[k].data(), 12);
    append("\0\0", 2);
  }
  return text;
}

std::string collada(const std::string& unit, const std::string& up, const std::string& matrix) {
  return R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified>)" +
         unit + "<up_axis>" + up + R"(</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">1 0 0 0 2 0 0 0 3</float_array><technique_common><accessor source="#pa" count="3" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n" type="NODE"><matrix>)" +
         matrix +
         R"(</matrix><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene>
</COLLADA>)";
}

constexpr const char* kIdentity = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";

/// Bounding box of the mesh's vertices.
std::pair<Eigen::Vector3d, Eigen::Vector3d> extent(const collision::Shape& shape) {
  Eigen::Vector3d low = shape.mesh()->vertices()[0], high = low;
  for (const Eigen::Vector3d& v : shape.mesh()->vertices()) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return {low, high};
}

TEST(MeshImport, BinaryStlIsWeldedIntoASolid) {
  const Folder folder;
  const auto shape = loadMesh(folder.write("t.stl", tetrahedronStl()), kOne, "r.urdf", 1);
  ASSERT_NE(shape.mesh(), nullptr);
  EXPECT_EQ(shape.mesh()->vertices().size(), 4u);
  EXPECT_EQ(shape.mesh()->triangles().size(), 4u);
  EXPECT_EQ(shape.mesh()->closedComponentCount(), 1);
  EXPECT_EQ(extent(shape).second, Eigen::Vector3d(1, 2, 3));
}

TEST(MeshImport, ScaleMirrorsAndStretches) {
  const Folder folder;
  const auto shape =
      loadMesh(folder.write("t.stl", tetrahedronStl()), {-1, 0.5, 0.001}, "r.urdf", 1);
  EXPECT_EQ(extent(shape).first, Eigen::Vector3d(-1, 0, 0));
  EXPECT_EQ(extent(shape).second, Eigen::Vector3d(0, 1, 0.003));
  EXPECT_EQ(shape.mesh()->closedComponentCount(), 1);
}

TEST(MeshImport, AsciiStlAndObjPolygons) {
  const Folder folder;
  const auto stl =
      loadMesh(folder.write("t.stl",
                            "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 "
                            "0\nvertex 0 1 0\nendloop\nendfacet\nendsolid t\n"),
               kOne, "r.urdf", 1);
  EXPECT_EQ(stl.mesh()->triangles().size(), 1u);
  EXPECT_EQ(stl.mesh()->closedComponentCount(), 0);
  const auto obj = loadMesh(
      folder.write("q.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"), kOne, "r.urdf", 1);
  EXPECT_EQ(obj.mesh()->triangles().size(), 2u);
  EXPECT_EQ(obj.mesh()->vertices().size(), 4u);
}

TEST(MeshImport, LinesAndPointsAreNotSolid) {
  const Folder folder;
  std::vector<std::string> warnings;
  const std::string file = folder.write(
      "l.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 5 0 0\nv 6 0 0\nf 1 2 3\nl 4 5\nl 5 4\np 4\n");
  const auto shape = loadMesh(file, kOne, "r.urdf", 1, {}, &warnings);
  EXPECT_EQ(shape.mesh()->triangles().size(), 1u);
  EXPECT_EQ(extent(shape).second.x(), 1);
  EXPECT_EQ(warnings, std::vector<std::string>{"r.urdf:1: mesh " + file +
                                               ":7: left out, as they have no area: 2 lines and "
                                               "1 point"});
}

TEST(MeshImport, ColladaUnitsAndNodesCountTheUpAxisDoesNot) {
  const Folder folder;
  const std::string centimetres = "<unit name=\"centimeter\" meter=\"0.01\"/>",
                    metres = "<unit name=\"meter\" meter=\"1\"/>";
  const std::string turned_and_moved = "0 -1 0 10 1 0 0 20 0 0 1 30 0 0 0 1";
  for (const char* up : {"X_UP", "Y_UP", "Z_UP"}) {
    const auto plain =
        loadMesh(folder.write("a.dae", collada(metres, up, kIdentity)), kOne, "r.urdf", 1);
    EXPECT_TRUE(extent(plain).second.isApprox(Eigen::Vector3d(1, 2, 3), 1e-6))
        << up << ": " << extent(plain).second.transpose();
    const auto small =
        loadMesh(folder.write("b.dae", collada(centimetres, up, kIdentity)), kOne, "r.urdf", 1);
    EXPECT_TRUE(extent(small).second.isApprox(Eigen::Vector3d(0.01, 0.02, 0.03), 1e-6))
        << up << ": " << extent(small).second.transpose();
    // (x, y, z) -> (10 - y, 20 + x, 30 + z) cm, then the URDF's scale.
    const auto moved = loadMesh(folder.write("c.dae", collada(centimetres, up, turned_and_moved)),
                                {2, 1, 1}, "r.urdf", 1);
    EXPECT_TRUE(extent(moved).first.isApprox(Eigen::Vector3d(0.16, 0.20, 0.30), 1e-6))
        << up << ": " << extent(moved).first.transpose();
    EXPECT_TRUE(extent(moved).second.isApprox(Eigen::Vector3d(0.20, 0.21, 0.33), 1e-6))
        << up << ": " << extent(moved).second.transpose();
  }
}

TEST(MeshImport, Messages) {
  const Folder folder;
  const auto expect = [&](const std::string& file, std::initializer_list<std::string> words) {
    expectInputError([&] { loadMesh(file, kOne, "r.urdf", 7); }, "r.urdf", 7, words);
  };
  expect(folder.path("none.stl"),
         {"mesh " + folder.path("none.stl"), "is not there", "STL, OBJ, PLY, DAE"});
  expect(folder.write("empty.stl", ""), {"empty.stl", "would be accepted"});
  expect(folder.write("cut.stl", tetrahedronStl().substr(0, 150)),
         {"cut.stl", "would be accepted"});
  expect(folder.write("text.obj", "this is no mesh\n"), {"text.obj", "would be accepted"});
  expect(folder.write("points.obj", "v 0 0 0\nv 1 0 0\n"), {"points.obj", "would be accepted"});
  expect(folder.write("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), {"nan.obj", "finite"});
  expect(folder.write("inf.obj", "v 0 0 inf\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), {"inf.obj", "finite"});
  std::string nan_stl = tetrahedronStl();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(&nan_stl[84 + 12], &nan, 4);
  expect(folder.write("nan.stl", nan_stl), {"nan.stl", "finite"});
  expect(folder.write("broken.dae", "<COLLADA><asset>"), {"broken.dae", "would be accepted"});
  expect(folder.write("what.xyz", "1 2 3"),
         {"what.xyz", "has the ending '.xyz'", "STL, OBJ, PLY, DAE, glTF or GLB"});
  const std::string good = folder.write("t.stl", tetrahedronStl());
  expectInputError([&] { loadMesh(good, {1, 0, 1}, "r.urdf", 7); }, "r.urdf", 7, {"scale", "zero"});
}

/// A bumpy ball of a few hundred triangles.
std::string ballStl(double radius) {
  constexpr int kRings = 12, kSectors = 20;
  std::vector<Eigen::Vector3f> corners;
  const auto at = [&](int i, int j) {
    const double a = 3.14159265358979 * i / kRings,
                 b = 2 * 3.14159265358979 * (j % kSectors) / kSectors;
    const double r =
        radius * (1 + 0.1 * ((i * 7 + j % kSectors * 3) % 5)) * (i % kRings == 0 ? 0.0 : 1.0);
    return Eigen::Vector3f(Eigen::Vector3d(r * std::sin(a) * std::cos(b),
                                           r * std::sin(a) * std::sin(b), radius * std::cos(a))
                               .cast<float>());
  };
  for (int i = 0; i < kRings; ++i)
    for (int j = 0; j < kSectors; ++j) {
      for (const auto& [di, dj] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}})
        corners.push_back(at(i + di, j + dj));
    }
  std::string text(80, ' ');
  const auto append = [&](const void* data, std::size_t bytes) {
    text.append(static_cast<const char*>(data), bytes);
  };
  const auto count = static_cast<std::uint32_t>(corners.size() / 3);
  append(&count, 4);
  for (std::size_t t = 0; t < corners.size(); t += 3) {
    const float normal[3] = {0, 0, 0};
    append(normal, 12);
    for (std::size_t k = 0; k < 3; ++k) append(corners[t + k].data(), 12);
    append("\0\0", 2);
  }
  return text;
}

std::vector<std::filesystem::path> filesIn(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  if (std::filesystem::exists(folder))
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      files.push_back(entry.path());
  return files;
}

void expectSame(const collision::Shape& a, const collision::Shape& b) {
  const collision::TriangleMesh &s = *a.mesh(), &t = *b.mesh();
  ASSERT_TRUE(std::equal(s.vertices().begin(), s.vertices().end(), t.vertices().begin(),
                         t.vertices().end()));
  ASSERT_TRUE(std::equal(s.triangles().begin(), s.triangles().end(), t.triangles().begin(),
                         t.triangles().end()));
  EXPECT_EQ(s.hullExcess(), t.hullExcess());
  for (int i = 0; i < 20; ++i) {
    collision::Pose X;
    X.translation = Eigen::Vector3d(0.1 * i, 0.7 - 0.05 * i, 0.03 * i);
    const auto of = [&](const collision::Shape& shape) {
      return collision::distance(shape, {}, collision::Shape::box({0.1, 0.2, 0.3}), X);
    };
    const collision::DistanceResult p = of(a), q = of(b);
    EXPECT_EQ(p.distance.lower, q.distance.lower);
    EXPECT_EQ(p.distance.upper, q.distance.upper);
    EXPECT_EQ(p.point_a, q.point_a);
  }
}

TEST(MeshImport, KeepsMeshesOnDisk) {
  const Folder folder;
  const std::string cache = folder.path("cache");
  LoadOptions options;
  options.cache = cache;
  const std::string file = folder.write("ball.stl", ballStl(0.5));
  const auto none = loadMesh(file, kOne, "r.urdf", 1);
  EXPECT_TRUE(filesIn(cache).empty());
  const auto cold = loadMesh(file, kOne, "r.urdf", 1, options);
  EXPECT_EQ(filesIn(cache).size(), 1U);
  const auto warm = loadMesh(file, kOne, "r.urdf", 1, options);
  expectSame(none, cold);
  expectSame(none, warm);
  // A file with the same content under another name.
  std::filesystem::rename(file, folder.path("moved.stl"));
  expectSame(none, loadMesh(folder.path("moved.stl"), kOne, "r.urdf", 1, options));
  EXPECT_EQ(filesIn(cache).size(), 1U);
  // Another ending selects another reader.
  const std::string other = folder.write("ball.obj", ballStl(0.5));
  EXPECT_THROW(loadMesh(other, kOne, "r.urdf", 1, options), InputError);
  // Other scales and contents give other meshes.
  EXPECT_EQ(extent(loadMesh(folder.path("moved.stl"), {2, 1, 1}, "r.urdf", 1, options)).second.x(),
            2 * extent(none).second.x());
  EXPECT_EQ(filesIn(cache).size(), 2U);
  const std::string changed = folder.write("ball.stl", ballStl(0.25));
  EXPECT_EQ(extent(loadMesh(changed, kOne, "r.urdf", 1, options)).second.z(), 0.25);
  EXPECT_EQ(filesIn(cache).size(), 3U);
}

TEST(MeshImport, NeverBelievesADamagedFile) {
  const Folder folder;
  const std::string cache = folder.path("cache");
  LoadOptions options;
  options.cache = cache;
  const std::string file = folder.write("ball.stl", ballStl(0.5));
  const auto truth = loadMesh(file, kOne, "r.urdf", 1, options);
  ASSERT_EQ(filesIn(cache).size(), 1U);
  const std::string kept = filesIn(cache)[0].string();
  const std::string whole = readText(kept);
  const auto cases = static_cast<std::size_t>(casesToAsk(60));
  for (std::size_t i = 0; i < cases; ++i) {
    std::string damaged = whole;
    const std::size_t place = i * whole.size() / cases + i;
    if (i % 3 == 0) {
      damaged.resize(place);
    } else {
      damaged[place] = static_cast<char>(damaged[place] ^ (1 << (i % 8)));
    }
    writeText(kept, damaged);
    expectSame(truth, loadMesh(file, kOne, "r.urdf", 1, options));
    EXPECT_EQ(readText(kept), whole) << "not mended, place " << place;
  }
}

TEST(MeshImport, KeepsOnlyWhatDependsOnOneFile) {
  const Folder folder;
  const std::string cache = folder.path("cache");
  LoadOptions options;
  options.cache = cache;
  std::string vertices, faces;
  for (int i = 0; i < 400; ++i) {
    vertices += "v " + std::to_string(i % 20) + ' ' + std::to_string(i / 20) + " 0\n";
    if (i % 20 < 19 && i / 20 < 19)
      faces += (i % 2 == 0 ? "usemtl red\nf " : "usemtl blue\nf ") + std::to_string(i + 1) + ' ' +
               std::to_string(i + 2) + ' ' + std::to_string(i + 21) + '\n';
  }
  // Materials are not used: the result is the same with and without them.
  const std::string plain = folder.write("plain.obj", vertices + faces),
                    painted = folder.write("painted.obj", "mtllib paint.mtl\n" + vertices + faces);
  folder.write("paint.mtl", "newmtl blue\nKd 0 0 1\nnewmtl red\nKd 1 0 0\n");
  expectSame(loadMesh(plain, kOne, "r.urdf", 1, options),
             loadMesh(painted, kOne, "r.urdf", 1, options));
  EXPECT_EQ(filesIn(cache).size(), 2U);
  // glTF has its numbers in a second file.
  std::string numbers(3 * 12, '\0');
  const float corner[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::memcpy(numbers.data(), corner, sizeof(corner));
  folder.write("numbers.bin", numbers);
  const std::string gltf = folder.write(
      "t.gltf", R"({"asset": {"version": "2.0", "copyright": ")" + std::string(5000, ' ') +
                    R"("}, "buffers": [{"uri": "numbers.bin", "byteLength": 36}],
"bufferViews": [{"buffer": 0, "byteLength": 36}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
"nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0})");
  EXPECT_EQ(loadMesh(gltf, kOne, "r.urdf", 1, options).mesh()->triangles().size(), 1U);
  EXPECT_EQ(filesIn(cache).size(), 2U);
  // Small files are imported as fast as they would be read.
  loadMesh(folder.write("t.stl", tetrahedronStl()), kOne, "r.urdf", 1, options);
  EXPECT_EQ(filesIn(cache).size(), 2U);
}

/// A box of 1, 2 and 3 with quadrangles as faces and one corner moved by `bend`.
std::string boxObj(double bend = 0) {
  std::string obj;
  for (int i = 0; i < 8; ++i)
    obj += "v " + std::to_string(i & 1) + ' ' + std::to_string(i & 2) + ' ' +
           (i == 7 ? std::to_string(3 + bend) : std::to_string(3 * (i >> 2))) + '\n';
  return obj + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

TEST(MeshImport, PolygonsOfASolidKeepItClosed) {
  const Folder folder;
  std::vector<std::string> warnings;
  const auto plain = loadMesh(folder.write("b.obj", boxObj()), kOne, "r.urdf", 1, {}, &warnings);
  EXPECT_EQ(plain.mesh()->triangles().size(), 12U);
  EXPECT_EQ(plain.mesh()->closedComponentCount(), 1);
  EXPECT_TRUE(warnings.empty());
  // Three faces meet at the moved corner; one of them stays in its plane.
  const std::string file = folder.write("bent.obj", boxObj(0.1));
  const auto bent = loadMesh(file, {2, 2, 2}, "r.urdf", 1, {}, &warnings);
  EXPECT_EQ(bent.mesh()->triangles().size(), 12U + 4);
  EXPECT_EQ(bent.mesh()->componentCount(), 2);
  EXPECT_EQ(bent.mesh()->closedComponentCount(), 2);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].find("r.urdf:1: mesh " + file +
                             ":10: a face is not planar, by 0.1 m; every surface between"),
            0U)
      << warnings[0];
}

TEST(MeshImport, CoordinatesAreThoseOfTheFile) {
  const Folder folder;
  const auto shape = loadMesh(
      folder.write("far.obj", "v 4000000.04 0 0\nv 4000000.04 0 3\nv 4000000.04 2 0\nf 1 2 3\n"),
      kOne, "r.urdf", 1);
  EXPECT_EQ(extent(shape).first.x(), 4000000.04);
}

/// A file that was truncated between two lines has vertices that no face uses.
TEST(MeshImport, VerticesThatNoFaceUsesAreCounted) {
  const Folder folder;
  const auto told = [&](const std::string& name, const std::string& text) {
    std::vector<std::string> warnings;
    loadMesh(folder.write(name, text), kOne, "r.urdf", 1, {}, &warnings);
    return warnings;
  };
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  const std::string faces = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
  EXPECT_TRUE(told("whole.obj", corners + faces).empty());
  const std::vector<std::string> cut = told("cut.obj", corners + "v 5 5 5\nf 1 3 2\n");
  ASSERT_EQ(cut.size(), 1U);
  EXPECT_EQ(cut[0], "r.urdf:1: mesh " + folder.path("cut.obj") +
                        " has 2 vertices that no face uses; faces may be missing from the file");
  EXPECT_NE(told("one.obj", corners + "v 5 5 5\n" + faces)[0].find("has 1 vertex that"),
            std::string::npos);
  // Lines and points use them.
  const std::vector<std::string> lines =
      told("lines.obj", corners + "v 5 5 5\nv 6 6 6\n" + faces + "l 1 -2\np 6\n");
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_NE(lines[0].find("left out"), std::string::npos);
  EXPECT_EQ(told("more.obj", corners + "v 5 5 5\nv 6 6 6\n" + faces + "l 1 5\n").size(), 2U);
  const auto ply = [](int vertices) {
    std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(vertices) +
                       "\nproperty float x\nproperty float y\nproperty float z\nelement face "
                       "1\nproperty list int int vertex_indices\nend_header\n";
    for (int i = 0; i < vertices; ++i)
      text += std::to_string(i * i) + ' ' + std::to_string(i) + " 0\n";
    return text + "3 0 1 2\n";
  };
  EXPECT_TRUE(told("whole.ply", ply(3)).empty());
  EXPECT_NE(told("more.ply", ply(5))[0].find("has 2 vertices"), std::string::npos);
}

/// A mesh from the cache has its warnings, too.
TEST(MeshImport, WarningsAreKeptWithTheMesh) {
  const Folder folder;
  LoadOptions options;
  options.cache = folder.path("cache");
  const std::string file =
      folder.write("bent.obj", boxObj(0.1) + "l 1 2\n" + std::string(5000, '#'));
  std::vector<std::string> cold, warm, other;
  const auto made = loadMesh(file, kOne, "r.urdf", 1, options, &cold);
  EXPECT_EQ(filesIn(options.cache).size(), 1U);
  expectSame(made, loadMesh(file, kOne, "r.urdf", 1, options, &warm));
  EXPECT_EQ(cold.size(), 2U);
  EXPECT_EQ(cold, warm);
  const std::string copy = folder.write("copy.obj", readText(file));
  loadMesh(copy, kOne, "p.yaml", 9, options, &other);
  EXPECT_EQ(filesIn(options.cache).size(), 1U);
  ASSERT_EQ(other.size(), 2U);
  EXPECT_EQ(other[0].find("p.yaml:9: mesh " + copy + ":15: left out"), 0U) << other[0];
}

TEST(MeshImport, WarningsComeWithTheModel) {
  const Folder folder;
  folder.write("bent.obj", boxObj(0.1));
  const std::string collision =
      "<collision><geometry>\n<mesh filename=\"bent.obj\"/></geometry></collision>\n";
  const std::string urdf = folder.write("r.urdf", "<robot name=\"r\"><link name=\"a\">\n" +
                                                      collision + collision + "</link></robot>");
  const auto model = loadModel(urdf, "");
  ASSERT_EQ(model->warnings.size(), 1U);  // one for each file
  EXPECT_EQ(model->warnings[0].find(urdf + ":3: mesh " + folder.path("bent.obj") + ":10: a face"),
            0U)
      << model->warnings[0];
}

TEST(MeshImport, EndingsThatNobodyKnows) {
  const Folder folder;
  const std::string dae = collada("", "Z_UP", kIdentity);
  EXPECT_EQ(extent(loadMesh(folder.write("a.xml", dae), kOne, "r", 1)).second,
            Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(extent(loadMesh(folder.write("b", dae), kOne, "r", 1)).second,
            Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(loadMesh(folder.write("c.what",
                                  "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                                  "vertex 0 0.1 0\nendloop\nendfacet\nendsolid\n"),
                     kOne, "r", 1)
                .mesh()
                ->triangles()
                .size(),
            1U);
}

/// Regression: Assimp read them, and lost faces and units in silence.
TEST(MeshImport, OtherFormatsAreRefused) {
  const Folder folder;
  for (const char* name : {"a.off", "a.3mf", "a.fbx", "a.X", "a.3ds"}) {
    const std::string file = folder.write(name, "OFF\n3 1 0\n0 0 0\n3 0 0\n3 1 0\n3 0 1 2\n");
    expectInputError([&] { loadMesh(file, kOne, "r.urdf", 1); }, "r.urdf", 1,
                     {"mesh " + file + " has the ending '.", "STL, OBJ, PLY, DAE, glTF or GLB"});
  }
  const std::string bare = folder.write("a", "OFF\n");
  expectInputError([&] { loadMesh(bare, kOne, "r.urdf", 1); }, "r.urdf", 1, {"has no ending"});
}

class MeshPath : public testing::Test {
 protected:
  /// Loads a URDF whose single link has the mesh.
  std::shared_ptr<const Model> load(const std::string& uri, const LoadOptions& options = {}) {
    urdf_ = folder_.write(
        "ws/arm/urdf/arm.urdf",
        "<robot name=\"r\"><link name=\"a\"><collision><geometry>\n<mesh filename=\"" + uri +
            "\"/></geometry></collision></link></robot>");
    return loadModel(urdf_, "", options);
  }
  Folder folder_;
  std::string urdf_;
};

TEST_F(MeshPath, PackagesAndRelativePaths) {
  ::unsetenv("ROS_PACKAGE_PATH");
  folder_.write("ws/arm/meshes/a.stl", tetrahedronStl());
  folder_.write("ws/arm/urdf/here.stl", tetrahedronStl());
  folder_.write("ws/other/b.stl", tetrahedronStl());
  const std::string far = folder_.write("far/away/c.stl", tetrahedronStl());
  EXPECT_NO_THROW(load("package://arm/meshes/a.stl"));  // a parent folder is the package
  EXPECT_NO_THROW(load("package://other/b.stl"));       // a parent folder holds the package
  EXPECT_NO_THROW(load("here.stl"));
  EXPECT_NO_THROW(load("../meshes/a.stl"));
  EXPECT_NO_THROW(load(far));
  EXPECT_NO_THROW(load("file://" + far));
  EXPECT_NO_THROW(load("file://localhost" + far));
  EXPECT_NO_THROW(load("package://named/c.stl", {{{"named", folder_.path("far/away")}}}));
  EXPECT_THROW(load("package://away/c.stl"), InputError);
  ::setenv("ROS_PACKAGE_PATH", (folder_.path("nowhere") + ":" + folder_.path("far")).c_str(), 1);
  EXPECT_NO_THROW(load("package://away/c.stl"));
  ::setenv("ROS_PACKAGE_PATH", folder_.path("far/away").c_str(), 1);
  EXPECT_NO_THROW(load("package://away/c.stl"));
  ::setenv("ROS_PACKAGE_PATH", folder_.path("none").c_str(), 1);
  EXPECT_THROW(load("package://away/c.stl"), InputError);
  ::unsetenv("ROS_PACKAGE_PATH");
  folder_.write("prefix/share/installed/d.stl", tetrahedronStl());
  ::setenv("AMENT_PREFIX_PATH", (folder_.path("nowhere") + ":" + folder_.path("prefix")).c_str(),
           1);
  EXPECT_NO_THROW(load("package://installed/d.stl"));
  ::unsetenv("AMENT_PREFIX_PATH");
}

TEST_F(MeshPath, PackagesByTheNameInTheirPackageXml) {
  const auto package = [&](const std::string& folder, const std::string& name) {
    folder_.write(
        folder + "/package.xml",
        "<?xml version=\"1.0\"?>\n<package format=\"3\"><name>\n " + name + " </name></package>");
  };
  package("ws/arm", "arm_description");
  package("ws/meshes_of_the_arm", "arm_meshes");
  package("ws/broken", "<name>");
  folder_.write("ws/arm/meshes/a.stl", tetrahedronStl());
  folder_.write("ws/meshes_of_the_arm/b.stl", tetrahedronStl());
  EXPECT_NO_THROW(load("package://arm_description/meshes/a.stl"));
  EXPECT_NO_THROW(load("package://arm_meshes/b.stl"));  // beside a folder above
  // By the folder's own name, still. Regression: in silence.
  const auto other = load("package://arm/meshes/a.stl");
  ASSERT_EQ(other->warnings.size(), 1U);
  EXPECT_EQ(other->warnings[0],
            urdf_ + ":2: the package \"arm\" is taken from the folder of that name, but " +
                folder_.path("ws/arm/package.xml") +
                " calls it \"arm_description\"; --package arm=FOLDER says which is meant");
  EXPECT_THROW(load("package://meshes_of/b.stl"), InputError);
  EXPECT_TRUE(load("package://arm_meshes/b.stl")->warnings.empty());
  // Regression: the folder's own name counted before its package.xml.
  package("ws/arm_meshes", "something_else");
  folder_.write("ws/arm_meshes/b.stl", "solid\n");
  EXPECT_NO_THROW(load("package://arm_meshes/b.stl"));
  // Regression: a link to the package counted as a second one.
  std::filesystem::create_directory_symlink(folder_.path("ws/meshes_of_the_arm"),
                                            folder_.path("ws/a_link"));
  EXPECT_TRUE(load("package://arm_meshes/b.stl")->warnings.empty());
  std::filesystem::remove(folder_.path("ws/a_link"));
  // Regression: the first of two was taken in silence.
  package("ws/their_copy", "arm_meshes");
  EXPECT_TRUE(load("package://arm_meshes/b.stl")->warnings.empty());  // has no such file
  folder_.write("ws/their_copy/b.stl", tetrahedronStl());
  const auto model = load("package://arm_meshes/b.stl");
  ASSERT_EQ(model->warnings.size(), 1U);
  EXPECT_EQ(model->warnings[0],
            urdf_ + ":2: the package \"arm_meshes\" is " + folder_.path("ws/meshes_of_the_arm") +
                ", and also " + folder_.path("ws/their_copy") +
                "; the first is taken, --package arm_meshes=FOLDER says which is meant");
}

TEST_F(MeshPath, SpellingsOfOneFile) {
  folder_.write("ws/arm/meshes/a b.stl", tetrahedronStl());
  folder_.write("ws/arm/meshes/100%20.stl", tetrahedronStl());
  folder_.write("ws/arm/urdf/rel.stl", tetrahedronStl());
  for (const char* uri :
       {"package://arm/meshes/a b.stl", "package://arm/meshes/a%20b.stl",
        "package://arm//meshes///a%20b.stl", "package:///arm/meshes/a b.stl",
        "model://arm/meshes/a b.stl", "../meshes/a%20b.stl", "..//meshes/./a b.stl ",
        "package://arm/meshes/100%20.stl", "file://../meshes/a b.stl", " rel.stl"})
    EXPECT_NO_THROW(load(uri)) << uri;
  EXPECT_THROW(load("../meshes/a%2b.stl"), InputError);
}

TEST_F(MeshPath, Messages) {
  EXPECT_THROW(load("package://arm"), InputError);
  expectInputError([&] { load("package://arm"); }, urdf_, 2, {"package://NAME/PATH"});
  expectInputError(
      [&] {
        load("package://gone/x.stl", {{{"gone", "/no/such"}}});
      },
      urdf_, 2, {"the package \"gone\" is /no/such, without that file", "--package gone=FOLDER"});
  expectInputError([&] { load("package://gone/x.stl"); }, urdf_, 2,
                   {"there is no package \"gone\"", "ws/arm/urdf up", "--package gone=FOLDER"});
  expectInputError([&] { load("package://arm/x.stl"); }, urdf_, 2,
                   {"the package \"arm\" is " + folder_.path("ws/arm") + ", without that file"});
  expectInputError([&] { load("x.stl"); }, urdf_, 2,
                   {"\"x.stl\" was not found", "looked for", "ws/arm/urdf/x.stl"});
  folder_.write("ws/arm/urdf/bad.stl", "solid");
  expectInputError([&] { load("bad.stl"); }, urdf_, 2, {"bad.stl", "would be accepted"});
}

}  // namespace
}  // namespace leeway::robots
