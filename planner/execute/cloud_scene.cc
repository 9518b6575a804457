#include "planner/execute/cloud_scene.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>
#include <vector>

#include "leeway/robots/input_error.h"
#include "planner/base/tolerances.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

/// An object of which margins and contacts know the name.
Object nameOnly(const std::string& name) { return {name, {}, {}}; }

}  // namespace

CloudScene::CloudScene(const Problem& problem, const Object& object)
    : alone_(problem), number_(problem.world.objects.size()) {
  std::vector<Object>& objects = alone_.world.objects;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (objects[i].name == object.name)
      number_ = i;
    else
      objects[i] = nameOnly(objects[i].name);
  }
  for (const DeformingObstacle& obstacle : alone_.world.deforming)
    objects.push_back(nameOnly(obstacle.object.name));
  alone_.world.deforming.clear();
  // Only poses that are known in advance move it in its scene; what was seen stays where it is.
  if (!object.motion->poses) objects[number_].motion = nullptr;
  scene_ = compiled(alone_);
}

std::shared_ptr<const CompiledScene> CloudScene::compiled(const Problem& alone) {
  const CompiledScene all(alone);
  return all.withPairs([&](const collision::ScenePair& pair) { return !all.isOfRobot(pair); });
}

std::string CloudScene::fault(const PointCloud* cloud, const robots::Pose& X_WO) {
  if (cloud == nullptr) return "is missing; a cloud is expected";
  if (!cloud->crops.empty())
    return "was cropped, and what it lacks may move; a cloud that is not cropped is expected";
  if (const std::string of_balls = cloudFault(*cloud); !of_balls.empty()) return ": " + of_balls;
  if (const std::string of_pose = poseFault(X_WO); !of_pose.empty()) return ": its pose " + of_pose;
  return carveFault(*cloud, X_WO);
}

void CloudScene::replace(std::shared_ptr<const PointCloud> cloud, const robots::Pose& X_WO) {
  if (const std::string wrong = fault(cloud.get(), X_WO); !wrong.empty())
    throw std::invalid_argument(
        fmt::format("cloud '{}'{}{}", object().name, wrong.starts_with(':') ? "" : " ", wrong));
  Problem next = alone_;
  Object& changed = next.world.objects[number_];
  changed.cloud = std::move(cloud);
  changed.X_WO = X_WO;
  changed.motion = nullptr;
  try {
    scene_ = compiled(next);
  } catch (const robots::InputError& error) {
    throw std::invalid_argument(error.what());
  }
  alone_ = std::move(next);
}

std::shared_ptr<const CompiledScene> CloudScene::at(const robots::Pose& X_WO) const {
  const Object& cloud = object();
  const bool is_there =
      X_WO.translation == cloud.X_WO.translation && X_WO.rotation == cloud.X_WO.rotation;
  if (is_there || !cloud.motion) return scene_;
  const CompiledScene::Replacement moved{scene_->scene().find(cloud.name), 0, X_WO, 0};
  return scene_->withShapes({&moved, 1});
}

Object CloudScene::standing(const robots::Pose& X_WO, double growth) const {
  Object object = this->object();
  object.X_WO = X_WO;
  object.motion = nullptr;
  if (!(growth > 0)) return object;
  PointCloud grown = *cloud();
  for (PointCloud::Ball& ball : grown.balls)
    ball.radius = (ball.radius + growth) * (1 + kGrowthRounding);
  object.cloud = std::make_shared<const PointCloud>(std::move(grown));
  return object;
}

Problem withoutMovingClouds(const Problem& problem) {
  Problem without = problem;
  for (Object& object : without.world.objects)
    if (object.cloud && object.motion) object = nameOnly(object.name);
  return without;
}

}  // namespace leeway::planner
