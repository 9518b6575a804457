#include "robots/inverse/reach_proof.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <string>

#include "collision/base/numbers.h"
#include "leeway/robots/kinematics.h"
#include "tests/support/build_paths.h"
#include "tests/support/random_model.h"
#include "tests/support/sanitized.h"

namespace leeway::robots {
namespace {

using testing::Random;

/// A configuration within the limits, with variables that are often at a limit.
std::vector<double> nearLimits(Random& random, const Model& model) {
  std::vector<double> q = testing::randomConfiguration(random, model);
  for (std::size_t v = 0; v < q.size(); ++v)
    if (random.integer(3) == 0 && std::isfinite(model.variables[v].lower))
      q[v] = random.integer(2) == 0 ? model.variables[v].lower : model.variables[v].upper;
  return q;
}

/// Tries the proof for the pose of `link` at a random configuration, in regions of random widths
/// around it. True if the proof that it cannot be there succeeds, wrongly.
bool wronglyProven(Random& random, const Model& model, int link, int limit) {
  const auto q = nearLimits(random, model);
  auto configuration = testing::randomConfiguration(random, model);
  std::vector<int> column(q.size(), -1);
  std::vector<double> lower, upper;
  for (std::size_t v = 0; v < q.size(); ++v) {
    if (random.integer(6) == 0) {
      configuration[v] = q[v];
      continue;
    }
    column[v] = static_cast<int>(lower.size());
    lower.push_back(model.variables[v].lower);
    upper.push_back(model.variables[v].upper);
  }
  std::vector<Pose> X_WL(model.links.size());
  forwardKinematics(model, q, X_WL);
  const Pose X_WR = random.pose(1), X_LF = random.pose(0.3);
  PoseRegion region = PoseRegion::exact(link, X_LF, X_WR, X_WR.inverse() * (X_WL[at(link)] * X_LF));
  for (auto* ranges : {&region.position, &region.rpy})
    for (auto& range : *ranges)
      if (random.integer(4) == 0) {
        range.first -= random.uniform(0, 0.3);
        range.second += random.uniform(0, 4);
      }
  forwardKinematics(model, configuration, X_WL);
  const Chain chain = makeChain(model, region, X_WL, column);
  return proveUnreachable(chain, region, configuration, lower, upper, limit).proven;
}

TEST(ReachProof, NeverForAPoseOfAConfiguration) {
  Random random(21);
  const int rounds = bySanitizer(25'000, 1'000, 200);
  for (const std::string name : {"arm6", "arm7", "snake10", "dual_arm"}) {
    const auto model = loadModel(sourceFolder() + "/robots/" + name + "/" + name + ".urdf", "");
    for (int i = 0; i < rounds; ++i) {
      const int link = static_cast<int>(model->links.size()) - 1 - random.integer(3);
      ASSERT_FALSE(wronglyProven(random, *model, link, i % 500 == 0 ? 1000 : 12))
          << name << " " << i;
    }
  }
}

TEST(ReachProof, NeverForAPoseOfARandomTree) {
  Random random(22);
  for (int tree = 0; tree < (kSanitized ? 100 : 2'000); ++tree) {
    const auto model = testing::randomTree(random, 3 + random.integer(8));
    for (int i = 0; i < 5; ++i)
      ASSERT_FALSE(
          wronglyProven(random, *model, random.integer(static_cast<int>(model->links.size())), 100))
          << tree << " " << i;
  }
}

ReachProof prove(const Model& model, const PoseRegion& region, std::int64_t limit) {
  const auto q = model.defaultConfiguration();
  std::vector<int> column;
  std::vector<double> lower, upper;
  for (const Variable& v : model.variables) {
    column.push_back(static_cast<int>(lower.size()));
    lower.push_back(v.lower);
    upper.push_back(v.upper);
  }
  std::vector<Pose> X_WL(model.links.size());
  forwardKinematics(model, q, X_WL);
  return proveUnreachable(makeChain(model, region, X_WL, column), region, q, lower, upper, limit);
}

// 1 cm beyond the greatest distance of the wrist from the shoulder, in all directions and
// rotations.
TEST(ReachProof, JustBeyondTheReach) {
  const auto model = loadModel(sourceFolder() + "/robots/arm7/arm7.urdf", "");
  const int link = model->findLink("hand");
  Random random(5);
  std::vector<Pose> X_WL(model->links.size());
  // The wrist is where the last two axes meet. It is farthest from the shoulder when the arm is
  // stretched.
  forwardKinematics(*model, model->defaultConfiguration(), X_WL);
  const Eigen::Vector3d shoulder = X_WL[at(model->joints[at(2)].child_link)].translation;
  const Eigen::Vector3d hand = X_WL[at(link)].translation;
  double beyond = 0;
  for (int i = 0; i < 20'000; ++i) {
    forwardKinematics(*model, testing::randomConfiguration(random, *model), X_WL);
    beyond = std::max(beyond, (X_WL[at(link)].translation - shoulder).norm());
  }
  ASSERT_GT(beyond, 0.9 * (hand - shoulder).norm());
  for (int i = 0; i < 100; ++i) {
    const Pose X_WF{random.rotation(), shoulder + 1.05 * beyond * random.direction()};
    EXPECT_TRUE(prove(*model, PoseRegion::exact(link, {}, {}, X_WF), 100'000).proven) << i;
  }
}

TEST(ReachProof, WhatJointsCannotDo) {
  const auto body = freeBody("box", {}, JointType::kPlanar, {-1, -1, 0}, {1, 1, 0});
  PoseRegion region = PoseRegion::exact(0, {}, {}, {});
  EXPECT_FALSE(prove(*body, region, 10'000).proven);
  region.position[2] = {0.1, 0.2};  // it does not leave the plane,
  EXPECT_TRUE(prove(*body, region, 10'000).proven);
  region = PoseRegion::exact(0, {}, {}, {rotationOf({0.1, 0, 0}), Eigen::Vector3d::Zero()});
  EXPECT_TRUE(prove(*body, region, 10'000).proven);  // nor tilts,
  region.rpy[0] = {-0.1, 0};
  EXPECT_FALSE(prove(*body, region, 10'000).proven);
  region.position[0] = {1.01, 2};  // and its x ends at 1
  EXPECT_TRUE(prove(*body, region, 10'000).proven);
  region.position[0] = {1, 2};
  EXPECT_FALSE(prove(*body, region, 10'000).proven);
}

// A pose outside by more than the tolerance and rounding is out of reach; outside by less it is
// not.
TEST(ReachProof, Tolerances) {
  const auto body = freeBody("box", {}, JointType::kPlanar, {-1, -1, 0}, {1, 1, 0});
  PoseRegion region = PoseRegion::exact(0, {}, {}, {});
  region.position_tolerance = 1e-3;
  region.position[2] = {0.99e-3, 0.99e-3};
  EXPECT_FALSE(prove(*body, region, 10'000).proven);
  region.position[2] = {1.01e-3, 1.01e-3};
  EXPECT_TRUE(prove(*body, region, 10'000).proven);
}

}  // namespace
}  // namespace leeway::robots
