#include "collision/curved_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/curved_cell.h"
#include "collision/sharp.h"

namespace leeway::collision {

namespace {

// Cells of one query [count]: some thirty milliseconds; most take a tenth.
constexpr int kMostCells = 131'072;
// The same, of those that are looked at in twice the precision: some sixty milliseconds.
constexpr int kMostSharpCells = 32'768;
// Halvings of a face of the octahedron: its corners' coordinates are exact then, and cells that
// share an edge leave nothing between them.
constexpr int kMostHalvings = 48;
// A box has three parameters, a cone one.
constexpr int kMostParameters = 4;
// Rounds through several parameters, stiffnesses, and Newton's steps, their halves
// and steps back onto an edge [count].
constexpr int kRounds = 4;
constexpr int kStiffnesses = 8;
constexpr int kDescentSteps = 12;
constexpr int kHalves = 4;
constexpr int kEdgeSteps = 3;
// |M e| below this share of a rim's radius: all of its disc is farthest. (It only says which member
// is told.)
constexpr double kFlat = 1e-8;
// Rounding of a cell's bound, derived below [units of roundoff of the sizes involved].
constexpr double kCellRounding = 128;

// One core of the difference B - A; A is turned about.
struct Part {
  const ConvexView* view = nullptr;
  Vector semi_axes = Vector::Zero();
  int first = 0, count = 0;  // parameters
};

// Where a direction is looked at: how much of each piece stands for the cores.
struct Node {
  Vector x;  // exact, of a length from 0.5 to 1
  double parameter[kMostParameters];
  CurvedCorner<Vector> corner;
};

struct Cell {
  Node node[3];
  int halvings;
};

// The members of the face in a direction, and what is beside it: base + sum parameter[k] way[k].
struct Face {
  Vector e;  // the direction, of length 1
  Vector base;
  Vector way[kMostParameters];
  Vector arm[2];              // of the round parts, of a share of 1
  double length[2] = {0, 0};  // |M e|
};

bool isCounted(Core core) {
  return core == Core::kPoint || core == Core::kSegment || core == Core::kBox || isRound(core);
}

class CurvedDepth {
 public:
  CurvedDepth(Difference<false>& difference, Progress& progress, const SharpDifference* sharp);
  bool run();

 private:
  double low(int k) const { return k == cone_[0] || k == cone_[1] ? 0 : -1; }
  Vector turned(int part, const Vector& v) const {
    return part == 0 ? rotated(difference_.pose().rotation, v) : v;
  }
  Face faceAlong(const Vector& direction) const;
  double supportOf(const Face& face, double* parameter) const;
  Vector blend(const Face& face, double stiffness, double* parameter) const;
  double bendAlong(const Face& face, const double* parameter, const Vector& v,
                   const Vector& w) const;
  template <class Number>
  void centerOf(int part, const double* parameter, Number center[3]) const;
  double shareOf(int part, const double* parameter) const;
  Node nodeAt(const Vector& x);
  CurvedCorner<DoubleDoubleVector> sharpCornerOf(const Node& node) const;
  void look(const Vector& e);
  void lookBelow(const Vector& e);
  bool askPlane(const Vector& e);
  void descend(Vector e);
  Vector stepOnto(const Face& face, const int* edge, int edges) const;
  Vector stepFrom(const Face& face, int* edge, int& edges) const;
  void setDepth();
  bool proves(const Cell& cell);
  void claim();

