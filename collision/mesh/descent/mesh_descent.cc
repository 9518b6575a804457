#include "collision/mesh/descent/mesh_descent.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/scratch.h"
#include "collision/base/tolerances.h"
#include "collision/mesh/descent/branch_and_bound.h"
#include "collision/mesh/descent/sweep_front.h"
#include "collision/mesh/descent/touching_triangles.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

// A pair of nodes; -1 is a convex shape as a whole.
struct NodePair {
  std::int32_t a, b;
  double lower;  // proven for all pairs of triangles below
  double order;  // of visits: smaller first
};

class Descent : public DescentBounds {
 public:
  Descent(const DescentSide& a, const DescentSide& b, const DescentPlacement& placement,
          const DistanceRequest& asked, Scratch& scratch, PairCache& cache)
      : DescentBounds(asked, scratch,
                      {.swept = placement.swept,
                       .depth = asked.depth,
                       .limits_depth = !isHalfSpace(a) && !isHalfSpace(b),
                       .near = placement.swept ? 0 : scratch.impl().touching.near()}),
        a_(a),
        b_(b),
        placement_(placement),
        scratch_(scratch),
        cache_(cache),
        touching_(scratch.impl().touching),
        recorder_(scratch.impl().fronts.found, cache) {
    rounding_ = kRelativeRounding *
                    (finite(a.extent) + finite(b.extent) + placement.X_BA0.translation.norm() +
                     placement.X_BA1.translation.norm()) +
                placement.slack;
  }

  DescentResult run() {
    search();
    return result;
  }

  using DescentBounds::settle;
  void settle(const NodePair& pair) {
    settle(pair.lower);
    recorder_.record(pair.a, pair.b);
  }

 private:
  static bool isHalfSpace(const DescentSide& side) {
    return side.tree == nullptr && side.view.core == Core::kHalfSpace;
  }

  void search() {
    if (SweepFront* front = lastFront(); front != nullptr) {
      fromFront(*front);
      return;
    }
    recorder_.start(keepsFronts());
    if (root()) return;
    warmStart();
    descend();
    const bool limited = !open_.isEmpty() && !isDone();
    if (open_.isEmpty() && !isDone()) keepFront();
    open_.settleRest(*this);
    const bool threshold = request.threshold == request.threshold;
    if (hulls_upper_ < result.upper && (limited || threshold)) {
      offer(hulls_, hulls_upper_, -1, -1);
      // An interval this wide must also contain the distance of the hulls' witness points. If there
      // is a threshold, the verdict does not need it.
      if (!threshold) settle(hulls_.distance.lower);
    }
  }

  void descend() {
    for (NodePair pair; open_.next(*this, pair);) {
      expand(pair);
      if (isDone()) settle(pair.lower);  // some of its parts may not have been visited
    }
  }

  // Fronts are not kept for thresholds below 0, where only the hulls give an answer, which no front
  // describes; nor for the triangles of a deforming mesh, which come one by one, each near other
  // parts.
  bool keepsFronts() const {
    const auto isTriangle = [](const DescentSide& side) {
      return side.tree == nullptr && side.view.core == Core::kPoints && side.view.count <= 3;
    };
    return placement_.swept && scratch_.impl().fronts.active && request.threshold >= 0 &&
           request.node_limit > 2 * static_cast<int>(SweepFront::kMost) && !isTriangle(a_) &&
           !isTriangle(b_);
  }
  SweepFront* lastFront() {
    return keepsFronts() ? scratch_.impl().fronts.of(a_.tree, b_.tree) : nullptr;
  }

  // Starts from the pairs of a front, which together cover all pairs of triangles.
  void fromFront(SweepFront& front) {
    recorder_.start(true);
    for (std::size_t i = 0; i < front.count; ++i) {
      SweepFront::Entry& entry = front.entries[i];
      NodePair pair{entry.a, entry.b, -kInfinity, 0};
      cache_.direction_B = entry.direction_B;
      cache_.vertex_a = entry.vertex_a;
      cache_.vertex_b = entry.vertex_b;
      if (evaluate(pair)) {
        open_.push(pair);
        descend();
      }
      if (open_.isEmpty() && !isDone()) continue;
      // The pair that could not be separated comes first next time. The pairs after it are unknown.
      std::swap(entry, front.entries[0]);
      open_.settleRest(*this);
      if (i + 1 < front.count) settle(-kInfinity);
      return;
    }
    keepFront();
  }

  // The front is complete, because the stack is empty: the recorded pairs cover all pairs.
  void keepFront() { recorder_.keep(scratch_.impl().fronts, a_.tree, b_.tree); }

  static double finite(double x) { return std::isfinite(x) ? x : 0; }

