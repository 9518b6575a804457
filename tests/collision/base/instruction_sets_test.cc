// Every instruction set of this machine, forced in turn, returns equal bytes.

#include <gtest/gtest.h>

#include <vector>

#include "leeway/collision/distance.h"
#include "tests/support/every_target.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;

Shape roundHull(Random& random, int count) {
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) points.push_back(random.direction());
  return Shape::convexHull(points);
}

/// Answers of many queries, cold and cached, over all shape types and hull sizes.
std::vector<double> answers() {
  constexpr ShapeType kTypes[] = {ShapeType::kBox, ShapeType::kCapsule, ShapeType::kCylinder,
                                  ShapeType::kEllipsoid, ShapeType::kConvexHull};
  Random random(61);
  Scratch scratch;
  PairCache cache;
  std::vector<double> all;
  for (int i = 0; i < casesToAsk(1500); ++i) {
    const auto any = [&] {
      return random.chance(0.4) ? roundHull(random, 4 + random.below(130))
                                : oracle::randomShape(
                                      random, kTypes[random.below(5)],
                                      oracle::kFlavours[static_cast<std::size_t>(random.below(6))]);
    };
    const Shape a = any(), b = any();
    const double reach = oracle::sizeOf(a) + oracle::sizeOf(b);
    const Pose X_WA{random.rotation(), {0, 0, 0}};
    const Pose X_WB{random.chance(0.2) ? X_WA.rotation : random.rotation(),
                    reach * random.uniform(0, 1.3) * random.direction()};
    DistanceRequest request;
    if (random.chance(0.3)) request.threshold = reach * random.uniform(-0.2, 0.5);
    const Pose X_WE{random.rotation(), X_WA.translation + 0.3 * reach * random.direction()};
    const DistanceResult swept = sweptDistance(a, X_WA, X_WE, 0.01 * reach, b, request, scratch);
    all.insert(all.end(), {swept.distance.lower, swept.distance.upper, double(swept.iterations)});
    for (PairCache* with : {static_cast<PairCache*>(nullptr), &cache}) {
      const DistanceResult r = distance(a, X_WA, b, X_WB, request, scratch, with);
      all.insert(all.end(),
                 {r.distance.lower, r.distance.upper, double(r.iterations), r.point_a.x(),
                  r.point_a.y(), r.point_a.z(), r.point_b.x(), r.point_b.y(), r.point_b.z(),
                  r.normal.x(), r.normal.y(), r.normal.z(), double(static_cast<int>(r.status))});
    }
  }
  return all;
}

TEST(InstructionSets, DistancesAreTheSameBytes) { expectTheSameBytesOnEveryTarget(answers); }

}  // namespace
}  // namespace leeway::collision
