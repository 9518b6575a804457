#include "collision/mesh/descent/mesh_descent.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/scratch.h"
#include "collision/base/tolerances.h"
#include "collision/base/work.h"
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

class Descent {
 public:
  Descent(const DescentSide& a, const DescentSide& b, const DescentPlacement& placement,
          const DistanceRequest& request, Scratch& scratch, PairCache& cache)
      : a_(a),
        b_(b),
        placement_(placement),
        request_(request),
        scratch_(scratch),
        cache_(cache),
        touching_(scratch.impl().touching),
        recorder_(scratch.impl().fronts.found, cache) {
    rounding_ = kRelativeRounding *
                    (finite(a.extent) + finite(b.extent) + placement.X_BA0.translation.norm() +
                     placement.X_BA1.translation.norm()) +
                placement.slack;
    half_space_ = (a.tree == nullptr && a.view.core == Core::kHalfSpace) ||
                  (b.tree == nullptr && b.view.core == Core::kHalfSpace);
  }

  DescentResult run() {
    search();
    result_.visited = visited_;
    return result_;
  }

 private:
  void search() {
    result_.lower = kInfinity;
    result_.upper = kInfinity;
    result_.hull_lower = -kInfinity;
    if (SweepFront* front = lastFront(); front != nullptr) {
      fromFront(*front);
      return;
    }
    recorder_.start(keepsFronts());
    if (root()) return;
    warmStart();
    const bool limited = goDown();
    if (!limited && !done()) keepFront();
    while (size_ > 0) settle(stack_[--size_].lower);
    const bool threshold = request_.threshold == request_.threshold;
    if (hulls_upper_ < result_.upper && (limited || threshold)) {
      offer(hulls_, hulls_upper_, -1, -1);
      // An interval this wide must also contain the distance of the hulls' witness points. If there
      // is a threshold, the verdict does not need it.
      if (!threshold) settle(hulls_.distance.lower);
    }
  }

  // Processes the stack. True if a limit ended it.
  bool goDown() {
    while (size_ > 0 && !done()) {
      const NodePair pair = stack_[--size_];
      if (isPruned(pair.lower)) {
        settle(pair.lower);
        record(pair);
        continue;
      }
      if (visited_ >= limit() || scratch_.impl().work->isSpent()) {
        settle(pair.lower);
        return true;
      }
      expand(pair);
      if (done()) settle(pair.lower);  // some of its parts may not have been visited
    }
    return false;
  }

