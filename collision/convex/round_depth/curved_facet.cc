#include "collision/convex/round_depth/curved_facet.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "collision/base/tolerances.h"
#include "collision/convex/gjk/sharp.h"

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

}  // namespace

// Rounding, in units of u L^2 with u = kUnitRoundoff and L = extent A + extent B + |t|, all of x,
// C and M within L: a vertex's x errs by 3 u L as a member (see support.h), its centres by 8, M x
// by 10; each of at most kMostHalvings means of two adds half a unit of each, 12 in all. A product
// of two of them then errs by less than 48, of which there are four in a bound (x . C; A; B; the
// depth, which is less than L); their own roundings are less than 8 of each. In all less than 224,
// and less than 16 more for what cells do to corners' lengths.
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
  slack_ = kFacetRounding * roundoff * size;
  sharp_slack_ = kSharpFacetRounding * size * size;
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
  c.center = sharp.memberOf(DoubleDoubleVector(p_a), DoubleDoubleVector(p_b));
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
  const double sizes[2] = {part_[0].view->extent, part_[1].view->extent};
  const auto proven = [&](const Cell<Wide>& cell) {
    if constexpr (kSharp) {
      const Corner<Vector> coarse[3] = {rounded(cell.corner[0]), rounded(cell.corner[1]),
                                        rounded(cell.corner[2])};
      if (provesCell(coarse, sizes, valueOf(depth), slack_)) return true;
    }
    --cells_left;
    return provesCell(cell.corner, sizes, depth, Number(slackOf(depth)));
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
