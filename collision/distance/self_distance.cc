#include <algorithm>
#include <cmath>

#include "collision/base/numbers.h"
#include "collision/base/scratch.h"
#include "collision/base/status.h"
#include "collision/base/tolerances.h"
#include "collision/convex/convex_distance.h"
#include "collision/deform/query/float_box.h"
#include "collision/deform/query/probe.h"
#include "collision/deform/snapshot.h"
#include "collision/distance/mesh_distance.h"
#include "collision/mesh/descent/branch_and_bound.h"
#include "collision/mesh/descent/descent_bounds.h"
#include "collision/mesh/descent/triangle_pair.h"
#include "collision/shapes/default_tolerance.h"
#include "leeway/collision/deformable_mesh.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

// Two nodes of one tree, or a node with itself.
struct SelfPair {
  std::int32_t a, b;
  float lower;
  FloatBox box_a, box_b;
};

// Lower bound on the distance of two boxes.
float boxDistance(const FloatBox& a, const FloatBox& b) {
  float squared = 0;
  for (int k = 0; k < 3; ++k) {
    const float gap = std::max(std::max(b.low[k] - a.high[k], a.low[k] - b.high[k]), 0.0F);
    squared += gap * gap;
  }
  return std::sqrt(squared) * kBoxDistanceInwards;
}

class SelfDescent : public DescentBounds {
 public:
  SelfDescent(const DeformableSnapshotImpl& snapshot, const DistanceRequest& asked,
              Scratch& scratch, PairCache& cache)
      : DescentBounds(asked, scratch, {}),
        snapshot_(snapshot),
        tree_(*snapshot.tree),
        scratch_(scratch),
        cache_(cache),
        boxes_(snapshot, scratch.impl().deform),
        rounding_(roundingOf(snapshot.low.cwiseAbs().cwiseMax(snapshot.high.cwiseAbs()).norm())) {}

  DistanceResult run() {
    const int count = tree_.triangleCount();
    if (cache_.triangle_a >= 0 && cache_.triangle_a < count && cache_.triangle_b >= 0 &&
        cache_.triangle_b < count && cache_.triangle_a != cache_.triangle_b)
      compareFirst(
          [&] { triangles(tree_.slotOf(cache_.triangle_a), tree_.slotOf(cache_.triangle_b)); });
    open_.push({});
    for (SelfPair pair; open_.next(*this, pair);) {
      expand(pair);
      if (isDone()) settle(pair);
    }
    open_.settleRest(*this);
    DistanceResult found = result.witness;
    found.iterations = result.iterations;
    // Crossing triangles end the search; other pairs may be deeper.
    found.distance = {result.upper <= 0 ? -kInfinity : result.lower, result.upper};
    if (found.triangle_a > found.triangle_b) {
      std::swap(found.triangle_a, found.triangle_b);
      std::swap(found.point_a, found.point_b);
      found.normal = -found.normal;
    }
    if (found.triangle_a >= 0) {
      cache_.triangle_a = found.triangle_a;
      cache_.triangle_b = found.triangle_b;
    }
    found.status = statusOf(found.distance, request);
    return found;
  }

 private:
  static double roundingOf(double extent) { return 2 * kRelativeRounding * (extent + kLeastSum); }

  void expand(const SelfPair& pair) {
    visit();
    const bool leaf_a = DeformTree::isLeaf(pair.a), leaf_b = DeformTree::isLeaf(pair.b);
    if (pair.a == pair.b) {
      if (leaf_a) {
        leaves(pair);
      } else {
        within(pair.a);
      }
    } else if (leaf_a && leaf_b) {
      leaves(pair);
    } else if (leaf_a || (!leaf_b && size(pair.box_b) > size(pair.box_a))) {
      split(pair.b, pair.a, pair.box_a);
    } else {
      split(pair.a, pair.b, pair.box_b);
    }
  }

  static float size(const FloatBox& box) {
    float sum = 0;
    for (int k = 0; k < 3; ++k) sum += box.high[k] - box.low[k];
    return sum;
  }

  void within(std::int32_t id) {
    WideBox room;
    const WideBox& box = boxes_.boxes(id, room);
    const DeformTree::Node& node = tree_.node(id);
    // Pushes pairs of children first: each child with itself, whose lower end is 0, goes on top.
    for (int own = 0; own < 2; ++own) {
      for (int i = 0; i < kWidth && node.child[i] != DeformTree::kNone; ++i) {
        for (int j = own == 0 ? i + 1 : i;
             j < (own == 0 ? kWidth : i + 1) && node.child[j] != DeformTree::kNone; ++j) {
          SelfPair pair{node.child[i], node.child[j], 0, floatBox(box, i), floatBox(box, j)};
          if (i != j) pair.lower = boxDistance(pair.box_a, pair.box_b);
          open_.pushSibling(*this, open_.size(), pair);
        }
      }
    }
  }

