#pragma once

// Triangles of directions on which the support function of a difference of two cores is bounded
// from below: what curved_facet.cc and curved_depth.cc have in common.

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/double_double.h"
#include "collision/base/tolerances.h"
#include "collision/base/vector.h"

namespace leeway::collision {

// One vocabulary for both precisions.
inline double dot(const Vector& a, const Vector& b) { return a.dot(b); }
inline double norm(const Vector& a) { return a.norm(); }
inline double squareRoot(double a) { return std::sqrt(a); }
inline double absolute(double a) { return std::abs(a); }
inline double valueOf(double a) { return a; }
inline double valueOf(const DoubleDouble& a) { return a.high; }
inline Vector valueOf(const Vector& a) { return a; }
inline Vector valueOf(const DoubleDoubleVector& a) { return a.rounded(); }
inline Vector scaledBy(double s, const Vector& a) { return s * a; }
inline DoubleDoubleVector scaledBy(const DoubleDouble& s, const DoubleDoubleVector& a) {
  return s * a;
}
template <class Number>
constexpr double kRootRoundingOf = kRootRounding;
template <>
constexpr double kRootRoundingOf<DoubleDouble> = kSharpRootRounding;

// A quadratic form on a triangle: the value at mu is sum mu_i mu_j of it.
template <class Number>
struct Form {
  Number p00 = 0, p11 = 0, p22 = 0, p01 = 0, p02 = 0, p12 = 0;

