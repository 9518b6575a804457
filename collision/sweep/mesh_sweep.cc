#include "collision/sweep/mesh_sweep.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "collision/base/scratch.h"
#include "collision/base/tolerances.h"
#include "collision/base/work.h"
#include "collision/convex/convex_distance.h"
#include "collision/mesh/descent/box_gaps.h"
#include "collision/mesh/descent/branch_and_bound.h"
#include "collision/mesh/descent/descent_answer.h"
#include "collision/mesh/descent/mesh_body.h"
#include "collision/mesh/descent/triangle_pair.h"
#include "collision/sweep/mesh_sweep_scratch.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {
namespace {

using Kind = Part::Kind;
using Time = SweepScratch::Time;
using Stretch = SweepScratch::Stretch;

bool operator==(const Time& l, const Time& r) { return l.level == r.level && l.number == r.number; }

/// Two boxes, in the numbering of MeshBody, over an interval of the motion.
struct SweptPair {
  std::int32_t a, b;
  Time time;
  float lower;   ///< the gap, proven if positive; otherwise lower for a deeper overlap
  bool open;     ///< convex pieces did not suffice, so their triangles are visited
  int halvings;  ///< halvings of the interval since `lower` was computed
};

/// Spectral norm of A, which is a multiple of the difference of two rotations, or their mean minus
/// the rotation halfway between them. Either stretches two directions equally and does not stretch
/// the axis, so the norm is the Frobenius norm / sqrt(2), up to the matrices' departure from
/// rotations.
double spectralNorm(const Eigen::Matrix3d& A, double departure) {
  return A.norm() * (std::numbers::sqrt2 / 2 + kStretchRounding) + 16 * departure;
}

class MeshSweep {
 public:
  MeshSweep(const DescentSide& a, const DescentSide& b, Placements& motion,
            const MeshSweepRequest& request, Scratch& scratch)
      : side_a_(a),
        side_b_(b),
        a_(a),
        b_(b),
        motion_(motion),
        request_(request),
        scratch_(scratch),
        stretches_(scratch.impl().sweep.begin()) {
    by_pieces_ = a_.consistsOfPieces() && b_.consistsOfPieces();
  }

  MeshSweepResult run() {
    Time whole{0, 0};
    for (double h = request_.h; h < 1; h *= 2) ++whole.level;
    whole.number = static_cast<std::int32_t>(std::lround(std::ldexp(request_.t0, whole.level)));
    // The interval is not representable, and a different interval would prove nothing.
    if (whole.length() != request_.h || whole.begin() != request_.t0) return {};
    result_.status = MeshSweepStatus::kFree;
    open_.push({a_.root(), b_.root(), whole, -1, !by_pieces_, 0});
    Work& work = *scratch_.impl().work;
    for (SweptPair pair; open_.next(*this, pair);) {
      const int before = result_.nodes;
      expand(pair);
      work.add((result_.nodes - before) * kBoxWork);
    }
    if (!isDone() && !open_.isEmpty()) result_.status = MeshSweepStatus::kUndecided;
    return result_;
  }

  // As BranchAndBound requires. Pairs that are apart are not pushed.
  bool isDone() const { return result_.status != MeshSweepStatus::kFree; }
  bool isSpent() const {
    return result_.nodes >= request_.node_limit || scratch_.impl().work->isSpent();
  }
  static bool isPruned(const SweptPair&) { return false; }
  static void settle(const SweptPair&) {}

 private:
  // Null if a pose is missing or invalid.
  const Stretch* stretchOver(const Time& time) {
    const auto place =
        static_cast<std::size_t>((time.number + 5 * time.level) & (SweepScratch::kStretches - 1));
    Stretch& s = stretches_[place];
    if (s.time == time) return &s;
    s.time.level = -1;
    if (!measure(time, s)) return nullptr;
    s.time = time;
    return &s;
  }

