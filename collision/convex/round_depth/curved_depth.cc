#include "collision/convex/round_depth/curved_depth.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "collision/base/tolerances.h"
#include "collision/convex/round_depth/cell_bound.h"
#include "collision/convex/round_depth/curved_face.h"

namespace leeway::collision {

namespace {

// Cells, directions and planes that one step of the caller's limit is worth [count]: some 0.3 us
// each. Less leaves more of the long run's needles wider than asked, one case in a hundred at a
// twentieth of it.
constexpr std::int64_t kWorkPerStep = 320;
// What a direction is worth where a hull's vertices are blended, too.
constexpr std::int64_t kHullWork = 8;
// Descents beside directions that are far enough out which found nothing, and after how many of
// these at the most the next is tried [count].
constexpr int kLongestRest = 63;
// Halvings of a face of the octahedron: most corners' coordinates are exact then, and cells that
// share an edge leave nothing between them. (A search ends at the first that is not.)
constexpr int kMostHalvings = 96;
// Cells that have been halved so often since the last such one end the rest from descents [count].
constexpr int kHalvingsPerLook = 8;
// Stiffnesses, and Newton's steps, their halves and steps back onto an edge [count].
constexpr int kStiffnesses = 16;
constexpr int kDescentSteps = 12;
constexpr int kHalves = 4;
constexpr int kEdgeSteps = 3;
constexpr int kNearestSteps = 32;
// Least stiffnesses of what is apart [of the sizes involved].
constexpr double kNearestStiffnesses[] = {0, 1e-4, 1};

// From one stiffness to the next: by and by, and to what is as good as the farthest piece.
double stifferBy(int i) { return i < kStiffnesses / 2 ? 4 : 64; }

// Where a direction is looked at.
struct Node {
  Vector x;  // exact, of a length from 0.5 to 1
  CurvedChoice choice;
  CurvedCorner corner;
  double value, length;  // the bound there, and the length of x
  int looks;  // see CurvedDepth: what it has been chosen for may be farther out than the depth now
};

struct Cell {
  Node node[3];
  int halvings;
};

// (Triangles of meshes and the like are many: they are others' work.)
bool isCounted(const ConvexView& view) {
  return view.core == Core::kPoint || view.core == Core::kSegment || view.core == Core::kBox ||
         (view.core == Core::kPoints && view.hull != nullptr) || isRound(view.core);
}

class CurvedDepth {
 public:
  CurvedDepth(Difference<false>& difference, Progress& progress, double evenly);
  bool run();
  void findNearest();

 private:
  Node nodeAt(const Vector& x);
  void fill(Node& node) const;
  void look(const Vector& e);
  void lookBelow(const Vector& e);
  double askPlane(const Vector& e);
  Vector nextFrom(const Vector& e, const Vector& step, const CurvedEdge* edge, int edges) const;
  void descend(Vector e, double value);
  bool meetsCap(const CurvedFace& face, int part, double wide) const;
  Vector memberOf(const CurvedFace& face, const CurvedChoice& choice, double wide,
                  Vector& point_a) const;
  double offerNearest(const CurvedFace& face, const CurvedChoice& choice);
  double offerNearest(const Vector& e);
  void stepNearer();
  Vector stepOnto(const CurvedFace& face, const CurvedEdge* edge, int edges) const;
  Vector stepFrom(const CurvedFace& face, CurvedEdge* edge, int& edges) const;
  void setDepth();
  bool search();
  bool proves(const Cell& cell);
  bool provesBalls(const CurvedCorner (&corners)[3], const double (&margins)[3],
                   double depth) const;
  double bentAlong(const Cell& cell, int i, int j, bool edges) const;
  bool provesAll(bool edges, std::int64_t spare);
  void claim();

