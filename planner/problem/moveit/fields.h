#pragma once

// Private to planner/: fields of MoveIt's messages, as YAML. Fields that change neither geometry
// nor joints are ignored. A field that would change the problem and is not supported is an error. A
// field that the message does not have is an error too.

#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "leeway/planner/problem.h"
#include "planner/problem/other_formats.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

class HeaderFrames;

/// Fails if the message `name` ("PlanningScene") or one inside it has a key that is not a field of
/// it, or a value that is not a message where one is expected. O(keys * fields).
void expectMessage(const YamlReader& reader, std::string_view name);

/// Whether a value exists and is not empty. A map of empty values is empty.
bool hasContent(const std::optional<YamlReader>& value);

/// Fails if the key has content. `accepted` says what is expected instead.
void refuseContent(const YamlReader& map, std::string_view key, std::string_view accepted);

/// Reads a truth value: true or false, or True or False as ROS 1 prints them.
bool readMoveitBoolean(const YamlReader& reader);

/// Reads a point: a list of three numbers, or x, y, z.
Eigen::Vector3d readMoveitVector(const YamlReader& reader);

/// Reads a unit quaternion: a list x y z w, or a map. Takes all zeros for the identity, with a
/// warning.
Eigen::Vector4d readMoveitQuaternion(const YamlReader& reader, std::vector<std::string>& warnings);

/// Reads {position, orientation} or {translation, rotation}.
robots::Pose readMoveitPose(const YamlReader& map, const char* translation, const char* rotation,
                            std::vector<std::string>& warnings);

/// The pose of a half-space (z <= 0 of its frame) whose surface is the plane normal . p + offset =
/// 0, and which fills the side opposite to the normal. Empty if the normal is zero.
std::optional<robots::Pose> halfSpacePose(const Eigen::Vector3d& normal, double offset);

/// Reads a moveit_msgs/CollisionObject in the frame of its header: primitives, meshes and planes.
/// The caller checks that there is a shape.
Object readCollisionObject(const YamlReader& map, const robots::LoadOptions& load,
                           std::vector<std::string>& warnings);

/// Adds objects to problem.world. Each must have a shape and a unique name.
class SceneObjects {
 public:
  explicit SceneObjects(Problem& problem);
  void add(const std::string& file, int line, Object object);

 private:
  Problem& problem_;
  std::unordered_set<std::string> names_;
};

/// Reads objects of a moveit_msgs/PlanningScene into problem.world.
void readSceneObjects(const YamlReader& scene, const robots::LoadOptions& load,
                      HeaderFrames& frames, Problem& problem);

/// Reads objects of MoveIt's text format (.scene) into problem.world.
void readTextScene(const std::string& path, const robots::LoadOptions& load, Problem& problem);

/// Reads the objects that the robot holds at the problem's start into problem.robot.attachments,
/// from the request's start_state and the scene's robot_state. `scene` may be null. Call it after
/// reading start and objects.
void readAttachedObjects(const YamlReader* scene, const YamlReader& request,
                         const robots::LoadOptions& load, HeaderFrames& frames, Problem& problem);

/// Reads `link_padding` of a scene, and refuses a `link_scale` other than 1.
LinkPadding readLinkPadding(const YamlReader& scene, const robots::Model& model);

/// Reads allowed_collision_matrix into problem.contacts. Call it after reading all objects,
/// including attached ones.
void readAllowedCollisions(const YamlReader& scene, Problem& problem);

/// Reads one entry of position_constraints (the point of a link in a box within its primitive) or
/// of orientation_constraints. Neither allows more than MoveIt does (constraints.cc).
robots::PoseRegion readPositionConstraint(const YamlReader& constraint, HeaderFrames& frames,
                                          Problem& problem);
robots::PoseRegion readOrientationConstraint(const YamlReader& constraint, HeaderFrames& frames,
                                             Problem& problem);

/// Add the same to the constraints of the problem's paths. Neither allows more than MoveIt does. An
/// orientation that may be any is left out, with a warning.
void readPathPosition(const YamlReader& constraint, HeaderFrames& frames, Problem& problem);
void readPathOrientation(const YamlReader& constraint, HeaderFrames& frames, Problem& problem);

/// Read group, start and goals of a moveit_msgs/MotionPlanRequest. The start also takes what only
/// the scene's robot_state says; `scene` may be null. Goals may be relative to all else.
void readRequestGroup(const YamlReader& request, Problem& problem);
void readRequestStart(const YamlReader* scene, const YamlReader& request, HeaderFrames& frames,
                      Problem& problem);
void readRequestGoals(const YamlReader& request, HeaderFrames& frames, Problem& problem);

}  // namespace leeway::planner
