#include "leeway/collision/pose_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace leeway::collision {
namespace {

using Key = PoseMotion::Key;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Pose posed(const Eigen::Vector3d& position, const Eigen::Vector3d& axis, double angle) {
  return {Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(), position};
}

double apart(const Pose& x, const Pose& y) {
  return (x.translation - y.translation).norm() + (x.rotation - y.rotation).norm();
}

class Numbers {
 public:
  double in(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Eigen::Vector3d vector(double size) {
    return {in(-size, size), in(-size, size), in(-size, size)};
  }
  Pose pose() { return posed(vector(2), vector(1), in(-3, 3)); }

 private:
  std::mt19937 engine_{5};
};

TEST(PoseMotion, PassesItsKeysAndRestsBeyondThem) {
  const Pose a = posed({0, 0, 0}, {0, 0, 1}, 0.2), b = posed({1, 0, 2}, {0, 1, 0}, 1.2),
             c = posed({1, 1, 1}, {1, 0, 0}, -2);
  const auto motion = PoseMotion::keys({{1, a}, {3, b}, {3.5, c}});
  EXPECT_EQ(motion->keyPoses().size(), 3u);
  EXPECT_FALSE(motion->isSteady());
  EXPECT_LT(apart(motion->pose(-5), a), 1e-14);
  EXPECT_LT(apart(motion->pose(1), a), 1e-14);
  EXPECT_LT(apart(motion->pose(3), b), 1e-14);
  EXPECT_LT(apart(motion->pose(std::nextafter(3.0, 0)), b), 1e-13);
  EXPECT_LT(apart(motion->pose(3.5), c), 1e-14);
  EXPECT_LT(apart(motion->pose(1e9), c), 1e-14);
  EXPECT_EQ(motion->speedBound(-5, 1, 1), 0);
  EXPECT_EQ(motion->speedBound(3.5, 9, 1), 0);
  EXPECT_TRUE(std::isnan(motion->pose(kNan).translation.x()));
}

/// The slow twin: Eigen's slerp.
TEST(PoseMotion, GoesStraightAndTurnsTheShorterWay) {
  Numbers random;
  int turned = 0;
  for (int i = 0; i < 300; ++i) {
    const Key a{random.in(-5, 5), random.pose()};
    const Key b{a.time + random.in(0.01, 4), random.pose()};
    const Eigen::Quaterniond from(a.X_WB.rotation), to(b.X_WB.rotation);
    turned += from.angularDistance(to) > 2 ? 1 : 0;
    const auto motion = PoseMotion::keys({a, b});
    for (const double s : {0.0, 0.2, 0.5, 0.9, 1.0}) {
      const Pose X = motion->pose(a.time + s * (b.time - a.time));
      const Eigen::Vector3d p = (1 - s) * a.X_WB.translation + s * b.X_WB.translation;
      EXPECT_LT(apart(X, {from.slerp(s, to).toRotationMatrix(), p}), 1e-12);
    }
  }
  EXPECT_GT(turned, 50);
}

TEST(PoseMotion, ASteadyMotionHasNoEnd) {
  const Pose X = posed({1, 2, 3}, {1, 1, 0}, 0.7);
  const auto motion = PoseMotion::steady({2, X}, {0.5, 0, -1}, {0, 0, 3});
  EXPECT_TRUE(motion->isSteady());
  for (const double t : {-40.0, 0.0, 2.0, 7.5, 100.0}) {
    const Pose expected = posed({1 + 0.5 * (t - 2), 2, 3 - (t - 2)}, {0, 0, 1}, 3 * (t - 2));
    EXPECT_LT(apart(motion->pose(t), {expected.rotation * X.rotation, expected.translation}),
              1e-12);
  }
  EXPECT_NEAR(motion->speedBound(0, 1, 0.5), std::sqrt(1.25) + 1.5, 1e-9);
  const auto still = PoseMotion::steady({0, X}, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  EXPECT_LT(apart(still->pose(1e6), X), 1e-14);
  EXPECT_EQ(still->speedBound(0, 1e6, 1), 0);
}

TEST(PoseMotion, NoPointIsFasterThanTheBound) {
  Numbers random;
  double tightest = 0;
  for (int i = 0; i < 200; ++i) {
    std::vector<Key> keys;
    for (int k = 0; k < 5; ++k)
      keys.push_back({k == 0 ? 0 : keys.back().time + random.in(0.05, 2), random.pose()});
    const auto motion = i % 4 == 0 ? PoseMotion::steady(keys[0], random.vector(3), random.vector(5))
                                   : PoseMotion::keys(keys);
    const double t0 = random.in(-1, 4), t1 = t0 + random.in(0, 3), reach = random.in(0, 2);
    const double bound = motion->speedBound(t0, t1, reach),
                 rounding = motion->rounding(t0, t1, reach);
    EXPECT_LT(rounding, 1e-11);
    const Eigen::Vector3d p = reach * random.vector(1).normalized();
    double moved = 0, most = 0;
    for (int s = 0; s < 100; ++s) {
      const double a = t0 + (t1 - t0) * s / 100, b = t0 + (t1 - t0) * (s + 1) / 100;
      const double step = (motion->pose(a) * p - motion->pose(b) * p).norm();
      EXPECT_LE(step, bound * (b - a) + 2 * rounding);
      most = std::max(most, step / (b - a));
      moved += step;
    }
    EXPECT_LE((motion->pose(t0) * p - motion->pose(t1) * p).norm(), moved + 1e-12);
    if (bound > 0) tightest = std::max(tightest, most / bound);
  }
  EXPECT_GT(tightest, 0.9);
}

TEST(PoseMotion, RoundingIsUnboundedWhereAnglesAre) {
  const auto motion = PoseMotion::steady({0, {}}, Eigen::Vector3d::Zero(), {0, 0, 100});
  EXPECT_LT(motion->rounding(0, 10, 1), 1e-10);
  EXPECT_TRUE(std::isinf(motion->rounding(0, 1e4, 1)));
}

TEST(PoseMotion, RefusesWhatMakesNoSense) {
  const auto refused = [](const auto& make, const std::string& part) {
    try {
      make();
      ADD_FAILURE() << "accepted: " << part;
    } catch (const InvalidMotion& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  refused([] { PoseMotion::keys({}); }, "at least one");
  refused([] { PoseMotion::keys({{0, {}}, {0, {}}}); }, "keys[1].time is not after");
  refused([] { PoseMotion::keys({{kNan, {}}}); }, "keys[0].time");
  refused([] { PoseMotion::keys({{1e300, {}}}); }, "keys[0].time is 1e+300 s");
  Pose bad;
  bad.translation.x() = kNan;
  refused([&] { PoseMotion::keys({{0, bad}}); }, "keys[0]: the position");
  bad = {};
  bad.rotation(0, 0) = -1;
  refused([&] { PoseMotion::keys({{0, {}}, {1, bad}}); }, "keys[1]: the orientation");
  const Pose half = posed(none, {0, 0, 1}, std::numbers::pi);
  refused([&] { PoseMotion::keys({{0, {}}, {1, half}}); }, "half a turn");
  refused([&] { PoseMotion::steady({0, {}}, {kNan, 0, 0}, none); }, "the velocity");
  refused([&] { PoseMotion::steady({0, {}}, none, {0, 1e10, 0}); }, "the angular velocity");
  refused(
      [&] {
        PoseMotion::keys({{0, {}}, {1e-15, {Eigen::Matrix3d::Identity(), {1, 0, 0}}}});
      },
      "too soon");
}

/// Rotations that are only nearly orthogonal do not make motions jump at keys.
TEST(PoseMotion, MeetsKeysWhoseRotationsAreInexact) {
  Pose a, b = posed({0, 0, 0}, {0, 0, 1}, 1);
  a.rotation *= 1 + 2e-7;
  b.rotation *= 1 - 2e-7;
  const auto motion = PoseMotion::keys({{0, a}, {1, b}, {2, a}});
  EXPECT_LT(apart(motion->pose(std::nextafter(1.0, 0)), motion->pose(1)), 1e-14);
  EXPECT_LT((motion->pose(0.3).rotation * motion->pose(0.3).rotation.transpose() -
             Eigen::Matrix3d::Identity())
                .norm(),
            1e-14);
}

}  // namespace
}  // namespace leeway::collision
