#pragma once

// Private to planner/: the frames that headers of MoveIt's messages name.

#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// Where a frame is: on a link, or in the world (link -1).
struct FramePlace {
  int link = -1;
  robots::Pose X_LF;
};

/// The frames that a header may name, as MoveIt looks them up: the planning frame, links, what they
/// hold, objects, and fixed_frame_transforms. Links stand where the start has them.
class HeaderFrames {
 public:
  HeaderFrames(Problem& problem, robots::Stop stop) : problem_(problem), stop_(std::move(stop)) {}

  /// Fails unless the header of a message names the planning frame, or no frame.
  void expectPlanningFrame(const YamlReader& message);
  /// Reads fixed_frame_transforms. Call it after reading the start.
  void readTransforms(const YamlReader& scene);
  /// Sets where the scene's own state has the robot. Its objects refer to that, and frames that
  /// stand elsewhere at the start are refused for them.
  void setSceneState(std::vector<double> configuration);

  /// Returns the pose in the world of the frame in the header of an object of the scene.
  robots::Pose ofObject(const YamlReader& message);
  /// Returns the frame's pose in a link that holds the object. `of_scene`: the scene attaches it,
  /// not the request.
  robots::Pose inLink(const YamlReader& message, int link, bool of_scene);
  /// The same for an object of the world. `place`: in messages.
  robots::Pose inLink(const YamlReader& place, const robots::Pose& X_WO, int link, bool of_scene);
  /// Returns the pose in the world of the frame in the header of a constraint. Fails for a frame
  /// that planned joints move.
  robots::Pose ofConstraint(const YamlReader& message);
  /// Warns that positions without a frame are in the world, if the robot's base was placed
  /// elsewhere. Once.
  void warnOfPlacedBase(const std::string& file, int line, const std::string& what);

 private:
  FramePlace find(const YamlReader& message);
  FramePlace find(const YamlReader& id, const std::string& name);
  bool isWorld(const std::string& name) { return name == "world" || name == parentFrame(); }
  bool hasFixedBase() const;
  const std::string& parentFrame();
  /// MoveIt's planning frame: the virtual joint's parent_frame, or the root link that is fixed.
  const std::string& planningFrame();
  robots::Pose linkPose(int link, const std::vector<double>& configuration);
  robots::Pose startPose(const FramePlace& place);
  void readTransform(const YamlReader& entry);
  robots::Pose inLink(const YamlReader& place, const FramePlace& of, int link, bool of_scene);

  Problem& problem_;
  robots::Stop stop_;
  std::optional<std::string> parent_frame_;  // once it was needed
  std::map<std::string, robots::Pose> transforms_;
  std::vector<double> scene_state_;  // empty: the start
  std::vector<double> placed_at_;    // where X_WL_ has the links
  std::vector<robots::Pose> X_WL_;
  // Objects of the world, as far as they were looked at.
  std::unordered_map<std::string, robots::Pose> objects_;
  std::size_t seen_ = 0;
  bool warned_ = false;
};

}  // namespace leeway::planner
