#include "collision/curved_facet.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "collision/sharp.h"

namespace leeway::collision {

namespace {

// Halvings of a cell [count]: rounding is counted for as many.
constexpr int kMostHalvings = 24;
// Cells of one facet [count]; more cover larger facets, and cost more where none do.
constexpr int kMostCells = 256;
// Cells of one query [count]: some two milliseconds.
constexpr int kMostCellsOfAll = 16'384;
// The same, of those that may be looked at in twice the precision: some ten milliseconds.
constexpr int kMostSharpCells = 4096;

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
constexpr double kRootRounding = 16 * kUnitRoundoff;
template <>
constexpr double kRootRounding<DoubleDouble> = 0x1p-80;

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
  const Number rounding = kRootRounding<Number>, zero = 0;
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

}  // namespace

// Rounding, in units of u L^2 with u = kUnitRoundoff and L = extent A + extent B + |t|, all of x,
// C and M within L: a vertex's x errs by 3 u L as a member (see support.h), its centres by 8, M x
// by 10; each of at most kMostHalvings means of two adds half a unit of each, 12 in all. A product
// of two of them then errs by less than 48, of which there are four in a bound (x . C; A; B; the
// depth, which is less than L); their own roundings are less than 8 of each. In all less than 224.
CurvedFacets::CurvedFacets(const Difference<false>& difference, double roundoff)
    : difference_(difference) {
  const ConvexView* views[2] = {&difference.viewA(), &difference.viewB()};
  for (int k = 0; k < 2; ++k) {
    const ConvexView& view = *views[k];
    part_[k].view = &view;
    part_[k].curved = isRound(view.core);
    if (view.core == Core::kEllipsoid) {
      part_[k].semi_axes = view.size;
    } else if (part_[k].curved) {
      part_[k].semi_axes = Vector(view.size.x(), view.size.x(), 0);
    }
    curved_ |= part_[k].curved;
  }
  cells_left_ = kMostCellsOfAll;
  sharp_cells_left_ = kMostSharpCells;
  const double size = roundoff / kUnitRoundoff;
  slack_ = 256 * roundoff * size;
  sharp_slack_ = 0x1p-80 * size * size;
}

// The centre of what a point of a round core is on, in the core's frame.
bool CurvedFacets::centerOf(int part, int piece, Vector& center) const {
  const ConvexView& view = *part_[part].view;
  if (!part_[part].curved) return false;
  center = Vector::Zero();
  if (view.core != Core::kEllipsoid) center.z() = piece == 1 ? view.size.z() : -view.size.z();
  return true;
}

Vector CurvedFacets::centerOfA(const SupportPoint& s) const {
  Vector center;
  return centerOf(0, s.index_a, center) ? placed(difference_.pose(), center) : s.a;
}

void CurvedFacets::shareOf(const SupportPoint& s, double share[2]) const {
  const int piece[2] = {s.index_a, s.index_b};
  for (int k = 0; k < 2; ++k) {
    const bool apex = part_[k].view->core == Core::kCone && piece[k] == 1;
    share[k] = part_[k].curved && !apex ? 1 : 0;
  }
}

CurvedFacets::Corner<Vector> CurvedFacets::cornerOf(const SupportPoint& s) const {
  Corner<Vector> c;
  c.x = s.w;
  shareOf(s, c.share);
  Vector center_b;
  if (!centerOf(1, s.index_b, center_b)) center_b = s.w + s.a;
  c.center = center_b - centerOfA(s);
  c.scaled[0] = part_[0].semi_axes.cwiseProduct(rotatedBack(difference_.pose().rotation, c.x));
  c.scaled[1] = part_[1].semi_axes.cwiseProduct(c.x);
  return c;
}

// In the world's axes, x the member that is made of the same points: facets that are flat enough
// and those that are looked at here then have their edges in common.
CurvedFacets::Corner<DoubleDoubleVector> CurvedFacets::sharpCornerOf(
    const SupportPoint& s, const SharpDifference& sharp) const {
  Corner<DoubleDoubleVector> c;
  shareOf(s, c.share);
  c.x = sharp.member(s, difference_.pose());
  Vector p_a, p_b;
  if (!centerOf(0, s.index_a, p_a)) vertex(sharp.a(), s.index_a, p_a);
  if (!centerOf(1, s.index_b, p_b)) vertex(sharp.b(), s.index_b, p_b);
  c.center = sharp.memberOf(p_a, p_b);
  const auto scaled = [](const Vector& m, const DoubleDoubleVector& v) {
    return DoubleDoubleVector(m.x() * v.x, m.y() * v.y, m.z() * v.z);
  };
  c.scaled[0] = scaled(part_[0].semi_axes, sharp.inA(c.x));
  c.scaled[1] = scaled(part_[1].semi_axes, sharp.inB(c.x));
  return c;
}

// The bound itself in one direction.
template <class Number, class Wide>
bool CurvedFacets::holdsAt(const Corner<Wide>& c, const Number& depth) {
  const Number length = norm(c.x);
  if (!(valueOf(length) > 0)) return false;
  const Number support =
      dot(c.x, c.center) + c.share[0] * norm(c.scaled[0]) + c.share[1] * norm(c.scaled[1]);
  if (valueOf(support) < least_value_ * valueOf(length)) {
    least_value_ = valueOf(support) / valueOf(length);
    least_direction_ = valueOf(c.x);
  }
  return valueOf(support - depth * length) >= slackOf(depth);
}

// A quadratic form below the bound on all of a cell. With e a unit vector, l = e . v and r what v
// has across e: |v| = sqrt(l^2 + r^2) = l + r^2 / (sqrt(l^2 + r^2) + l), whose denominator is
// largest at corners; and |v| <= l + r^2 / (2 l) for l > 0.
template <class Number, class Wide>
bool CurvedFacets::proves(const Cell<Wide>& cell, const Number& depth) const {
  const Corner<Wide>* c = cell.corner;
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
        !split(c[0].scaled[k], c[1].scaled[k], c[2].scaled[k], 1e-12 * part_[k].view->extent)) {
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
  const Number bend = Number(0.5) / nearest;
  form.add([&](int i, int j) -> Number {
    return -(depth * (along[j] + bend * dot(across[i], across[j])));
  });
  const Number slack = slackOf(depth);
  for (Number* p : {&form.p00, &form.p11, &form.p22, &form.p01, &form.p02, &form.p12}) {
    *p = *p - slack;
  }
  return copositive(form);
}

template <class Number, class Wide>
bool CurvedFacets::coversCells(const Corner<Wide> (&corners)[3], const Number& depth,
                               int& cells_left) {
  constexpr bool kSharp = std::is_same_v<Number, DoubleDouble>;
  const auto rounded = [](const Corner<Wide>& c) {
    return Corner<Vector>{valueOf(c.x),
                          valueOf(c.center),
                          {valueOf(c.scaled[0]), valueOf(c.scaled[1])},
                          {c.share[0], c.share[1]}};
  };
  const auto holds = [&](const Corner<Wide>& c) {
    if constexpr (kSharp) {
      if (holdsAt(rounded(c), valueOf(depth))) return true;
    }
    return holdsAt(c, depth);
  };
  const auto proven = [&](const Cell<Wide>& cell) {
    if constexpr (kSharp) {
      const Cell<Vector> coarse = {
          {rounded(cell.corner[0]), rounded(cell.corner[1]), rounded(cell.corner[2])}, cell.depth};
      if (proves(coarse, valueOf(depth))) return true;
    }
    --cells_left;
    return proves(cell, depth);
  };
  least_value_ = std::numeric_limits<double>::infinity();
  for (const Corner<Wide>& c : corners) {
    if (!holds(c)) return false;
  }
  Cell<Wide> stack[kMostHalvings + 1];
  stack[0] = {{corners[0], corners[1], corners[2]}, 0};
  int count = 1;
  for (int cells = 0; count > 0; ++cells) {
    Cell<Wide>& cell = stack[count - 1];
    if (proven(cell)) {
      --count;
      continue;
    }
    if (cells >= (kSharp ? kMostSharpCells : kMostCells) || cells_left <= 0 ||
        cell.depth == kMostHalvings) {
      return false;
    }
    // Halved across its longest edge: from corner i to corner j.
    int i = 0, j = 1;
    double longest = -1;
    for (int m = 0; m < 3; ++m) {
      const double squared =
          (valueOf(cell.corner[m].x) - valueOf(cell.corner[(m + 1) % 3].x)).squaredNorm();
      if (squared > longest) longest = squared, i = m, j = (m + 1) % 3;
    }
    const auto mean = [](const Wide& v, const Wide& w) -> Wide {
      return scaledBy(Number(0.5), Wide(v + w));
    };
    const Corner<Wide>&a = cell.corner[i], &b = cell.corner[j];
    const Corner<Wide> middle = {
        mean(a.x, b.x),
        mean(a.center, b.center),
        {mean(a.scaled[0], b.scaled[0]), mean(a.scaled[1], b.scaled[1])},
        {0.5 * (a.share[0] + b.share[0]), 0.5 * (a.share[1] + b.share[1])}};
    if (!holds(middle)) return false;
    ++cell.depth;
    stack[count] = cell;
    cell.corner[i] = middle;
    stack[count].corner[j] = middle;
    ++count;
  }
  return true;
}

bool CurvedFacets::covers(const SupportPoint& w0, const SupportPoint& w1, const SupportPoint& w2,
                          double depth) {
  const Corner<Vector> corners[3] = {cornerOf(w0), cornerOf(w1), cornerOf(w2)};
  return coversCells(corners, depth, cells_left_);
}

bool CurvedFacets::coversSharply(const SupportPoint& w0, const SupportPoint& w1,
                                 const SupportPoint& w2, const DoubleDouble& depth,
                                 const SharpDifference& sharp) {
  const Corner<DoubleDoubleVector> corners[3] = {sharpCornerOf(w0, sharp), sharpCornerOf(w1, sharp),
                                                 sharpCornerOf(w2, sharp)};
  return coversCells(corners, depth, sharp_cells_left_);
}

void CurvedFacets::member(const SupportPoint* const w[3], const double weights[3],
                          Vector& of_difference, Vector& of_a) const {
  Vector center(0, 0, 0), center_a(0, 0, 0), scaled[2] = {center, center};
  double share[2] = {0, 0};
  for (int i = 0; i < 3; ++i) {
    const Corner<Vector> c = cornerOf(*w[i]);
    center += weights[i] * c.center;
    center_a += weights[i] * centerOfA(*w[i]);
    for (int k = 0; k < 2; ++k) {
      scaled[k] += weights[i] * c.scaled[k];
      share[k] += weights[i] * c.share[k];
    }
  }
  // The farthest point of an ellipsoid along x, from its centre, is M M x / |M x|.
  Vector arm[2];
  for (int k = 0; k < 2; ++k) {
    const double length = scaled[k].norm();
    arm[k] = (length > 0 ? share[k] / length : 0) * part_[k].semi_axes.cwiseProduct(scaled[k]);
  }
  const Vector arm_a = rotated(difference_.pose().rotation, arm[0]);
  of_a = center_a - arm_a;
  of_difference = center + arm_a + arm[1];
}

}  // namespace leeway::collision
