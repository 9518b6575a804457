#pragma once

#include "leeway/planner/edge_certifier.h"

namespace leeway::planner {

/// Nearness at a clearance d [m]; of NaN 1.
double nearnessAt(const Nearness& nearness, double d);

/// From where on it is 0 [m]; infinity of an inverse.
double reachOf(const Nearness& nearness);

/// Bounds on the mean of nearness over a stretch in which the clearance goes evenly from `begin` to
/// `end` [m]; ends of infinity are allowed. Within 1e-13 of each other for a hinge. O(1).
Interval meanNearness(const Nearness& nearness, double begin, double end);

}  // namespace leeway::planner
