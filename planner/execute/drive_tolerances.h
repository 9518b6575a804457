#pragma once

// Private to planner/: numbers of executed motions that none of their proofs depends on. All others
// are in planner/base/tolerances.h.

namespace leeway::planner {

/// The longest period of an executed motion's rows [s]: those of common controllers are shorter.
constexpr double kLongestPeriod = 0.02;

/// Stops along a path that are tried: the periods for which the robot goes on at first, because it
/// cannot slow down where it brakes or turns already [count]; and their times as multiples of the
/// least at the velocity there. More find shorter stops, and take longer.
constexpr int kStopWaits[] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 14, 16,
                              18, 20, 22, 24, 27, 30, 33, 36, 40, 44, 48, 53, 58, 64};
constexpr double kStopTimes[] = {1, 1.15, 1.35, 1.6, 1.9, 2.3, 2.8, 3.5};

/// The largest departure of rows from a chord that is tried for all of them [m]: a greater one
/// would rarely be proven among obstacles.
constexpr double kLargestDeparture = 0.02;
/// The largest share of a clearance's tolerance that a chord's departure takes.
constexpr double kDepartureShare = 0.1;

/// The longest time that an evasion would take at the velocity limits [s]. From rest to rest it
/// takes about three times that.
constexpr double kEvasionTime = 0.4;

}  // namespace leeway::planner
