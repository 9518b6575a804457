#pragma once

// Private to planner/: fields of MoveIt's messages, as YAML. Fields without a bearing on geometry
// or joints are ignored. One that would change the problem and is not supported is an error.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// True for a value that is there and not empty.
bool hasContent(const std::optional<YamlReader>& value);

/// Fails if the key has content. `accepted` names what is expected in its place.
void refuseContent(const YamlReader& map, std::string_view key, std::string_view accepted);

/// {position, orientation} or {translation, rotation}.
robots::Pose readMoveitPose(const YamlReader& map, const char* translation, const char* rotation,
                            std::vector<std::string>& warnings);

/// Objects of a moveit_msgs/PlanningScene, into problem.world.
void readSceneObjects(const YamlReader& scene, Problem& problem);

/// Its allowed_collision_matrix, into problem.contacts; after the objects.
void readAllowedCollisions(const YamlReader& scene, Problem& problem);

/// One entry of position_constraints: the point of a link in a box within its primitive. And one of
/// orientation_constraints. Neither allows more than MoveIt does (constraints.cc).
robots::PoseRegion readPositionConstraint(const YamlReader& constraint, Problem& problem);
robots::PoseRegion readOrientationConstraint(const YamlReader& constraint, Problem& problem);

/// Group, start and goals of a moveit_msgs/MotionPlanRequest.
void readRequestGroup(const YamlReader& request, Problem& problem);
void readRequestStates(const YamlReader& request, Problem& problem);

}  // namespace leeway::planner