  // Computes A's motion over the interval. False if a pose is missing or invalid.
  bool measure(const Time& time, Stretch& s) {
    const double t0 = time.begin(), t1 = t0 + time.length();
    if (!motion_.at(t0, s.X_BA0) || !motion_.at(t1, s.X_BA1)) return false;
    const RelativePose begin = relativePose(s.X_BA0, Pose{}), end = relativePose(s.X_BA1, Pose{});
    if (!begin.valid || !end.valid) return false;
    s.slack = std::max(slackOf(begin, side_a_, side_b_), slackOf(end, side_a_, side_b_));
    s.box_slack =
        s.slack +
        boxRounding(a_, b_, std::max(s.X_BA0.translation.norm(), s.X_BA1.translation.norm()));
    s.growth = time.length() * time.length() * request_.bend;
    s.half.rotation = 0.5 * (s.X_BA0.rotation + s.X_BA1.rotation);
    s.half.translation = 0.5 * (s.X_BA0.translation + s.X_BA1.translation);
    s.away.rotation = 0.5 * (s.X_BA1.rotation - s.X_BA0.rotation);
    s.away.translation = 0.5 * (s.X_BA1.translation - s.X_BA0.translation);
    s.boxes_half = boxPlacement(s.half, a_, b_);
    s.boxes_away = {s.away.rotation, placed(s.away, a_.origin())};
    Eigen::Quaterniond q0(s.X_BA0.rotation), q1(s.X_BA1.rotation);
    if (q0.dot(q1) < 0) q1.coeffs() = -q1.coeffs();
    q0.coeffs() += q1.coeffs();
    s.X_BM.rotation = q0.normalized().toRotationMatrix();
    s.X_BM.translation = s.boxes_half.translation;
    const double departure = begin.slack + end.slack;
    s.turn = (spectralNorm(s.away.rotation, departure) +
              spectralNorm(s.half.rotation - s.X_BM.rotation, departure)) *
             kRadiusRounding;
    s.X_MB = s.X_BM.inverse();
    setBoxSweep(s);
    // A NaN fails this comparison, for example that of rotations half a turn apart, which have no
    // mean.
    return s.turn < 4 && s.growth < kFarthest;
  }