  // The symmetrised product of two functions that are linear in mu.
  template <class Product>
  void add(const Product& product) {
    const Number half = 0.5;
    p00 = p00 + product(0, 0), p11 = p11 + product(1, 1), p22 = p22 + product(2, 2);
    p01 = p01 + half * (product(0, 1) + product(1, 0));
    p02 = p02 + half * (product(0, 2) + product(2, 0));
    p12 = p12 + half * (product(1, 2) + product(2, 1));
  }
};

// Hadeler's criterion. Roots and sums err by a few units of roundoff of their terms, which are
// taken off. (Written so that NaN fails; entries are brought to about 1, since products of six
// would leave the range of double.)
template <class Number>
bool copositive(Form<Number> f) {
  Number* const entries[] = {&f.p00, &f.p11, &f.p22, &f.p01, &f.p02, &f.p12};
  double largest = 0;
  for (const Number* p : entries) {
    if (!(std::abs(valueOf(*p)) <= std::numeric_limits<double>::max())) return false;
    largest = std::max(largest, std::abs(valueOf(*p)));
  }
  if (!(largest > 0)) return true;
  const Number scale = std::ldexp(1.0, -std::ilogb(largest));
  for (Number* p : entries) *p = scale * *p;
  const Number rounding = kRootRoundingOf<Number>, zero = 0;
  if (!(zero <= f.p00 && zero <= f.p11 && zero <= f.p22)) return false;
  if (zero <= f.p01 && zero <= f.p02 && zero <= f.p12) return true;
  const Number r0 = squareRoot(f.p00), r1 = squareRoot(f.p11), r2 = squareRoot(f.p22);
  const auto edge = [&](const Number& p, const Number& roots) -> Number {
    return p + roots - rounding * (absolute(p) + roots);
  };
  const Number e01 = edge(f.p01, r0 * r1), e02 = edge(f.p02, r0 * r2), e12 = edge(f.p12, r1 * r2);
  if (!(zero <= e01 && zero <= e02 && zero <= e12)) return false;
  const Number all = r0 * r1 * r2, a = f.p01 * r2, b = f.p02 * r1, c = f.p12 * r0;
  const Number two = 2, last = squareRoot(two * e01 * e02 * e12);
  return rounding * (all + absolute(a) + absolute(b) + absolute(c) + last) <=
         all + a + b + c + last;
}

/// A corner of a triangle of directions, and of either core a convex combination of its pieces: a
/// point, and a share `share` of the ellipsoid with semi-axes M around it. All of it is linear
/// between the corners.
template <class Wide>
struct CurvedCorner {
  Wide x;           ///< direction
  Wide center;      ///< B's centre less A's
  Wide scaled[2];   ///< M x of A and B, in their frames
  double share[2];  ///< of A and B
};

/// True when x . center + sum over A and B of share |M x| is at least depth |x| for all x between
/// three corners, all of it linear between them and the weights' sum 1; `slack` [m^2, or m where x
/// has no unit] is what rounding may take off x . center and the like, sizes the cores' extents.
/// O(1).
///
/// A quadratic form below the bound on all of a cell. With e a unit vector, l = e . v and r what v
/// has across e: |v| = sqrt(l^2 + r^2) = l + r^2 / (sqrt(l^2 + r^2) + l), whose denominator is
/// largest at corners; and |v| <= (l^2 + r^2) / (2 k l) + k l / 2 for l > 0 and any k > 0, which is
/// best in the middle between e and the corners with k^2 = 1 + r^2 / (2 l^2) of theirs.
template <class Number, class Wide>
bool provesCell(const CurvedCorner<Wide> (&corners)[3], const double (&sizes)[2],
                const Number& depth, const Number& slack) {
  // Directions of one length, the least of the three: r^2 / (2 l) is taken with one l for all.
  CurvedCorner<Wide> c[3] = {corners[0], corners[1], corners[2]};
  double lengths[3];
  for (int i = 0; i < 3; ++i) lengths[i] = norm(valueOf(c[i].x));
  const double least_length = std::min({lengths[0], lengths[1], lengths[2]});
  if (!(least_length > 0)) return false;
  for (int i = 0; i < 3; ++i) {
    const Number shorter = least_length / lengths[i];
    for (Wide* v : {&c[i].x, &c[i].scaled[0], &c[i].scaled[1]}) *v = scaledBy(shorter, *v);
  }
  Form<Number> form;
  form.add([&](int i, int j) -> Number { return dot(c[i].x, c[j].center); });
  constexpr double kThird = 1.0 / 3;
  Number along[3];
  Wide across[3];
  const auto split = [&](const Wide& v0, const Wide& v1, const Wide& v2, double size) {
    const Wide middle = scaledBy(Number(kThird), Wide(v0 + v1 + v2));
    const Number length = norm(middle);
    if (!(valueOf(length) > size)) return false;
    const Wide e = scaledBy(Number(1) / length, middle);
    const Wide* v[3] = {&v0, &v1, &v2};
    for (int i = 0; i < 3; ++i) {
      along[i] = dot(e, *v[i]);
      across[i] = *v[i] - scaledBy(along[i], e);
    }
    return true;
  };
  const auto larger = [](const Number& p, const Number& q) { return p < q ? q : p; };
  for (int k = 0; k < 2; ++k) {
    const double least_share = std::min({c[0].share[k], c[1].share[k], c[2].share[k]});
    const double most_share = std::max({c[0].share[k], c[1].share[k], c[2].share[k]});
    // (Where the direction is lost, 0 is a bound, too.)
    if (!(most_share > 0) ||
        !split(c[0].scaled[k], c[1].scaled[k], c[2].scaled[k], kLostShare * sizes[k])) {
      continue;
    }
    Number l = 0, l_squared = 0, r_squared = 0;
    for (int i = 0; i < 3; ++i) {
      l = larger(l, along[i]);
      l_squared = larger(l_squared, along[i] * along[i]);
      r_squared = larger(r_squared, dot(across[i], across[i]));
    }
    const Number bend = Number(least_share) / (l + squareRoot(l_squared + r_squared));
    form.add([&](int i, int j) -> Number {
      return c[i].share[k] * along[j] + bend * dot(across[i], across[j]);
    });
  }
  if (!split(c[0].x, c[1].x, c[2].x, 0)) return false;
  const Number nearest = -larger(-along[0], larger(-along[1], -along[2]));
  if (!(valueOf(nearest) > 0)) return false;
  double r_squared = 0;
  for (const Wide& v : across) r_squared = std::max(r_squared, valueOf(dot(v, v)));
  const double l = valueOf(nearest);
  const Number k = std::sqrt(1 + 0.5 * r_squared / (l * l)), half = 0.5;
  const Number straight = half / k + half * k, bend = half / (k * nearest);
  form.add([&](int i, int j) -> Number {
    return -(depth * (straight * along[j] + bend * dot(across[i], across[j])));
  });
  for (Number* p : {&form.p00, &form.p11, &form.p22, &form.p01, &form.p02, &form.p12}) {
    *p = *p - slack;
  }
  return copositive(form);
}

}  // namespace leeway::collision
