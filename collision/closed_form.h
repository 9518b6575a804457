#pragma once

#include "collision/progress.h"

namespace leeway::collision {

/// Where a point stands to a core: what the two ends of a distance rest on.
struct PointDistance {
  double distance = 0;  ///< signed: below zero inside, minus the way out
  Vector nearest;       ///< the core's boundary point nearest to the point (or a point of the core,
                        ///< outside)
  Vector normal;        ///< unit, from the core towards the point; outwards when inside
};

/// True for the cores whose point distance has a closed form: all but kPoints and kEllipsoid.
bool hasPointDistance(Core core);

/// Signed distance of p (in the core's frame) from the core, within kClosedFormRounding units of
/// roundoff times (extent + |p|). O(1).
PointDistance pointDistance(const ConvexView& view, const Vector& p);

/// Nearest points of two segments through c0 and c1, with half vectors h0 and h1: c + s h, |s|
/// <= 1. After Lumelsky (1985). Near parallel they can be poor; the caller checks them.
void nearestOnSegments(const Vector& c0, const Vector& h0, const Vector& c1, const Vector& h1,
                       double& s0, double& s1);

/// Where the segment c + s h, |s| <= 1, comes nearest to the box |x| <= half: s. As good as
/// rounding lets the weight of the two breakpoints around it be.
double nearestToBox(const Vector& c, const Vector& h, const Vector& half);

}  // namespace leeway::collision