  // The motion of A's boxes in M, in single precision.
  void setBoxSweep(Stretch& s) const {
    s.of_node.of_node = true;
    const Eigen::Matrix3d map = s.X_MB.rotation * s.half.rotation,
                          turn = s.X_MB.rotation * s.away.rotation;
    const Vector way = s.X_MB.rotation * s.boxes_away.translation;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) {
        s.of_node.map[3 * i + k] = static_cast<float>(map(i, k));
        s.of_node.turn[3 * i + k] = static_cast<float>(turn(i, k));
      }
      s.of_node.way[i] = static_cast<float>(way[i]);
    }
    s.of_node.loose = roundedUpToFloat(s.turn);
    s.of_node.fixed = roundedUpToFloat(kWayRounding * (a_.reach() + way.lpNorm<1>()));
  }

  void expand(const SweptPair& pair) {
    const Stretch* s = stretchOver(pair.time);
    if (s == nullptr) {
      result_.status = MeshSweepStatus::kUndecided;
      return;
    }
    const Part part_a = a_.part(pair.a, pair.open), part_b = b_.part(pair.b, pair.open);
    const bool node_a = part_a.kind == Kind::kNode, node_b = part_b.kind == Kind::kNode;
    if (!node_a && !node_b) {
      leaves(pair, *s, part_a, part_b);
      return;
    }
    const Vector way = placed(s->boxes_away, a_.center(pair.a));
    const double radius_a = static_cast<double>(a_.radius(pair.a)),
                 radius_b = static_cast<double>(b_.radius(pair.b));
    // A pair that moves farther than its size is halved in time.
    const double size = node_a && node_b ? std::max(radius_a, radius_b)
                        : node_a         ? radius_a
                                         : radius_b;
    const double room = kSweepTimeShare * size - s->turn * radius_a - s->growth;
    if (!(room > 0 && way.squaredNorm() <= room * room)) {
      if (pair.halvings >= kSweepHalvingsBetweenLooks && isApart(pair, *s)) return;
      if (halve(pair)) return;
    }
    // The larger box is split.
    const bool split_a = !node_b || (node_a && radius_a >= radius_b);
    const std::int32_t child = split_a ? part_a.number : part_b.number;
    const BoxNode& split = (split_a ? a_ : b_).tree().boxes().node(child);
    float gap[BoxNode::kWidth];
    gaps(pair, *s, way, split_a, split, gap);
    result_.nodes += split.count;
    const double bar = barOf(*s);
    const std::size_t first = open_.size();
    for (int i = split.count; i-- > 0;) {
      if (static_cast<double>(gap[i]) > bar) continue;
      SweptPair part = pair;
      (split_a ? part.a : part.b) = child * BoxNode::kWidth + i;
      part.lower = gap[i];
      part.halvings = 0;
      open_.pushSibling(first, part);
    }
  }

  double barOf(const Stretch& s) const { return request_.threshold + s.growth + s.box_slack; }

  // Gaps between the boxes of a node of one body (A if `of_a`) and the pair's box of the other,
  // over the interval. `way`: displacement of the centre of A's box over half of the interval.
  void gaps(const SweptPair& pair, const Stretch& s, const Vector& way, bool of_a,
            const BoxNode& node, float* gap) {
    if (of_a) {
      const BoxDirection direction =
          has_plane_ ? boxDirection(rotated(s.X_MB.rotation, plane_)) : BoxDirection{};
      sweptBoxGaps(node, placedBox(b_.box(pair.b), s.X_MB), s.of_node, direction, gap);
      return;
    }
    const Vector middle = placed(s.boxes_half, a_.center(pair.a));
    OrientedBox box = placedBox(a_.box(pair.a), s.X_BM);
    BoxSweep sweep;
    for (int k = 0; k < 3; ++k) sweep.way[k] = static_cast<float>(way[k]);
    sweep.fixed = roundedUpToFloat(s.turn * static_cast<double>(a_.radius(pair.a)) +
                                   kWayRounding * way.lpNorm<1>());
    for (int k = 0; k < 3; ++k) box.center[k] = static_cast<float>(middle[k]);
    sweptBoxGaps(node, box, sweep, has_plane_ ? boxDirection(plane_) : BoxDirection{}, gap);
  }

  // Whether the pair's own two boxes are apart; one of them belongs to a node.
  bool isApart(const SweptPair& pair, const Stretch& s) {
    const bool of_a = a_.isMesh();
    const std::int32_t part = of_a ? pair.a : pair.b;
    float gap[BoxNode::kWidth];
    gaps(pair, s, placed(s.boxes_away, a_.center(pair.a)), of_a, (of_a ? a_ : b_).node(part), gap);
    ++result_.nodes;
    return static_cast<double>(gap[part % BoxNode::kWidth]) > barOf(s);
  }

  // Pushes both halves of the pair's interval, the earlier one on top. False if it is too short.
  bool halve(const SweptPair& pair) {
    if (pair.time.level >= kSweepHalvings) return false;
    SweptPair half = pair;
    ++half.halvings;
    half.time = {pair.time.level + 1, 2 * pair.time.number + 1};
    open_.push(half);
    --half.time.number;
    open_.push(half);
    return true;
  }

  // Handles a pair of leaves that is not proven apart: contact in the middle of the interval, or
  // its halves, or undecided.
  void contactOrHalve(const SweptPair& pair, const Part& a, const Part& b, double motion) {
    const double t = pair.time.begin() + pair.time.length() / 2;
    Pose X_BA;
    if (!motion_.at(t, X_BA)) {
      result_.status = MeshSweepStatus::kUndecided;
      return;
    }
    const RelativePose halfway = relativePose(X_BA, Pose{});
    if (halfway.valid && meets(X_BA, slackOf(halfway, side_a_, side_b_), a, b)) {
      result_.status = MeshSweepStatus::kContact;
      result_.t = t;
    } else if (motion <= request_.least_motion || pair.time.length() <= request_.least_time ||
               !halve(pair)) {
      result_.status = MeshSweepStatus::kUndecided;
    }
  }

  // Whether two leaves are proven to be within the threshold at this pose.
  bool meets(const Pose& X_BA, double slack, const Part& a, const Part& b) {
    ++result_.nodes;
    const double excess = a_.excess(a) + b_.excess(b);
    DistanceRequest request;
    request.tolerance = kDefaultTolerance;
    request.threshold = request_.threshold - excess;
    request.iteration_limit = request_.iteration_limit;
    request.depth = excess > 0;
    const DistanceResult r =
        convexDistance(a_.view(a), X_BA, b_.view(b), request, scratch_, nullptr, slack);
    return r.distance.upper + excess <= request_.threshold;
  }

  void leaves(const SweptPair& pair, const Stretch& s, const Part& a, const Part& b) {
    const bool triangles = a.kind == Kind::kTriangle && b.kind == Kind::kTriangle;
    if (triangles && trianglesApart(s, a.number, b.number)) return;
    ++result_.nodes;
    DistanceRequest request;
    request.tolerance = kDefaultTolerance;
    request.threshold = request_.threshold;
    request.iteration_limit = request_.iteration_limit;
    request.depth = false;
    const DistanceResult r = convexSweptDistance(a_.view(a), s.X_BA0, s.X_BA1, s.growth, b_.view(b),
                                                 request, scratch_, nullptr, s.slack);
    if (r.distance.lower > request_.threshold) return;
    const Vector way = placed(s.boxes_away, a_.center(pair.a));
    const double motion = way.norm() + s.turn * static_cast<double>(a_.radius(pair.a)) + s.growth;
    const bool piece_a = a.kind == Kind::kPiece, piece_b = b.kind == Kind::kPiece;
    if (!piece_a && !piece_b) {
      contactOrHalve(pair, a, b, motion);
      return;
    }
    const float size = std::max(piece_a ? a_.radius(pair.a) : 0, piece_b ? b_.radius(pair.b) : 0);
    if (motion > kSweepTimeShare * static_cast<double>(size) && halve(pair)) return;
    SweptPair open = pair;
    open.open = true;
    open_.push(open);
  }

  // A's corners over an interval: halfway, and their displacement to either side.
  struct SweptCorners {
    Vector half[3], away[3];
  };

  // The gap that a plane with this unit normal, from A to B, proves for two triangles over the
  // interval.
  static double gapAlong(const Vector& normal, const SweptCorners& p, const Vector* q) {
    double reach = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i)
      reach = std::max(reach, normal.dot(p.half[i]) + std::abs(normal.dot(p.away[i])));
    return std::min({normal.dot(q[0]), normal.dot(q[1]), normal.dot(q[2])}) - reach;
  }

  // Whether a plane separates the triangles. It tries the plane that last separated two others,
  // which separates most neighbours; the planes of both triangles; and the plane between their
  // nearest points in the middle of the interval.
  bool trianglesApart(const Stretch& s, int slot_a, int slot_b) {
    ++result_.nodes;
    const Vector* corners = a_.tree().corners(slot_a);
    const Vector* q = b_.tree().corners(slot_b);
    SweptCorners p;
    for (int i = 0; i < 3; ++i) {
      p.half[i] = placed(s.half, corners[i]);
      p.away[i] = placed(s.away, corners[i]);
    }
    // The same as for support points, see gjk.cc.
    const double rounding =
        kSupportRounding * kUnitRoundoff *
        (a_.extent() + b_.extent() + s.half.translation.norm() + s.away.translation.norm());
    const double least = request_.threshold + s.growth + s.slack + 2 * rounding;
    if (has_plane_ && gapAlong(plane_, p, q) > least) return true;
    const auto parts = [&](const Vector& normal) {
      if (!(gapAlong(normal, p, q) > least)) return false;
      has_plane_ = true;
      plane_ = normal;
      return true;
    };
    for (const Vector* t : {q, static_cast<const Vector*>(p.half)}) {
      const Vector n = cross(t[1] - t[0], t[2] - t[0]);
      const double squared = n.squaredNorm();
      if (!(squared > kLeastSquare)) continue;
      // Points from A to B, determined by the corners that are not in the plane.
      const bool is_a = t == p.half;
      const double side = is_a ? n.dot(q[0] - t[0]) : n.dot(t[0] - p.half[0]);
      if (parts((side < 0 ? -1 : 1) / std::sqrt(squared) * n)) return true;
    }
    return parts(trianglePair(p.half, q).normal);
  }

  const DescentSide &side_a_, &side_b_;
  const MeshBody a_, b_;
  Placements& motion_;
  const MeshSweepRequest& request_;
  Scratch& scratch_;
  MeshSweepResult result_;
  // Visits convex pieces before triangles, if both bodies have pieces. (The pieces of only one body
  // are not worthwhile.)
  bool by_pieces_ = false;
  SweepScratch::Stretches& stretches_;
  bool has_plane_ = false;
  Vector plane_;  // its unit normal, from A to B, in B's frame
  // A popped pair pushes at most kWidth pairs, one level lower on one side; or its two halves; or
  // itself, opened.
  BranchAndBound<SweptPair,
                 2 * (BoxTree::kMaxDepth + 1) * (BoxNode::kWidth - 1) + kSweepHalvings + 3>
      open_;
};

