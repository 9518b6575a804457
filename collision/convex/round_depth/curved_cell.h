#pragma once

// A lower bound of the support function of a difference on a triangle of directions (a cell),
// shared by curved_facet.cc and curved_depth.cc.

#include <algorithm>
#include <cmath>

#include "collision/base/tolerances.h"
#include "collision/base/vector.h"

namespace leeway::collision {

/// A quadratic form on a triangle: sum over i, j of mu_i mu_j p_ij at barycentric mu.
struct Form {
  double p00 = 0, p11 = 0, p22 = 0, p01 = 0, p02 = 0, p12 = 0;

  /// Adds the product of two functions that are linear in mu, symmetrised.
  template <class Product>
  void add(const Product& product) {
    p00 += product(0, 0), p11 += product(1, 1), p22 += product(2, 2);
    p01 += 0.5 * (product(0, 1) + product(1, 0));
    p02 += 0.5 * (product(0, 2) + product(2, 0));
    p12 += 0.5 * (product(1, 2) + product(2, 1));
  }
};

/// True if the form is proven to be nonnegative: Hadeler's criterion for copositive matrices. Roots
/// and sums err by a few units of roundoff of their terms, which are subtracted. (Written so that
/// NaN fails.)
inline bool copositive(const Form& f) {
  if (!(0 <= f.p00 && 0 <= f.p11 && 0 <= f.p22)) return false;
  if (0 <= f.p01 && 0 <= f.p02 && 0 <= f.p12) return true;
  const double r0 = std::sqrt(f.p00), r1 = std::sqrt(f.p11), r2 = std::sqrt(f.p22);
  const auto edge = [&](double p, double roots) -> double {
    return p + roots - kRootRounding * (std::abs(p) + roots);
  };
  const double e01 = edge(f.p01, r0 * r1), e02 = edge(f.p02, r0 * r2), e12 = edge(f.p12, r1 * r2);
  if (!(0 <= e01 && 0 <= e02 && 0 <= e12)) return false;
  const double all = r0 * r1 * r2, a = f.p01 * r2, b = f.p02 * r1, c = f.p12 * r0;
  const double last = std::sqrt(2 * e01 * e02 * e12);
  return kRootRounding * (all + std::abs(a) + std::abs(b) + std::abs(c) + last) <=
         all + a + b + c + last;
}

/// A corner of a triangle of directions, with a convex combination of pieces of each core: a point
/// and a share of the ellipsoid with semi-axes M around it. All of this is linear between the
/// corners.
struct CurvedCorner {
  Vector x;          ///< direction
  Vector center;     ///< B's centre less A's
  Vector scaled[2];  ///< M x of A and B, in their frames
  double share[2];   ///< of A and B
};

/// True when
///   x . center + sum over A and B of share |M x| >= depth |x|
/// for all x between three corners. `slack` [m^2, or m where x has no unit] bounds the rounding of
/// x . center and the like; sizes are the cores' extents. O(1).
///
/// A quadratic form bounds the difference of both sides from below. With e a unit vector, l = e . v
/// and r the part of v across e:
///   |v| = l + r^2 / (sqrt(l^2 + r^2) + l), whose denominator is largest at a corner;
///   |v| <= (l^2 + r^2) / (2 k l) + k l / 2 for l > 0 and any k > 0, best in the middle between e
///   and the corners: k^2 = 1 + r^2 / (2 l^2) with their r and l.
inline bool provesCell(const CurvedCorner (&corners)[3], const double (&sizes)[2], double depth,
                       double slack) {
  // Uses directions of equal length, the least of the three, because r^2 / (2 l) has one l for all.
  CurvedCorner c[3] = {corners[0], corners[1], corners[2]};
  double lengths[3];
  for (int i = 0; i < 3; ++i) lengths[i] = c[i].x.norm();
  const double least_length = std::min({lengths[0], lengths[1], lengths[2]});
  if (!(least_length > 0)) return false;
  for (int i = 0; i < 3; ++i) {
    const double shorter = least_length / lengths[i];
    for (Vector* v : {&c[i].x, &c[i].scaled[0], &c[i].scaled[1]}) *v *= shorter;
  }
  Form form;
  form.add([&](int i, int j) -> double { return c[i].x.dot(c[j].center); });
  constexpr double kThird = 1.0 / 3;
  double along[3];
  Vector across[3];
  const auto split = [&](const Vector& v0, const Vector& v1, const Vector& v2, double size) {
    const Vector middle = kThird * (v0 + v1 + v2);
    const double length = middle.norm();
    if (!(length > size)) return false;
    const Vector e = middle / length;
    const Vector* v[3] = {&v0, &v1, &v2};
    for (int i = 0; i < 3; ++i) {
      along[i] = e.dot(*v[i]);
      across[i] = *v[i] - along[i] * e;
    }
    return true;
  };
  for (int k = 0; k < 2; ++k) {
    const double least_share = std::min({c[0].share[k], c[1].share[k], c[2].share[k]});
    const double most_share = std::max({c[0].share[k], c[1].share[k], c[2].share[k]});
    // (If the direction is lost, |v| >= 0 is the bound.)
    if (!(most_share > 0) ||
        !split(c[0].scaled[k], c[1].scaled[k], c[2].scaled[k], kLostShare * sizes[k])) {
      continue;
    }
    double l = 0, l_squared = 0, r_squared = 0;
    for (int i = 0; i < 3; ++i) {
      l = std::max(l, along[i]);
      l_squared = std::max(l_squared, along[i] * along[i]);
      r_squared = std::max(r_squared, across[i].squaredNorm());
    }
    const double bend = least_share / (l + std::sqrt(l_squared + r_squared));
    form.add([&](int i, int j) -> double {
      return c[i].share[k] * along[j] + bend * across[i].dot(across[j]);
    });
  }
  if (!split(c[0].x, c[1].x, c[2].x, 0)) return false;
  const double nearest = std::min({along[0], along[1], along[2]});
  if (!(nearest > 0)) return false;
  double r_squared = 0;
  for (const Vector& v : across) r_squared = std::max(r_squared, v.squaredNorm());
  const double k = std::sqrt(1 + 0.5 * r_squared / (nearest * nearest));
  const double straight = 0.5 / k + 0.5 * k, bend = 0.5 / (k * nearest);
  form.add([&](int i, int j) -> double {
    return -(depth * (straight * along[j] + bend * across[i].dot(across[j])));
  });
  for (double* p : {&form.p00, &form.p11, &form.p22, &form.p01, &form.p02, &form.p12}) {
    *p -= slack;
  }
  return copositive(form);
}

}  // namespace leeway::collision
