#include "collision/mesh/point_in_solid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

TEST(PointInSolid, AgreesWithSolidAngles) {
  int inside = 0, outside = 0;
  for (const NamedMesh& m : sampleMeshes(13)) {
    SCOPED_TRACE(m.name);
    Random random(5);
    for (int c = 0; c < m.mesh->componentCount(); ++c) {
      if (!m.mesh->isClosed(c)) continue;
      for (int i = 0; i < casesToAsk(1000); ++i) {
        const Vector3d p = random.vector();
        const Side side = sideOf(*m.mesh, c, p);
        const bool expected = std::lround(windingAround(*m.mesh, c, p)) != 0;
        ASSERT_EQ(side, expected ? Side::kInside : Side::kOutside) << p.transpose();
        ++(expected ? inside : outside);
      }
    }
  }
  EXPECT_GT(inside, casesToAsk(400));
  EXPECT_GT(outside, casesToAsk(400));
}

TEST(PointInSolid, DecidesOnAxesAndDiagonalsOfABox) {
  const auto mesh = TriangleMesh::make(boxSoup({1, 1, 1}).vertices, boxSoup({1, 1, 1}).triangles);
  for (const double x : {0.0, 0.5, -0.25, 0.999}) {
    EXPECT_EQ(sideOf(*mesh, 0, {x, x, x}), Side::kInside);
    EXPECT_EQ(sideOf(*mesh, 0, {x, 0, 0}), Side::kInside);
    EXPECT_EQ(sideOf(*mesh, 0, {1 + 1e-15, x, x}), Side::kOutside);
  }
  EXPECT_EQ(sideOf(*mesh, 0, {1, 0.5, 0.5}), Side::kUnknown);  // on the surface
}

}  // namespace
}  // namespace leeway::collision
