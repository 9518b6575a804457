#include "robots/mesh/triangulate.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "leeway/collision/distance.h"
#include "leeway/collision/triangle_mesh.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"

namespace leeway::robots {
namespace {

using collision::TriangleMesh;
using collision::testing::Random;
using Eigen::Vector3d;

FileMesh polygon(const std::vector<Vector3d>& corners) {
  FileMesh mesh;
  std::vector<std::int32_t> numbers;
  for (const Vector3d& corner : corners) {
    numbers.push_back(static_cast<std::int32_t>(mesh.vertices.size()));
    mesh.vertices.push_back(corner);
  }
  mesh.addFace(numbers, FilePlace::line(5));
  return mesh;
}

std::shared_ptr<const TriangleMesh> meshOf(FileMesh& file, CutMesh& cut) {
  cut = triangulate(file, Bent::kCovered);
  return TriangleMesh::make(file.vertices, cut.triangles, {.decompose = false});
}

/// Largest distance of a triangle's points from a mesh, solids filled.
double farthest(const Vector3d& a, const Vector3d& b, const Vector3d& c,
                const collision::Shape& shape) {
  double worst = 0;
  for (int i = 0; i <= 3; ++i)
    for (int j = 0; i + j <= 3; ++j) {
      const Vector3d p = a + (b - a) * (i / 3.0) + (c - a) * (j / 3.0);
      collision::Pose X;
      X.translation = p;
      worst = std::max(
          worst, collision::distance(shape, {}, collision::Shape::sphere(0), X).distance.lower);
    }
  return worst;
}

TEST(Triangulate, PlanarFacesAreCutAlone) {
  FileMesh square = polygon({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  const CutMesh cut = triangulate(square, Bent::kCovered);
  EXPECT_EQ(cut.triangles, (decltype(cut.triangles){{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(cut.bent.count, 0);
  EXPECT_EQ(square.vertices.size(), 4U);
  // A plane that is rounded to six digits, also far from the origin.
  for (const double offset : {0.0, 5.0}) {
    FileMesh rounded =
        polygon({{offset, 0, 0}, {offset + 1, 0, 0}, {offset + 1, 1, 9e-7}, {offset, 1, 0}});
    EXPECT_EQ(triangulate(rounded, Bent::kCovered).bent.count, 0);
  }
  // But digits are not lost to an offset for which there would have been room.
  FileMesh far = polygon({{1e6, 0, 0}, {1e6 + 1, 0, 0}, {1e6 + 1, 1, 1e-4}, {1e6, 1, 0}});
  EXPECT_EQ(triangulate(far, Bent::kCovered).bent.count, 1);
}

TEST(Triangulate, FacesWithoutAreaStay) {
  FileMesh line = polygon({{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {2, 0, 0}});
  const CutMesh cut = triangulate(line, Bent::kCovered);
  EXPECT_FALSE(cut.triangles.empty());
  EXPECT_EQ(cut.bent.count, 0);
  EXPECT_EQ(cut.crossing.count, 0);
  const auto shape = collision::Shape::mesh(TriangleMesh::make(line.vertices, cut.triangles));
  collision::Pose X;
  X.translation = {2.5, 0.5, 0};
  EXPECT_NEAR(collision::distance(shape, {}, collision::Shape::sphere(0), X).distance.upper, 0.5,
              1e-9);
  FileMesh point = polygon({{1, 2, 3}, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}});
  EXPECT_EQ(triangulate(point, Bent::kCovered).triangles.size(), 1U);
}

/// A quadrangle that is not planar means the triangles of either diagonal, and everything in
/// between.
TEST(Triangulate, BentQuadranglesAreCoveredByTheirTetrahedron) {
  Random random(3);
  for (int i = 0; i < bySanitizer(100, 10, 2); ++i) {
    const double height = std::pow(10, random.uniform(-4, 0)),
                 size = std::pow(10, random.uniform(-3, 3));
    const Vector3d offset =
        i % 2 == 0 ? Vector3d(Vector3d::Zero()) : Vector3d(1e4 * random.vector());
    std::vector<Vector3d> corners;
    const Eigen::Matrix3d turn = random.pose(1).rotation;
    const double flat[4][2] = {{0, 0}, {1.2, 0.1}, {1, 0.9}, {-0.2, 1.1}};
    for (std::size_t k = 0; k < 4; ++k)
      corners.push_back(offset +
                        size * (turn * Vector3d(flat[k][0], flat[k][1], k == 2 ? height : 0)));
    FileMesh file = polygon(corners);
    CutMesh cut;
    const auto mesh = meshOf(file, cut);
    ASSERT_EQ(cut.bent.count, 1) << i;
    EXPECT_EQ(cut.bent.first.text(), ":5");
    EXPECT_GT(cut.bent.largest.norm(), 0.3 * size * height);
    EXPECT_LT(cut.bent.largest.norm(), size * height);
    // The triangulated face, and a separate solid.
    EXPECT_EQ(cut.triangles.size(), 6U);
    EXPECT_EQ(mesh->componentCount(), 2);
    EXPECT_EQ(mesh->closedComponentCount(), 1);
    const collision::Shape shape = collision::Shape::mesh(mesh);
    const double rounding = 1e-15 * (offset.norm() + size);
    for (const auto& [a, b, c] :
         {std::array<std::size_t, 3>{0, 1, 2}, {0, 2, 3}, {0, 1, 3}, {1, 2, 3}})
      EXPECT_LE(farthest(corners[a], corners[b], corners[c], shape), rounding) << i;
    // Points between both, inside the tetrahedron.
    const Vector3d middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
    EXPECT_LE(farthest(middle, middle, middle, shape), rounding);
  }
}

/// All surfaces between the corners of a larger face are within its departure.
TEST(Triangulate, BentPolygonsAreCoveredBySlabs) {
  Random random(4);
  for (int i = 0; i < bySanitizer(20, 4, 2); ++i) {
    std::vector<Vector3d> corners;
    const int count = 5 + random.below(6);
    const double height = std::pow(10, random.uniform(-4, -1));
    for (int k = 0; k < count; ++k) {
      const double angle = 2 * 3.14159265358979 * k / count,
                   radius = i % 2 == 0 ? 1 : random.uniform(0.4, 1);
      corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                           height * random.uniform());
    }
    FileMesh file = polygon(corners);
    CutMesh cut;
    const auto mesh = meshOf(file, cut);
    ASSERT_EQ(cut.bent.count, 1);
    EXPECT_EQ(mesh->componentCount(), 2);
    EXPECT_EQ(mesh->closedComponentCount(), 1);
    const collision::Shape shape = collision::Shape::mesh(mesh);
    // Every fan of a convex one.
    for (std::size_t first = 0; first < corners.size() && i % 2 == 0; ++first) {
      const auto corner = [&](std::size_t k) { return corners[(first + k) % corners.size()]; };
      for (std::size_t k = 1; k + 1 < corners.size(); ++k)
        EXPECT_LE(farthest(corner(0), corner(k), corner(k + 1), shape), 1e-15);
    }
    // The slab does not reach much farther.
    const double departure = cut.bent.largest.norm();
    for (const Vector3d& v : mesh->vertices()) EXPECT_LE(std::abs(v.z()), height + 2 * departure);
  }
}

/// A bent wall with a window: the slab has a window, too.
TEST(Triangulate, SlabsKeepWindows) {
  std::vector<Vector3d> corners;
  const double flat[10][2] = {{0, 0}, {3, 0}, {3, 3}, {0, 3}, {0, 0},
                              {1, 1}, {1, 2}, {2, 2}, {2, 1}, {1, 1}};
  for (const auto& [x, y] : flat) corners.emplace_back(x, y, 0.01 * std::sin(3 * x + 2 * y));
  FileMesh file = polygon(corners);
  CutMesh cut;
  const auto mesh = meshOf(file, cut);
  EXPECT_EQ(cut.bent.count, 1);
  EXPECT_EQ(cut.crossing.count, 0);
  EXPECT_EQ(mesh->closedComponentCount(), 1);
  const collision::Shape shape = collision::Shape::mesh(mesh);
  collision::Pose X;
  X.translation = {1.5, 1.5, 0};
  EXPECT_GT(collision::distance(shape, {}, collision::Shape::sphere(0.4), X).distance.lower, 0.05);
}

/// A bow tie covers both of its halves and has a note.
TEST(Triangulate, CrossingFacesAreCoveredAndTold) {
  FileMesh file = polygon({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}});
  CutMesh cut;
  const auto mesh = meshOf(file, cut);
  EXPECT_EQ(cut.crossing.count, 1);
  EXPECT_EQ(cut.crossing.first.text(), ":5");
  EXPECT_EQ(cut.bent.count, 0);
  const collision::Shape shape = collision::Shape::mesh(mesh);
  for (const double x : {0.1, 0.9}) {
    const Vector3d p(x, 0.5, 0);
    EXPECT_LE(farthest(p, p, p, shape), 0);
  }
  // A window that turns as its wall does is covered.
  FileMesh filled = polygon({{0, 0, 0},
                             {3, 0, 0},
                             {3, 3, 0},
                             {0, 3, 0},
                             {0, 0, 0},
                             {1, 1, 0},
                             {2, 1, 0},
                             {2, 2, 0},
                             {1, 2, 0},
                             {1, 1, 0}});
  EXPECT_EQ(triangulate(filled, Bent::kCovered).crossing.count, 1);
}

/// Ten thousand corners take about a second.
TEST(Triangulate, LargePolygons) {
  std::vector<Vector3d> comb;
  constexpr int kTeeth = 2500;
  for (int i = 0; i < kTeeth; ++i) {
    comb.emplace_back(i, 0, 0);
    comb.emplace_back(i + 0.5, 100, 0);
  }
  comb.emplace_back(kTeeth, 200, 0);
  comb.emplace_back(-1, 200, 0);
  FileMesh file = polygon(comb);
  const CutMesh cut = triangulate(file, Bent::kCovered);
  EXPECT_EQ(cut.triangles.size(), comb.size() - 2);
  EXPECT_EQ(cut.crossing.count, 0);
}

}  // namespace
}  // namespace leeway::robots
