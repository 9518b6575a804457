#pragma once

#include "collision/support.h"

namespace leeway::collision {

/// Up to four points of a difference and the point of their hull nearest to the origin.
struct Simplex {
  int count = 0;
  SupportPoint points[4];
  double lambda[4] = {
      1, 0, 0,
      0};  ///< weights of `nearest`; not negative, their sum is 1 within 4 units of roundoff
  Vector nearest = Vector::Zero();
  double norm_squared = 0;  ///< of nearest
  /// A better direction than `nearest` where there is one, of any length: near contact
  /// nearest/|nearest| is lost to cancellation, but the normal of the triangle that carries it is
  /// still known, and so is its right angle to an edge. Else zero.
  Vector feature_normal = Vector::Zero();

  /// The point with the given weights, of A.
  Vector pointOfA() const {
    Vector a = lambda[0] * points[0].a;
    for (int i = 1; i < count; ++i) a += lambda[i] * points[i].a;
    return a;
  }
};

/// Reduces the simplex, whose last point is the newest, to the points that carry the nearest one.
/// False when the four points hold the origin (or so nearly that rounding cannot tell); they are
/// all kept then. After Gilbert, Johnson and Keerthi (1988); regions are told apart by cross
/// products as in Montanari, Petrinic and Barbieri (2017), but where they leave several faces open
/// the nearest of all of them is taken, which needs no exact predicates: a wrong region can only
/// cost a step, because every candidate is a point of the hull.
bool reduceToNearest(Simplex& simplex);

/// The point of a triangle nearest to the origin: its weights. Any triangle, degenerate ones
/// included.
Vector nearestOnTriangle(const Vector& a, const Vector& b, const Vector& c, double weights[3]);

}  // namespace leeway::collision
