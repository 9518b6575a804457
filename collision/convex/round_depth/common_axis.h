#pragma once

#include <limits>

#include "collision/convex/gjk/support.h"

namespace leeway::collision {

/// Two bodies of revolution about parallel axes. Their difference is also one of revolution, but
/// moved across its axis. Among all directions at one angle to the axis, it reaches least far in
/// the one that points the other way, so the half plane of directions through the axis and `across`
/// represents all directions.
struct CommonAxis {
  Vector along, across;  ///< unit, in B's frame; across is from B's axis towards A's
  /// How much the least reach in the half plane may exceed that in all directions, because the axes
  /// are parallel and the bodies round only up to rounding or a little more [m]; infinite if one
  /// body is not of revolution.
  double excess = std::numeric_limits<double>::infinity();
};

/// The common axis of two cores. An ellipsoid whose semi-axes differ by at most `wide` [m] counts
/// as a ball. O(1).
CommonAxis commonAxis(const ConvexView& a, const Pose& X_BA, const ConvexView& b, double roundoff,
                      double wide);

}  // namespace leeway::collision
