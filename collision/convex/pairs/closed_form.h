#pragma once

#include "collision/base/tolerances.h"
#include "collision/base/triple.h"
#include "collision/convex/gjk/progress.h"

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

/// Where the segment s h, |s| <= 1, comes nearest to p: s.
inline double nearestOnSegment(const Triple& p, const Triple& h) {
  // (Limits that are no constants are kept by instructions without a branch.)
  const double length_squared = squared(h);
  return within(dot(p, h), -length_squared, length_squared) /
         (length_squared > 0 ? length_squared : 1);
}

/// Nearest points of two segments c0 + s0 u, |s0| <= h0, and c1 + s1 v, |s1| <= h1, with unit
/// vectors u and v, after Lumelsky (1985), from the products b = u v, c = u r, f = v r with r = c0
/// - c1. Near parallel they can be poor; the caller checks them.
inline void nearestOnAxes(double b, double c, double f, double h0, double h1, double& s0,
                          double& s1) {
  // Parallel: any start is right, the ones after it do the rest.
  const double per = 1 / std::max(1 - b * b, kInsteadOfZero);
  s0 = within((b * f - c) * per, -h0, h0);
  s1 = within(b * s0 + f, -h1, h1);
  s0 = within(b * s1 - c, -h0, h0);
}

/// Nearest points of two segments through c0 and c1, with half vectors h0 and h1: c + s h, |s| <= 1
/// (by rounding, a few units more). The same.
inline void nearestOnSegments(const Triple& c0, const Triple& h0, const Triple& c1,
                              const Triple& h1, double& s0, double& s1) {
  const Triple r = c0 - c1;
  const double a = squared(h0), e = squared(h1), b = dot(h0, h1);
  const double c = dot(h0, r), f = dot(h1, r);
  // (Without length b, c or f are 0, too.)
  const double denominator = std::max(a * e - b * b, kInsteadOfZero);
  s0 = within(b * f - c * e, -denominator, denominator) / denominator;
  s1 = within(b * s0 + f, -e, e) / std::max(e, kInsteadOfZero);
  s0 = within(b * s1 - c, -a, a) / std::max(a, kInsteadOfZero);
}

/// Where the segment c + s h, |s| <= 1, comes nearest to the box |x| <= half: s. As good as
/// rounding lets the weight of the two breakpoints around it be.
double nearestToBox(const Triple& c, const Triple& h, const Triple& half);

}  // namespace leeway::collision
