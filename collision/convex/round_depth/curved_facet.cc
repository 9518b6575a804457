#include "collision/convex/round_depth/curved_facet.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"

namespace leeway::collision {

namespace {

// Limit on the halvings of a cell [count]: the slack covers the rounding of this many.
constexpr int kMostFacetHalvings = 24;
// Cells of one facet [count]. More cells cover larger facets, but cost more if they fail.
constexpr int kMostCells = 256;

}  // namespace

// clang-format off
// Rounding, with u = kUnitRoundoff and L = extent A + extent B + |t|; x, C and M are within L.
//
// In units of u L:
//   a vertex's x, as a member (see support.h)                      3
//   its centres                                                    8
//   M x                                                            10
//   at most kMostFacetHalvings means of two, half a unit each      12
//
// In units of u L^2:
//   a product of two of these                                      < 48
//   four such products: x . C; A; B; depth, which is less than L   < 192
//   their own roundings, 8 of each                                 < 32
//   scaling the corners' lengths                                   < 16
//
// In all less than 240, which kFacetRounding covers.
// clang-format on
CurvedFacets::CurvedFacets(const Difference<false>& difference, double roundoff,
                           int iteration_limit)
    : difference_(difference), most_cells_(kFacetCellsPerStep * iteration_limit) {
  const ConvexView* views[2] = {&difference.viewA(), &difference.viewB()};
  for (int k = 0; k < 2; ++k) {
    const ConvexView& view = *views[k];
    part_[k].view = &view;
    part_[k].curved = isRound(view.core);
    if (view.core == Core::kEllipsoid) {
      part_[k].semi_axes = view.size;
    } else if (part_[k].curved) {  // a cylinder or cone
      part_[k].semi_axes = Vector(view.size.x(), view.size.x(), 0);
    }
    curved_ |= part_[k].curved;
  }
  cells_left_ = most_cells_;
  slack_ = kFacetRounding * roundoff * (roundoff / kUnitRoundoff);
}

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

CurvedCorner CurvedFacets::cornerOf(const SupportPoint& s) const {
  CurvedCorner c;
  c.x = s.w;
  shareOf(s, c.share);
  Vector center_b;
  if (!centerOf(1, s.index_b, center_b)) center_b = s.w + s.a;
  c.center = center_b - centerOfA(s);
  c.scaled[0] = part_[0].semi_axes.cwiseProduct(rotatedBack(difference_.pose().rotation, c.x));
  c.scaled[1] = part_[1].semi_axes.cwiseProduct(c.x);
  return c;
}

// Evaluates the bound in one direction.
bool CurvedFacets::holdsAt(const CurvedCorner& c, double depth) {
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

bool CurvedFacets::covers(const SupportPoint& w0, const SupportPoint& w1, const SupportPoint& w2,
                          double depth) {
  const CurvedCorner corners[3] = {cornerOf(w0), cornerOf(w1), cornerOf(w2)};
  const double sizes[2] = {part_[0].view->extent, part_[1].view->extent};
  least_value_ = std::numeric_limits<double>::infinity();
  for (const CurvedCorner& c : corners) {
    if (!holdsAt(c, depth)) return false;
  }
  Cell stack[kMostFacetHalvings + 1];
  stack[0] = {{corners[0], corners[1], corners[2]}, 0};
  int count = 1;
  for (int cells = 0; count > 0; ++cells) {
    Cell& cell = stack[count - 1];
    --cells_left_;
    if (provesCell(cell.corner, sizes, depth, slack_)) {
      --count;
      continue;
    }
    if (cells >= kMostCells || cells_left_ <= 0 || cell.depth == kMostFacetHalvings) {
      return false;
    }
    // Halves the cell across its longest edge, from corner i to corner j.
    int i = 0, j = 1;
    double longest = -1;
    for (int m = 0; m < 3; ++m) {
      const double squared = (cell.corner[m].x - cell.corner[(m + 1) % 3].x).squaredNorm();
      if (squared > longest) longest = squared, i = m, j = (m + 1) % 3;
    }
    const auto mean = [](const Vector& v, const Vector& w) -> Vector { return 0.5 * (v + w); };
    const CurvedCorner &a = cell.corner[i], &b = cell.corner[j];
    const CurvedCorner middle = {
        mean(a.x, b.x),
        mean(a.center, b.center),
        {mean(a.scaled[0], b.scaled[0]), mean(a.scaled[1], b.scaled[1])},
        {0.5 * (a.share[0] + b.share[0]), 0.5 * (a.share[1] + b.share[1])}};
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
    const CurvedCorner c = cornerOf(*w[i]);
    center += weights[i] * c.center;
    center_a += weights[i] * centerOfA(*w[i]);
    for (int k = 0; k < 2; ++k) {
      scaled[k] += weights[i] * c.scaled[k];
      share[k] += weights[i] * c.share[k];
    }
  }
  // Relative to its centre, an ellipsoid's farthest point along x is M M x / |M x|.
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
