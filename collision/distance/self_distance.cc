#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/base/scratch.h"
#include "collision/base/status.h"
#include "collision/base/tolerances.h"
#include "collision/convex/convex_distance.h"
#include "collision/deform/query/probe.h"
#include "collision/deform/snapshot.h"
#include "collision/distance/mesh_distance.h"
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
  float low_a[3], high_a[3], low_b[3], high_b[3];
};

// Lower bound on the distance of two boxes.
float boxDistance(const float* low_a, const float* high_a, const float* low_b,
                  const float* high_b) {
  float squared = 0;
  for (int k = 0; k < 3; ++k) {
    const float gap = std::max(std::max(low_b[k] - high_a[k], low_a[k] - high_b[k]), 0.0F);
    squared += gap * gap;
  }
  return std::sqrt(squared) * kBoxDistanceInwards;
}

class SelfDescent {
 public:
  SelfDescent(const DeformableSnapshotImpl& snapshot, const DistanceRequest& request,
              Scratch& scratch, PairCache& cache)
      : snapshot_(snapshot),
        tree_(*snapshot.tree),
        request_(request),
        scratch_(scratch),
        cache_(cache),
        boxes_(snapshot, scratch.impl().deform),
        rounding_(roundingOf(snapshot.low.cwiseAbs().cwiseMax(snapshot.high.cwiseAbs()).norm())) {}

  DistanceResult run() {
    result_.distance = {kInfinity, kInfinity};
    const int count = tree_.triangleCount();
    if (cache_.triangle_a >= 0 && cache_.triangle_a < count && cache_.triangle_b >= 0 &&
        cache_.triangle_b < count && cache_.triangle_a != cache_.triangle_b) {
      triangles(tree_.slotOf(cache_.triangle_a), tree_.slotOf(cache_.triangle_b));
      result_.distance.lower = kInfinity;  // the descent visits the pair again
    }
    SelfPair root{};
    stack_[size_++] = root;
    while (size_ > 0 && !done()) {
      const SelfPair pair = stack_[--size_];
      const auto lower = static_cast<double>(pair.lower);
      if (lower > bar()) {
        settle(lower);
        continue;
      }
      if (visited_ >= request_.node_limit) {
        settle(lower);
        break;
      }
      expand(pair);
      if (done()) settle(lower);
    }
    while (size_ > 0) settle(static_cast<double>(stack_[--size_].lower));
    // Crossing triangles end the search; other pairs may be deeper.
    if (result_.distance.upper <= 0) result_.distance.lower = -kInfinity;
    if (result_.triangle_a > result_.triangle_b) {
      std::swap(result_.triangle_a, result_.triangle_b);
      std::swap(result_.point_a, result_.point_b);
      result_.normal = -result_.normal;
    }
    if (result_.triangle_a >= 0) {
      cache_.triangle_a = result_.triangle_a;
      cache_.triangle_b = result_.triangle_b;
    }
    result_.status = statusOf(result_.distance, request_);
    return result_;
  }

 private:
  static double roundingOf(double extent) { return 2 * kRelativeRounding * (extent + kLeastSum); }
  double bar() const {
    const double bar =
        request_.threshold == request_.threshold ? std::max(request_.threshold, 0.0) : kInfinity;
    return std::min(bar, result_.distance.upper - request_.tolerance);
  }
  bool done() const {
    return result_.distance.upper <= 0 || result_.distance.upper <= request_.threshold;
  }
  void settle(double lower) { result_.distance.lower = std::min(result_.distance.lower, lower); }

  void push(const SelfPair& pair) {
    const auto lower = static_cast<double>(pair.lower);
    if (lower > bar()) {
      settle(lower);
    } else {
      stack_[size_++] = pair;
    }
  }

  void expand(const SelfPair& pair) {
    ++visited_;
    const bool leaf_a = DeformTree::isLeaf(pair.a), leaf_b = DeformTree::isLeaf(pair.b);
    if (pair.a == pair.b) {
      if (leaf_a) {
        leaves(pair);
      } else {
        within(pair.a);
      }
    } else if (leaf_a && leaf_b) {
      leaves(pair);
    } else if (leaf_a ||
               (!leaf_b && size(pair.low_b, pair.high_b) > size(pair.low_a, pair.high_a))) {
      split(pair.b, pair.a, pair.low_a, pair.high_a);
    } else {
      split(pair.a, pair.b, pair.low_b, pair.high_b);
    }
  }

