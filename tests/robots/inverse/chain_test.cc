#include "robots/inverse/chain.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "leeway/robots/kinematics.h"
#include "robots/inverse/arc_tangent.h"
#include "robots/inverse/region.h"
#include "tests/support/random_model.h"

namespace leeway::robots {
namespace {

using testing::Random;

// The chain's pose equals that of forwardKinematics(), and its twists are central differences of
// it.
TEST(Chain, PosesAndTwistsOfRandomTrees) {
  Random random(4);
  int compared = 0;
  for (int tree = 0; tree < 100; ++tree) {
    const auto model = testing::randomTree(random, 3 + random.integer(10));
    std::vector<int> column(model->variables.size(), -1);
    int columns = 0;
    for (int& c : column)
      if (random.integer(4) > 0) c = columns++;
    PoseRegion region;
    region.link = static_cast<int>(model->links.size()) - 1;
    region.X_LF = random.pose(0.3);
    region.X_WR = random.pose(1);
    const auto configuration = testing::randomConfiguration(random, *model);
    std::vector<Pose> X_WL(model->links.size());
    forwardKinematics(*model, configuration, X_WL);
    const Chain chain = makeChain(*model, region, X_WL, column);

    auto q = testing::randomConfiguration(random, *model);
    for (std::size_t v = 0; v < q.size(); ++v)
      if (column[v] < 0) q[v] = configuration[v];
    const auto slow = [&](const std::vector<double>& values) {
      forwardKinematics(*model, values, X_WL);
      return region.X_WR.inverse() * (X_WL[static_cast<std::size_t>(region.link)] * region.X_LF);
    };
    std::vector<Twist> twists;
    std::vector<Pose> X_RC;
    const Pose X_RF = place(chain, q.data(), X_RC), expected = slow(q);
    findTwists(chain, q.data(), X_RC, X_RF, twists);
    EXPECT_LT((X_RF.rotation - expected.rotation).norm(), 1e-13);
    EXPECT_LT((X_RF.translation - expected.translation).norm(), 1e-13);
    for (std::size_t v = 0; v < q.size(); ++v) {
      if (column[v] < 0) continue;
      Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
      for (const Twist& twist : twists)
        if (twist.column == column[v]) {
          linear += twist.linear;
          angular += twist.angular;
          ++compared;
        }
      const double h = 1e-5;
      auto more = q, less = q;
      more[v] += h;
      less[v] -= h;
      const Pose X_more = slow(more), X_less = slow(less);
      const Eigen::Vector3d slope = (X_more.translation - X_less.translation) / (2 * h);
      const Eigen::Vector3d turn =
          rotationVector(X_more.rotation * X_less.rotation.transpose()) / (2 * h);
      EXPECT_LT((linear - slope).norm(), 1e-8);
      EXPECT_LT((angular - turn).norm(), 1e-8);
    }
  }
  EXPECT_GT(compared, 300);
}

TEST(ArcTangent, LikeTheCLibrary) {
  Random random(1);
  for (int i = 0; i < 100'000; ++i) {
    const double size = std::pow(10, random.uniform(-200, 200));
    double y = size * random.uniform(-1, 1), x = size * random.uniform(-1, 1);
    if (i % 4 == 0) y *= std::pow(10, random.uniform(-20, 0));
    if (i % 4 == 1) x *= std::pow(10, random.uniform(-20, 0));
    const double expected = std::atan2(y, x);
    EXPECT_NEAR(arcTangent(y, x), expected, 4e-16 * (1 + std::fabs(expected))) << y << " " << x;
  }
  EXPECT_EQ(arcTangent(0, 0), 0);
  EXPECT_EQ(arcTangent(0, 1), 0);
  EXPECT_EQ(arcTangent(0, -1), std::numbers::pi);
  EXPECT_DOUBLE_EQ(arcTangent(-2, 0), -std::numbers::pi / 2);
}

TEST(RollPitchYaw, AndBack) {
  Random random(8);
  for (int i = 0; i < 20'000; ++i) {
    Eigen::Vector3d angles(random.uniform(-3, 3), random.uniform(-1.5, 1.5), random.uniform(-3, 3));
    const double quarter = std::numbers::pi / 2;
    if (i % 5 == 0) angles(1) = (i % 2 == 0 ? 1 : -1) * quarter;
    if (i % 5 == 1) angles(1) = quarter - std::pow(10, random.uniform(-17, -3));
    const Eigen::Matrix3d R = rotationOf(angles);
    const Eigen::Matrix3d slow = (Eigen::AngleAxisd(angles(2), Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(angles(1), Eigen::Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(angles(0), Eigen::Vector3d::UnitX()))
                                     .toRotationMatrix();
    EXPECT_LT((R - slow).norm(), 2e-15);
    const Eigen::Vector3d back = rollPitchYaw(R);
    EXPECT_LT((rotationOf(back) - R).norm(), 5e-12) << angles.transpose();
    if (i % 5 > 1) {
      EXPECT_LT((back - angles).norm(), 2e-14);
    }
  }
}

TEST(RotationVector, OfTurnsUpToHalf) {
  Random random(6);
  for (int i = 0; i < 20'000; ++i) {
    const Eigen::Vector3d axis = random.direction();
    double angle = random.uniform(0, std::numbers::pi);
    if (i % 3 == 0) angle = std::pow(10, random.uniform(-16, 0));
    if (i % 3 == 1) angle = std::numbers::pi - std::pow(10, random.uniform(-6, 0));
    const Eigen::Matrix3d R = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    EXPECT_LT((rotationVector(R) - angle * axis).norm(), 3e-15 * (1 + angle)) << angle;
  }
}

// The error is never below that of brute force over the allowed angles, and not above it where it
// is small.
TEST(RegionError, NearestRotationOfRanges) {
  Random random(12);
  int outside = 0;
  for (int i = 0; i < 300; ++i) {
    PoseRegion region;
    region.link = 0;
    region.position.fill({0, 0});
    for (auto& range : region.rpy) {
      range.first = random.uniform(-4, 4);
      range.second = range.first + (random.integer(2) == 0 ? 0 : random.uniform(0, 1));
    }
    const Eigen::Vector3d inside(random.uniform(region.rpy[0].first, region.rpy[0].second),
                                 random.uniform(region.rpy[1].first, region.rpy[1].second),
                                 random.uniform(region.rpy[2].first, region.rpy[2].second));
    const double away = random.uniform(0, 0.3);
    const Pose X_RF{
        Eigen::AngleAxisd(away, random.direction()).toRotationMatrix() * rotationOf(inside),
        Eigen::Vector3d::Zero()};
    const PreparedRegion prepared(region);
    const RegionError error = regionError(prepared, X_RF);
    double least = 10;
    const int steps = 8;
    for (int a = 0; a <= steps; ++a)
      for (int b = 0; b <= steps; ++b)
        for (int c = 0; c <= steps; ++c) {
          const auto value = [&](std::size_t k, int n) {
            return region.rpy[k].first + (region.rpy[k].second - region.rpy[k].first) * n / steps;
          };
          const Eigen::Matrix3d R = rotationOf({value(0, a), value(1, b), value(2, c)});
          least = std::min(least, rotationVector(X_RF.rotation * R.transpose()).norm());
        }
    EXPECT_GT(error.turn.norm(), least - 0.2) << i;
    if (std::fabs(std::cos(inside(1))) > 0.3) {
      EXPECT_LT(error.turn.norm(), least + 1e-6) << i;
      EXPECT_LE(error.turn.norm(), away + 1e-9);
      outside += error.turn.norm() > 1e-9 ? 1 : 0;
      for (int k = 0; k < error.free_turns; ++k)
        EXPECT_LT(std::fabs(error.free_axis[static_cast<std::size_t>(k)].dot(error.turn)), 1e-6);
    }
    const Pose exactly{rotationOf(inside), Eigen::Vector3d::Zero()};
    EXPECT_LT(regionError(prepared, exactly).turn.norm(), 1e-12);
  }
  EXPECT_GT(outside, 100);
}

}  // namespace
}  // namespace leeway::robots
