#include "collision/curved_facet.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace leeway::collision {

namespace {

// Halvings of a cell [count]: rounding is counted for as many.
constexpr int kMostHalvings = 24;
// Cells of one facet [count]; more cover larger facets, and cost more where none do.
constexpr int kMostCells = 256;
// Cells of one query [count]: some two milliseconds.
constexpr int kMostCellsOfAll = 16'384;

// A quadratic form on a triangle: the value at mu is sum mu_i mu_j of it.
struct Form {
  double p00 = 0, p11 = 0, p22 = 0, p01 = 0, p02 = 0, p12 = 0;

  // The symmetrised product of two functions that are linear in mu.
  template <class Product>
  void add(const Product& product) {
    p00 += product(0, 0), p11 += product(1, 1), p22 += product(2, 2);
    p01 += 0.5 * (product(0, 1) + product(1, 0)), p02 += 0.5 * (product(0, 2) + product(2, 0));
    p12 += 0.5 * (product(1, 2) + product(2, 1));
  }
};

// Hadeler's criterion. Roots and sums err by a few units of roundoff of their terms, which are
// taken off.
bool copositive(const Form& f) {
  constexpr double kRounding = 16 * kUnitRoundoff;
  if (!(f.p00 >= 0 && f.p11 >= 0 && f.p22 >= 0)) return false;
  if (f.p01 >= 0 && f.p02 >= 0 && f.p12 >= 0) return true;
  const double r0 = std::sqrt(f.p00), r1 = std::sqrt(f.p11), r2 = std::sqrt(f.p22);
  const auto edge = [](double p, double roots) {
    return p + roots - kRounding * (std::abs(p) + roots);
  };
  const double e01 = edge(f.p01, r0 * r1), e02 = edge(f.p02, r0 * r2), e12 = edge(f.p12, r1 * r2);
  if (!(e01 >= 0 && e02 >= 0 && e12 >= 0)) return false;
  const double all = r0 * r1 * r2, a = f.p01 * r2, b = f.p02 * r1, c = f.p12 * r0;
  const double last = std::sqrt(2 * e01 * e02 * e12);
  return all + a + b + c + last >=
         kRounding * (all + std::abs(a) + std::abs(b) + std::abs(c) + last);
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
  slack_ = 256 * roundoff * (roundoff / kUnitRoundoff);
}

CurvedFacets::Corner CurvedFacets::cornerOf(const SupportPoint& s) const {
  const Pose& X_BA = difference_.pose();
  Corner c;
  c.x = s.w;
  // The centre of what a point of a round core is on, in the core's frame.
  const auto centerOf = [&](int k, int piece) {
    const ConvexView& view = *part_[k].view;
    const bool apex = view.core == Core::kCone && piece == 1;
    c.share[k] = apex ? 0 : 1;
    if (view.core == Core::kEllipsoid) return Vector(0, 0, 0);
    return Vector(0, 0, piece == 1 ? view.size.z() : -view.size.z());
  };
  c.share[0] = c.share[1] = 0;
  c.center_a = part_[0].curved ? placed(X_BA, centerOf(0, s.index_a)) : s.a;
  c.center = (part_[1].curved ? centerOf(1, s.index_b) : Vector(s.w + s.a)) - c.center_a;
  c.scaled[0] = part_[0].semi_axes.cwiseProduct(rotatedBack(X_BA.rotation, c.x));
  c.scaled[1] = part_[1].semi_axes.cwiseProduct(c.x);
  return c;
}

CurvedFacets::Corner CurvedFacets::between(const Corner& a, const Corner& b) {
  Corner c;
  c.x = 0.5 * (a.x + b.x);
  c.center = 0.5 * (a.center + b.center);
  c.center_a = 0.5 * (a.center_a + b.center_a);
  for (int k = 0; k < 2; ++k) {
    c.scaled[k] = 0.5 * (a.scaled[k] + b.scaled[k]);
    c.share[k] = 0.5 * (a.share[k] + b.share[k]);
  }
  return c;
}

// The bound itself in one direction.
bool CurvedFacets::holdsAt(const Corner& c, double depth) {
  const double length = c.x.norm();
  if (!(length > 0)) return false;
  const double support =
      c.x.dot(c.center) + c.share[0] * c.scaled[0].norm() + c.share[1] * c.scaled[1].norm();
  if (support < least_value_ * length) {
    least_value_ = support / length;
    least_direction_ = c.x;
  }
  return support - depth * length >= slack_;
}

// A quadratic form below the bound on all of a cell. With e a unit vector, l = e . v and r what v
// has across e: |v| = sqrt(l^2 + r^2) = l + r^2 / (sqrt(l^2 + r^2) + l), whose denominator is
// largest at corners; and |v| <= l + r^2 / (2 l) for l > 0.
bool CurvedFacets::proves(const Cell& cell, double depth) const {
  const Corner* c = cell.corner;
  Form form;
  form.add([&](int i, int j) { return c[i].x.dot(c[j].center); });
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
    // (Where the direction is lost, 0 is a bound, too.)
    if (!(most_share > 0) ||
        !split(c[0].scaled[k], c[1].scaled[k], c[2].scaled[k], 1e-12 * part_[k].view->extent)) {
      continue;
    }
    double l = 0, l_squared = 0, r_squared = 0;
    for (int i = 0; i < 3; ++i) {
      l = std::max(l, along[i]);
      l_squared = std::max(l_squared, along[i] * along[i]);
      r_squared = std::max(r_squared, across[i].squaredNorm());
    }
    const double bend = least_share / (l + std::sqrt(l_squared + r_squared));
    form.add(
        [&](int i, int j) { return c[i].share[k] * along[j] + bend * across[i].dot(across[j]); });
  }
  if (!split(c[0].x, c[1].x, c[2].x, 0)) return false;
  const double nearest = std::min({along[0], along[1], along[2]});
  if (!(nearest > 0)) return false;
  const double bend = 0.5 / nearest;
  form.add([&](int i, int j) { return -depth * (along[j] + bend * across[i].dot(across[j])); });
  form.p00 -= slack_, form.p11 -= slack_, form.p22 -= slack_;
  form.p01 -= slack_, form.p02 -= slack_, form.p12 -= slack_;
  return copositive(form);
}

