#pragma once

#include <string>

#include "leeway/planner/plan.h"
#include "leeway/planner/trajectory.h"

namespace leeway::planner {

/// Reads .json, .yaml, .csv or .path by its ending. Columns are matched to the problem's planned
/// variables by name (.path: by order); one that is not planned must say what the problem says of
/// it. JSON and YAML: trajectory_msgs/JointTrajectory, alone or under `joint_trajectory`, or what
/// `leeway plan --json` prints. Numbers come back to the bit. Throws robots::InputError.
Path readPath(const std::string& file, const Problem& problem);

/// Writes by ending, whole or not at all (temporary name, then rename). Throws robots::InputError
/// when it cannot, leaving an existing file as it was. Continuous joints are written unwrapped. A
/// path has no times of its own: those written are when a trajectory within the problem's limits
/// that stops at every corner is there (motionLimits()), and mean nothing to the certificate.
void writePath(const std::string& file, const Problem& problem, const PlanResult& result);

/// Writes a timed motion along the result's path, .json or .yaml shaped like
/// trajectory_msgs/JointTrajectory, whole or not at all: positions, velocities and accelerations
/// (from that moment on; all of the numbers themselves, orientations included) at its knots, and
/// every `period` seconds where that is above 0. The cubic through positions and velocities of
/// joints is the motion itself between knots on an edge. .csv has times and positions alone. The
/// certificate beside them is that of the motion: with blended corners its clearance is told to be
/// at least the least margin, and no upper bound is where a blend cuts off the place that it was
/// found at. Throws robots::InputError, also for motions of more than 2^31 s and more than a
/// million periods.
void writeTrajectory(const std::string& file, const Problem& problem, const PlanResult& result,
                     const Trajectory& trajectory, double period = 0);

/// The text of a file, whole or not at all: written under a temporary name beside it, then renamed.
/// Of a symbolic link what it names is replaced; a device or pipe is written to. Throws
/// robots::InputError.
void writeFileWhole(const std::string& file, const std::string& text);

}  // namespace leeway::planner
