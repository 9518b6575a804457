#pragma once

// Private to planner/: a cloud that moves or is seen again, in a scene of its own.

#include <memory>
#include <string>

#include "leeway/planner/compiled_scene.h"

namespace leeway::planner {

/// The scene of a robot and one cloud, with only their pairs.
class CloudScene {
 public:
  /// `object`: one of the problem's, with a cloud and a motion. O(balls log(balls)), and O(balls)
  /// for each of the robot's shapes.
  CloudScene(const Problem& problem, const Object& object);

  /// Returns what is wrong with a cloud that was seen at X_WO; empty: nothing. O(balls).
  static std::string fault(const PointCloud* cloud, const robots::Pose& X_WO);
  /// Puts another cloud in place of the cloud, at X_WO. Its motion is no longer known. Throws
  /// std::invalid_argument, and changes nothing, for what fault() names and for more balls than a
  /// scene can have. Costs what the constructor costs.
  void replace(std::shared_ptr<const PointCloud> cloud, const robots::Pose& X_WO);

  const std::shared_ptr<const PointCloud>& cloud() const { return object().cloud; }
  const std::shared_ptr<const CompiledScene>& scene() const { return scene_; }
  /// The scene with the cloud at X_WO; the same pairs as scene(). O(1) at the pose of scene(),
  /// O(balls log(balls)) at another one.
  std::shared_ptr<const CompiledScene> at(const robots::Pose& X_WO) const;
  /// The object at X_WO, standing still, with balls greater by `growth` [m]. Shapes that it has
  /// besides stay as they are.
  Object standing(const robots::Pose& X_WO, double growth) const;

 private:
  const Object& object() const { return alone_.world.objects[number_]; }
  static std::shared_ptr<const CompiledScene> compiled(const Problem& alone);

  Problem alone_;       ///< all other obstacles are only names in it
  std::size_t number_;  ///< of the cloud among the objects
  std::shared_ptr<const CompiledScene> scene_;
};

/// The problem without its clouds that move, of which only the names stay.
Problem withoutMovingClouds(const Problem& problem);

}  // namespace leeway::planner
