#include "collision/mesh_pair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collision/simd/box_gaps.h"
#include "collision/support.h"
#include "collision/triangle_pair.h"
#include "leeway/collision/tolerances.h"

namespace leeway::collision {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Two boxes, each a lane of a node: (node, lane) as node * kWidth + lane.
struct BoxPair {
  std::int32_t a, b;
  double lower;  // proven for everything in the boxes; below 0 the deeper, the more of an overlap
};

class PairDescent {
 public:
  PairDescent(const MeshTree& a, const MeshTree& b, const DescentPlacement& placement,
              const DistanceRequest& request, Scratch& scratch, PairCache& cache)
      : a_(a),
        b_(b),
        X_BA_(placement.X_BA0),
        slack_(placement.slack),
        request_(request),
        scratch_(scratch),
        cache_(cache) {
    X_AB_ = X_BA_.inverse();
    // As for support points, see gjk.cc: corners are placed and their products with a unit vector
    // taken in the same way.
    rounding_ =
        kSupportRounding * kUnitRoundoff * (a.extent() + b.extent() + X_BA_.translation.norm()) +
        slack_;
    floor_ = request.threshold == request.threshold ? std::max(request.threshold, 0.0) : kInfinity;
  }

  DescentResult run() {
    result_.lower = kInfinity;
    result_.upper = kInfinity;
    result_.hull_lower = -kInfinity;
    float gap[BoxNode::kWidth];
    const OrientedBox root = placedBox(a_.boxes().node(0), 0, X_BA_);
    boxGaps(b_.boxes().node(0), root, gap);
    result_.hull_lower = static_cast<double>(gap[0]) - slack_;
    if (result_.hull_lower > bar()) {
      settle(result_.hull_lower);
      return result_;
    }
    warmStart();
    stack_[size_++] = {0, 0, result_.hull_lower};
    while (size_ > 0 && !done()) {
      const BoxPair pair = stack_[--size_];
      if (pair.lower > bar() || visited_ >= request_.node_limit) {
        settle(pair.lower);
        continue;
      }
      expand(pair);
    }
    while (size_ > 0) settle(stack_[--size_].lower);
    hulls();
    return result_;
  }

 private:
  static const BoxNode& nodeOf(const BoxTree& tree, std::int32_t box) {
    return tree.node(box / BoxNode::kWidth);
  }
  static std::int32_t childOf(const BoxTree& tree, std::int32_t box) {
    return nodeOf(tree, box).child[box % BoxNode::kWidth];
  }

