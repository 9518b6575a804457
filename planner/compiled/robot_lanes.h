#pragma once

// Private to planner/: the part of EdgeLanes that depends only on the robot.

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "collision/lanes/lane_frames.h"
#include "collision/lanes/lane_sweep.h"
#include "leeway/collision/scene.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/model.h"
#include "planner/compiled/edge_model.h"

namespace leeway::planner {

/// Frames of the moving joints, bounds on accelerations, and the geometries as pieces and obstacles
/// of a collision::LaneSweep. Constant.
struct RobotLanes {
  /// The members of a PreparedRobot from which lanes are made.
  struct Source {
    const collision::Scene& scene;
    std::span<const int> carriers;
    const RobotMotions& motions;
    std::span<const int> variables;
    std::span<const robots::VariableRange> ranges;
  };
  /// O(vertices) for the first robot with these meshes, later O(points of their covers).
  RobotLanes(const robots::Model& model, const Source& robot);

  /// A joint that turns or slides: a step between two frames, the upper one with its z axis along
  /// the joint's. A floating joint has two steps; the second turns its frame back to the link's
  /// axes.
  struct Step {
    int joint;
    collision::Pose X_PJ;      ///< from the frame below it to the joint, joint at rest
    bool restores = false;     ///< the second step of a floating joint
    std::size_t variable = 0;  ///< its own or its master's, by which it turns or slides
    double multiplier = 1, offset = 0;
  };
  std::vector<Step> steps;
  std::vector<collision::FrameStep> frame_steps;  ///< shared by all edges
  int deepest = 0;                                ///< steps of the deepest chain

  /// Growth of RobotMotions::motions, with the same numbers.
  collision::LaneGrowth growth;
  std::vector<char> is_bounded;  ///< whether `growth` can bound each motion

  /// A geometry in `sweep`.
  struct Piece {
    int piece = -1;     ///< -1: none
    int obstacle = -1;  ///< if it stands still; -1: none
    double reach = 0;   ///< of the piece [m]
  };
  std::vector<Piece> pieces;   ///< one per geometry of PreparedRobot::scene()
  collision::LaneSweep sweep;  ///< with these pieces and obstacles; scenes copy it
};

/// Adds a geometry of the world to a sweep as an obstacle and, if balls are tighter than its box,
/// as a piece. `outer`: its ball, in the world; `place`: see LaneSweep::addObstacle().
RobotLanes::Piece addStill(const collision::Geometry& geometry, const collision::Pose& X_WB,
                           const collision::Ball& outer, collision::LaneSweep& sweep,
                           int place = -1);

/// A rotation that turns z onto the unit vector `axis`, orthogonal to rounding.
inline Eigen::Matrix3d turningZ(const Eigen::Vector3d& axis) {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d u, v;
  robots::planeAxes(axis, u, v);
  rotation << u, v, axis;
  return rotation;
}

inline void copyMatrix(const Eigen::Matrix3d& m, float* out) {
  for (int i = 0; i < 9; ++i) out[i] = static_cast<float>(m.data()[i]);
}

inline void copyVector(const Eigen::Vector3d& v, float* out) {
  for (int i = 0; i < 3; ++i) out[i] = static_cast<float>(v[i]);
}

}  // namespace leeway::planner
