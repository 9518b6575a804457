#pragma once

#include <span>
#include <vector>

#include "leeway/planner/problem.h"
#include "planner/constraint/frame_motion.h"

namespace leeway::planner {

/// A part of a line: straight or an arc, with a turn about one axis.
struct WayStretch {
  robots::Pose from;                                ///< X_WF at its beginning
  Eigen::Vector3d along = Eigen::Vector3d::Zero();  ///< from there to its end, in the world [m]
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< of the turn, in F
  double turn = 0;                                  ///< about it [rad]
  double arc = 0;                                   ///< angle of the arc; 0: straight [rad]
  Eigen::Vector3d center = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::UnitZ();  ///< of it

  /// X_WF after a share of it, in [0, 1].
  robots::Pose at(double share) const;
  double length() const;  ///< of the origin's way [m]
  /// How far the frame departs from a point that goes along the chord of its places at both ends of
  /// a part at a constant rate, where `share` of the stretch lies between them: at most A / 8, with
  /// the acceleration A = r a^2 of a part of angle a.
  ChordDeparture departure(double share) const;
};

/// Where the frame of a line goes, from where it is at the beginning.
struct LineWay {
  int link = -1;
  robots::Pose X_LF;
  std::vector<WayStretch> stretches;

  double size() const { return static_cast<double>(stretches.size()); }
  /// X_WF at a place in [0, size()]: the whole number of the stretch, and the share of it.
  robots::Pose at(double place) const;
};

/// The way of a line in a world, with the links at X_WL. Throws std::invalid_argument for names
/// that do not exist, half turns between two poses, which may go either way round, and arcs through
/// three points of one line.
LineWay lineWay(const Problem& world, const LineStep& line, std::span<const robots::Pose> X_WL);

}  // namespace leeway::planner
