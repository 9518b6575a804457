// Bodies of a change that are moved.

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "leeway/collision/scene.h"

namespace leeway::collision {
namespace {

Pose at(double x) {
  Pose pose;
  pose.translation.x() = x;
  return pose;
}

Body ball(const std::string& name, double x, bool moving = false) {
  return {name, {{Shape::sphere(0.1), {}, name}}, moving, at(x)};
}

/// A moving ball at the origin, a post at 1, and two balls that a change added at 2 and 3.
Scene changedScene() {
  SceneBuilder builder;
  builder.add(ball("moving", 0, true));
  builder.add(ball("post", 1));
  SceneChange change(std::move(builder).build());
  EXPECT_EQ(change.add(ball("second", 2)), 2);
  EXPECT_EQ(change.add(ball("third", 3)), 3);
  change.setMargin(0, 3, 0.25);
  return std::move(change).build();
}

double clearanceOf(const Scene& scene) {
  Workspace workspace(scene);
  workspace.setPose(0, at(0));
  return clearance(scene, workspace, 1e-9).clearance.upper;
}

TEST(ScenePoses, MovedBodiesAreFoundWhereTheyAre) {
  const Scene before = changedScene();
  EXPECT_NEAR(clearanceOf(before), 0.8, 1e-9);
  Scene scene = before;
  const std::vector<std::pair<int, Pose>> near = {{3, at(-0.5)}, {2, at(50)}};
  scene.setPoses(near);
  EXPECT_NEAR(clearanceOf(scene), 0.3, 1e-9);
  EXPECT_NEAR(clearanceOf(before), 0.8, 1e-9);  // copies do not move
  EXPECT_EQ(scene.bodies()[3].X_WB.translation.x(), -0.5);
  const std::vector<std::pair<int, Pose>> nearer = {{2, at(0.25)}};
  scene.setPoses(nearer);
  EXPECT_NEAR(clearanceOf(scene), 0.05, 1e-9);
  const std::vector<std::pair<int, Pose>> away = {{2, at(9)}, {3, at(0.4)}};
  scene.setPoses(away);
  Workspace workspace(scene);
  workspace.setPose(0, at(0));
  EXPECT_EQ(decide(scene, workspace).verdict, Verdict::kNotFree);  // 0.2, at a margin of 0.25
  EXPECT_EQ(scene.pairs().size(), before.pairs().size());
}

TEST(ScenePoses, OthersAreRefused) {
  Scene scene = changedScene();
  const auto refused = [&](int body, double x) {
    const std::vector<std::pair<int, Pose>> poses = {{2, at(7)}, {body, at(x)}};
    EXPECT_THROW(scene.setPoses(poses), std::invalid_argument);
    EXPECT_EQ(scene.bodies()[2].X_WB.translation.x(), 2);  // nothing has changed
  };
  refused(0, 0);
  refused(1, 0);
  refused(4, 0);
  refused(-1, 0);
  refused(3, std::numeric_limits<double>::quiet_NaN());
  SceneChange change(scene);
  change.remove(3);
  scene = std::move(change).build();
  refused(3, 0);
  scene.setPoses({});
}

}  // namespace
}  // namespace leeway::collision
