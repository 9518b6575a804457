#include "leeway/robots/link_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "leeway/robots/kinematics.h"
#include "tests/support/random_model.h"

namespace leeway::robots {
namespace {

using testing::Random;

TEST(LinkMotion, MovesAsKinematicsAndWithinItsBounds) {
  Random random(3);
  double tightest_speed = 0, tightest_acceleration = 0;
  for (int i = 0; i < 200; ++i) {
    const std::shared_ptr<Model> model = testing::randomTree(random, 6);
    const std::vector<double> q0 = testing::randomConfiguration(random, *model);
    const std::vector<double> dq = testing::randomDifference(random, *model, q0);
    const int link = static_cast<int>(model->links.size()) - 1;
    const LinkMotion motion(model, link, q0, dq);
    std::vector<Pose> X_WL(model->links.size());
    const Eigen::Vector3d p = random.direction();
    const collision::FrameMotionBound bound = motion.bound(0, 1);
    for (int k = 0; k < 5; ++k) {
      const double t = random.uniform(0.05, 0.95), h = 1e-4;
      forwardKinematics(*model, testing::advanced(*model, q0, dq, t), X_WL);
      const Pose truth = X_WL[static_cast<std::size_t>(link)];
      const Pose before = motion.pose(t - h), now = motion.pose(t), after = motion.pose(t + h);
      EXPECT_LE((now.translation - truth.translation).norm(), 1e-13);
      EXPECT_LE((now.rotation - truth.rotation).norm(), 1e-13);
      const collision::FrameVelocity v = motion.velocity(t);
      const Eigen::Vector3d r = now.rotation * p;
      EXPECT_LE(((after * p - before * p) / (2 * h) - v.linear - v.angular.cross(r)).norm(), 1e-4)
          << "tree " << i;
      EXPECT_LE(v.linear.norm(), bound.speed * (1 + 1e-12));
      EXPECT_LE(v.angular.norm(), bound.angular_speed * (1 + 1e-12));
      const double second =
          (after.translation - 2 * now.translation + before.translation).norm() / (h * h);
      EXPECT_LE(second, bound.acceleration + 1e-4);
      const collision::FrameVelocity v0 = motion.velocity(t - h), v1 = motion.velocity(t + h);
      EXPECT_LE((v1.angular - v0.angular).norm() / (2 * h), bound.angular_acceleration + 1e-4);
      if (bound.speed > 0) tightest_speed = std::max(tightest_speed, v.linear.norm() / bound.speed);
      if (bound.acceleration > 0)
        tightest_acceleration = std::max(tightest_acceleration, second / bound.acceleration);
    }
  }
  EXPECT_GT(tightest_speed, 0.8);  // the bounds are not useless
  EXPECT_GT(tightest_acceleration, 0.5);
}

TEST(LinkMotion, RefusesWhatIsNotThere) {
  Random random(4);
  const std::shared_ptr<Model> model = testing::randomTree(random, 3);
  const std::vector<double> q(model->variables.size(), 0.0), wrong(q.size() + 1, 0.0);
  EXPECT_THROW(LinkMotion(model, 3, q, q), std::invalid_argument);
  EXPECT_THROW(LinkMotion(model, -1, q, q), std::invalid_argument);
  EXPECT_THROW(LinkMotion(model, 0, q, wrong), std::invalid_argument);
}

/// Slow twin by sampling: rates that change within their limits never move a point faster than
/// claimed. In every fourth case joints are faster than their limits to begin with.
TEST(PointMotion, BoundsSpeedsAndTheirChange) {
  Random random(9);
  double tightest = 0;
  for (int i = 0; i < 200; ++i) {
    const std::shared_ptr<Model> model = testing::randomTree(random, 5);
    const std::size_t n = model->variables.size();
    const int link = static_cast<int>(model->links.size()) - 1;
    const Eigen::Vector3d center = random.vector(0.3);
    const double radius = 0.2;
    const RelativeMotion relative = relativeMotion(*model, link, -1, center, radius);
    std::vector<double> velocity(n), velocity_limits(n), acceleration_limits(n);
    for (std::size_t k = 0; k < n; ++k) {
      velocity_limits[k] = random.uniform(0, 2);
      velocity[k] = random.uniform(-1, 1) * velocity_limits[k] * (i % 4 == 0 ? 3 : 1);
      acceleration_limits[k] = random.uniform(0, 5);
    }
    const collision::PointMotion m =
        pointMotion(*model, relative, velocity, {velocity_limits, acceleration_limits});
    EXPECT_LE(m.speed, m.speed_cap * (1 + 1e-12));
    // Along q(s) = q0 + v s + a s^2 / 2 for joints with one variable, by differences.
    bool simple = true;
    for (const Joint& joint : model->joints) simple = simple && joint.variable_count <= 1;
    if (!simple) continue;
    const std::vector<double> q0 = testing::randomConfiguration(random, *model);
    std::vector<double> a(n);
    for (std::size_t k = 0; k < n; ++k) a[k] = random.uniform(-1, 1) * acceleration_limits[k];
    const Eigen::Vector3d p = center + radius * random.direction();
    const auto at = [&](double s) {
      std::vector<double> q(n);
      for (std::size_t k = 0; k < n; ++k) q[k] = q0[k] + velocity[k] * s + a[k] * s * s / 2;
      std::vector<Pose> X_WL(model->links.size());
      forwardKinematics(*model, q, X_WL);
      return Eigen::Vector3d(X_WL[static_cast<std::size_t>(link)] * p);
    };
    const double h = 1e-4;
    const double speed = (at(h) - at(-h)).norm() / (2 * h);
    const double second = (at(h) - 2 * at(0) + at(-h)).norm() / (h * h);
    EXPECT_LE(speed, m.speed + 1e-5) << i;
    EXPECT_LE(second, m.acceleration + 1e-4) << i;
    if (m.speed > 0) tightest = std::max(tightest, speed / m.speed);
  }
  EXPECT_GT(tightest, 0.7);
}

}  // namespace
}  // namespace leeway::robots