  DistanceResult convex(const ConvexView& a, const ConvexView& b, double threshold,
                        double tolerance, bool depth) {
    DistanceRequest own;
    own.threshold = threshold;
    own.tolerance = tolerance;
    own.depth = depth;
    own.iteration_limit = request.iteration_limit;
    visit();
    const DistanceResult r = pieceDistance(a, b, placement_, own, scratch_, &cache_);
    result.iterations += r.iterations;
    return r;
  }

  // Bounds the pair of roots, and the hulls of both bodies. True if that decides, which is usual.
  bool root() {
    const std::int32_t root_a = a_.tree != nullptr ? 0 : -1, root_b = b_.tree != nullptr ? 0 : -1;
    NodePair pair{root_a, root_b, -kInfinity, 0};
    const bool more = evaluate(pair);
    result.hull_lower = pair.lower;
    if (!more) return true;
    const double excess = a_.hull_excess + b_.hull_excess;
    const ConvexView hull_a = a_.tree != nullptr ? a_.tree->hullView() : a_.view;
    const ConvexView hull_b = b_.tree != nullptr ? b_.tree->hullView() : b_.view;
    const double bar_now = bar();
    const double size = std::min(a_.radius, b_.radius);
    const DistanceResult r = convex(hull_a, hull_b, bar_now < kInfinity ? bar_now : kNaN,
                                    std::max(request.tolerance, kNodeTolerance * size), false);
    pair.lower = std::max(pair.lower, r.distance.lower);
    result.hull_lower = pair.lower;
    // If hulls are apart, their nearest points are on their surfaces, and the meshes are within the
    // excess of those points.
    if (pair.lower >= 0) {
      // This is only an upper bound for the search, unless it is an answer, because the hulls'
      // witness points may protrude from the meshes by the whole excess.
      const double upper = r.distance.upper + excess;
      if (upper <= request.threshold || pair.lower > upper - request.tolerance) {
        offer(r, upper, -1, -1);
      } else {
        hulls_ = r;
        hulls_upper_ = upper;
        pruneBy(upper);
      }
    }
    if (isDone() || isPruned(pair)) {
      settle(pair.lower);
      return true;
    }
    open_.push(pair);
    return false;
  }

  // Starts with the upper end of the pair of triangles that was closest last time.
  void warmStart() {
    const bool usable_a = a_.tree == nullptr ||
                          (cache_.triangle_a >= 0 && cache_.triangle_a < a_.tree->triangleCount());
    const bool usable_b = b_.tree == nullptr ||
                          (cache_.triangle_b >= 0 && cache_.triangle_b < b_.tree->triangleCount());
    if (!usable_a || !usable_b) return;
    compareFirst([&] {
      triangles(a_.tree != nullptr ? a_.tree->slotOf(cache_.triangle_a) : -1,
                b_.tree != nullptr ? b_.tree->slotOf(cache_.triangle_b) : -1);
    });
  }

  // Bounds a pair of nodes. False if it is pruned; its lower end is settled in that case.
  bool evaluate(NodePair& pair) {
    const double sphere = sphereLower(pair);
    // Below 0 it does not bound the depth.
    if (sphere > 0) pair.lower = std::max(pair.lower, sphere);
    pair.order = sphere;
    const double bar_now = bar();
    if (isPruned(pair)) {
      settle(pair);
      return false;
    }
    const ConvexView view_a = pair.a >= 0 ? a_.tree->nodeView(a_.tree->node(pair.a)) : a_.view;
    const ConvexView view_b = pair.b >= 0 ? b_.tree->nodeView(b_.tree->node(pair.b)) : b_.view;
    const double size = std::min(pair.a >= 0 ? a_.tree->node(pair.a).radius : a_.radius,
                                 pair.b >= 0 ? b_.tree->node(pair.b).radius : b_.radius);
    const double tolerance =
        std::max(request.tolerance, kNodeTolerance * size + 1.1 * (view_a.excess + view_b.excess));
    const DistanceResult r = convex(view_a, view_b, bar_now < kInfinity ? bar_now : kNaN, tolerance,
                                    request.depth && !placement_.swept && result.upper <= 0);
    pair.lower = std::max(pair.lower, r.distance.lower);
    if (r.distance.lower > 0) pair.order = r.distance.lower;
    if (isPruned(pair)) {
      settle(pair);
      return false;
    }
    return true;
  }

