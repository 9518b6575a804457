#pragma once

#include <limits>

#include "collision/convex/gjk/support.h"

namespace leeway::collision {

/// Two bodies of revolution about parallel axes. Their difference is one of revolution, too, but
/// moved across its axis: of all directions at one angle to the axis it reaches least far in the
/// one that points the other way. So the half plane of directions through the axis and `across`
/// stands for all.
struct CommonAxis {
  Vector along, across;  ///< unit, in B's frame; across is from B's axis towards A's
  /// By how much the least reach of the half plane may exceed that of all directions, since the
  /// axes are parallel and the bodies round only to within rounding or a little more [m]; infinite
  /// where a body is not one of revolution.
  double excess = std::numeric_limits<double>::infinity();
};

/// The axis that two cores have in common. Semi-axes of an ellipsoid that differ by `wide` [m] at
/// most make a ball. O(1).
CommonAxis commonAxis(const ConvexView& a, const Pose& X_BA, const ConvexView& b, double roundoff,
                      double wide);

}  // namespace leeway::collision
