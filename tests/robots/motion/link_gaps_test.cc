#include "robots/motion/link_gaps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/collision/distance.h"
#include "leeway/robots/kinematics.h"
#include "tests/support/build_paths.h"
#include "tests/support/random_model.h"

namespace leeway::robots {
namespace {

using collision::Shape;
using testing::Random;

double angleOf(const Model& model, int joint, const std::vector<double>& q) {
  const KinematicStep& step = model.steps[at(joint)];
  return step.multiplier * q[at(step.variable)] + step.offset;
}

/// Slow twin: distances of two links at random angles, also full turns away, are never below the
/// gap claimed for these angles and for ranges around them. Counts the claims.
void expectKept(const Model& model, const LinkGap& gap, Random& random, int count, int& told,
                int& near) {
  std::vector<Pose> X_WL(model.links.size());
  collision::Scratch scratch;
  collision::DistanceRequest request;
  request.depth = false;
  for (int i = 0; i < count; ++i) {
    std::vector<double> q = testing::randomConfiguration(random, model);
    for (const int joint : {gap.joint, gap.other})
      q[at(model.steps[at(joint)].variable)] = random.uniform(-9, 9);
    forwardKinematics(model, q, X_WL);
    const double angle = angleOf(model, gap.joint, q), other = angleOf(model, gap.other, q);
    const double width = random.uniform(0, 0.3);
    const double least = gap.over({angle, angle}, {other, other});
    ASSERT_LE(gap.over({angle - width, angle + width}, {other + width, other - width}), least);
    if (least == 0) continue;
    ++told;
    double distance = std::numeric_limits<double>::infinity();
    for (const Geometry& a : model.links[at(gap.link_a)].geometries)
      for (const Geometry& b : model.links[at(gap.link_b)].geometries)
        distance =
            std::min(distance, collision::distance(a.shape, X_WL[at(gap.link_a)] * a.X_BG, b.shape,
                                                   X_WL[at(gap.link_b)] * b.X_BG, request, scratch)
                                   .distance.upper);
    ASSERT_GE(distance, least) << model.links[at(gap.link_a)].name << " and "
                               << model.links[at(gap.link_b)].name << " at " << angle << " and "
                               << other;
    if (distance < 2 * least) ++near;
  }
}

// Chains and branches of neighbouring hulls, mimic joints included.
TEST(LinkGaps, AreKeptOnRandomTrees) {
  Random random(1);
  int pairs = 0, told = 0, near = 0;
  for (int run = 0; run < 60; ++run) {
    const auto model = testing::randomTree(random, 5);
    for (Link& link : model->links) {
      std::vector<Eigen::Vector3d> points;
      for (int i = 0; i < 12; ++i) points.push_back(random.vector(0.12));
      link.geometries.push_back({Shape::convexHull(points), random.pose(0.15), ""});
    }
    for (const LinkGap& gap : provenGaps(*model)) {
      ++pairs;
      expectKept(*model, gap, random, 200, told, near);
      if (HasFatalFailure()) return;
    }
  }
  EXPECT_GT(pairs, 20);
  EXPECT_GT(told, 1000);
  EXPECT_GT(near, 30);
}

// Upper arms over bases, and wrists next to forearms: the tables' purpose.
TEST(LinkGaps, AreKeptByArms) {
  for (const std::string arm : {"panda", "ur5"}) {
    LEEWAY_NEEDS_DATA("robots/" + arm);
    const std::string file = dataFolder() + "/robots/" + arm + "/" + arm;
    const auto model = loadModel(file + ".urdf", file + ".srdf");
    Random random(2);
    int told = 0, near = 0;
    for (const LinkGap& gap : model->linkGaps()) {
      expectKept(*model, gap, random, 400, told, near);
      if (HasFatalFailure()) return;
    }
    EXPECT_GE(model->linkGaps().size(), 4U);
    EXPECT_GT(told, 800);
    EXPECT_GT(near, 200);
  }
}

}  // namespace
}  // namespace leeway::robots