  static float size(const float* low, const float* high) {
    float sum = 0;
    for (int k = 0; k < 3; ++k) sum += high[k] - low[k];
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
          SelfPair pair{node.child[i], node.child[j], 0, {}, {}, {}, {}};
          for (int k = 0; k < 3; ++k) {
            pair.low_a[k] = box.low[k][i];
            pair.high_a[k] = box.high[k][i];
            pair.low_b[k] = box.low[k][j];
            pair.high_b[k] = box.high[k][j];
          }
          if (i != j) pair.lower = boxDistance(pair.low_a, pair.high_a, pair.low_b, pair.high_b);
          push(pair);
        }
      }
    }
  }

  // Pairs the children of one node with another part.
  void split(std::int32_t id, std::int32_t other, const float* low, const float* high) {
    WideBox room;
    const WideBox& box = boxes_.boxes(id, room);
    const DeformTree::Node& node = tree_.node(id);
    const std::size_t begin = size_;
    for (int i = 0; i < kWidth && node.child[i] != DeformTree::kNone; ++i) {
      SelfPair pair{node.child[i], other, 0, {}, {}, {}, {}};
      for (int k = 0; k < 3; ++k) {
        pair.low_a[k] = box.low[k][i];
        pair.high_a[k] = box.high[k][i];
        pair.low_b[k] = low[k];
        pair.high_b[k] = high[k];
      }
      pair.lower = boxDistance(pair.low_a, pair.high_a, pair.low_b, pair.high_b);
      push(pair);
      // Keeps the nearest on top.
      for (std::size_t at = size_; at > begin + 1 && stack_[at - 1].lower > stack_[at - 2].lower;
           --at)
        std::swap(stack_[at - 1], stack_[at - 2]);
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
        float low_a[3], high_a[3], low_b[3], high_b[3];
        for (int k = 0; k < 3; ++k) {
          low_a[k] = box_a.low[k][a - leaf_a.slot_begin];
          high_a[k] = box_a.high[k][a - leaf_a.slot_begin];
          low_b[k] = box_b.low[k][b - leaf_b.slot_begin];
          high_b[k] = box_b.high[k][b - leaf_b.slot_begin];
        }
        const auto lower = static_cast<double>(boxDistance(low_a, high_a, low_b, high_b));
        if (lower > bar()) {
          settle(lower);
          continue;
        }
        triangles(a, b);
        if (done()) return;
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
    ++visited_;
    const TrianglePair pair = trianglePair(corners[0], corners[1]);
    const double bar_now = bar(), lower = pair.below - rounding_, upper = pair.above + rounding_;
    if (lower > 0 && (lower > bar_now || upper - lower <= request_.tolerance)) {
      ++result_.iterations;
      settle(lower);
      if (!(upper < result_.distance.upper)) return;
      result_.distance.upper = upper;
      result_.point_a = pair.p;
      result_.point_b = pair.q;
      result_.normal = pair.normal;
      result_.triangle_a = tree_.triangleOf(slot_a);
      result_.triangle_b = tree_.triangleOf(slot_b);
      return;
    }
    // Crossing, touching, or a sliver: GJK.
    DistanceRequest request = request_;
    request.depth = false;
    if (bar_now < kInfinity && bar_now > 0) request.threshold = bar_now;
    const ConvexView view_a = viewOfPoints(corners[0], 3, 0),
                     view_b = viewOfPoints(corners[1], 3, 0);
    DistanceResult r = convexDistance(view_a, Pose{}, view_b, request, scratch_, &cache_);
    result_.iterations += r.iterations;
    if (r.status == DistanceStatus::kNotAboveThreshold && r.distance.upper > 0 &&
        !(r.distance.upper <= request_.threshold)) {
      request.threshold = request_.threshold;
      r = convexDistance(view_a, Pose{}, view_b, request, scratch_, &cache_);
      result_.iterations += r.iterations;
    }
    settle(r.distance.lower);
    if (!(r.distance.upper < result_.distance.upper)) return;
    const double settled = result_.distance.lower;
    const int iterations = result_.iterations;
    result_ = r;
    result_.iterations = iterations;
    result_.distance.lower = settled;
    result_.triangle_a = tree_.triangleOf(slot_a);
    result_.triangle_b = tree_.triangleOf(slot_b);
  }

  const DeformableSnapshotImpl& snapshot_;
  const DeformTree& tree_;
  const DistanceRequest& request_;
  Scratch& scratch_;
  PairCache& cache_;
  BoxSource boxes_;
  const double rounding_;  // of a pair in closed form, as in mesh_pair.cc [m]
  DistanceResult result_;
  int visited_ = 0;
  // A pair that is popped pushes at most 36 (a node with itself, once for each level) or 8.
  std::array<SelfPair, 36 * DeformTree::kMaxDepth + 8 * 2 * DeformTree::kMaxDepth> stack_;
  std::size_t size_ = 0;
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
