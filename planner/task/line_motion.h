#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "leeway/robots/inverse_kinematics.h"
#include "planner/constraint/frame_motion.h"
#include "planner/task/line_way.h"

namespace leeway::planner {

/// How far a frame departs from its places on a line, on an edge.
struct LineDeparture {
  double deviation = 0;  ///< of its origin [m]
  double turn = 0;       ///< of its rotation [rad]
};

/// Bounds on both over the whole edge from a to b, while the place on the line goes from `place` to
/// `next`, in one stretch, at a constant rate. What the errors are at both ends bounds those
/// between, up to how far the frame and its place leave their chords. O(joints).
LineDeparture lineDeparture(FrameMotion& frame, const LineWay& way, double place, double next,
                            std::span<const double> a, std::span<const double> b);

/// A line in joint pieces, as far as it was had.
struct LineMotion {
  std::vector<std::vector<double>> points;  ///< the start first
  std::vector<double> places;               ///< of each point, on the way
  LineDeparture departure;                  ///< the largest
  std::optional<LineEnd> end;               ///< nothing: all of it
};

/// How much a line is tried.
struct LineTries {
  int free = 0;                     ///< with other motions of joints that the line leaves free
  std::uint64_t seed = 1;           ///< of these
  std::function<bool()> stop = {};  ///< called before each; may be empty
};

/// Follows a line from `start`, in pieces whose departure is proven to be within the step's
/// tolerances and which are certified to keep all margins: half as long where one fails, twice
/// where one succeeds. If the motion ends early and the line leaves joints free, it is tried again
/// from earlier places with random motions of these joints; the longest motion is returned.
/// Deterministic, except where `stop` ends it. Throws std::invalid_argument as lineWay().
LineMotion followLine(EdgeCertifier& certifier, const robots::InverseKinematics& kinematics,
                      const Problem& world, const LineStep& line, const std::vector<double>& start,
                      const LineTries& tries);

}  // namespace leeway::planner