  Difference<false>& difference_;
  Progress& progress_;
  const double roundoff_;
  CurvedFaces faces_;
  double sizes_[2];
  NearlyBall balls_[2];
  bool has_balls_ = false;
  const std::int64_t node_work_;
  std::int64_t work_left_;
  int idle_ = 0, rest_ = 0;  // descents that found nothing, and for how many to do without
  double reach_ = 0;         // the nearest plane asked
  double gap_ = 0;           // how much less is to be proven
  double depth_ = std::numeric_limits<double>::infinity();  // what is to be proven
  double stiff_ = 0;                                        // the least for blending [m]
  double wanted_ = 0;  // directions in which the difference is nearer lead to a nearer plane
  int looks_ = 0;      // how often the depth has become less
};

CurvedDepth::CurvedDepth(Difference<false>& difference, Progress& progress, double evenly)
    : difference_(difference),
      progress_(progress),
      roundoff_(progress.query().roundoff),
      faces_(difference, evenly),
      sizes_{faces_.semiAxes(0).maxCoeff(), faces_.semiAxes(1).maxCoeff()},
      node_work_(faces_.hasHull() ? kHullWork : 1),
      work_left_(kWorkPerStep * progress.query().request.iteration_limit) {
  for (int k = 0; k < 2; ++k) {
    if (faces_.view(k).core != Core::kEllipsoid) continue;
    const Vector& m = faces_.semiAxes(k);
    const double least = m.minCoeff(), most = m.maxCoeff();
    if (!(most - least <= kSlightlyLonger * least && least > 0)) continue;
    balls_[k].radius = least;
    balls_[k].sum = least + most;
    for (int i = 0; i < 3; ++i) {
      balls_[k].spread[i] = std::sqrt((m[i] - least) * (m[i] + least)) / m[i];
    }
    has_balls_ = true;
  }
}

Node CurvedDepth::nodeAt(const Vector& x) {
  Node node;
  node.x = x;
  work_left_ -= node_work_;
  const CurvedFace face = faces_.along(x);
  const double support = faces_.support(face, node.choice);
  if (support < wanted_) look(face.e);
  // Less than the depth it may be far from an edge, where more of the piece that is farther is
  // needed, or close to a place on it that is nearer than the depth.
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

// What follows from the choice.
void CurvedDepth::fill(Node& node) const {
  CurvedCorner& c = node.corner;
  const Vector& x = node.x;
  c.x = x;
  const Pose& X_BA = difference_.pose();
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

// Offers the plane across e, and tells how far it is. (A step along ways of next to no length may
// be so long that its direction is lost, and 0 or no number: that is no plane.)
double CurvedDepth::askPlane(const Vector& e) {
  SupportPoint s;
  --work_left_;
  if (!(e.squaredNorm() > 0.5)) return std::numeric_limits<double>::infinity();
  difference_.support(-e, s);
  const double value = e.dot(s.w);
  progress_.offerLower(-value, -e);
  reach_ = std::min(reach_, value);
  return value;
}

// The depth to be proven. It only becomes less, so that what is proven stays so.
void CurvedDepth::setDepth() {
  const double depth = reach_ - std::min(gap_, 0.25 * reach_);
  if (!(depth < depth_)) return;
  ++looks_;
  // Once more, so that what has been kept before does not move it.
  for (int i = 0; i < 2; ++i) {
    CurvedChoice choice;
    faces_.blend(faces_.along(-progress_.normal()), reach_, 1, choice);
    faces_.keepNear(choice);
  }
  depth_ = depth;
  wanted_ = depth + 2 * kCellRounding * roundoff_;
}

// The step onto one or two edges of the difference.
Vector CurvedDepth::stepOnto(const CurvedFace& face, const CurvedEdge* edge, int edges) const {
  const auto besideOf = [&](const CurvedEdge& of, double& gain) {
    const Vector way = faces_.wayOf(face, of);
    gain = face.e.dot(way);
    return Vector(way - gain * face.e);
  };
  double gain_a = 0, gain_b = 0;
  const Vector a = besideOf(edge[0], gain_a);
  const double aa = a.squaredNorm();
  if (edges == 2) {
    const Vector b = besideOf(edge[1], gain_b);
    const double ab = a.dot(b), bb = b.squaredNorm(), determinant = aa * bb - ab * ab;
    if (determinant > kSameDirectionSquared * aa * bb) {
      return ((ab * gain_b - bb * gain_a) / determinant) * a +
             ((ab * gain_a - aa * gain_b) / determinant) * b;
    }
  }
  return aa > 0 ? Vector((-gain_a / aa) * a) : Vector::Zero();
}

// To where the gradient of the plane's distance vanishes, along the edges of the difference that
// the direction belongs to (what may still be moved between two pieces), if it does to any.
Vector CurvedDepth::stepFrom(const CurvedFace& face, CurvedEdge* edge, int& edges) const {
  CurvedChoice choice;
  const Vector y = faces_.blend(face, std::max(std::abs(reach_), stiff_), 1, choice);
  const Vector& e = face.e;
  const double reach = e.dot(y);
  // Along v and w: second derivatives of the support less the distance.
  const auto bend = [&](const Vector& v, const Vector& w) {
    return faces_.bend(face, choice, v, w) - reach * v.dot(w);
  };
  edges = faces_.edges(choice, edge);
  if (edges > 0) {
    const Vector across = stepOnto(face, edge, edges), way = faces_.wayOf(face, edge[0]);
    const Vector beside = way - e.dot(way) * e;
    const double squared = beside.squaredNorm();
    if (edges == 2 || !(squared > 0)) return across;
    const Vector along = cross(e, beside) / std::sqrt(squared);
    const double second = bend(along, along), first = y.dot(along) + bend(along, across);
    return across - (first / (second > 0 ? second : reach)) * along;
  }
  const Vector helper = std::abs(e.x()) < 0.6 ? Vector::UnitX() : Vector::UnitY();
  Vector u = cross(e, helper);
  u /= u.norm();
  const Vector v = cross(e, u);
  const double uu = bend(u, u), uv = bend(u, v), vv = bend(v, v), gu = y.dot(u), gv = y.dot(v);
  const double determinant = uu * vv - uv * uv;
  if (uu > 0 && determinant > 0) {
    return ((uv * gv - vv * gu) / determinant) * u + ((uv * gu - uu * gv) / determinant) * v;
  }
  return -(gu * u + gv * v) / reach;
}

// (Edges are curved.)
Vector CurvedDepth::nextFrom(const Vector& e, const Vector& step, const CurvedEdge* edge,
                             int edges) const {
  Vector next = (e + step).normalized();
  for (int j = 0; j < kEdgeSteps && edges > 0; ++j) {
    next = (next + stepOnto(faces_.along(next), edge, edges)).normalized();
  }
  return next;
}

// From a direction whose plane is that far; by way of planes that are not the nearest, too.
void CurvedDepth::descend(Vector e, double value) {
  for (int i = 0; i < kDescentSteps && !progress_.decided(); ++i) {
    CurvedEdge edge[2];
    int edges = 0;
    Vector step = stepFrom(faces_.along(e), edge, edges);
    const double length = step.norm();
    if (!(length > 0)) return;
    if (length > 1) step /= length;
    bool nearer = false;
    for (int k = 0; k < kHalves && !nearer; ++k, step *= 0.5) {
      const Vector next = nextFrom(e, step, edge, edges);
      const double next_value = askPlane(next);
      nearer = next_value < value;
      if (nearer) e = next, value = next_value;
    }
    // (Of two that are all but parallel the step is onto the first.)
    if (edges == 2) {
      std::swap(edge[0], edge[1]);
      const Vector next = nextFrom(e, Vector::Zero(), edge, edges);
      const double next_value = askPlane(next);
      if (next_value < value) e = next, value = next_value, nearer = true;
    }
    if (!nearer) return;
  }
}

// A direction in which the difference is no farther out than the depth.
void CurvedDepth::look(const Vector& e) {
  const double before = reach_, value = askPlane(e);
  if (!(value < before)) return;
  descend(e, value);
  setDepth();
}

// The same for one in which it is, but that an edge beside it may be no farther out.
void CurvedDepth::lookBelow(const Vector& e) {
  if (rest_ > 0) {
    --rest_;
    return;
  }
  const double before = reach_;
  descend(e, askPlane(e));
  if (reach_ < before) {
    idle_ = 0;
    setDepth();
  } else {
    idle_ = std::min(2 * idle_ + 1, kLongestRest);
    rest_ = idle_;
  }
}

// With nearly balls taken apart, if there are any.
bool CurvedDepth::provesBalls(const CurvedCorner (&corners)[3], const double (&margins)[3],
                              double depth) const {
  if (!has_balls_) return false;
  return CellBound(corners, sizes_, roundoff_, balls_).proves(margins, depth);
}

// Rounding of a cell's bound, in units of u L with u = kUnitRoundoff and L = extent A + extent B +
// |t|; directions are exact and no longer than 1. Centres err by 8 at most, and M x by 5; x . C by
// 11, each of the two products of a round part by 20 with what its unit vector lacks, that of the
// depth, which is less than L, by 16; and the sum of these by 8 more. In all less than 80.
bool CurvedDepth::proves(const Cell& cell) {
  --work_left_;
  const Node* node = cell.node;
  const CurvedCorner corners[3] = {node[0].corner, node[1].corner, node[2].corner};
  double margins[3];
  for (int i = 0; i < 3; ++i) {
    margins[i] = node[i].value - depth_ * node[i].length - kCellRounding * roundoff_;
  }
  if (provesBalls(corners, margins, depth_)) return true;
  CellBound bound(corners, sizes_, roundoff_);
  if (bound.proves(margins, depth_)) return true;
  if (bound.seemsBelow()) lookBelow(bound.leastDirection().normalized());
  return false;
}

// True for the core's flat end where the direction meets it squarely, to within `wide`.
bool CurvedDepth::meetsCap(const CurvedFace& face, int part, double wide) const {
  const Core core = faces_.view(part).core;
  return (core == Core::kCylinder || core == Core::kCone) && !(face.length[part] > wide);
}

// The member of a choice, afresh: what blend() returns is a sum of many steps. Of a cap that is met
// squarely, the point that is wanted, which blending knows nothing of.
Vector CurvedDepth::memberOf(const CurvedFace& face, const CurvedChoice& choice, double wide,
                             Vector& point_a) const {
  point_a = placed(difference_.pose(), faces_.center(0, choice));
  Vector y = faces_.center(1, choice) - point_a;
  for (const bool caps : {false, true}) {
    for (int k = 0; k < 2; ++k) {
      if (meetsCap(face, k, wide) != caps) continue;
      const double share = faces_.share(k, choice);
      Vector arm = share * face.arm[k];
      if (caps) {
        const double radius = share * faces_.semiAxes(k).x();
        const Vector up = faces_.axis(k);
        arm = y.dot(face.e) * face.e - y;
        arm -= up.dot(arm) * up;
        const double length = arm.norm();
        if (length > radius) arm *= radius / length;
      }
      y += arm;
      if (k == 0) point_a -= arm;
    }
  }
  return y;
}

// The depth proven, with the member that lies along the nearest plane's normal.
void CurvedDepth::claim() {
  const CurvedFace face = faces_.along(-progress_.normal());
  const double wide = std::max(reach_ - depth_, 0.0);
  CurvedChoice choice;
  Vector a, other_a;
  faces_.blend(face, reach_, 1, choice);
  Vector w = memberOf(face, choice, wide, a);
  faces_.support(face, choice);
  const Vector other = memberOf(face, choice, wide, other_a);
  if ((other - reach_ * face.e).norm() < (w - reach_ * face.e).norm()) w = other, a = other_a;
  progress_.offerWitness(-depth_, w, a);
}

// The member that is chosen along e, a point of the difference: how far it is. A centre errs by 8
// units of roundoff of its body's extent, turning by 6, an arm by 11 and sums and the norm by 6 of
// all: less than kSupportRounding.
double CurvedDepth::offerNearest(const CurvedFace& face, const CurvedChoice& choice) {
  Vector point_a;
  const Vector y = memberOf(face, choice, 0, point_a);
  const double apart = y.norm();
  progress_.offerWitness(apart, y, point_a);
  return apart;
}

// What is blended, and what is farthest out.
double CurvedDepth::offerNearest(const Vector& e) {
  const CurvedFace face = faces_.along(e);
  CurvedChoice choice;
  faces_.blend(face, std::max(std::abs(reach_), stiff_), 1, choice);
  const double apart = offerNearest(face, choice);
  if (!meetsCap(face, 0, 0) && !meetsCap(face, 1, 0)) return apart;
  faces_.support(face, choice);
  return std::min(apart, offerNearest(face, choice));
}

// Newton's steps as descend() takes them, which go on while the plane or the member gets nearer:
// where the plane is known to within rounding, its direction is to the root of that only. Bodies
// that all but touch hold pieces loosely, and of a hull's far vertices those that lie along the
// direction: the same again, stiffer.
void CurvedDepth::findNearest() {
  const std::int64_t before = work_left_;
  reach_ = std::numeric_limits<double>::infinity();
  askPlane(-progress_.normal());
  const double size = roundoff_ / kUnitRoundoff;
  for (const double share : kNearestStiffnesses) {
    if (progress_.enough()) break;
    stiff_ = share * size;
    stepNearer();
  }
  stiff_ = 0;
  progress_.iterations += static_cast<int>(before - work_left_);
}

void CurvedDepth::stepNearer() {
  Vector e = -progress_.normal();
  double least = offerNearest(e);
  for (int i = 0; i < kNearestSteps && !progress_.enough(); ++i) {
    CurvedEdge edge[2];
    int edges = 0;
    Vector step = stepFrom(faces_.along(e), edge, edges);
    const double length = step.norm();
    if (!(length > 0)) break;
    if (length > 1) step /= length;
    bool nearer = false;
    for (int k = 0; k < kHalves && !nearer && !progress_.enough(); ++k, step *= 0.5) {
      const Vector next = nextFrom(e, step, edge, edges);
      const double reach = reach_;
      askPlane(next);
      const double apart = offerNearest(next);
      nearer = reach_ < reach || apart < least;
      least = std::min(least, apart);
      if (nearer) e = next;
    }
    if (!nearer) break;
  }
}

bool CurvedDepth::run() {
  const std::int64_t before = work_left_;
  const CoreQuery& query = progress_.query();
  const double offsets = query.lower_offset - query.upper_offset;
  // A quarter of the width is left for the plane and for rounding. (In this order, so that a
  // tolerance that is no number is the least.)
  const double wanted =
      std::max(4 * kCellRounding * roundoff_, 0.75 * (query.request.tolerance - offsets));
  if (progress_.upper() - progress_.lower() <= wanted + offsets) return false;
  // Roughly first: what is proven stays proven where the rest comes to no end.
  bool proven = false;
  for (const double share : {kRoughDepth, 0.0}) {
    gap_ = 0.75 * share * (roundoff_ / kUnitRoundoff);
    if (!(gap_ > 4 * wanted)) gap_ = wanted;
    const bool found = search();
    if (found) claim();
    proven = found && gap_ == wanted;
    if (!found || proven || progress_.enough()) break;
  }
  // (No more than the limit, but for the last descent.)
  progress_.iterations += static_cast<int>((before - work_left_) / kWorkPerStep);
  return proven;
}

// About what a cell's bound errs by along its edge from corner i to j, but for a factor: of each
// |v| the fourth power of the angle that v turns by. Ellipsoids like needles turn theirs in
// directions across them within a strip as narrow as they are thin, along which cells may be long.
// (Shares and lengths are those of the cell, so that of edges in one line the whole is longer than
// its parts: else cells become flat, and never small.)
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

bool CurvedDepth::search() {
  reach_ = -(progress_.lower() + progress_.query().lower_offset);
  if (!(reach_ > 0)) return false;
  reach_ = std::numeric_limits<double>::infinity();
  depth_ = std::numeric_limits<double>::infinity();
  look(-progress_.normal());
  // (Infinity: no plane has been asked, and nothing is to be proven.)
  if (!(depth_ > 0 && std::isfinite(depth_)) || progress_.decided()) return false;
  // (What the one way of halving spends itself on is most often nothing to the other.)
  return provesAll(false, work_left_ / 2) || provesAll(true, 0);
}

// True when what is to be proven holds in all directions; no more work than leaves `spare`.
bool CurvedDepth::provesAll(bool edges, std::int64_t spare) {
  Cell stack[8 + kMostHalvings];
  int count = 0;
  for (int octant = 0; octant < 8; ++octant) {
    Cell& cell = stack[count++];
    cell.halvings = 0;
    for (int i = 0; i < 3; ++i) {
      cell.node[i] = nodeAt((octant >> i & 1) != 0 ? Vector(-Vector::Unit(i)) : Vector::Unit(i));
    }
  }
  while (count > 0) {
    if (progress_.decided() || !(depth_ > 0)) return false;
    Cell& cell = stack[count - 1];
    if (proves(cell)) {
      --count;
      continue;
    }
    if (work_left_ <= spare) return false;
    if (cell.halvings % kHalvingsPerLook == 0) rest_ = 0;
    // What was chosen beside an edge for a depth that was no bound is far from what is best there.
    bool again = false;
    for (Node& node : cell.node) {
      if (node.looks == looks_) continue;
      node = nodeAt(node.x);
      again = true;
    }
    if (again) continue;
    if (cell.halvings == kMostHalvings) return false;
    // Halved across the edge along which its bound errs most: from corner i to corner j.
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
    Cell& other = stack[count++];
    other = cell;
    cell.node[i] = middle;
    other.node[j] = middle;
  }
  return true;
}

}  // namespace

bool haveCurvedDepth(const ConvexView& a, const ConvexView& b) {
  return isCounted(a) && isCounted(b) && (isRound(a.core) || isRound(b.core));
}

void offerCurvedNearest(Difference<false>& difference, Progress& progress) {
  CurvedDepth search(difference, progress, 0);
  search.findNearest();
}

bool offerCurvedDepth(Difference<false>& difference, Progress& progress) {
  CurvedDepth search(difference, progress, kEvenly);
  return search.run();
}

}  // namespace leeway::collision