  // Fronts are not kept for thresholds below 0, where only the hulls give an answer, which no front
  // describes; nor for the triangles of a deforming mesh, which come one by one, each near other
  // parts.
  bool keepsFronts() const {
    const auto isTriangle = [](const DescentSide& side) {
      return side.tree == nullptr && side.view.core == Core::kPoints && side.view.count <= 3;
    };
    return placement_.swept && scratch_.impl().fronts.active && request_.threshold >= 0 &&
           request_.node_limit > 2 * static_cast<int>(SweepFront::kMost) && !isTriangle(a_) &&
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
      bool limited = false;
      if (evaluate(pair)) {
        stack_[size_++] = pair;
        limited = goDown();
      }
      if (!limited && !done()) continue;
      // The pair that could not be separated comes first next time. The pairs after it are unknown.
      std::swap(entry, front.entries[0]);
      while (size_ > 0) settle(stack_[--size_].lower);
      if (i + 1 < front.count) settle(-kInfinity);
      return;
    }
    keepFront();
  }

  void record(const NodePair& pair) { recorder_.record(pair.a, pair.b); }

  // The front is complete, because the stack is empty: the recorded pairs cover all pairs.
  void keepFront() { recorder_.keep(scratch_.impl().fronts, a_.tree, b_.tree); }

  static double finite(double x) { return std::isfinite(x) ? x : 0; }

  // Pairs whose lower end is above this need not be expanded.
  double bar() const {
    double bar = kInfinity;
    if (request_.threshold == request_.threshold) bar = floor();
    double tolerance = request_.tolerance;
    // A finer tolerance would be wasted, because the depth of two meshes is not that of their
    // deepest triangles.
    if (result_.upper <= 0 && !half_space_)
      tolerance = std::max(tolerance, kDeeperShare * -result_.upper);
    const double nearer = result_.upper > 0 && !placement_.swept
                              ? touching_.bar(result_.upper, tolerance)
                              : result_.upper - tolerance;
    bar = std::min(bar, std::min(nearer, hulls_upper_));
    // A sweep only needs pairs that can reduce its lower end.
    return placement_.swept ? std::min(bar, result_.lower) : bar;
  }

  bool isPruned(double lower) const {
    return lower > bar() || (placement_.swept && lower >= result_.lower);
  }

  bool done() const {
    if (result_.upper <= request_.threshold) return true;
    if (!placement_.swept) return result_.upper <= 0 && !request_.depth;
    // A sweep only needs its lower end, so one pair that does not exceed floor() decides.
    return result_.upper <= 0 || result_.lower <= floor();
  }

  // A sweep's lower end is only useful above this, because below 0 pieces bound only themselves.
  double floor() const { return request_.threshold > 0 ? request_.threshold : 0; }

  int limit() const {
    // The search for deeper pairs is limited.
    return result_.upper <= 0 && !half_space_ ? std::min(request_.node_limit, overlap_limit_)
                                              : request_.node_limit;
  }

  void settle(double lower) { result_.lower = std::min(result_.lower, lower); }

  DistanceResult convex(const ConvexView& a, const ConvexView& b, double threshold,
                        double tolerance, bool depth) {
    DistanceRequest request;
    request.threshold = threshold;
    request.tolerance = tolerance;
    request.depth = depth;
    request.iteration_limit = request_.iteration_limit;
    ++visited_;
    const DistanceResult r = pieceDistance(a, b, placement_, request, scratch_, &cache_);
    result_.iterations += r.iterations;
    return r;
  }

  // Updates the upper end with the one that a pair of exact pieces proves.
  void offer(const DistanceResult& r, double upper, int triangle_a, int triangle_b) {
    if (!(upper < result_.upper)) return;
    if (upper <= 0 && result_.upper > 0) overlap_limit_ = visited_ + kDeeperNodes;
    result_.upper = upper;
    result_.witness = r;
    result_.witness.triangle_a = triangle_a;
    result_.witness.triangle_b = triangle_b;
  }

  // Bounds the pair of roots, and the hulls of both bodies. True if that decides, which is usual.
  bool root() {
    const std::int32_t root_a = a_.tree != nullptr ? 0 : -1, root_b = b_.tree != nullptr ? 0 : -1;
    NodePair pair{root_a, root_b, -kInfinity, 0};
    const bool more = evaluate(pair);
    result_.hull_lower = pair.lower;
    if (!more) return true;
    const double excess = a_.hull_excess + b_.hull_excess;
    const ConvexView hull_a = a_.tree != nullptr ? a_.tree->hullView() : a_.view;
    const ConvexView hull_b = b_.tree != nullptr ? b_.tree->hullView() : b_.view;
    const double bar_now = bar();
    const double size = std::min(a_.radius, b_.radius);
    const DistanceResult r = convex(hull_a, hull_b, bar_now < kInfinity ? bar_now : kNaN,
                                    std::max(request_.tolerance, kNodeTolerance * size), false);
    pair.lower = std::max(pair.lower, r.distance.lower);
    result_.hull_lower = pair.lower;
    // If hulls are apart, their nearest points are on their surfaces, and the meshes are within the
    // excess of those points.
    if (pair.lower >= 0) {
      // This is only an upper bound for the search, unless it is an answer, because the hulls'
      // witness points may protrude from the meshes by the whole excess.
      const double upper = r.distance.upper + excess;
      if (upper <= request_.threshold || pair.lower > upper - request_.tolerance) {
        offer(r, upper, -1, -1);
      } else {
        hulls_ = r;
        hulls_upper_ = upper;
      }
    }
    if (done() || isPruned(pair.lower)) {
      settle(pair.lower);
      return true;
    }
    stack_[size_++] = pair;
    return false;
  }

  // Starts with the upper end of the pair of triangles that was closest last time.
  void warmStart() {
    const bool usable_a = a_.tree == nullptr ||
                          (cache_.triangle_a >= 0 && cache_.triangle_a < a_.tree->triangleCount());
    const bool usable_b = b_.tree == nullptr ||
                          (cache_.triangle_b >= 0 && cache_.triangle_b < b_.tree->triangleCount());
    if (!usable_a || !usable_b) return;
    const double lower = result_.lower;
    triangles(a_.tree != nullptr ? a_.tree->slotOf(cache_.triangle_a) : -1,
              b_.tree != nullptr ? b_.tree->slotOf(cache_.triangle_b) : -1);
    // The pair is visited again later, and may get a better lower end than now.
    if (!placement_.swept) result_.lower = lower;
  }

  // Bounds a pair of nodes. False if it is pruned; its lower end is settled in that case.
  bool evaluate(NodePair& pair) {
    const double sphere = sphereLower(pair);
    if (sphere > 0)
      pair.lower = std::max(pair.lower, sphere);  // below 0 it does not bound the
                                                  // depth
    pair.order = sphere;
    const double bar_now = bar();
    if (isPruned(pair.lower)) {
      settle(pair.lower);
      record(pair);
      return false;
    }
    const ConvexView view_a = pair.a >= 0 ? a_.tree->nodeView(a_.tree->node(pair.a)) : a_.view;
    const ConvexView view_b = pair.b >= 0 ? b_.tree->nodeView(b_.tree->node(pair.b)) : b_.view;
    const double size = std::min(pair.a >= 0 ? a_.tree->node(pair.a).radius : a_.radius,
                                 pair.b >= 0 ? b_.tree->node(pair.b).radius : b_.radius);
    const double tolerance =
        std::max(request_.tolerance, kNodeTolerance * size + 1.1 * (view_a.excess + view_b.excess));
    const DistanceResult r = convex(view_a, view_b, bar_now < kInfinity ? bar_now : kNaN, tolerance,
                                    request_.depth && !placement_.swept && result_.upper <= 0);
    pair.lower = std::max(pair.lower, r.distance.lower);
    if (r.distance.lower > 0) pair.order = r.distance.lower;
    if (isPruned(pair.lower)) {
      settle(pair.lower);
      record(pair);
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
    if (far_open) stack_[size_++] = far;
    if (near_open) stack_[size_++] = near;
  }

  void leaves(const NodePair& pair) {
    record(pair);
    const int begin_a = pair.a >= 0 ? a_.tree->node(pair.a).triangle_begin : -1;
    const int end_a = pair.a >= 0 ? a_.tree->node(pair.a).triangle_end : 0;
    const int begin_b = pair.b >= 0 ? b_.tree->node(pair.b).triangle_begin : -1;
    const int end_b = pair.b >= 0 ? b_.tree->node(pair.b).triangle_end : 0;
    for (int slot_a = begin_a; slot_a < end_a; ++slot_a) {
      for (int slot_b = begin_b; slot_b < end_b; ++slot_b) {
        triangles(slot_a, slot_b);
        if (done()) return;
      }
    }
  }

  // Queries a pair of exact pieces; -1 is a convex shape as a whole.
  void triangles(int slot_a, int slot_b) {
    const ConvexView view_a = slot_a >= 0 ? a_.tree->triangleView(slot_a) : a_.view;
    const ConvexView view_b = slot_b >= 0 ? b_.tree->triangleView(slot_b) : b_.view;
    const bool depth = request_.depth && !placement_.swept;
    const DistanceResult r = askOfPieces(bar(), request_, depth, [&](double threshold) {
      return convex(view_a, view_b, threshold, request_.tolerance, depth);
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
  const DistanceRequest& request_;
  Scratch& scratch_;
  PairCache& cache_;
  TouchingTriangles& touching_;
  DescentResult result_;
  DistanceResult hulls_;            // of the hulls, if that alone is not an answer
  double hulls_upper_ = kInfinity;  // the upper end of the bodies' distance that follows from it
  double rounding_ = 0;             // of sphereLower() [m]
  bool half_space_ = false;
  int visited_ = 0;
  FrontRecorder recorder_;
  int overlap_limit_ = std::numeric_limits<int>::max();
  // Each popped pair pushes at most two, one level lower on one side.
  std::array<NodePair, 2 * MeshTree::kMaxDepth + 4> stack_;
  std::size_t size_ = 0;
};

}  // namespace

DescentResult descend(const DescentSide& a, const DescentSide& b, const DescentPlacement& placement,
                      const DistanceRequest& request, Scratch& scratch, PairCache* cache) {
  return Descent(a, b, placement, request, scratch, *cache).run();
}

}  // namespace leeway::collision
