#include "collision/convex/round_depth/curved_depth.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "collision/base/tolerances.h"
#include "collision/convex/pairs/closed_form.h"
#include "collision/convex/round_depth/cell_bound.h"
#include "collision/convex/round_depth/common_axis.h"
#include "collision/convex/round_depth/curved_planes.h"

namespace leeway::collision {

namespace {

// The work of a direction in which a hull's vertices are blended [count].
constexpr std::int64_t kHullWork = 4;
// Back-off: after descents that found nothing, up to this many are skipped [count].
constexpr int kLongestRest = 255;
// Halvings of a face of the octahedron [count]. Most corners' coordinates stay exact, so that cells
// that share an edge leave no gap. (A search ends at the first inexact one.)
constexpr int kMostHalvings = 96;
// Halvings of a half plane [count].
constexpr int kMostPlaneHalvings = 48;
// The back-off ends at every cell whose halvings are a multiple of this [count].
constexpr int kHalvingsPerLook = 32;
// Stiffnesses tried for a choice [count].
constexpr int kStiffnesses = 16;
// Share of the width that may be used by axes that are not quite parallel.
constexpr double kShareOfAxis = 0.2;

// Factor to the next stiffness: small steps at first, and finally to the farthest piece alone.
double stifferBy(int i) { return i < kStiffnesses / 2 ? 4 : 64; }

// A direction at which the bound is evaluated.
struct Node {
  Vector x;  // exact, of a length from 0.5 to 1
  CurvedChoice choice;
  CurvedCorner corner;
  double value, length;  // the bound at x, and the length of x
  int looks;             // CurvedDepth::looks_ of the depth for which it was chosen
};

struct Cell {
  Node node[3];
  int halvings;
};

// (Points need a hull, because there are too many triangles of meshes.)
bool isSearched(const ConvexView& view) {
  return view.core == Core::kPoint || view.core == Core::kSegment || view.core == Core::kBox ||
         (view.core == Core::kPoints && view.hull != nullptr) || isRound(view.core);
}

// The ball in an ellipsoid whose axes are nearly equal; its radius is 0 for any other ellipsoid.
NearlyBall nearlyBall(const Vector& semi_axes) {
  NearlyBall ball;
  const double least = semi_axes.minCoeff(), most = semi_axes.maxCoeff();
  if (!(most - least <= kSlightlyLonger * least && least > 0)) return ball;
  ball.radius = least;
  ball.sum = least + most;
  for (int i = 0; i < 3; ++i) {
    const double m = semi_axes[i];
    ball.spread[i] = std::sqrt((m - least) * (m + least)) / m;
  }
  return ball;
}

class CurvedDepth {
 public:
  CurvedDepth(Difference<false>& difference, Progress& progress);
  bool run();

 private:
  std::int64_t workLeft() const { return work_limit_ - planes_.work(); }
  Node nodeAt(const Vector& x);
  void fill(Node& node) const;
  void look(const Vector& e);
  void lookBelow(const Vector& e);
  void setDepth();
  bool startSearch();
  bool search();
  bool provesAtPoint() const;
  bool proves(const Cell& cell);
  double bentAlong(const Cell& cell, int i, int j, bool edges) const;
  bool renew(Cell& cell);
  bool halve(Cell& cell, bool edges, Cell& other);
  template <class Halve>
  bool provesCells(Cell* stack, int count, int most_halvings, std::int64_t spare,
                   const Halve& halve);
  bool provesAll(bool edges, std::int64_t spare);
  bool provesHalfPlane(const CommonAxis& axis);
  bool provesAroundAxis(double wanted);
  bool provesByStages(double wanted, double offsets);
  void claim(double less);

