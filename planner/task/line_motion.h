#pragma once

#include <string>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "leeway/robots/inverse_kinematics.h"
#include "planner/task/stages.h"

namespace leeway::planner {

/// How far a frame departs from a straight line on an edge.
struct LineDeparture {
  double deviation = 0;  ///< of its origin [m]
  double turn = 0;       ///< of its rotation, from the line's [rad]
};

/// Bounds on both over the whole edge from a to b. The origin leaves the chord of its places at the
/// ends by at most A / 8, A its acceleration, and these are as far from the line as kinematics
/// say. So do the ends of unit vectors fixed to the frame, whose acceleration is at most 1.5 W^2
/// where W is the sum of the joints' turns: |alpha| <= W^2 / 2 as each joint's axis is turned by
/// those below it, and |omega|^2 <= W^2. `length`: the line's. O(joints^2).
LineDeparture lineDeparture(const CompiledScene& scene, const LinePlace& place,
                            std::span<const double> a, std::span<const double> b);

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
