// The same bytes from every instruction set that this machine has: targets forced one by one.

#include <gtest/gtest.h>

#include "collision/simd/targets.h"
//
#include <hwy/highway.h>

#include <cstring>
#include <vector>

#include "collision/convex.h"
#include "collision/hull_support.h"
#include "collision/support.h"
#include "leeway/collision/distance.h"
#include "tools/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;

Shape roundHull(Random& random, int count) {
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) points.push_back(random.direction());
  return Shape::convexHull(points);
}

/// The numbers of many queries, cold and with a cache, of all types and sizes of hulls.
std::vector<double> answers() {
  constexpr ShapeType kTypes[] = {ShapeType::kBox, ShapeType::kCapsule, ShapeType::kCylinder,
                                  ShapeType::kEllipsoid, ShapeType::kConvexHull};
  Random random(61);
  Scratch scratch;
  PairCache cache;
  std::vector<double> all;
  for (int i = 0; i < 1500; ++i) {
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

TEST(InstructionSets, DistancesAreTheSameBytes) {
  const std::vector<double> best = answers();
  int targets = 0;
  // Not those that this compiler made no code for: a call would go nowhere.
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().DeInit();
    const std::vector<double> other = answers();
    ++targets;
    ASSERT_EQ(best.size(), other.size());
    EXPECT_EQ(std::memcmp(best.data(), other.data(), best.size() * sizeof(double)), 0)
        << hwy::TargetName(target);
    hwy::SetSupportedTargetsForTest(0);
  }
  hwy::GetChosenTarget().DeInit();
  EXPECT_GE(targets, 1);
}

/// Vector scans and climbs against the plain scan: the same vertex, or one within rounding; of
/// equal ones the first where all are looked at.
TEST(HullSupport, FindsTheFarthestVertex) {
  Random random(62);
  int scanned = 0, climbed = 0, tied = 0;
  for (int i = 0; i < 120; ++i) {
    const int count = 1 + random.below(i % 3 == 0 ? 300 : 90);
    std::vector<Vector3d> points;
    const bool grid = random.chance(0.3);
    for (int k = 0; k < count; ++k) {
      points.push_back(grid ? Vector3d(random.below(3), random.below(3), random.below(3))
                            : random.direction());
    }
    const Shape shape = Shape::convexHull(points);
    const ConvexView view = viewOf(shape);
    ASSERT_NE(view.support, nullptr);
    const bool scans = view.support->length() > 0;
    (scans ? scanned : climbed) += 1;
    for (int k = 0; k < 100; ++k) {
      Vector3d d = random.direction();
      if (random.chance(0.3)) d = Vector3d::Unit(random.below(3)) * (random.chance(0.5) ? 1 : -1);
      const int found = farthestPoint(view, d, random.below(view.count));
      int expected = 0, equal = 0;
      double most = -1e300;
      for (int v = 0; v < view.count; ++v) {
        const Vector3d& p = view.points[v];
        const double value = p.x() * d.x() + p.y() * d.y() + p.z() * d.z();
        equal = value > most ? 1 : equal + (value == most ? 1 : 0);
        if (value > most) {
          most = value;
          expected = v;
        }
      }
      tied += equal > 1 ? 1 : 0;
      if (scans) {
        EXPECT_EQ(found, expected);
      } else {
        EXPECT_GE(view.points[found].dot(d), most - 8 * kUnitRoundoff * view.extent);
      }
    }
  }
  EXPECT_GT(scanned, 50);
  EXPECT_GT(climbed, 10);
  EXPECT_GT(tied, 500);
}

}  // namespace
}  // namespace leeway::collision