  // A lower bound: the distance of the sphere around A's node, swept, from the box around B's.
  double sphereLower(const NodePair& pair) const {
    const Vector3d& center = pair.a >= 0 ? a_.tree->node(pair.a).center : a_.center;
    double radius = pair.a >= 0 ? a_.tree->node(pair.a).radius : a_.radius;
    if (!(radius < kInfinity)) return -kInfinity;
    const Vector3d& low = pair.b >= 0 ? b_.tree->node(pair.b).low : b_.low;
    const Vector3d& high = pair.b >= 0 ? b_.tree->node(pair.b).high : b_.high;
    Vector3d p = placement_.X_BA0 * center;
    if (placement_.swept) {
      const Vector3d end = placement_.X_BA1 * center;
      radius += 0.5 * (end - p).norm() + placement_.growth;
      p = 0.5 * (p + end);
    }
    const double outside = (low - p).cwiseMax(p - high).cwiseMax(0.0).norm();
    return outside - radius - rounding_;
  }

  void expand(const NodePair& pair) {
    const bool leaf_a = pair.a < 0 || a_.tree->node(pair.a).isLeaf();
    const bool leaf_b = pair.b < 0 || b_.tree->node(pair.b).isLeaf();
    if (leaf_a && leaf_b) {
      leaves(pair);
      return;
    }
    // Descends into the larger one.
    const bool split_a =
        leaf_b || (!leaf_a && a_.tree->node(pair.a).radius >= b_.tree->node(pair.b).radius);
    NodePair near = pair, far = pair;
    if (split_a) {
      near.a = pair.a + 1;
      far.a = a_.tree->node(pair.a).right;
    } else {
      near.b = pair.b + 1;
      far.b = b_.tree->node(pair.b).right;
    }
    bool near_open = evaluate(near), far_open = evaluate(far);
    if (near_open && far_open && far.order < near.order) std::swap(near, far);
    if (far_open) open_.push(far);
    if (near_open) open_.push(near);
  }

  void leaves(const NodePair& pair) {
    recorder_.record(pair.a, pair.b);
    const int begin_a = pair.a >= 0 ? a_.tree->node(pair.a).triangle_begin : -1;
    const int end_a = pair.a >= 0 ? a_.tree->node(pair.a).triangle_end : 0;
    const int begin_b = pair.b >= 0 ? b_.tree->node(pair.b).triangle_begin : -1;
    const int end_b = pair.b >= 0 ? b_.tree->node(pair.b).triangle_end : 0;
    for (int slot_a = begin_a; slot_a < end_a; ++slot_a) {
      for (int slot_b = begin_b; slot_b < end_b; ++slot_b) {
        triangles(slot_a, slot_b);
        if (isDone()) return;
      }
    }
  }

  // Queries a pair of exact pieces; -1 is a convex shape as a whole.
  void triangles(int slot_a, int slot_b) {
    const ConvexView view_a = slot_a >= 0 ? a_.tree->triangleView(slot_a) : a_.view;
    const ConvexView view_b = slot_b >= 0 ? b_.tree->triangleView(slot_b) : b_.view;
    const bool depth = request.depth && !placement_.swept;
    const DistanceResult r = askOfPieces(bar(), request, depth, [&](double threshold) {
      return convex(view_a, view_b, threshold, request.tolerance, depth);
    });
    settle(r.distance.lower);
    // (A triangle of a deforming mesh is a body of three points here.)
    if (!placement_.swept && r.distance.upper > 0 && r.distance.lower <= touching_.near() &&
        view_a.count == 3 && view_b.count == 3) {
      const Vector3d p[3] = {placed(placement_.X_BA0, view_a.points[0]),
                             placed(placement_.X_BA0, view_a.points[1]),
                             placed(placement_.X_BA0, view_a.points[2])};
      touching_.add(p, view_b.points);
    }
    offer(r, r.distance.upper, slot_a >= 0 ? a_.tree->triangleOf(slot_a) : -1,
          slot_b >= 0 ? b_.tree->triangleOf(slot_b) : -1);
  }

  const DescentSide& a_;
  const DescentSide& b_;
  const DescentPlacement& placement_;
  Scratch& scratch_;
  PairCache& cache_;
  TouchingTriangles& touching_;
  DistanceResult hulls_;            // of the hulls, if that alone is not an answer
  double hulls_upper_ = kInfinity;  // the upper end of the bodies' distance that follows from it
  double rounding_ = 0;             // of sphereLower() [m]
  FrontRecorder recorder_;
  // Each popped pair pushes at most two, one level lower on one side.
  BranchAndBound<NodePair, 2 * MeshTree::kMaxDepth + 4> open_;
};

}  // namespace

DescentResult descend(const DescentSide& a, const DescentSide& b, const DescentPlacement& placement,
                      const DistanceRequest& request, Scratch& scratch, PairCache* cache) {
  return Descent(a, b, placement, request, scratch, *cache).run();
}

}  // namespace leeway::collision
