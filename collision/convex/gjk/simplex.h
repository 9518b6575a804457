#pragma once

#include "collision/convex/gjk/support.h"

namespace leeway::collision {

/// Up to four points of a difference and the point of their hull nearest to the origin. Points stay
/// in their slots, so that giving up a step is giving up a slot.
struct Simplex {
  SupportPoint points[4];
  int count = 0;
  int slot[4] = {0, 1, 2, 3};       ///< of the points in use, the newest last; then the free ones
  double lambda[4] = {1, 0, 0, 0};  ///< weights of `nearest`, in the order of slot[]; not negative,
                                    ///< their sum is 1 within 4 units
  Vector nearest = Vector::Zero();
  double norm_squared = 0;  ///< of nearest
  /// A better direction than `nearest` where there is one, of any length: near contact
  /// nearest/|nearest| is lost to cancellation, but the normal of the triangle that carries it is
  /// still known, and so is its right angle to an edge.
  Vector feature_normal = Vector::Zero();
  bool has_normal = false;

  const SupportPoint& point(int i) const { return points[slot[i]]; }
  SupportPoint& free() { return points[slot[count]]; }

  /// The point with the given weights, of A.
  Vector pointOfA() const {
    Vector a = lambda[0] * point(0).a;
    for (int i = 1; i < count; ++i) a += lambda[i] * point(i).a;
    return a;
  }
};

enum class Reduction : unsigned char {
  kReduced,
  kHoldsOrigin,  ///< the four points, the one in free() included, hold the origin; the simplex is
                 ///< as it was
  kNoProgress,   ///< no point of their hull is nearer, as there is in exact arithmetic; the simplex
                 ///< is as it was
};

/// Takes the point in free() and reduces the simplex to the points that carry the one nearest to
/// the origin. After Gilbert, Johnson and Keerthi (1988); regions are told apart by cross products
/// as in Montanari, Petrinic and Barbieri (2017), but where they leave several faces open the
/// nearest of all of them is taken, which needs no exact predicates: a wrong region can only cost a
/// step, because every candidate is a point of the hull.
Reduction addAndReduce(Simplex& simplex);

/// The same after a linear change of coordinates w -> rows w: the faces are told apart and weighed
/// there. `nearest` and norm_squared are of the point with those weights in true coordinates, which
/// need not shrink; feature_normal is the direction in true coordinates. Never kNoProgress.
Reduction addAndReduceScaled(Simplex& simplex, const Vector rows[3]);

/// Reduces the first `count` <= 3 points in the order of slot[], whatever was known of them.
void reduceAll(Simplex& simplex, int count);

/// The point of a triangle nearest to the origin, and its weights. Any triangle, degenerate ones
/// included.
Vector nearestOnTriangle(const Vector& a, const Vector& b, const Vector& c, double weights[3]);

}  // namespace leeway::collision