bool isSweepable(const DescentSide& side) {
  return side.tree != nullptr ? side.tree->boxes().usable() : isBounded(side);
}

}  // namespace

bool sweepsMesh(const Shape& a, const Shape& b) {
  const auto isMesh = [](const Shape& s) { return s.type() == ShapeType::kMesh; };
  const auto isFit = [&](const Shape& s) { return isMesh(s) || s.isConvex(); };
  if (!(isMesh(a) || isMesh(b)) || !isFit(a) || !isFit(b)) return false;
  return isSweepable(descentSide(a)) && isSweepable(descentSide(b));
}

MeshSweepResult sweepMesh(const Shape& a, Placements& motion, const Shape& b,
                          const MeshSweepRequest& request, Scratch& scratch) {
  // A NaN fails these comparisons.
  if (!(request.bend >= 0 && request.threshold >= 0 && request.t0 >= 0 && request.t0 < 1 &&
        request.h >= std::ldexp(1.0, -kSweepHalvings) && request.h <= 1))
    return {};
  const DescentSide side_a = descentSide(a), side_b = descentSide(b);
  if (!isSweepable(side_a) || !isSweepable(side_b)) return {};
  return MeshSweep(side_a, side_b, motion, request, scratch).run();
}

}  // namespace leeway::collision
