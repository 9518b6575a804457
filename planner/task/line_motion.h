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

/// How far a frame departs from its places on a line during an edge.
struct LineDeparture {
  double deviation = 0;  ///< of its origin [m]
  double turn = 0;       ///< of its rotation [rad]
};

/// Returns bounds on both over the whole edge from a to b. The place on the line goes from `place`
/// to `next` at a constant rate, within one stretch. The errors at both ends bound those between
/// them, up to how far the frame and its place leave their chords. O(joints).
LineDeparture lineDeparture(FrameMotion& frame, const LineWay& way, double place, double next,
                            std::span<const double> a, std::span<const double> b);

/// A line as joint motions, up to where it could be followed.
struct LineMotion {
  std::vector<std::vector<double>> points;  ///< begin with the start
  std::vector<double> places;               ///< of each point, on the way
  LineDeparture departure;                  ///< the largest of all edges
  std::optional<LineEnd> end;               ///< where and why it ends early; else nothing
};

/// Limits the tries to follow a line.
struct LineTries {
  int free = 0;                     ///< failed tries to move free joints before giving up
  std::uint64_t seed = 1;           ///< of the random motions
  std::function<bool()> stop = {};  ///< called before each piece; may be empty
};

/// Follows a line from `start` in pieces. Each piece is proven to stay within the step's tolerances
/// and certified to keep all margins. The length is halved after a piece that fails and doubled
/// after one that succeeds. If the motion ends early and the line leaves joints free, tries again
/// from earlier places with random motions of these joints, and returns the longest motion.
/// Deterministic, unless `stop` ends it. Throws std::invalid_argument as lineWay() does.
LineMotion followLine(EdgeCertifier& certifier, const robots::InverseKinematics& kinematics,
                      const Problem& world, const LineStep& line, const std::vector<double>& start,
                      const LineTries& tries);

}  // namespace leeway::planner
