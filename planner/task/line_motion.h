#pragma once

#include <string>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "leeway/robots/inverse_kinematics.h"
#include "planner/constraint/frame_motion.h"
#include "planner/task/stages.h"

namespace leeway::planner {

/// How far a frame departs from a straight line on an edge.
struct LineDeparture {
  double deviation = 0;  ///< of its origin [m]
  double turn = 0;       ///< of its rotation, from the line's [rad]
};

/// Bounds on both over the whole edge from a to b: its ends are as far from the line as kinematics
/// say, all between at most a ChordDeparture farther. `frame`: the line's. O(joints).
LineDeparture lineDeparture(FrameMotion& frame, const LinePlace& place, std::span<const double> a,
                            std::span<const double> b);

/// A line in joint pieces.
struct LineMotion {
  std::vector<std::vector<double>> points;  ///< the start first; empty where it failed
  LineDeparture departure;                  ///< the largest
  std::string fault;                        ///< why it failed, in words
};
/// Follows a line from `start`, in pieces whose departure is proven to be within the step's
/// tolerances and which are certified to keep all margins: half as long where one fails, twice
/// where one succeeds.
LineMotion followLine(EdgeCertifier& certifier, const robots::InverseKinematics& kinematics,
                      const Problem& world, const LineStep& line, const std::vector<double>& start);

}  // namespace leeway::planner