  static OrientedBox placedBox(const BoxNode& node, int lane, const Pose& X) {
    const OrientedBox box = node.box(lane);
    OrientedBox result;
    const Vector center =
        placed(X, Vector(static_cast<double>(box.center[0]), static_cast<double>(box.center[1]),
                         static_cast<double>(box.center[2])));
    float R[3][3];
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) R[i][k] = static_cast<float>(X.rotation(i, k));
    }
    for (int i = 0; i < 3; ++i) {
      result.center[i] = static_cast<float>(center[i]);
      result.half[i] = box.half[i];
      for (int k = 0; k < 3; ++k) {
        result.axis[k][i] =
            R[i][0] * box.axis[k][0] + R[i][1] * box.axis[k][1] + R[i][2] * box.axis[k][2];
      }
    }
    return result;
  }

  double bar() const { return std::min(floor_, result_.upper - request_.tolerance); }
  bool done() const {
    return result_.upper <= 0 || result_.upper <= request_.threshold;  // a NaN decides nothing
  }
  void settle(double lower) { result_.lower = std::min(result_.lower, lower); }

  void warmStart() {
    if (cache_.triangle_a < 0 || cache_.triangle_a >= a_.triangleCount() || cache_.triangle_b < 0 ||
        cache_.triangle_b >= b_.triangleCount()) {
      return;
    }
    triangles(a_.slotOf(cache_.triangle_a), b_.slotOf(cache_.triangle_b));
    // The pair comes again in its turn.
    if (!done()) result_.lower = kInfinity;
  }

  void expand(const BoxPair& pair) {
    const BoxTree &boxes_a = a_.boxes(), &boxes_b = b_.boxes();
    const std::int32_t child_a = childOf(boxes_a, pair.a), child_b = childOf(boxes_b, pair.b);
    if (child_a < 0 && child_b < 0) {
      triangles(~child_a, ~child_b);
      return;
    }
    const int lane_a = pair.a % BoxNode::kWidth, lane_b = pair.b % BoxNode::kWidth;
    const BoxNode &node_a = nodeOf(boxes_a, pair.a), &node_b = nodeOf(boxes_b, pair.b);
    // The larger one comes apart.
    const bool split_a =
        child_b < 0 || (child_a >= 0 && node_a.radius[lane_a] >= node_b.radius[lane_b]);
    const BoxNode& split = split_a ? boxes_a.node(child_a) : boxes_b.node(child_b);
    const OrientedBox other =
        split_a ? placedBox(node_b, lane_b, X_AB_) : placedBox(node_a, lane_a, X_BA_);
    float gap[BoxNode::kWidth];
    boxGaps(split, other, gap);
    visited_ += split.count;
    const double bar_now = bar();
    const std::size_t first = size_;
    for (int i = 0; i < split.count; ++i) {
      // What the parent has proven holds for its parts.
      const double found = static_cast<double>(gap[i]) - slack_;
      if (found > bar_now) {
        settle(std::max(found, pair.lower));
        continue;
      }
      BoxPair part = pair;
      (split_a ? part.a : part.b) = (split_a ? child_a : child_b) * BoxNode::kWidth + i;
      part.lower = found > 0 ? std::max(found, pair.lower) : found;
      // The nearest one on top; of several the first.
      std::size_t at = size_++;
      for (; at > first && stack_[at - 1].lower <= part.lower; --at) stack_[at] = stack_[at - 1];
      stack_[at] = part;
    }
  }

  void triangles(int slot_a, int slot_b) {
    ++visited_;
    const Vector* corners_a = a_.corners(slot_a);
    const Vector* q = b_.corners(slot_b);
    const Vector p[3] = {placed(X_BA_, corners_a[0]), placed(X_BA_, corners_a[1]),
                         placed(X_BA_, corners_a[2])};
    const TrianglePair pair = trianglePair(p, q);
    ++result_.iterations;
    double lower = pair.below - rounding_, upper = pair.above + rounding_;
    if (lower > 0 && (lower > bar() || upper - lower <= request_.tolerance)) {
      settle(lower);
      if (!(upper < result_.upper)) return;
      DistanceResult r;
      r.normal = pair.normal;
      r.point_a = pair.p;
      r.point_b = pair.q;
      offer(r, upper, slot_a, slot_b);
      return;
    }
    // Crossing, touching, or a sliver.
    DistanceRequest request;
    request.threshold = request_.threshold;
    request.tolerance = request_.tolerance;
    request.depth = false;
    request.iteration_limit = request_.iteration_limit;
    PairCache* none = nullptr;
    const DistanceResult r = convexDistance(a_.triangleView(slot_a), X_BA_, b_.triangleView(slot_b),
                                            request, scratch_, none, slack_);
    result_.iterations += r.iterations;
    settle(std::max(lower, r.distance.lower));
    offer(r, std::min(upper, r.distance.upper), slot_a, slot_b);
  }

  void offer(const DistanceResult& r, double upper, int slot_a, int slot_b) {
    if (!(upper < result_.upper)) return;
    result_.upper = upper;
    result_.witness = r;
    result_.witness.triangle_a = a_.triangleOf(slot_a);
    result_.witness.triangle_b = b_.triangleOf(slot_b);
  }

  // Surfaces that are apart may be one inside the other: not if a plane between the witnesses parts
  // the bodies' hulls.
  void hulls() {
    if (result_.hull_lower > 0 || !(result_.lower > 0) || result_.witness.triangle_a < 0) return;
    const Vector& n = result_.witness.normal;
    int hint_a = 0, hint_b = 0;
    const ConvexView hull_a = a_.hullView(), hull_b = b_.hullView();
    const Vector p = placed(X_BA_, farthest(hull_a, rotatedBack(X_BA_.rotation, n), hint_a));
    const Vector q = farthest(hull_b, -n, hint_b);
    result_.hull_lower =
        std::max(result_.hull_lower, n.dot(q - p) - rounding_ - hull_a.excess - hull_b.excess);
  }

  const MeshTree& a_;
  const MeshTree& b_;
  const Pose& X_BA_;
  Pose X_AB_;
  const double slack_;
  const DistanceRequest& request_;
  Scratch& scratch_;
  PairCache& cache_;
  DescentResult result_;
  double rounding_ = 0;  // of a pair of triangles, the poses' slack included [m]
  double floor_ = kInfinity;
  int visited_ = 0;
  // A pair that is taken off puts at most kWidth back, which are one level lower on one side.
  std::array<BoxPair, 2 * (BoxTree::kMaxDepth + 1) * (BoxNode::kWidth - 1) + 1> stack_;
  std::size_t size_ = 0;
};

}  // namespace

bool takesPair(const DescentSide& a, const DescentSide& b, const DescentPlacement& placement) {
  return a.tree != nullptr && b.tree != nullptr && a.tree->boxes().usable() &&
         b.tree->boxes().usable() && !placement.swept &&
         placement.X_BA0.translation.norm() <= kLargestBoxScale;
}

DescentResult descendPair(const DescentSide& a, const DescentSide& b,
                          const DescentPlacement& placement, const DistanceRequest& request,
                          Scratch& scratch, PairCache* cache) {
  return PairDescent(*a.tree, *b.tree, placement, request, scratch, *cache).run();
}

}  // namespace leeway::collision