  Progress& progress_;
  const double roundoff_;
  CurvedPlanes planes_;
  const CurvedFaces& faces_;
  double sizes_[2];
  NearlyBall balls_[2];
  bool has_balls_ = false;
  const std::int64_t node_work_;
  const std::int64_t work_limit_;
  // Back-off: the number of successive descents that found nothing, and how many to skip.
  int idle_ = 0, rest_ = 0;
  double gap_ = 0;  // the depth to prove is this much less than the nearest plane [m]
  double depth_ = std::numeric_limits<double>::infinity();  // to be proven [m]
  double wanted_ = 0;  // a support below this leads to a closer plane [m]
  int looks_ = 0;      // how often the depth has decreased
};

CurvedDepth::CurvedDepth(Difference<false>& difference, Progress& progress)
    : progress_(progress),
      roundoff_(progress.query().roundoff),
      planes_(difference, progress, kEvenly),
      faces_(planes_.faces()),
      sizes_{faces_.semiAxes(0).maxCoeff(), faces_.semiAxes(1).maxCoeff()},
      node_work_(faces_.hasHull() ? kHullWork : 1),
      work_limit_(kCellsPerStep * progress.query().request.iteration_limit) {
  for (int k = 0; k < 2; ++k) {
    if (faces_.view(k).core == Core::kEllipsoid) balls_[k] = nearlyBall(faces_.semiAxes(k));
    has_balls_ |= balls_[k].radius > 0;
  }
}

Node CurvedDepth::nodeAt(const Vector& x) {
  Node node;
  node.x = x;
  planes_.spend(node_work_);
  const CurvedFace face = faces_.along(x);
  const double support = faces_.support(face, node.choice);
  if (support < wanted_) look(face.e);
  // A blend below the depth lies far from an edge, where it needs more of the farther piece, or
  // near a place on the edge that is closer than the depth.
  double times = 1;
  for (int i = 0; i < kStiffnesses; ++i, times *= stifferBy(i)) {
    const Vector y = faces_.blend(face, depth_, times, node.choice);
    if (face.e.dot(y) >= wanted_) break;
    if (i > 0) continue;
    lookBelow(face.e);
    if (face.e.dot(y) >= wanted_) break;
  }
  node.looks = looks_;
  fill(node);
  return node;
}

// Evaluates the choice.
void CurvedDepth::fill(Node& node) const {
  CurvedCorner& c = node.corner;
  const Vector& x = node.x;
  c.x = x;
  const Pose& X_BA = planes_.pose();
  c.center = faces_.center(1, node.choice) - placed(X_BA, faces_.center(0, node.choice));
  c.scaled[0] = faces_.semiAxes(0).cwiseProduct(rotatedBack(X_BA.rotation, x));
  c.scaled[1] = faces_.semiAxes(1).cwiseProduct(x);
  node.value = x.dot(c.center);
  for (int k = 0; k < 2; ++k) {
    c.share[k] = faces_.share(k, node.choice);
    node.value += c.share[k] * c.scaled[k].norm();
  }
  node.length = x.norm();
}

// Sets the depth to be proven. It only decreases, so what is proven stays proven.
void CurvedDepth::setDepth() {
  const double reach = planes_.reach(), depth = reach - std::min(gap_, 0.25 * reach);
  if (!(depth < depth_)) return;
  ++looks_;
  // (Twice, so that the parameters kept before have no effect.)
  for (int i = 0; i < 2; ++i) {
    CurvedChoice choice;
    faces_.blend(faces_.along(-progress_.normal()), reach, 1, choice);
    planes_.faces().keepNear(choice);
  }
  depth_ = depth;
  wanted_ = depth + 2 * kCellRounding * roundoff_;
}

// Descends from a direction in which the difference is not farther out than the depth.
void CurvedDepth::look(const Vector& e) {
  const double before = planes_.reach(), value = planes_.ask(e);
  if (!(value < before)) return;
  planes_.descend(e, value);
  setDepth();
}

// Descends from a direction in which the difference is farther out, but next to which an edge may
// not be.
void CurvedDepth::lookBelow(const Vector& e) {
  if (rest_ > 0) {
    --rest_;
    return;
  }
  const double before = planes_.reach();
  planes_.descend(e, planes_.ask(e));
  if (planes_.reach() < before) {
    idle_ = 0;
    setDepth();
  } else {
    idle_ = std::min(2 * idle_ + 1, kLongestRest);
    rest_ = idle_;
  }
}

// clang-format off
// Rounding of a cell's bound, in units of u L with u = kUnitRoundoff and L = extent A + extent B + |t|; directions are
// exact and no longer than 1.
//   centres                                                        8
//   M x                                                            5
//   x . C                                                          11
//   the product of each round part, with its unit vector's error   20
//   the product of the depth, which is less than L                 16
//   their sum                                                      8
// In all less than 80.
// clang-format on
bool CurvedDepth::proves(const Cell& cell) {
  planes_.spend(1);
  const Node* node = cell.node;
  const CurvedCorner corners[3] = {node[0].corner, node[1].corner, node[2].corner};
  double margins[3];
  for (int i = 0; i < 3; ++i) {
    margins[i] = node[i].value - depth_ * node[i].length - kCellRounding * roundoff_;
  }
  if (has_balls_ && CellBound(corners, sizes_, roundoff_, balls_).proves(margins, depth_)) {
    return true;
  }
  CellBound bound(corners, sizes_, roundoff_);
  if (bound.proves(margins, depth_)) return true;
  if (bound.seemsBelow()) lookBelow(bound.leastDirection().normalized());
  return false;
}

// Claims the proven depth, minus `less`, which the proof left open, with the member that lies along
// the nearest plane's normal.
void CurvedDepth::claim(double less) {
  const CurvedFace face = faces_.along(-progress_.normal());
  const double reach = planes_.reach(), wide = std::max(reach - depth_, 0.0);
  CurvedChoice choice;
  Vector a, other_a;
  faces_.blend(face, reach, 1, choice);
  Vector w = planes_.memberOf(face, choice, wide, a);
  faces_.support(face, choice);
  const Vector other = planes_.memberOf(face, choice, wide, other_a);
  if ((other - reach * face.e).norm() < (w - reach * face.e).norm()) w = other, a = other_a;
  progress_.offerWitness(less - depth_, w, a);
}

// Proves rough depths first: they stay proven if the search for the last digits does not end.
bool CurvedDepth::provesByStages(double wanted, double offsets) {
  for (const double share : {kRoughDepths[0], kRoughDepths[1], 0.0}) {
    gap_ = 0.75 * share * (roundoff_ / kUnitRoundoff);
    if (!(gap_ > 4 * wanted)) gap_ = wanted;
    const bool last = gap_ == wanted;
    if (!last && progress_.upper() - progress_.lower() <= 2 * gap_ + offsets) continue;
    if (!search()) return false;
    claim(0);
    if (last) return true;
    if (progress_.enough()) break;
  }
  return false;
}

bool CurvedDepth::run() {
  const CoreQuery& query = progress_.query();
  const double offsets = query.lower_offset - query.upper_offset;
  // A quarter of the width is reserved for the plane and for rounding. (In this order, so that a
  // NaN tolerance counts as the least.)
  const double wanted =
      std::max(4 * kCellRounding * roundoff_, 0.75 * (query.request.tolerance - offsets));
  if (progress_.upper() - progress_.lower() <= wanted + offsets) return false;
  const bool proven = provesAroundAxis(wanted) || provesByStages(wanted, offsets);
  // (At most the limit, except for the last descent.)
  progress_.iterations += static_cast<int>(planes_.work() / kCellsPerStep);
  return proven;
}

// Estimates, up to a factor, the error of a cell's bound along its edge from corner i to j: for
// each |v|, the fourth power of the angle by which v turns. For needle-like ellipsoids, v turns
// within a strip as narrow as they are thin; cells may be long along it. (Shares and lengths are
// those of the whole cell, so that an edge counts for more than its parts; otherwise cells become
// flat, never small.)
double CurvedDepth::bentAlong(const Cell& cell, int i, int j, bool edges) const {
  const auto bent = [&](double share, const auto& of) {
    double length = 0;
    for (const Node& node : cell.node) length = std::max(length, of(node).norm());
    const double way = (of(cell.node[i]) - of(cell.node[j])).norm();
    const double turn = length > way ? way / length : 1;
    return share * way * (turn * turn * turn);
  };
  double sum = bent(depth_, [](const Node& node) -> const Vector& { return node.x; });
  for (int k = 0; k < 2; ++k) {
    double share = 0;
    for (const Node& node : cell.node) share = std::max(share, node.corner.share[k]);
    if (!(share > 0)) continue;
    sum += bent(share, [k](const Node& node) -> const Vector& { return node.corner.scaled[k]; });
  }
  if (edges) {
    const Vector way = cell.node[i].corner.center - cell.node[j].corner.center;
    sum += way.squaredNorm() / (8 * depth_);
  }
  return sum;
}

// Finds the nearest plane, and with it the depth to be proven; false if there is none.
bool CurvedDepth::startSearch() {
  if (!(-(progress_.lower() + progress_.query().lower_offset) > 0)) return false;
  planes_.forgetReach();
  depth_ = std::numeric_limits<double>::infinity();
  look(-progress_.normal());
  return depth_ > 0 && std::isfinite(depth_) && !progress_.decided();
}

bool CurvedDepth::search() {
  if (!startSearch()) return false;
  if (provesAtPoint()) return true;
  // (Cells that use up the work of one way of halving are in most cases easy for the other.)
  return provesAll(false, workLeft() / 4) || provesAll(true, 0);
}

// The depth of two bodies is at least that of any point of one in the other, which has a closed
// form. If a corner or an edge lies in the middle of a round body, it is also at most that, and the
// difference is equally far out in many directions, which cells would have to prove one by one.
bool CurvedDepth::provesAtPoint() const {
  const CurvedFace face = faces_.along(-progress_.normal());
  CurvedChoice choice;
  faces_.blend(face, planes_.reach(), 1, choice);
  Vector a;
  const double wide = std::max(planes_.reach() - depth_, 0.0);
  const Vector b = planes_.memberOf(face, choice, wide, a) + a;
  // (Members err by less than kSupportRounding units, point distances by kClosedFormRounding.)
  const auto isDeep = [&](int part, const Vector& point) {
    const ConvexView& view = faces_.view(part);
    return hasPointDistance(view.core) &&
           -pointDistance(view, point).distance - kCellRounding * roundoff_ >= depth_;
  };
  const Pose& X_BA = planes_.pose();
  return isDeep(1, a) || isDeep(0, rotatedBack(X_BA.rotation, b - X_BA.translation));
}

// Evaluates again the corners that were chosen for a larger depth, because the best choice next to
// an edge depends on it. False if there are none.
bool CurvedDepth::renew(Cell& cell) {
  bool any = false;
  for (Node& node : cell.node) {
    if (node.looks == looks_) continue;
    node = nodeAt(node.x);
    any = true;
  }
  return any;
}

// Halves a cell across the edge, from corner i to corner j, along which its bound errs most. False
// if the middle is not exact.
bool CurvedDepth::halve(Cell& cell, bool edges, Cell& other) {
  int i = 0, j = 1;
  double most = -1;
  for (int k = 0; k < 3; ++k) {
    const double bent = bentAlong(cell, k, (k + 1) % 3, edges);
    if (bent > most) most = bent, i = k, j = (k + 1) % 3;
  }
  const Vector sum = cell.node[i].x + cell.node[j].x;
  if (!(sum - cell.node[i].x == cell.node[j].x && sum - cell.node[j].x == cell.node[i].x)) {
    return false;
  }
  const Node middle = nodeAt(0.5 * sum);
  ++cell.halvings;
  other = cell;
  cell.node[i] = middle;
  other.node[j] = middle;
  return true;
}

// True if the depth is proven in all cells of the stack, which halve() halves; ends when less work
// than `spare` is left.
template <class Halve>
bool CurvedDepth::provesCells(Cell* stack, int count, int most_halvings, std::int64_t spare,
                              const Halve& halve) {
  while (count > 0) {
    if (progress_.decided() || !(depth_ > 0)) return false;
    Cell& cell = stack[count - 1];
    if (proves(cell)) {
      --count;
      continue;
    }
    if (workLeft() <= spare) return false;
    if (cell.halvings % kHalvingsPerLook == 0) rest_ = 0;
    if (renew(cell)) continue;
    if (cell.halvings == most_halvings || !halve(cell, stack[count])) return false;
    ++count;
  }
  return true;
}

bool CurvedDepth::provesAll(bool edges, std::int64_t spare) {
  Node ends[2][3];
  for (int i = 0; i < 3; ++i) {
    ends[0][i] = nodeAt(Vector::Unit(i));
    ends[1][i] = nodeAt(-Vector::Unit(i));
  }
  Cell stack[8 + kMostHalvings];
  for (int octant = 0; octant < 8; ++octant) {
    stack[octant].halvings = 0;
    for (int i = 0; i < 3; ++i) stack[octant].node[i] = ends[octant >> i & 1][i];
  }
  return provesCells(stack, 8, kMostHalvings, spare,
                     [&](Cell& cell, Cell& other) { return halve(cell, edges, other); });
}

// Cells of a half plane are angles: the second and third corners are the same.
bool CurvedDepth::provesHalfPlane(const CommonAxis& axis) {
  Cell stack[2 + kMostPlaneHalvings];
  for (int i = 0; i < 2; ++i) {
    Cell& cell = stack[i];
    cell.halvings = 0;
    cell.node[0] = nodeAt(i == 0 ? Vector(-axis.along) : axis.along);
    cell.node[1] = cell.node[2] = nodeAt(axis.across);
  }
  return provesCells(stack, 2, kMostPlaneHalvings, 0, [&](Cell& cell, Cell& other) {
    const Node middle = nodeAt(0.5 * (cell.node[0].x + cell.node[1].x));
    ++cell.halvings;
    other = cell;
    cell.node[1] = cell.node[2] = middle;
    other.node[0] = middle;
    return true;
  });
}

// For bodies of revolution about axes that are nearly parallel. If the axes' excess is more than
// the requested width allows, only a rough depth is proven.
bool CurvedDepth::provesAroundAxis(double wanted) {
  const CommonAxis axis = commonAxis(faces_.view(0), planes_.pose(), faces_.view(1), roundoff_,
                                     0.25 * kShareOfAxis * wanted);
  if (!(axis.excess <= kRoughDepths[0] * (roundoff_ / kUnitRoundoff))) return false;
  gap_ = std::max(wanted - axis.excess, axis.excess);
  if (!startSearch() || !provesHalfPlane(axis)) return false;
  claim(axis.excess);
  return axis.excess <= kShareOfAxis * wanted;
}

}  // namespace

bool haveCurvedDepth(const ConvexView& a, const ConvexView& b) {
  return isSearched(a) && isSearched(b) && (isRound(a.core) || isRound(b.core));
}

bool offerCurvedDepth(Difference<false>& difference, Progress& progress) {
  return CurvedDepth(difference, progress).run();
}

}  // namespace leeway::collision
