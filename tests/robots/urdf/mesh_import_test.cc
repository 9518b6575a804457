#include <gtest/gtest.h>

#include <cstring>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/robots/model.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"

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

TEST(MeshImport, LinesAndPointsCanBeTouched) {
  const Folder folder;
  const auto shape = loadMesh(
      folder.write("l.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 5 0 0\nv 6 0 0\nf 1 2 3\nl 4 5\n"), kOne,
      "r.urdf", 1);
  EXPECT_EQ(shape.mesh()->triangles().size(), 2u);
  EXPECT_EQ(extent(shape).second.x(), 6);
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
         {"mesh " + folder.path("none.stl"), "is not there", "STL, OBJ, DAE"});
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
  expect(folder.write("what.xyz", "1 2 3"), {"what.xyz", "cannot be read", "STL, OBJ or DAE"});
  const std::string good = folder.write("t.stl", tetrahedronStl());
  expectInputError([&] { loadMesh(good, {1, 0, 1}, "r.urdf", 7); }, "r.urdf", 7, {"scale", "zero"});
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
  EXPECT_NO_THROW(load("package://named/c.stl", {{{"named", folder_.path("far/away")}}}));
  EXPECT_THROW(load("package://away/c.stl"), InputError);
  ::setenv("ROS_PACKAGE_PATH", (folder_.path("nowhere") + ":" + folder_.path("far")).c_str(), 1);
  EXPECT_NO_THROW(load("package://away/c.stl"));
  ::setenv("ROS_PACKAGE_PATH", folder_.path("far/away").c_str(), 1);
  EXPECT_NO_THROW(load("package://away/c.stl"));
  ::unsetenv("ROS_PACKAGE_PATH");
}

TEST_F(MeshPath, Messages) {
  EXPECT_THROW(load("package://arm"), InputError);
  expectInputError([&] { load("package://arm"); }, urdf_, 2, {"package://NAME/PATH"});
  expectInputError(
      [&] {
        load("package://gone/x.stl", {{{"gone", "/no/such"}}});
      },
      urdf_, 2, {"looked for /no/such/x.stl, ", "--package gone=FOLDER"});
  expectInputError([&] { load("x.stl"); }, urdf_, 2,
                   {"\"x.stl\" was not found", "looked for", "ws/arm/urdf/x.stl"});
  folder_.write("ws/arm/urdf/bad.stl", "solid");
  expectInputError([&] { load("bad.stl"); }, urdf_, 2, {"bad.stl", "would be accepted"});
}

}  // namespace
}  // namespace leeway::robots
