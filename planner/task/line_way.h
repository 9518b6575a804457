#pragma once

#include <span>
#include <vector>

#include "leeway/planner/problem.h"
#include "planner/constraint/frame_motion.h"

namespace leeway::planner {

/// A part of a line: straight or an arc, with a rotation about one axis.
struct WayStretch {
  robots::Pose from;                                ///< X_WF at its beginning
  Eigen::Vector3d along = Eigen::Vector3d::Zero();  ///< vector to its end, in the world [m]
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< of the rotation, in F
  double turn = 0;                                  ///< angle of the rotation [rad]
  double arc = 0;                                   ///< angle of the arc; 0: straight [rad]
  Eigen::Vector3d center = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::UnitZ();  ///< of it

  /// X_WF after a share of the stretch, in [0, 1].
  robots::Pose at(double share) const;
  double length() const;  ///< of the origin's path [m]
  /// Bounds how far the frame departs from a point that moves at a constant rate along the chord of
  /// a part. The part is `share` of the stretch. The bound is A / 8, where the acceleration of a
  /// part of angle a is A = r a^2.
  ChordDeparture departure(double share) const;
};

/// The places of a line's frame, from its place at the beginning.
struct LineWay {
  int link = -1;
  robots::Pose X_LF;
  std::vector<WayStretch> stretches;

  double size() const { return static_cast<double>(stretches.size()); }
  /// X_WF at a place in [0, size()]: the number of the stretch plus the share of it.
  robots::Pose at(double place) const;
};

/// Returns the way of a line in a world whose links are at X_WL. Throws std::invalid_argument for
/// names that do not exist, for half turns between two poses, which may go either way round, and
/// for arcs through three points of one line.
LineWay lineWay(const Problem& world, const LineStep& line, std::span<const robots::Pose> X_WL);

}  // namespace leeway::planner
