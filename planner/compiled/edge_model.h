#pragma once

// Private to planner/: what a CompiledScene holds for the certification of edges.

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
  /// One of those of collision::Scene::pairs() that are of two bodies of the robot.
  struct Pair {
    int motion;  ///< index into `motions`: how body a moves seen from body b, static: the world
    bool is_reversed;  ///< `motion` is that of b seen from a: of two moving bodies the one near the
                       ///< joints between them moves less
    const robots::LinkGap* gap;  ///< proven of the two links by two joints' angles; null: nothing
    float most_gap = 0;          ///< that `gap` proves at any angles [m]
  };
  std::vector<Pair> pairs;
  /// Pairs share them; the robot's, of which pairs need not use all.
  std::span<const robots::RelativeMotion> motions;
  std::shared_ptr<const PreparedRobot> robot;

  /// How far any point of a moving body may be from where the exact kinematics of the exact point
  /// of the edge have it [m]; added to every bound.
  double rounding = 0;
  /// `rounding` holds for bodies within this distance of the world's origin [m]: beyond all limits,
  /// or what an unlimited joint is trusted with.
  double reach = 0;
  /// Pairs were dropped by a proof that holds within the joints' limits only: points outside them
  /// cannot be answered.
  bool needs_limits = false;
  /// Places in a point of the circles in which some mimic joint is not periodic.
  std::vector<int> jumping_circles;

  /// True when the edge is one smooth motion of every joint: false only where a circle wraps under
  /// a mimic joint that is not periodic in it, so that the mimic would jump.
  bool isSmooth(std::span<const double> a, std::span<const double> b,
                std::span<const double> difference) const;
};

/// The robot's part of an EdgeModel. Constant.
struct RobotMotions {
  std::vector<EdgeModel::Pair> pairs;  ///< one a pair of the robot's scene
  std::vector<robots::RelativeMotion> motions;
  /// Of each geometry of a moving body, seen from the world: index into `motions`; -1: stands
  /// still.
  std::vector<int> of_world;
  double rounding = 0, reach = 0;  ///< as EdgeModel's
  std::vector<int> jumping_circles;
};

/// `robot`: bodies of the robot alone, with their pairs; `carriers`: the link of each body, and
/// `gaps`: one a pair. O(pairs * joints^2).
RobotMotions makeRobotMotions(const ConfigurationSpace& space, const collision::Scene& robot,
                              std::span<const int> carriers,
                              std::span<const robots::VariableRange> ranges,
                              std::span<const robots::LinkGap* const> gaps);

/// A difference of points as one of configurations: 0 for variables that are not planned.
void expandDifference(const ConfigurationSpace& space, std::span<const double> difference,
                      std::span<double> dq);

}  // namespace leeway::planner
