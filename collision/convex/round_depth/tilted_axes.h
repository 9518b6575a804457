#pragma once

#include "collision/convex/gjk/progress.h"

namespace leeway::collision {

/// Both ends of the signed separation of two overlapping bodies of revolution with straight sides
/// (see haveAxes()) whose axes are parallel but for a small angle, where the nearest surface of
/// their difference is beside the axes. All around them it is about as far out then, so that an
/// expanding polytope needs a facet for every width of the tolerance; but how far exactly is a
/// question of one angle. False where nothing is offered: the axes' angle is too large for the
/// depth, a way out along the axes is about as short, or they do not overlap.
///
/// Let h be the support function of the difference B - A, b and a the unit axes with a . b > 0, p
/// the sine of their angle. For a direction u across b, x(c) = u + c b goes through all directions
/// of a half plane. There B's part of h is linear in c but for kinks where another of its two rims
/// (a cone's apex and a segment's ends are rims, too) becomes the farthest, which is on a circle
/// x . b = const |x|. A's is as well, but for |x - (x . a) a|, whose second derivative is at most
/// p^2 / (1 - p - |c| p). So h(x) - d |x| is concave in c between kinks, |c| <= C, as long as the
/// radius of A's rims times that is at most the least bend of d |x|, d (1 + C^2)^(-3/2); and where
/// it is not negative on the two circles and for |c| >= C, it is not negative anywhere: the
/// difference holds a ball of radius d around the origin. Near the axes the planes of the caps tell
/// enough. On each circle h is the larger of two functions of one angle with bounded second
/// derivatives: branch and bound. O(1): some hundred cells, kTiltedCells at the most.
bool offerTiltedAxes(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                     Difference<false>& difference, Progress& progress);

}  // namespace leeway::collision
