#pragma once

#include "collision/base/tolerances.h"
#include "collision/base/triple.h"
#include "collision/convex/gjk/progress.h"

namespace leeway::collision {

/// The signed distance of a point from a core.
struct PointDistance {
  double distance = 0;  ///< below 0 inside: minus the distance to the boundary [m]
  Vector nearest;       ///< the core's point nearest to it; for a point inside, the nearest point
                        ///< of the boundary
  Vector normal;        ///< unit, from the core towards the point; outwards when inside
};

/// True for the cores whose point distance has a closed form: all except kPoints and kEllipsoid,
/// for which pointDistance() returns NaN, which no bound accepts.
bool hasPointDistance(Core core);

/// Signed distance of p (in the core's frame) from the core, within kClosedFormRounding units of
/// roundoff times (extent + |p|). O(1).
PointDistance pointDistance(const ConvexView& view, const Vector& p);

/// The s of the point on the segment s h, |s| <= 1, that is nearest to p.
inline double nearestOnSegment(const Triple& p, const Triple& h) {
  // (Clamped before the division, because compilers make variable limits branch-free there.)
  const double length_squared = squared(h);
  return within(dot(p, h), -length_squared, length_squared) /
         (length_squared > 0 ? length_squared : 1);
}

/// Nearest points of two segments c0 + s0 u, |s0| <= h0, and c1 + s1 v, |s1| <= h1, with unit
/// vectors u and v (Lumelsky 1985), from the dot products b = u v, c = u r and f = v r, where r =
/// c0 - c1. For nearly parallel segments they can be poor, so the caller must check them.
inline void nearestOnAxes(double b, double c, double f, double h0, double h1, double& s0,
                          double& s1) {
  // For parallel segments any start works, because the two steps after it find nearest points.
  const double per = 1 / std::max(1 - b * b, kInsteadOfZero);
  s0 = within((b * f - c) * per, -h0, h0);
  s1 = within(b * s0 + f, -h1, h1);
  s0 = within(b * s1 - c, -h0, h0);
}

/// nearestOnAxes() for segments c0 + s0 h0 and c1 + s1 h1, |s| <= 1 (a few units more by rounding).
inline void nearestOnSegments(const Triple& c0, const Triple& h0, const Triple& c1,
                              const Triple& h1, double& s0, double& s1) {
  const Triple r = c0 - c1;
  const double a = squared(h0), e = squared(h1), b = dot(h0, h1);
  const double c = dot(h0, r), f = dot(h1, r);
  // (For a segment without length, b and c, or b and f, are 0, too.)
  const double denominator = std::max(a * e - b * b, kInsteadOfZero);
  s0 = within(b * f - c * e, -denominator, denominator) / denominator;
  s1 = within(b * s0 + f, -e, e) / std::max(e, kInsteadOfZero);
  s0 = within(b * s1 - c, -a, a) / std::max(a, kInsteadOfZero);
}

/// The s of the point of the segment c + s h, |s| <= 1, that is nearest to the box |x| <= half; as
/// accurate as rounding allows for the interpolation between two breakpoints. O(1).
double nearestToBox(const Triple& c, const Triple& h, const Triple& half);

}  // namespace leeway::collision
