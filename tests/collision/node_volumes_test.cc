#include "collision/node_volumes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "collision/deform_build.h"
#include "tests/collision/motion_cases.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;

std::vector<Vector3d> positionsOf(const VertexMotion& motion, std::span<const double> parameters) {
  std::vector<Vector3d> positions(static_cast<std::size_t>(motion.vertexCount()));
  motion.vertices(parameters, 0, positions);
  return positions;
}

/// Exact to about 64 bits: how far the farthest vertex is from the centre.
double reachOf(const Vector3d& center, std::span<const std::int32_t> vertices,
               const std::vector<Vector3d>& positions) {
  long double reach = 0;
  for (const std::int32_t v : vertices) {
    reach = std::max(reach, (positions[static_cast<std::size_t>(v)].cast<long double>() -
                             center.cast<long double>())
                                .norm());
  }
  return static_cast<double>(reach);
}

/// Sets of neighbouring vertices, from few to all: the children of a hierarchy's nodes.
template <class Check>
void forSets(const motion_cases::MotionCase& c, Check check) {
  const auto tree = buildDeformTree(c.mesh.vertices, c.mesh.triangles, DeformMethod::kBinned, 64);
  std::vector<std::int32_t> all(c.mesh.vertices.size());
  std::iota(all.begin(), all.end(), 0);
  check(all);
  for (std::int32_t node = 0; node < tree->nodeCount(); ++node) {
    for (int lane = 0; lane < kWidth; ++lane) {
      const std::span<const std::int32_t> vertices = tree->vertices(node, lane);
      if (!vertices.empty()) check(vertices);
    }
  }
}

TEST(NodeVolumes, BlendedBallsAndDopsHoldTheirVertices) {
  int sets = 0, kinds = 0;
  for (const motion_cases::MotionCase& c : motion_cases::allMotions(16, 31)) {
    const auto* motion = dynamic_cast<const BlendedMotion*>(c.motion.get());
    if (motion == nullptr) continue;
    ++kinds;
    Random random(32);
    double balls = 0, exact = 0, dops = 0, exact_dops = 0;
    std::vector<double> parameters(static_cast<std::size_t>(motion->parameterCount()));
    forSets(c, [&](std::span<const std::int32_t> vertices) {
      const BlendedVolumes volumes(*motion, vertices);
      for (int i = 0; i < 6; ++i) {
        motion->parameters(random.uniform(-1, 4), parameters);
        const std::vector<Vector3d> positions = positionsOf(*motion, parameters);
        const BoundingBall ball = volumes.ball(parameters);
        const double reach = reachOf(ball.center, vertices, positions);
        ASSERT_LE(reach, ball.radius) << c.name << ", " << vertices.size() << " vertices";
        const Dop18 dop = volumes.dop(parameters);
        for (std::size_t k = 0; k < Dop18::kDirections; ++k) {
          double low = 1e300, high = -1e300;
          for (const std::int32_t v : vertices) {
            const double along = alongDop(positions[static_cast<std::size_t>(v)])[k];
            low = std::min(low, along);
            high = std::max(high, along);
          }
          ASSERT_LE(dop.low[k], low) << c.name << " direction " << k;
          ASSERT_GE(dop.high[k], high) << c.name << " direction " << k;
          dops += dop.high[k] - dop.low[k];
          exact_dops += high - low;
        }
        balls += ball.radius;
        exact += reach;
        ++sets;
      }
    });
    RecordProperty(c.name + ", radius over reach", std::to_string(balls / exact));
    RecordProperty(c.name + ", width over exact", std::to_string(dops / exact_dops));
    EXPECT_LT(balls / exact, 2.5) << c.name << ": the balls are idle";
    EXPECT_LT(dops / exact_dops, 2.5) << c.name << ": the 18-DOPs are idle";
  }
  EXPECT_EQ(kinds, 5);
  EXPECT_GT(sets, 1500);
}

TEST(NodeVolumes, SkinnedBallsHoldTheirVertices) {
  int sets = 0, kinds = 0;
  for (const motion_cases::MotionCase& c : motion_cases::allMotions(16, 33)) {
    const auto* motion = dynamic_cast<const SkinnedVertices*>(c.motion.get());
    if (motion == nullptr) continue;
    ++kinds;
    Random random(34);
    double balls = 0, exact = 0;
    std::vector<double> parameters(static_cast<std::size_t>(motion->parameterCount()));
    forSets(c, [&](std::span<const std::int32_t> vertices) {
      const SkinnedBall skinned(*motion, vertices);
      for (int i = 0; i < 6; ++i) {
        motion->parameters(random.uniform(-1, 4), parameters);
        const BoundingBall ball = skinned.ball(parameters);
        const double reach = reachOf(ball.center, vertices, positionsOf(*motion, parameters));
        ASSERT_LE(reach, ball.radius) << c.name << ", " << vertices.size() << " vertices";
        balls += ball.radius;
        exact += reach;
        ++sets;
      }
    });
    RecordProperty(c.name + ", radius over reach", std::to_string(balls / exact));
    EXPECT_LT(balls / exact, 1.6) << c.name << ": the balls are idle";
  }
  EXPECT_EQ(kinds, 2);
  EXPECT_GT(sets, 500);
}

}  // namespace
}  // namespace leeway::collision
