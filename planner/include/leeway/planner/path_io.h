#pragma once

#include <string>
#include <vector>

#include "leeway/planner/plan.h"
#include "leeway/planner/trajectory.h"

namespace leeway::planner {

struct PathReading {
  /// Continuous joints take the shorter way between rows instead of the straight line. The rows
  /// that are read get whole turns added, see unwrapped(). Use it for files whose angles are
  /// wrapped.
  bool shortest = false;
  /// Reads Path::times and velocities of a file whose rows have velocities, unless orientations
  /// turn. Otherwise such a file gives its rows alone, with a warning.
  bool cubics = false;
  /// Receives warnings about a file that can be used. Null: no warnings.
  std::vector<std::string>* warnings = nullptr;
};

/// Reads a .json, .yaml, .csv, .path or .txt file, whose rows mean straight lines. Columns are
/// matched to the problem's planned variables by name (.path, .txt: by order); a column of another
/// variable must have the value of the problem's start. JSON and YAML hold a
/// trajectory_msgs/JointTrajectory, alone or under `joint_trajectory`, or the output of `leeway
/// plan --json`. Numbers read back to the bit. Throws robots::InputError, also as validate().
Path readPath(const std::string& file, const Problem& problem, const PathReading& options = {});

/// Writes the format of the file's ending, whole or not at all (see writeFileWhole()). Rows are
/// written as they are: those of plan() have continuous joints unwrapped. A path has no times:
/// those written are of a trajectory within the problem's limits (motionLimits()) that stops at
/// every corner; the certificate does not depend on them. Throws robots::InputError, also as
/// validate(); std::invalid_argument for a result of other variables than the problem plans, or
/// that is certified for other margins.
void writePath(const std::string& file, const Problem& problem, const PlanResult& result);

/// Writes a timed motion along the result's path, whole or not at all. .json and .yaml have the
/// shape of trajectory_msgs/JointTrajectory: positions, velocities and accelerations at the
/// motion's knots, and every `period` seconds if that is above 0; for orientations the derivatives
/// are of the quaternion's numbers. Between knots on an edge, joints move on the cubic through
/// positions and velocities. Accelerations are left out where they jump, since controllers that get
/// them follow quintics. .csv has the same columns, always with accelerations (after a jump).
///
/// The certificate in the file is that of the motion. With blended corners, the lower bound of its
/// clearance is at most the least margin. If a blend cuts off the closest place of the path, the
/// clearance has no upper bound. Throws std::invalid_argument as writePath(), and for a trajectory
/// over other waypoints than those of edgesOf() the result's path; robots::InputError, also for
/// more than 2^31 s, a million periods, and a period below 20 us.
void writeTrajectory(const std::string& file, const Problem& problem, const PlanResult& result,
                     const Trajectory& trajectory, double period = 0);

/// Replaces a file as a whole or not at all: writes a temporary file next to it, and renames that.
/// Follows a symbolic link. Writes directly to a device or pipe. Throws robots::InputError and then
/// leaves an existing file unchanged.
void writeFileWhole(const std::string& file, const std::string& text);

}  // namespace leeway::planner