bool CurvedFacets::covers(const SupportPoint& w0, const SupportPoint& w1, const SupportPoint& w2,
                          double depth) {
  least_value_ = std::numeric_limits<double>::infinity();
  Cell stack[kMostHalvings + 1];
  stack[0] = {{cornerOf(w0), cornerOf(w1), cornerOf(w2)}, 0};
  bool holds = true;
  for (const Corner& c : stack[0].corner) holds &= holdsAt(c, depth);
  if (!holds) return false;
  int count = 1;
  for (int cells = 0; count > 0; ++cells, --cells_left_) {
    Cell& cell = stack[count - 1];
    if (proves(cell, depth)) {
      --count;
      continue;
    }
    if (cells >= kMostCells || cells_left_ <= 0 || cell.depth == kMostHalvings) return false;
    // Halved across its longest edge: from corner i to corner j.
    int i = 0, j = 1;
    double longest = -1;
    for (int m = 0; m < 3; ++m) {
      const double squared = (cell.corner[m].x - cell.corner[(m + 1) % 3].x).squaredNorm();
      if (squared > longest) longest = squared, i = m, j = (m + 1) % 3;
    }
    const Corner middle = between(cell.corner[i], cell.corner[j]);
    if (!holdsAt(middle, depth)) return false;
    ++cell.depth;
    stack[count] = cell;
    cell.corner[i] = middle;
    stack[count].corner[j] = middle;
    ++count;
  }
  return true;
}

void CurvedFacets::member(const SupportPoint* const w[3], const double weights[3],
                          Vector& of_difference, Vector& of_a) const {
  Vector center(0, 0, 0), center_a(0, 0, 0), scaled[2] = {center, center};
  double share[2] = {0, 0};
  for (int i = 0; i < 3; ++i) {
    const Corner c = cornerOf(*w[i]);
    center += weights[i] * c.center;
    center_a += weights[i] * c.center_a;
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
