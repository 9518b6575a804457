#pragma once

// Private to planner/: the data of a CompiledScene for the certification of edges.

#include <memory>
#include <span>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/motion_bound.h"

namespace leeway::planner {

class PreparedRobot;  // prepared_robot.h

/// How the bodies of a scene's pairs move along any edge, and how exact their poses are. Constant.
struct EdgeModel {
  /// One pair of collision::Scene::pairs() between two bodies of the robot.
  struct Pair {
    int motion;  ///< index into `motions`: how body a moves relative to body b; for a static b,
                 ///< relative to the world
    bool is_reversed;  ///< `motion` is that of b relative to a: of two moving bodies, the one near
                       ///< the joints between them moves less
    int gap = -1;      ///< index into `gaps`; -1: no proof
  };
  std::vector<Pair> pairs;
  /// The robot's motions. Pairs share them and need not use all.
  std::span<const robots::RelativeMotion> motions;
  /// A joint's angle is multiplier * a number of a point + offset [rad]; if place < 0, it is the
  /// offset.
  struct Angle {
    int place;
    double multiplier, offset;
  };
  /// The gap between a pair's links, proven by two joints' angles.
  struct Gap {
    const robots::LinkGap* table;
    Angle joint, other;
    double most;  ///< that the table proves at any angles [m]
  };
  std::span<const Gap> gaps;
  std::shared_ptr<const PreparedRobot> robot;

  /// The distance of any point of a moving body from its exact position, by exact kinematics at the
  /// exact point of the edge, is at most this [m]; it is added to every bound.
  double rounding = 0;
  /// `rounding` holds for bodies within this distance of the world's origin [m]: a distance beyond
  /// all limits, or the largest one supported for an unlimited joint.
  double reach = 0;
  /// A circle in which some mimic joint is not periodic.
  struct JumpingCircle {
    int place;  ///< in a point
    int mimic;  ///< the joint
  };
  std::vector<JumpingCircle> jumping_circles;

  /// True if the edge is one smooth motion of every joint. It is false only if a circle wraps under
  /// a mimic joint that is not periodic in it, because the mimic joint would jump.
  bool isSmooth(std::span<const double> a, std::span<const double> b,
                std::span<const double> difference) const;
};

/// The robot's part of an EdgeModel. Constant.
struct RobotMotions {
  std::vector<EdgeModel::Pair> pairs;  ///< one per pair of the robot's scene
  std::vector<robots::RelativeMotion> motions;
  std::vector<EdgeModel::Gap> gaps;
  /// For each geometry of a moving body, its motion relative to the world: index into `motions`;
  /// -1: it stands still.
  std::vector<int> of_world;
  double rounding = 0, reach = 0;                         ///< as in EdgeModel
  std::vector<EdgeModel::JumpingCircle> jumping_circles;  ///< as in EdgeModel
  std::vector<int> moved_joints;                          ///< that edges can move
  /// The largest magnitude at which each number of a point interpolates as exactly as bounds
  /// assume.
  std::vector<double> largest_exact;
};

/// `robot`: the robot's bodies with their pairs; `carriers`: the link of each body; `gaps`: one per
/// pair. O(pairs * joints^2).
RobotMotions makeRobotMotions(const ConfigurationSpace& space, const collision::Scene& robot,
                              std::span<const int> carriers,
                              std::span<const robots::VariableRange> ranges,
                              std::span<const robots::LinkGap* const> gaps);

/// Expands a difference of points to one of configurations: 0 for variables that are not planned.
void expandDifference(const ConfigurationSpace& space, std::span<const double> difference,
                      std::span<double> dq);

}  // namespace leeway::planner