  Difference<false>& difference_;
  Progress& progress_;
  const SharpDifference* sharp_;
  const double roundoff_;
  Part part_[2];
  int cone_[2] = {-1, -1};  // the parameter that is a cone's
  int parameters_ = 0;
  double sizes_[2];
  int cells_left_ = kMostCells, sharp_cells_left_ = kMostSharpCells;
  double reach_ = 0;  // the nearest plane asked
  // What is to be proven; the second, for cells in double precision, holds for the world's poses.
  DoubleDouble depth_ = std::numeric_limits<double>::infinity();
  double plain_depth_ = 0;
  double wanted_ = 0;  // directions in which the difference is nearer lead to a nearer plane
};

CurvedDepth::CurvedDepth(Difference<false>& difference, Progress& progress,
                         const SharpDifference* sharp)
    : difference_(difference),
      progress_(progress),
      sharp_(sharp),
      roundoff_(progress.query().roundoff),
      sizes_{difference.viewA().extent, difference.viewB().extent} {
  const ConvexView* views[2] = {&difference.viewA(), &difference.viewB()};
  for (int k = 0; k < 2; ++k) {
    Part& part = part_[k];
    part.view = views[k];
    part.first = parameters_;
    switch (views[k]->core) {
      case Core::kEllipsoid:
        part.semi_axes = views[k]->size;
        break;
      case Core::kCone:
        cone_[k] = parameters_;
        [[fallthrough]];
      case Core::kCylinder:
        part.semi_axes = Vector(views[k]->size.x(), views[k]->size.x(), 0);
        [[fallthrough]];
      case Core::kSegment:
        part.count = 1;
        break;
      case Core::kBox:
        part.count = 3;
        break;
      default:
        break;
    }
    parameters_ += part.count;
  }
}

Face CurvedDepth::faceAlong(const Vector& direction) const {
  Face face;
  face.e = direction / direction.norm();
  face.base = -difference_.pose().translation;
  for (int k = 0; k < 2; ++k) {
    const Part& part = part_[k];
    const ConvexView& view = *part.view;
    face.arm[k].setZero();
    if (isRound(view.core)) {
      const Vector e_k = k == 0 ? rotatedBack(difference_.pose().rotation, face.e) : face.e;
      const Vector scaled = part.semi_axes.cwiseProduct(e_k);
      const double length = scaled.norm();
      // (The centre of a cap that is met squarely.)
      if (length > (view.core == Core::kEllipsoid ? 0 : kFlat * view.size.x())) {
        face.length[k] = length;
        face.arm[k] = turned(k, part.semi_axes.cwiseProduct(scaled) / length);
      }
    }
    if (view.core == Core::kCone) {
      const Vector apex = turned(k, Vector(0, 0, k == 0 ? -view.size.z() : view.size.z()));
      face.base += apex;
      face.way[part.first] = face.arm[k] - 2 * apex;
    } else {
      face.base += face.arm[k];
      for (int i = 0; i < part.count; ++i) {
        const int axis = part.count == 1 ? 2 : i;
        face.way[part.first + i] = turned(k, view.size[axis] * Vector::Unit(axis));
      }
    }
  }
  return face;
}

// How far the difference reaches along e, and the parameters of what does.
double CurvedDepth::supportOf(const Face& face, double* parameter) const {
  double most = face.e.dot(face.base);
  for (int k = 0; k < parameters_; ++k) {
    const double gain = face.e.dot(face.way[k]);
    parameter[k] = gain >= 0 ? 1 : low(k);
    most += gain * parameter[k];
  }
  return most;
}

// How much the round parts' farthest points move along v when the direction does.
double CurvedDepth::bendAlong(const Face& face, const double* parameter, const Vector& v,
                              const Vector& w) const {
  double sum = 0;
  for (int k = 0; k < 2; ++k) {
    const double share = shareOf(k, parameter);
    if (!(share > 0 && face.length[k] > 0)) continue;
    const Eigen::Matrix3d& R = difference_.pose().rotation;
    const Vector mv = part_[k].semi_axes.cwiseProduct(k == 0 ? rotatedBack(R, v) : v);
    const Vector mw = part_[k].semi_axes.cwiseProduct(k == 0 ? rotatedBack(R, w) : w);
    sum += share * (mv.dot(mw) - face.arm[k].dot(v) * face.arm[k].dot(w)) / face.length[k];
  }
  return sum;
}

// The member with the largest e . y - |y - (e . y) e|^2 / (2 stiffness), one parameter after the
// other; with the round parts' bend the stiffness is that of what parameters do alone.
Vector CurvedDepth::blend(const Face& face, double stiffness, double* parameter) const {
  supportOf(face, parameter);
  Vector y = face.base;
  for (int k = 0; k < parameters_; ++k) y += parameter[k] * face.way[k];
  Vector beside[kMostParameters];
  double gain[kMostParameters];
  for (int k = 0; k < parameters_; ++k) {
    gain[k] = face.e.dot(face.way[k]);
    beside[k] = face.way[k] - gain[k] * face.e;
  }
  // Along parameter k, and against l as far as that keeps the sum of what is beside e: both exact.
  const auto move = [&](int k, int l, double against) {
    const Vector way = beside[k] - against * beside[l];
    const double along = gain[k] - against * gain[l], squared = way.squaredNorm();
    const double stiff =
        stiffness > 0 ? stiffness * squared + std::max(bendAlong(face, parameter, way, way), 0.0)
                      : 0;
    // (stiff / squared: a stiffness that the round parts' bend is added to.)
    const double wanted = squared > 0 ? along * (stiff / squared) - way.dot(y) : along * stiffness;
    double most = wanted > 0 ? 1 - parameter[k] : low(k) - parameter[k];
    if (against != 0) {
      const double end = (wanted > 0) == (against > 0) ? low(l) : 1.0;
      const double other = (parameter[l] - end) / against;
      if (std::abs(other) < std::abs(most)) most = other;
    }
    double step = most;
    if (std::abs(wanted) < std::abs(most) * squared) step = wanted / squared;
    if (!(std::abs(step) <= 2)) return;
    const auto moved = [&](int m, double by) {
      const double next = std::clamp(parameter[m] + by, low(m), 1.0);
      y += (next - parameter[m]) * face.way[m];
      parameter[m] = next;
    };
    moved(k, step);
    if (against != 0) moved(l, -against * step);
  };
  const int rounds = parameters_ > 1 ? kRounds : 1;
  for (int i = 0; i < rounds; ++i) {
    for (int k = 0; k < parameters_; ++k) {
      move(k, k, 0);
      for (int l = 0; l < k; ++l) {
        const double squared = beside[l].squaredNorm();
        if (squared > 0) move(k, l, beside[k].dot(beside[l]) / squared);
      }
    }
  }
  return y;
}

double CurvedDepth::shareOf(int part, const double* parameter) const {
  const Core core = part_[part].view->core;
  if (core == Core::kCone) return parameter[part_[part].first];
  return isRound(core) ? 1 : 0;
}

// In the core's frame.
template <class Number>
void CurvedDepth::centerOf(int part, const double* parameter, Number center[3]) const {
  const Part& p = part_[part];
  const ConvexView& view = *p.view;
  const double* of = parameter + p.first;
  for (int i = 0; i < 3; ++i) center[i] = 0;
  if (view.core == Core::kCone) {
    // (Twice the parameter is exact.)
    center[2] = Number(view.size.z()) * (Number(1) - Number(2 * of[0]));
    return;
  }
  for (int i = 0; i < p.count; ++i) {
    const int axis = p.count == 1 ? 2 : i;
    center[axis] = Number(part == 0 ? -view.size[axis] : view.size[axis]) * Number(of[i]);
  }
}

Node CurvedDepth::nodeAt(const Vector& x) {
  Node node;
  node.x = x;
  const Face face = faceAlong(x);
  const double support = supportOf(face, node.parameter);
  if (support < wanted_) look(face.e);
  // Less than the depth it may be far from an edge, where more of the piece that is farther is
  // needed, or close to a place on it that is nearer than the depth.
  double stiffness = depth_.high;
  for (int i = 0; i < kStiffnesses; ++i, stiffness *= 4) {
    const Vector y = blend(face, stiffness, node.parameter);
    if (face.e.dot(y) >= wanted_) break;
    if (i == 0) lookBelow(face.e);
  }
  CurvedCorner<Vector>& c = node.corner;
  c.x = x;
  const Pose& X_BA = difference_.pose();
  double of_a[3], of_b[3];
  centerOf(0, node.parameter, of_a);
  centerOf(1, node.parameter, of_b);
  c.center = Vector(of_b[0], of_b[1], of_b[2]) - placed(X_BA, Vector(of_a[0], of_a[1], of_a[2]));
  c.scaled[0] = part_[0].semi_axes.cwiseProduct(rotatedBack(X_BA.rotation, x));
  c.scaled[1] = part_[1].semi_axes.cwiseProduct(x);
  for (int k = 0; k < 2; ++k) c.share[k] = shareOf(k, node.parameter);
  return node;
}

CurvedCorner<DoubleDoubleVector> CurvedDepth::sharpCornerOf(const Node& node) const {
  CurvedCorner<DoubleDoubleVector> c;
  c.x = sharp_->inWorld(node.x);
  DoubleDouble of_a[3], of_b[3];
  centerOf(0, node.parameter, of_a);
  centerOf(1, node.parameter, of_b);
  c.center = sharp_->memberOf({of_a[0], of_a[1], of_a[2]}, {of_b[0], of_b[1], of_b[2]});
  const auto scaled = [](const Vector& m, const DoubleDoubleVector& v) {
    return DoubleDoubleVector(m.x() * v.x, m.y() * v.y, m.z() * v.z);
  };
  c.scaled[0] = scaled(part_[0].semi_axes, sharp_->inA(c.x));
  c.scaled[1] = scaled(part_[1].semi_axes, sharp_->inB(c.x));
  for (int k = 0; k < 2; ++k) c.share[k] = node.corner.share[k];
  return c;
}

// Offers the plane across e; true when it is the nearest so far.
bool CurvedDepth::askPlane(const Vector& e) {
  SupportPoint s;
  ++progress_.iterations;
  difference_.support(-e, s);
  const double value = e.dot(s.w);
  progress_.offerLower(-value, -e);
  if (sharp_ != nullptr) offerSharpPlane(*sharp_, sharp_->inWorld(-e), progress_);
  if (!(value < reach_)) return false;
  reach_ = value;
  return true;
}

// A quarter of the width is left for the plane and for rounding; in twice the precision a half. It
// only becomes less, so that what is proven stays so.
void CurvedDepth::setDepth() {
  const CoreQuery& query = progress_.query();
  DoubleDouble depth;
  if (sharp_ == nullptr) {
    const double tolerance = query.request.tolerance - (query.lower_offset - query.upper_offset);
    // (In this order, so that a tolerance that is no number is the least.)
    const double gap = std::max(4 * kCellRounding * roundoff_, 0.75 * tolerance);
    depth = reach_ - std::min(gap, 0.25 * reach_);
  } else {
    const DoubleDoubleVector n = sharp_->inWorld(-progress_.normal());
    depth = sharp_->mostAlong(n) / norm(n) - DoubleDouble(0.5 * query.request.tolerance);
  }
  if (!(depth < depth_)) return;
  depth_ = depth;
  plain_depth_ = wanted_ = depth.high;
  if (sharp_ == nullptr) {
    wanted_ += 2 * kCellRounding * roundoff_;
  } else {
    plain_depth_ += 8 * roundoff_ + sharp_->moved();
  }
}

// The step onto the edges of the difference where the pieces of one or two parameters meet.
Vector CurvedDepth::stepOnto(const Face& face, const int* edge, int edges) const {
  const auto besideOf = [&](int k, double& gain) {
    gain = face.e.dot(face.way[k]);
    return Vector(face.way[k] - gain * face.e);
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
Vector CurvedDepth::stepFrom(const Face& face, int* edge, int& edges) const {
  double parameter[kMostParameters];
  const Vector y = blend(face, reach_, parameter);
  const Vector& e = face.e;
  const double reach = e.dot(y);
  // Along v and w: second derivatives of the support less the distance.
  const auto bend = [&](const Vector& v, const Vector& w) {
    return bendAlong(face, parameter, v, w) - reach * v.dot(w);
  };
  edges = 0;
  for (int k = 0; k < parameters_ && edges < 2; ++k) {
    if (parameter[k] > low(k) && parameter[k] < 1) edge[edges++] = k;
  }
  if (edges > 0) {
    const Vector across = stepOnto(face, edge, edges);
    const Vector beside = face.way[edge[0]] - e.dot(face.way[edge[0]]) * e;
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

void CurvedDepth::descend(Vector e) {
  for (int i = 0; i < kDescentSteps && !progress_.decided(); ++i) {
    int edge[2], edges = 0;
    Vector step = stepFrom(faceAlong(e), edge, edges);
    const double length = step.norm();
    if (!(length > 0)) return;
    if (length > 1) step /= length;
    bool nearer = false;
    for (int k = 0; k < kHalves && !nearer; ++k, step *= 0.5) {
      Vector next = (e + step).normalized();
      // (Edges are curved.)
      for (int j = 0; j < kEdgeSteps && edges > 0; ++j) {
        next = (next + stepOnto(faceAlong(next), edge, edges)).normalized();
      }
      nearer = askPlane(next);
      if (nearer) e = next;
    }
    if (!nearer) return;
  }
}

// A direction in which the difference is no farther out than the depth.
void CurvedDepth::look(const Vector& e) {
  if (!askPlane(e)) return;
  descend(e);
  setDepth();
}

// The same for one in which it is, but that an edge beside it may be no farther out.
void CurvedDepth::lookBelow(const Vector& e) {
  const double before = reach_;
  descend(e);
  if (reach_ < before) setDepth();
}

// Rounding of a cell's bound, in units of u L with u = kUnitRoundoff and L = extent A + extent B +
// |t|; directions are exact and no longer than 1. Centres err by 8 at most, and M x by 5; x . C by
// 11, each of the two products of a round part by 20 with what its unit vector lacks, that of the
// depth, which is less than L, by 16; and the sum of these by 8 more. In all less than 80.
// In twice the precision the same of 2^-100; in double what is proven of X_BA is so for the world's
// poses less by what rounding and their departures move.
bool CurvedDepth::proves(const Cell& cell) {
  --cells_left_;
  const Node* node = cell.node;
  const CurvedCorner<Vector> corners[3] = {node[0].corner, node[1].corner, node[2].corner};
  if (provesCell(corners, sizes_, plain_depth_, kCellRounding * roundoff_)) return true;
  if (sharp_ == nullptr) return false;
  --sharp_cells_left_;
  const CurvedCorner<DoubleDoubleVector> sharp_corners[3] = {
      sharpCornerOf(node[0]), sharpCornerOf(node[1]), sharpCornerOf(node[2])};
  return provesCell(sharp_corners, sizes_, depth_,
                    DoubleDouble(0x1p-80 * (roundoff_ / kUnitRoundoff)));
}

// The depth proven, with the member that lies along the nearest plane's normal.
void CurvedDepth::claim() {
  const Face face = faceAlong(-progress_.normal());
  double parameter[kMostParameters], of_a[3];
  Vector y = blend(face, reach_, parameter);
  centerOf(0, parameter, of_a);
  Vector point_a = placed(difference_.pose(), Vector(of_a[0], of_a[1], of_a[2])) -
                   shareOf(0, parameter) * face.arm[0];
  // Of a cap that is met squarely, the point that is wanted.
  for (int k = 0; k < 2; ++k) {
    const Core core = part_[k].view->core;
    const double radius = shareOf(k, parameter) * part_[k].semi_axes.x();
    if ((core != Core::kCylinder && core != Core::kCone) || face.length[k] > 0) continue;
    Vector arm = y.dot(face.e) * face.e - y;
    const double length = arm.norm();
    if (length > radius) arm *= radius / length;
    y += arm;
    if (k == 0) point_a -= arm;
  }
  if (sharp_ == nullptr) {
    progress_.offerWitness(-depth_.high, y, point_a);
  } else {
    offerSharpWitness(*sharp_, -depth_, 0, y, point_a, progress_);
  }
}

bool CurvedDepth::run() {
  // What is narrower than a cell's rounding is a matter of twice the precision, which comes later.
  const double size = roundoff_ / kUnitRoundoff;
  if (sharp_ == nullptr && progress_.upper() - progress_.lower() <= kSharpFrom * size) return false;
  reach_ = -(progress_.lower() + progress_.query().lower_offset);
  if (!(reach_ > 0)) return false;
  reach_ = std::numeric_limits<double>::infinity();
  look(-progress_.normal());
  // (Infinity: no plane has been asked, and nothing is to be proven.)
  if (!(depth_.high > 0 && std::isfinite(depth_.high)) || progress_.decided()) return false;
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
    if (progress_.decided() || !(depth_.high > 0)) return false;
    Cell& cell = stack[count - 1];
    if (proves(cell)) {
      --count;
      continue;
    }
    if (cell.halvings == kMostHalvings || cells_left_ <= 0 || sharp_cells_left_ <= 0) return false;
    // Halved across its longest edge: from corner i to corner j.
    int i = 0, j = 1;
    double longest = -1;
    for (int k = 0; k < 3; ++k) {
      const double squared = (cell.node[k].x - cell.node[(k + 1) % 3].x).squaredNorm();
      if (squared > longest) longest = squared, i = k, j = (k + 1) % 3;
    }
    const Node middle = nodeAt(0.5 * (cell.node[i].x + cell.node[j].x));
    ++cell.halvings;
    Cell& other = stack[count++];
    other = cell;
    cell.node[i] = middle;
    other.node[j] = middle;
  }
  claim();
  return true;
}

}  // namespace

bool haveCurvedDepth(const ConvexView& a, const ConvexView& b) {
  return isCounted(a.core) && isCounted(b.core) && (isRound(a.core) || isRound(b.core));
}

bool offerCurvedDepth(Difference<false>& difference, Progress& progress,
                      const SharpDifference* sharp) {
  CurvedDepth search(difference, progress, sharp);
  return search.run();
}

}  // namespace leeway::collision
