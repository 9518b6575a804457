// The fields of the messages in MoveIt's scenes and requests (moveit_msgs, shape_msgs,
// geometry_msgs, ... of ROS 1 and ROS 2). Most readers look up a field by its name and use the
// default if it is missing. Without this check, they would ignore a misspelt field.

#include <map>
#include <string_view>
#include <vector>

#include "planner/problem/moveit/fields.h"

namespace leeway::planner {
namespace {

/// A field and the message that it holds: empty for numbers and texts, NAME[] for a list.
struct Field {
  std::string_view name, message;
};

struct Message {
  std::vector<Field> fields;
  bool may_be_plain = false;  ///< accepts a list of values, or a number for a time, as well
};

const std::map<std::string_view, Message>& messages() {
  static const std::map<std::string_view, Message> kMessages = {
      {"PlanningScene",
       {{{"name", ""},
         {"robot_state", "RobotState"},
         {"robot_model_name", ""},
         {"fixed_frame_transforms", "TransformStamped[]"},
         {"allowed_collision_matrix", "AllowedCollisionMatrix"},
         {"link_padding", "LinkPadding[]"},
         {"link_scale", "LinkScale[]"},
         {"object_colors", "ObjectColor[]"},
         {"world", "PlanningSceneWorld"},
         {"is_diff", ""}}}},
      {"MotionPlanRequest",
       {{{"workspace_parameters", "WorkspaceParameters"},
         {"start_state", "RobotState"},
         {"goal_constraints", "Constraints[]"},
         {"path_constraints", "Constraints"},
         {"trajectory_constraints", "TrajectoryConstraints"},
         {"reference_trajectories", "GenericTrajectory[]"},
         {"pipeline_id", ""},
         {"planner_id", ""},
         {"group_name", ""},
         {"num_planning_attempts", ""},
         {"allowed_planning_time", ""},
         {"motion_execution_time_factor", ""},
         {"max_velocity_scaling_factor", ""},
         {"max_acceleration_scaling_factor", ""},
         {"cartesian_speed_end_effector_link", ""},
         {"cartesian_speed_limited_link", ""},
         {"max_cartesian_speed", ""}}}},
      {"RobotState",
       {{{"joint_state", "JointState"},
         {"multi_dof_joint_state", "MultiDOFJointState"},
         {"attached_collision_objects", "AttachedCollisionObject[]"},
         {"is_diff", ""}}}},
      {"JointState",
       {{{"header", "Header"}, {"name", ""}, {"position", ""}, {"velocity", ""}, {"effort", ""}}}},
      {"MultiDOFJointState",
       {{{"header", "Header"},
         {"joint_names", ""},
         {"transforms", "Transform[]"},
         {"twist", "Twist[]"},
         {"wrench", "Wrench[]"}}}},
      {"AttachedCollisionObject",
       {{{"link_name", ""},
         {"object", "CollisionObject"},
         {"touch_links", ""},
         {"detach_posture", "JointTrajectory"},
         {"weight", ""}}}},
      {"PlanningSceneWorld",
       {{{"collision_objects", "CollisionObject[]"}, {"octomap", "OctomapWithPose"}}}},
      {"OctomapWithPose", {{{"header", "Header"}, {"origin", "Pose"}, {"octomap", "Octomap"}}}},
      {"Octomap",
       {{{"header", "Header"}, {"binary", ""}, {"id", ""}, {"resolution", ""}, {"data", ""}}}},
      {"CollisionObject",
       {{{"header", "Header"},
         {"pose", "Pose"},
         {"id", ""},
         {"type", "ObjectType"},
         {"primitives", "SolidPrimitive[]"},
         {"primitive_poses", "Pose[]"},
         {"meshes", "Mesh[]"},
         {"mesh_poses", "Pose[]"},
         {"planes", "Plane[]"},
         {"plane_poses", "Pose[]"},
         {"subframe_names", ""},
         {"subframe_poses", "Pose[]"},
         {"operation", ""}}}},
      {"ObjectType", {{{"key", ""}, {"db", ""}}}},
      {"SolidPrimitive", {{{"type", ""}, {"dimensions", ""}, {"polygon", "Polygon"}}}},
      {"Polygon", {{{"points", "Point[]"}}}},
      // Robowflex and MotionBenchMaker add `resource` and `dimensions`.
      {"Mesh",
       {{{"triangles", "MeshTriangle[]"},
         {"vertices", "Point[]"},
         {"resource", ""},
         {"dimensions", ""}}}},
      {"MeshTriangle", {{{"vertex_indices", ""}}, true}},
      {"Plane", {{{"coef", ""}}}},
      {"AllowedCollisionMatrix",
       {{{"entry_names", ""},
         {"entry_values", "AllowedCollisionEntry[]"},
         {"default_entry_names", ""},
         {"default_entry_values", ""}}}},
      {"AllowedCollisionEntry", {{{"enabled", ""}}, true}},
      {"LinkPadding", {{{"link_name", ""}, {"padding", ""}}}},
      {"LinkScale", {{{"link_name", ""}, {"scale", ""}}}},
      {"ObjectColor", {{{"id", ""}, {"color", "ColorRGBA"}}}},
      {"ColorRGBA", {{{"r", ""}, {"g", ""}, {"b", ""}, {"a", ""}}, true}},
      {"Constraints",
       {{{"name", ""},
         {"joint_constraints", "JointConstraint[]"},
         {"position_constraints", "PositionConstraint[]"},
         {"orientation_constraints", "OrientationConstraint[]"},
         {"visibility_constraints", "VisibilityConstraint[]"}}}},
      {"JointConstraint",
       {{{"joint_name", ""},
         {"position", ""},
         {"tolerance_above", ""},
         {"tolerance_below", ""},
         {"weight", ""}}}},
      {"PositionConstraint",
       {{{"header", "Header"},
         {"link_name", ""},
         {"target_point_offset", "Point"},
         {"constraint_region", "BoundingVolume"},
         {"weight", ""}}}},
      {"BoundingVolume",
       {{{"primitives", "SolidPrimitive[]"},
         {"primitive_poses", "Pose[]"},
         {"meshes", "Mesh[]"},
         {"mesh_poses", "Pose[]"}}}},
      {"OrientationConstraint",
       {{{"header", "Header"},
         {"orientation", "Quaternion"},
         {"link_name", ""},
         {"absolute_x_axis_tolerance", ""},
         {"absolute_y_axis_tolerance", ""},
         {"absolute_z_axis_tolerance", ""},
         {"parameterization", ""},
         {"weight", ""}}}},
      {"VisibilityConstraint",
       {{{"target_radius", ""},
         {"target_pose", "PoseStamped"},
         {"cone_sides", ""},
         {"sensor_pose", "PoseStamped"},
         {"max_view_angle", ""},
         {"max_range_angle", ""},
         {"sensor_view_direction", ""},
         {"weight", ""}}}},
      {"TrajectoryConstraints", {{{"constraints", "Constraints[]"}}}},
      {"GenericTrajectory",
       {{{"header", "Header"},
         {"joint_trajectory", "JointTrajectory[]"},
         {"cartesian_trajectory", "CartesianTrajectory[]"}}}},
      {"CartesianTrajectory",
       {{{"header", "Header"}, {"tracked_frame", ""}, {"points", "CartesianTrajectoryPoint[]"}}}},
      {"CartesianTrajectoryPoint", {{{"point", "CartesianPoint"}, {"time_from_start", "Time"}}}},
      {"CartesianPoint", {{{"pose", "Pose"}, {"velocity", "Twist"}, {"acceleration", "Accel"}}}},
      {"JointTrajectory",
       {{{"header", "Header"}, {"joint_names", ""}, {"points", "JointTrajectoryPoint[]"}}}},
      {"JointTrajectoryPoint",
       {{{"positions", ""},
         {"velocities", ""},
         {"accelerations", ""},
         {"effort", ""},
         {"time_from_start", "Time"}}}},
      {"WorkspaceParameters",
       {{{"header", "Header"}, {"min_corner", "Point"}, {"max_corner", "Point"}}}},
      {"Header", {{{"seq", ""}, {"stamp", "Time"}, {"frame_id", ""}}}},
      {"Time", {{{"secs", ""}, {"nsecs", ""}, {"sec", ""}, {"nanosec", ""}}, true}},
      {"TransformStamped",
       {{{"header", "Header"}, {"child_frame_id", ""}, {"transform", "Transform"}}}},
      {"Transform", {{{"translation", "Point"}, {"rotation", "Quaternion"}}}},
      {"PoseStamped", {{{"header", "Header"}, {"pose", "Pose"}}}},
      {"Pose", {{{"position", "Point"}, {"orientation", "Quaternion"}}}},
      {"Twist", {{{"linear", "Point"}, {"angular", "Point"}}}},
      {"Accel", {{{"linear", "Point"}, {"angular", "Point"}}}},
      {"Wrench", {{{"force", "Point"}, {"torque", "Point"}}}},
      {"Point", {{{"x", ""}, {"y", ""}, {"z", ""}}, true}},
      {"Quaternion", {{{"x", ""}, {"y", ""}, {"z", ""}, {"w", ""}}, true}},
  };
  return kMessages;
}

}  // namespace

void expectMessage(const YamlReader& reader, std::string_view name) {
  if (reader.isEmpty() || name.empty()) return;
  if (name.ends_with("[]")) {
    name.remove_suffix(2);
    reader.eachItem([&](const YamlReader& item) { expectMessage(item, name); });
    return;
  }
  const Message& message = messages().at(name);
  if (!reader.isMap() && message.may_be_plain) return;
  std::vector<std::string_view> known;
  for (const Field& field : message.fields) known.push_back(field.name);
  reader.expectKeys(known);
  for (const Field& field : message.fields)
    if (const auto value = reader.find(field.name))
      reader.readOn([&] { expectMessage(*value, field.message); });
}

}  // namespace leeway::planner
