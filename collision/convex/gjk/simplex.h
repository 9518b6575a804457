#pragma once

#include "collision/convex/gjk/support.h"

namespace leeway::collision {

/// Up to four points of a difference and the point of their hull nearest to the origin. Points stay
/// in their slots, so that a step is undone by freeing a slot.
struct Simplex {
  SupportPoint points[4];
  int count = 0;
  int slot[4] = {0, 1, 2, 3};  ///< of the points in use, the newest last; then the free ones
  /// Weights of `nearest` in the order of slot[]: not negative, with a sum of 1 within 4 units.
  double lambda[4] = {1, 0, 0, 0};
  Vector nearest = Vector::Zero();
  double norm_squared = 0;  ///< of nearest
  /// A better direction than `nearest`, if there is one, of any length. Near contact
  /// nearest/|nearest| is lost to cancellation, but the normal of the triangle that holds it is
  /// still known, and so is the perpendicular to an edge.
  Vector feature_normal = Vector::Zero();
  bool has_normal = false;

  const SupportPoint& point(int i) const { return points[slot[i]]; }
  SupportPoint& free() { return points[slot[count]]; }

  /// A's part of the point with these weights.
  Vector pointOfA() const {
    Vector a = lambda[0] * point(0).a;
    for (int i = 1; i < count; ++i) a += lambda[i] * point(i).a;
    return a;
  }
};

enum class Reduction : unsigned char {
  kReduced,
  kHoldsOrigin,  ///< the four points, including that in free(), hold the origin; nothing changes
  kNoProgress,   ///< rounding hides the closer point of their hull; nothing changes
};

/// Adds the point in free() and reduces the simplex to the points that carry the one nearest to the
/// origin. After Gilbert, Johnson and Keerthi (1988); cross products distinguish the regions, as in
/// Montanari, Petrinic and Barbieri (2017). If they leave several faces open, the nearest of all is
/// taken. This needs no exact predicates: every candidate is a point of the hull, so a wrong region
/// only costs a step.
Reduction addAndReduce(Simplex& simplex);

/// addAndReduce() after a linear change of coordinates w -> rows w: face and weights are those
/// nearest there. `nearest` and norm_squared belong to the point with these weights in true
/// coordinates, which need not come closer; feature_normal is the direction in true coordinates.
/// Never kNoProgress.
Reduction addAndReduceScaled(Simplex& simplex, const Vector rows[3]);

/// Reduces the first `count` <= 3 points, in the order of slot[], again.
void reduceAll(Simplex& simplex, int count);

/// The point of a triangle, degenerate or not, nearest to the origin, and its weights.
Vector nearestOnTriangle(const Vector& a, const Vector& b, const Vector& c, double weights[3]);

}  // namespace leeway::collision