  // Pairs the children of one node with another part.
  void split(std::int32_t id, std::int32_t other, const FloatBox& other_box) {
    WideBox room;
    const WideBox& box = boxes_.boxes(id, room);
    const DeformTree::Node& node = tree_.node(id);
    const std::size_t first = open_.size();
    for (int i = 0; i < kWidth && node.child[i] != DeformTree::kNone; ++i) {
      const FloatBox own = floatBox(box, i);
      open_.pushSibling(*this, first,
                        {node.child[i], other, boxDistance(own, other_box), own, other_box});
    }
  }

  void leaves(const SelfPair& pair) {
    const DeformTree::Leaf& leaf_a = tree_.leaf(DeformTree::leafOf(pair.a));
    const DeformTree::Leaf& leaf_b = tree_.leaf(DeformTree::leafOf(pair.b));
    WideBox box_a, box_b;
    const DeformKernels& kernels = deformKernels();
    kernels.triangles(tree_, snapshot_.vertices.data(), leaf_a.slot_begin, leaf_a.slot_end, box_a);
    kernels.triangles(tree_, snapshot_.vertices.data(), leaf_b.slot_begin, leaf_b.slot_end, box_b);
    for (int a = leaf_a.slot_begin; a < leaf_a.slot_end; ++a) {
      for (int b = pair.a == pair.b ? a + 1 : leaf_b.slot_begin; b < leaf_b.slot_end; ++b) {
        const auto lower = static_cast<double>(boxDistance(floatBox(box_a, a - leaf_a.slot_begin),
                                                           floatBox(box_b, b - leaf_b.slot_begin)));
        if (isPruned(lower)) {
          settle(lower);
          continue;
        }
        triangles(a, b);
        if (isDone()) return;
      }
    }
  }

  void triangles(int slot_a, int slot_b) {
    const DeformTree::Triangle &a = tree_.corners(slot_a), &b = tree_.corners(slot_b);
    Vector3d corners[2][3];
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        if (a[i] == b[j]) return;  // neighbours touch
      }
      corners[0][i] = snapshot_.vertices[static_cast<std::size_t>(a[i])];
      corners[1][i] = snapshot_.vertices[static_cast<std::size_t>(b[i])];
    }
    visit();
    const TrianglePair pair = trianglePair(corners[0], corners[1]);
    const double bar_now = bar(), lower = pair.below - rounding_, upper = pair.above + rounding_;
    if (lower > 0 && (lower > bar_now || upper - lower <= request.tolerance)) {
      ++result.iterations;
      settle(lower);
      DistanceResult apart;
      apart.point_a = pair.p;
      apart.point_b = pair.q;
      apart.normal = pair.normal;
      offer(apart, upper, tree_.triangleOf(slot_a), tree_.triangleOf(slot_b));
      return;
    }
    // Crossing, touching, or a sliver: GJK.
    DistanceRequest own = request;
    own.depth = false;
    if (bar_now < kInfinity && bar_now > 0) own.threshold = bar_now;
    const ConvexView view_a = viewOfPoints(corners[0], 3, 0),
                     view_b = viewOfPoints(corners[1], 3, 0);
    DistanceResult r = convexDistance(view_a, Pose{}, view_b, own, scratch_, &cache_);
    result.iterations += r.iterations;
    if (r.status == DistanceStatus::kNotAboveThreshold && r.distance.upper > 0 &&
        !(r.distance.upper <= request.threshold)) {
      own.threshold = request.threshold;
      r = convexDistance(view_a, Pose{}, view_b, own, scratch_, &cache_);
      result.iterations += r.iterations;
    }
    settle(r.distance.lower);
    offer(r, r.distance.upper, tree_.triangleOf(slot_a), tree_.triangleOf(slot_b));
  }

  const DeformableSnapshotImpl& snapshot_;
  const DeformTree& tree_;
  Scratch& scratch_;
  PairCache& cache_;
  BoxSource boxes_;
  const double rounding_;  // of a pair in closed form, as in mesh_pair.cc [m]
  // A pair that is popped pushes at most 36 (a node with itself, once for each level) or 8.
  BranchAndBound<SelfPair, 36 * DeformTree::kMaxDepth + 8 * 2 * DeformTree::kMaxDepth> open_;
};

}  // namespace

DistanceResult selfDistance(const DeformableSnapshot& snapshot, const DistanceRequest& request,
                            Scratch& scratch, PairCache* cache) {
  PairCache own;
  PairCache& warm = cache != nullptr ? *cache : own;
  if (!std::isnan(request.tolerance)) {
    return SelfDescent(snapshot.impl(), request, scratch, warm).run();
  }
  // The default tolerance of distance(), with this body for both.
  const DeformableSnapshotImpl& mesh = snapshot.impl();
  const double radius = 0.5 * (mesh.high - mesh.low).norm(),
               extent = mesh.low.cwiseAbs().cwiseMax(mesh.high.cwiseAbs()).norm();
  const DistanceRequest by_default = withTolerance(request, toleranceOf(radius, extent));
  return SelfDescent(snapshot.impl(), by_default, scratch, warm).run();
}

}  // namespace leeway::collision
