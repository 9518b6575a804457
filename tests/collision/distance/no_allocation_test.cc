#include <gtest/gtest.h>

#include "leeway/collision/distance.h"
#include "tests/support/allocations.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

TEST(Allocation, QueriesOfConvexShapesAllocateNothing) {
  oracle::Random random(5);
  Scratch scratch;
  PairCache cache;
  const ShapeType types[8] = {ShapeType::kSphere,    ShapeType::kCapsule,   ShapeType::kBox,
                              ShapeType::kCylinder,  ShapeType::kCone,      ShapeType::kEllipsoid,
                              ShapeType::kHalfSpace, ShapeType::kConvexHull};
  long queries = 0, overlapping = 0;
  for (const ShapeType type_a : types) {
    for (const ShapeType type_b : types) {
      for (const oracle::Flavour flavour : oracle::kFlavours) {
        const Shape a = oracle::randomShape(random, type_a, flavour);
        const Shape b = oracle::randomShape(random, type_b, oracle::Flavour::kPlain);
        for (const double apart : {0.0, 0.1, 0.6, 1.5}) {
          const double size = oracle::sizeOf(a) + oracle::sizeOf(b);
          const Pose X_WA{random.rotation(), apart * size * random.direction()};
          const Pose X_WB{random.rotation(), Eigen::Vector3d::Zero()};
          Pose X_BA1 = X_WA;
          X_BA1.translation += 0.1 * size * random.direction();
          const std::size_t before = testing::allocationCount();
          const DistanceResult r = distance(a, X_WA, b, X_WB, {}, scratch, &cache);
          sweptDistance(a, X_WA, X_BA1, 0.01, b, {}, scratch, &cache);
          ASSERT_EQ(testing::allocationCount(), before)
              << toString(type_a) << " " << toString(type_b);
          ++queries;
          overlapping += r.distance.upper < 0;
        }
      }
    }
  }
  EXPECT_EQ(queries, 8 * 8 * 6 * 4);
  EXPECT_GT(overlapping, queries / 10);
}

TEST(Allocation, AQueryWithoutScratchAnswersAsOneWithIt) {
  oracle::Random random(6);
  Scratch scratch;
  for (int i = 0; i < 200; ++i) {
    const Shape a = oracle::randomShape(random, ShapeType::kConvexHull, oracle::Flavour::kPlain);
    const Shape b = oracle::randomShape(random, ShapeType::kCylinder, oracle::Flavour::kPlain);
    const Pose X_WA{random.rotation(),
                    0.5 * (oracle::sizeOf(a) + oracle::sizeOf(b)) * random.direction()};
    const DistanceResult own = distance(a, X_WA, b, {});
    const DistanceResult given = distance(a, X_WA, b, {}, {}, scratch);
    EXPECT_EQ(own.distance.lower, given.distance.lower);
    EXPECT_EQ(own.distance.upper, given.distance.upper);
    EXPECT_EQ(own.normal, given.normal);
    EXPECT_EQ(own.status, given.status);
  }
}

}  // namespace
}  // namespace leeway::collision
