#pragma once

#include "leeway/planner/edge_certifier.h"

namespace leeway::planner {

/// Nearness at a clearance d [m]; 1 for NaN.
double nearnessAt(const Nearness& nearness, double d);

/// The clearance from which on nearness is 0 [m]; infinity for an inverse.
double reachOf(const Nearness& nearness);

/// Bounds on the mean of nearness over a stretch in which the clearance changes linearly from
/// `begin` to `end` [m]; ends of infinity are allowed. The bounds are within 1e-13 of each other
/// for a hinge. O(1).
Interval meanNearness(const Nearness& nearness, double begin, double end);

}  // namespace leeway::planner
