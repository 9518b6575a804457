#include "leeway/collision/pose.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstddef>

#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

TEST(Pose, IsTheIsometryItIsMadeFrom) {
  oracle::Random random(1);
  for (int i = 0; i < 100; ++i) {
    Eigen::Isometry3d X_AB = Eigen::Isometry3d::Identity();
    X_AB.linear() = random.rotation();
    X_AB.translation() = 3 * random.direction();
    const Pose pose = Pose::fromIsometry(X_AB);
    EXPECT_EQ(pose.rotation, X_AB.linear());
    EXPECT_EQ(pose.translation, X_AB.translation());
    EXPECT_EQ(pose.toIsometry().matrix(), X_AB.matrix());
    const Eigen::Vector3d p_B = random.direction();
    EXPECT_LT((pose * p_B - X_AB * p_B).norm(), 1e-14);
  }
}

// -march must not change the layout: the alignment is that of a double.
TEST(Pose, HasThePlainLayoutOfTwelveDoubles) {
  EXPECT_EQ(sizeof(Pose), 12 * sizeof(double));
  EXPECT_EQ(alignof(Pose), alignof(double));
}

}  // namespace
}  // namespace leeway::collision
