// Depth of concave bodies: neither end of the interval is beyond what a search in all directions
// finds, and both are near it.

#include <gtest/gtest.h>

#include <algorithm>

#include "collision/solid_depth.h"
#include "leeway/collision/distance.h"
#include "tests/collision/mesh_cases.h"
#include "tests/sanitized.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

// The length of the shortest translation of B that separates, of many directions and steps.
double shortest(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB, double far,
                double step, Scratch& scratch) {
  DistanceRequest request;
  request.threshold = 0;
  request.depth = false;
  double best = far;
  constexpr int kDirections = 120;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2 * i + 1.0) / kDirections, r = std::sqrt(1 - z * z), turn = 10.1664 * i;
    const Vector3d direction(r * std::cos(turn), r * std::sin(turn), z);
    for (double length = step; length < best; length += step) {
      Pose moved = X_WB;
      moved.translation += length * direction;
      if (distance(a, X_WA, b, moved, request, scratch).distance.lower > 0) best = length;
    }
  }
  return best;
}

TEST(MeshDepth, IsEnclosedByASearchInAllDirections) {
  Random random(71);
  Scratch scratch;
  const auto meshes = sampleMeshes(71);
  int unsafe = 0, count = 0;
  double lower = 0, upper = 0;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 4; ++j) {
      if (kSanitized && (i + j) % 2 != 0) continue;
      for (int k = 0; k < casesToAsk(2); ++k) {
        const NamedMesh &m = meshes[static_cast<std::size_t>(i)],
                        &n = meshes[static_cast<std::size_t>(j)];
        const Shape a = Shape::mesh(m.mesh), b = Shape::mesh(n.mesh);
        const Pose X_WA = random.pose(0.1), X_WB = random.pose(0.7);
        const DistanceResult r = distance(a, X_WA, b, X_WB, {}, scratch);
        if (!(r.distance.upper <= 0)) continue;
        const double step = 0.02, twin = shortest(a, X_WA, b, X_WB, 2, step, scratch);
        ++count;
        if (-r.distance.upper > twin) {
          ++unsafe;
          ADD_FAILURE() << m.name << " and " << n.name << ": " << twin
                        << " separates, the answer is [" << r.distance.lower << ", "
                        << r.distance.upper << "]";
        }
        lower += -r.distance.lower / twin;
        upper += -r.distance.upper / twin;
        EXPECT_LT(-r.distance.lower, 2 * twin) << m.name << " and " << n.name;
      }
    }
  }
  EXPECT_EQ(unsafe, 0);
  EXPECT_GT(count, kSanitized ? 5 : 25);
  EXPECT_LT(lower, 1.05 * count);
  EXPECT_GT(upper, 0.65 * count);
}

// Of convex solids the deepest balls touch where the shapes part: the depth itself.
TEST(MeshDepth, ByConcentricBallsIsExactForBoxes) {
  Scratch scratch;
  const Shape a = Shape::mesh(named("box", boxSoup({0.5, 0.4, 0.3})).mesh),
              b = Shape::box({0.2, 0.2, 0.2});
  Pose X_WB;
  X_WB.translation = {0.6, 0.1, 0.05};
  const Vector3d start(0.45, 0.1, 0.05);
  EXPECT_NEAR(solidDepth(a, {}, b, X_WB, &start, 1, scratch).depth, 0.1, 1e-9);
  const Vector3d outside(0.9, 0.1, 0.05);
  EXPECT_EQ(solidDepth(a, {}, b, X_WB, &outside, 1, scratch).depth, 0);
}

}  // namespace
}  // namespace leeway::collision
