#include "collision/deform/query/deform_descent.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "collision/base/round_box.h"
#include "collision/base/scratch.h"
#include "collision/base/status.h"
#include "collision/base/tolerances.h"
#include "collision/base/work.h"
#include "collision/convex/gjk/support.h"
#include "collision/deform/query/nearest_triangle.h"
#include "collision/deform/query/overlap_octree.h"
#include "collision/deform/query/probe.h"
#include "collision/deform/query/round_body.h"
#include "leeway/collision/convex_hull.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

FloatBox boxOf(const Vector3d& low, const Vector3d& high) {
  FloatBox box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = roundedDown(low[k]);
    box.high[k] = roundedUpToFloat(high[k]);
  }
  return box;
}

FloatBox laneOf(const WideBox& box, int lane) {
  FloatBox one;
  for (int k = 0; k < 3; ++k) {
    one.low[k] = box.low[k][lane];
    one.high[k] = box.high[k][lane];
  }
  return one;
}

Vector3d lowOf(const FloatBox& box) {
  return {static_cast<double>(box.low[0]), static_cast<double>(box.low[1]),
          static_cast<double>(box.low[2])};
}
Vector3d highOf(const FloatBox& box) {
  return {static_cast<double>(box.high[0]), static_cast<double>(box.high[1]),
          static_cast<double>(box.high[2])};
}

double sizeOf(const FloatBox& box) { return (highOf(box) - lowOf(box)).norm(); }

// What stands for a part of a body: a node or a leaf (as in DeformTree::Node), or the whole of a
// rigid body.
struct Part {
  std::int32_t ref;
  FloatBox box;  // in the body's frame
};

struct PartPair {
  Part a, b;
  double lower;  // proven for everything below
};

// Nodes of a hierarchy that are looked at together.
constexpr std::size_t kTogether = 8;

// A node or a leaf that is still to be looked at.
struct Open {
  float lower;  // proven for everything below
  std::int32_t ref;
};

class DeformDescent {
 public:
  DeformDescent(const DeformSide& a, const DeformSide& b, const DescentPlacement& placement,
                const DistanceRequest& request, Scratch& scratch, PairCache& cache)
      : a_(a),
        b_(b),
        placement_(placement),
        request_(request),
        scratch_(scratch),
        cache_(cache),
        kernels_(deformKernels()) {
    if (a.snapshot != nullptr) boxes_a_ = BoxSource(*a.snapshot, scratch.impl().deform);
    if (b.snapshot != nullptr) boxes_b_ = BoxSource(*b.snapshot, scratch.impl().deform);
    half_space_ = isHalfSpace(a) || isHalfSpace(b);
    has_volumes_ =
        b.snapshot != nullptr && b.snapshot->bounds != nullptr && b.snapshot->bounds->hasVolumes();
    extent_b_ = magnitude(b.low) + magnitude(b.high);
    if (isWhole(a) && !isThin()) whole_probe_ = wholeProbe();
  }

  DescentResult run() {
    result_.lower = kInfinity;
    result_.upper = kInfinity;
    setBar();
    if (isThin()) {
      if (thin()) return result_;
      whole_probe_ = wholeProbe();
    }
    PartPair root;
    root.b = {0, boxOf(b_.low, b_.high)};
    if (!isWhole(a_)) root.a = {0, boxOf(a_.low, a_.high)};
    root.lower = lowerBound(makeProbeOf(root.a), root.b.box.low, root.b.box.high);
    result_.hull_lower = root.lower;
    if (needless(root.lower)) {
      settle(root.lower);
      return result_;
    }
    // (The triangle nearest to a thin body has been found, if there is one.)
    if (!(result_.upper < kInfinity)) warmStart();
    if (isFlat(a_) || isFlat(b_)) {
      flat(root);
      return result_;
    }
    if (isWhole(a_)) {
      whole(root.lower);
      return result_;
    }
    stack_[size_++] = root;
    while (size_ > 0 && !done()) {
      const PartPair pair = stack_[--size_];
      if (needless(pair.lower)) {
        settle(pair.lower);
        continue;
      }
      if (visited_ >= limit()) {
        settle(pair.lower);
        break;
      }
      expand(pair);
      if (done()) settle(pair.lower);  // parts of it may not have been looked at
    }
    while (size_ > 0) settle(stack_[--size_].lower);
    return result_;
  }

 private:
  static bool isHalfSpace(const DeformSide& side) {
    return side.snapshot == nullptr && side.rigid.tree == nullptr &&
           side.rigid.view.core == Core::kHalfSpace;
  }
  static double magnitude(const Vector3d& p) { return p.allFinite() ? p.lpNorm<1>() : 0; }

  // Pairs whose lower end is above the bar need no closer look. As in mesh_descent.cc.
  double bar() const { return placement_.swept ? std::min(bar_, result_.lower) : bar_; }
  // To be called when the upper end has changed.
  void setBar() {
    bar_ = kInfinity;
    if (request_.threshold == request_.threshold) bar_ = floor();
    double tolerance = request_.tolerance;
    if (result_.upper <= 0 && !half_space_)
      tolerance = std::max(tolerance, kDeeperShare * -result_.upper);
    bar_ = std::min(bar_, result_.upper - tolerance);
  }
  bool needless(double lower) const {
    return lower > bar() || (placement_.swept && lower >= result_.lower);
  }
  bool done() const {
    if (result_.upper <= request_.threshold) return true;
    if (!placement_.swept) return result_.upper <= 0 && !request_.depth;
    return result_.upper <= 0 || result_.lower <= floor();
  }
  double floor() const { return request_.threshold > 0 ? request_.threshold : 0; }
  int limit() const {
    if (scratch_.impl().work->isSpent()) return 0;
    const int most = request_.node_limit - below_;
    return result_.upper <= 0 && !half_space_ ? std::min(most, overlap_limit_) : most;
  }
  void settle(double lower) { result_.lower = std::min(result_.lower, lower); }

  // A deforming triangle as mesh_descent.cc takes a convex shape.
  static DescentSide triangleSide(const ConvexView& view) {
    DescentSide side;
    side.view = view;
    side.center = view.center;
    side.low = side.high = view.points[0];
    for (int i = 0; i < view.count; ++i) {
      side.low = side.low.cwiseMin(view.points[i]);
      side.high = side.high.cwiseMax(view.points[i]);
      side.radius = std::max(side.radius, (view.points[i] - view.center).norm());
    }
    side.radius = side.radius * (1 + kRelativeRounding) + kRelativeRounding * view.extent;
    side.extent = view.extent;
    return side;
  }

  // A rigid mesh and one triangle.
  DistanceResult mesh(const DescentSide& a, const DescentSide& b, double threshold, bool depth) {
    DistanceRequest request = request_;
    request.threshold = threshold;
    request.depth = depth;
    request.node_limit = request_.node_limit - below_ - visited_;
    ++visited_;
    const DescentResult found = descend(a, b, placement_, request, scratch_, &cache_);
    below_ += found.visited;
    result_.iterations += found.iterations;
    DistanceResult r = found.witness;
    r.distance = {std::max(found.lower, found.hull_lower), found.upper};
    // Below zero pieces that are swept say nothing about the whole.
    if (placement_.swept && !(found.lower > 0)) r.distance.lower = found.hull_lower;
    r.status = statusOf(r.distance, request);
    cache_.triangle_a = r.triangle_a >= 0 ? r.triangle_a : cache_.triangle_a;
    cache_.triangle_b = r.triangle_b >= 0 ? r.triangle_b : cache_.triangle_b;
    return r;
  }

  DistanceResult pieces(const ConvexView& a, const ConvexView& b, double threshold, bool depth) {
    DistanceRequest request;
    request.threshold = threshold;
    request.tolerance = request_.tolerance;
    request.depth = depth;
    request.iteration_limit = request_.iteration_limit;
    ++visited_;
    const DistanceResult r = pieceDistance(a, b, placement_, request, scratch_, &cache_);
    result_.iterations += r.iterations;
    return r;
  }

  // Without a hierarchy: all pieces of both bodies, as many at a time as there is room for.

  static bool isFlat(const DeformSide& side) {
    return side.snapshot != nullptr && side.snapshot->demand == Demand::kNoTree;
  }
  static int slotCount(const DeformSide& side) {
    return side.snapshot != nullptr ? side.snapshot->tree->triangleCount() : 1;
  }

  void flat(const PartPair& root) {
    DeformScratch& scratch = scratch_.impl().deform;
    std::array<FloatBox, 64> few_a, few_b;
    std::array<std::int32_t, 512> few_lists;
    const bool room = !scratch.boxes_b.empty();
    const std::span<FloatBox> boxes_a = room ? std::span<FloatBox>(scratch.boxes_a)
                                             : std::span<FloatBox>(few_a),
                              boxes_b = room ? std::span<FloatBox>(scratch.boxes_b)
                                             : std::span<FloatBox>(few_b);
    const std::span<std::int32_t> lists =
        room ? std::span<std::int32_t>(scratch.lists) : std::span<std::int32_t>(few_lists);
    const int count_a = slotCount(a_), count_b = slotCount(b_);
    const int chunk_a = std::min(count_a, static_cast<int>(boxes_a.size())),
              chunk_b = std::min(count_b, static_cast<int>(boxes_b.size()));
    for (int begin_a = 0; begin_a < count_a && !done(); begin_a += chunk_a) {
      const int end_a = std::min(begin_a + chunk_a, count_a);
      for (int slot = begin_a; slot < end_a; ++slot)
        boxes_a[static_cast<std::size_t>(slot - begin_a)] = boxInB(a_, slot, true);
      for (int begin_b = 0; begin_b < count_b && !done(); begin_b += chunk_b) {
        const int end_b = std::min(begin_b + chunk_b, count_b);
        for (int slot = begin_b; slot < end_b; ++slot)
          boxes_b[static_cast<std::size_t>(slot - begin_b)] = boxInB(b_, slot, false);
        if (!(bar() < kInfinity)) {
          // Some upper end: how far to look has to be known.
          const double lower = result_.lower;
          triangles(isWhole(a_) ? -1 : begin_a, isWhole(b_) ? -1 : begin_b);
          if (!placement_.swept) result_.lower = lower;
        }
        near(boxes_a.first(static_cast<std::size_t>(end_a - begin_a)), begin_a,
             boxes_b.first(static_cast<std::size_t>(end_b - begin_b)), begin_b, lists);
      }
    }
    // What was not looked at is where the boxes of the bodies are, or farther.
    if (done() || !complete_) settle(root.lower);
  }

  // The pairs that are within the bar as it is now; all others are settled with it.
  void near(std::span<const FloatBox> a, int begin_a, std::span<const FloatBox> b, int begin_b,
            std::span<std::int32_t> lists) {
    const double reach = std::max(bar(), 0.0);
    // Growing boxes by the reach is itself rounded.
    const double grown =
        reach + kSingleRounding * (reach + extent_b_ + magnitude(a_.low) + magnitude(a_.high) +
                                   placement_.X_BA0.translation.lpNorm<1>());
    OctreePairs octree(
        a, b, std::nextafter(static_cast<float>(grown), std::numeric_limits<float>::infinity()),
        lists);
    const bool all = octree.run([&](int i, int j, float distance) {
      const double lower = distance > 0 ? static_cast<double>(distance) : -kInfinity;
      if (needless(lower)) {
        settle(lower);
        return true;
      }
      if (++visited_ >= limit()) {
        complete_ = false;
        return false;
      }
      triangles(isWhole(a_) ? -1 : begin_a + i, isWhole(b_) ? -1 : begin_b + j);
      return !done();
    });
    if (all) settle(std::nextafter(reach, kInfinity));
  }

  // The box of an exact piece in B, grown by the growth of a sweep and by all rounding.
  FloatBox boxInB(const DeformSide& side, int slot, bool moves) const {
    Vector3d corners[3];
    const bool whole = isWhole(side);
    if (whole && !moves) return boxOf(side.low, side.high);
    Part part{0, boxOf(side.low, side.high)};
    if (!whole) {
      const ConvexView view = viewOfSlot(side, slot, corners);
      const Vector3d* c = view.points;
      part.box = boxOf(c[0].cwiseMin(c[1]).cwiseMin(c[2]), c[0].cwiseMax(c[1]).cwiseMax(c[2]));
    }
    if (!moves) return part.box;
    const Probe probe = makeProbeOf(part);
    FloatBox box;
    for (int k = 0; k < 3; ++k) {
      const float grown = probe.radius + probe.slack;
      box.low[k] = probe.low[k] - grown;
      box.high[k] = probe.high[k] + grown;
    }
    return box;
  }

  // Hierarchies.

  // A rigid body is taken as a whole, against one triangle after the other: its own hierarchy is
  // gone into by mesh_descent.cc where its hull does not decide.
  static bool isWhole(const DeformSide& side) { return side.snapshot == nullptr; }
  static bool isLeaf(const DeformSide& side, const Part& part) {
    return side.snapshot == nullptr || DeformTree::isLeaf(part.ref);
  }
  // Slots of a leaf; one, numbered -1, of a rigid body.
  static void slotsOf(const DeformSide& side, const Part& part, int& begin, int& end) {
    if (side.snapshot != nullptr) {
      const DeformTree::Leaf& leaf = side.snapshot->tree->leaf(DeformTree::leafOf(part.ref));
      begin = leaf.slot_begin;
      end = leaf.slot_end;
    } else {
      begin = -1;
      end = 0;
    }
  }
  static int triangleOf(const DeformSide& side, int slot) {
    return slot < 0 ? -1 : side.snapshot->tree->triangleOf(slot);
  }

  // An exact piece; `corners` is where a deforming triangle's stand.
  static ConvexView viewOfSlot(const DeformSide& side, int slot, Vector3d* corners) {
    if (side.snapshot != nullptr) {
      const DeformTree::Triangle& t = side.snapshot->tree->corners(slot);
      for (std::size_t k = 0; k < 3; ++k)
        corners[k] = side.snapshot->vertices[static_cast<std::size_t>(t[k])];
      return viewOfPoints(corners, 3, 0);
    }
    return side.rigid.view;
  }
  // Whether those corners, if there are any, are finite: x - x is 0 then.
  static bool isFinite(const DeformSide& side, const Vector3d* corners) {
    if (isWhole(side)) return true;
    const double sum = corners[0].sum() + corners[1].sum() + corners[2].sum();
    return sum - sum == 0;
  }

  Probe makeProbeOf(const Part& part) const {
    return isWhole(a_) ? whole_probe_
                       : makeProbeOf(lowOf(part.box), highOf(part.box), placement_.growth);
  }
  Probe makeProbeOf(const Vector3d& low, const Vector3d& high, double radius) const {
    return makeProbe(low, high, radius, placement_.X_BA0,
                     placement_.swept ? &placement_.X_BA1 : nullptr, extent_b_, placement_.slack);
  }
  // Of a rigid A: its core's own box, and what it is grown by apart.
  Probe wholeProbe() const {
    const bool has_core = !half_space_ && a_.rigid.tree == nullptr;
    const double grown = has_core ? a_.rigid.view.radius : 0;
    return makeProbeOf(a_.low.array() + grown, a_.high.array() - grown, placement_.growth + grown);
  }

  // A sphere or a capsule.
  bool isThin() const {
    if (!isWhole(a_) || a_.rigid.tree != nullptr || placement_.swept) return false;
    const ConvexView& view = a_.rigid.view;
    const bool is_segment = view.core == Core::kSegment;
    return (is_segment || view.core == Core::kPoint) &&
           hasNearest(is_segment, view.size.z(), placement_.X_BA0, *b_.snapshot);
  }

  // False where the question is still open: in contact, for a depth, and where rounding is not
  // small beside the tolerance. Nothing has been settled then, but there is an upper end.
  bool thin() {
    const ConvexView& a = a_.rigid.view;
    const RoundBody body = roundBody(a.radius, a.size.z(), placement_.X_BA0);
    NearestSearch search = nearestSearch(body, *b_.snapshot, placement_.slack, request_);
    double root = boxLower(body, *b_.snapshot, search);
    if (!(root > 0)) {
      // How deep boxes are in each other is for those to tell that know of depths.
      whole_probe_ = wholeProbe();
      const FloatBox box = boxOf(b_.low, b_.high);
      root = lowerBound(whole_probe_, box.low, box.high);
    }
    result_.hull_lower = root;
    if (needless(root)) {
      settle(root);
      return true;
    }
    search.limit = limit();
    const DeformTree& tree = *b_.snapshot->tree;
    if (cache_.triangle_b >= 0 && cache_.triangle_b < tree.triangleCount())
      search.first = tree.slotOf(cache_.triangle_b);
    const NearestFound found = findNearest(search, *b_.snapshot, boxes_b_);
    visited_ += found.visited;
    if (found.slot >= 0) {
      if (answerNearest(body, found, tree, request_, result_.witness)) {
        ++visited_;
        ++result_.iterations;
        settle(result_.witness.distance.lower);
        result_.upper = result_.witness.distance.upper;
        setBar();
      } else {
        triangles(-1, found.slot);
      }
    }
    const double lower = found.lower - a.radius;
    if (done() || needless(lower) || visited_ >= limit()) {
      settle(std::max(done() ? root : lower, root));
      return true;
    }
    if (found.slot >= 0) {
      warmed(-1, found.slot);
      remember(result_.witness);
    }
    result_.lower = kInfinity;
    return false;
  }

  // A rigid body against the nodes of B alone. Those on top of the stack are looked at several at a
  // time, so that nobody waits for what one comes to before the next is begun; before there is an
  // upper end, one at a time, since the nearest leads to it. (Not inlined: most questions about a
  // threshold end before it, and its room on the stack is another page.)
  __attribute__((noinline)) void whole(double root) {
    // What is taken together stands on top, deeper nodes above others: no level of the hierarchy
    // has more than the children of one taking there.
    std::array<Open, (DeformTree::kMaxDepth + 1) * kWidth * kTogether> open;
    std::size_t size = 0;
    open[size++] = {roundedDown(root), 0};
    bool over = done(), within = true;  // the limit
    while (size > 0 && !over && within) {
      const std::size_t most = result_.upper < kInfinity ? kTogether : 1;
      std::array<Open, kTogether> taken;
      std::size_t count = 0;
      while (size > 0 && count < most) {
        const Open at = open[size - 1];
        const auto lower = static_cast<double>(at.lower);
        if (needless(lower)) {
          settle(lower);
          --size;
          continue;
        }
        const bool leaf = DeformTree::isLeaf(at.ref);
        if (leaf && count > 0) break;
        within = visited_ < limit();
        if (!within) break;
        ++visited_;
        --size;
        if (!leaf) {
          taken[count++] = at;
          continue;
        }
        wholeAgainstLeaf(at);
        over = done();
        if (over) settle(lower);  // parts of it may not have been looked at
        break;
      }
      if (count > 0) size += children({taken.data(), count}, &open[size]);
      // Nodes alone end nothing but sweeps.
      over = over || (placement_.swept && done());
    }
    while (size > 0) settle(static_cast<double>(open[--size].lower));
  }

  void wholeAgainstLeaf(const Open& at) {
    const DeformTree& tree = *b_.snapshot->tree;
    const DeformTree::Leaf& leaf = tree.leaf(DeformTree::leafOf(at.ref));
    if (isBeyondPlane(tree.leafVertices().subspan(
            static_cast<std::size_t>(leaf.vertex_begin),
            static_cast<std::size_t>(leaf.vertex_end - leaf.vertex_begin))))
      return;
    Bounds bounds;
    kernels_.triangleBounds(whole_probe_, tree, b_.snapshot->vertices.data(), leaf.slot_begin,
                            leaf.slot_end, bounds);
    leafAgainst(-1, leaf.slot_begin, leaf.slot_end, static_cast<double>(at.lower), bounds);
  }

  // Those children of the nodes that need a closer look, the first node's last, and of each the
  // nearest last.
  std::size_t children(std::span<const Open> parents, Open* open) {
    const DeformTree& tree = *b_.snapshot->tree;
    std::array<WideBox, kTogether> room;
    std::array<const WideBox*, kTogether> boxes;
    std::array<std::int32_t, kTogether> nodes;
    std::array<Bounds, kTogether> bounds;
    for (std::size_t i = 0; i < parents.size(); ++i) {
      nodes[i] = parents[i].ref;
      boxes[i] = &boxes_b_.boxes(nodes[i], room[i]);
    }
    kernels_.childBounds(whole_probe_, tree, b_.snapshot->vertices.data(),
                         {nodes.data(), parents.size()}, boxes.data(), roundedUpToFloat(bar()),
                         bounds.data());
    std::size_t count = 0;
    for (std::size_t i = parents.size(); i-- > 0;) {
      tighten(nodes[i], whole_probe_, bounds[i]);
      settle(static_cast<double>(bounds[i].closed));
      const DeformTree::Node& node = tree.node(nodes[i]);
      const std::size_t first = count;
      for (unsigned left = bounds[i].open; left != 0; left &= left - 1) {
        const int lane = std::countr_zero(left);
        const float lower = std::max(parents[i].lower, bounds[i].lower[lane]);
        std::size_t at = count++;
        for (; at > first && open[at - 1].lower < lower; --at) open[at] = open[at - 1];
        open[at] = {lower, node.child[lane]};
        boxes_b_.fetch(node.child[lane]);
      }
    }
    return count;
  }

  // What the volumes of B's motion prove beyond the boxes.
  void tighten(std::int32_t node, const Probe& probe, Bounds& bounds) const {
    if (!has_volumes_) return;
    b_.snapshot->bounds->tighten(node, b_.snapshot->parameters, probe, bounds);
    for (unsigned left = bounds.open; left != 0; left &= left - 1) {
      const int lane = std::countr_zero(left);
      if (!needless(static_cast<double>(bounds.lower[lane]))) continue;
      bounds.open &= ~(1U << lane);
      bounds.closed = std::min(bounds.closed, bounds.lower[lane]);
    }
  }

  void expand(const PartPair& pair) {
    const bool leaf_a = isLeaf(a_, pair.a), leaf_b = isLeaf(b_, pair.b);
    ++visited_;
    if (leaf_a && leaf_b) {
      leaves(pair);
    } else if (leaf_a || (!leaf_b && sizeOf(pair.b.box) >= sizeOf(pair.a.box))) {
      splitB(pair);
    } else {
      splitA(pair);
    }
  }

  // Pairs in the order of their lower ends, the least on top of the stack; what needs no closer
  // look is settled.
  void push(std::array<PartPair, kWidth>& pairs, int count) {
    std::array<int, kWidth> order{};
    int open = 0;
    for (int i = 0; i < count; ++i) {
      const PartPair& pair = pairs[static_cast<std::size_t>(i)];
      if (needless(pair.lower)) {
        settle(pair.lower);
        continue;
      }
      int at = open++;
      for (; at > 0 &&
             pairs[static_cast<std::size_t>(order[static_cast<std::size_t>(at - 1)])].lower <
                 pair.lower;
           --at)
        order[static_cast<std::size_t>(at)] = order[static_cast<std::size_t>(at - 1)];
      order[static_cast<std::size_t>(at)] = i;
    }
    for (int i = 0; i < open; ++i)
      stack_[size_++] = pairs[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])];
  }

  void splitB(const PartPair& pair) {
    std::array<PartPair, kWidth> pairs;
    int count = 0;
    WideBox room;
    const WideBox& box = boxes_b_.boxes(pair.b.ref, room);
    const WideBox* const boxes = &box;
    Bounds bounds;
    const Probe probe = makeProbeOf(pair.a);
    kernels_.childBounds(probe, *b_.snapshot->tree, b_.snapshot->vertices.data(), {&pair.b.ref, 1},
                         &boxes, roundedUpToFloat(bar()), &bounds);
    tighten(pair.b.ref, probe, bounds);
    const DeformTree::Node& node = b_.snapshot->tree->node(pair.b.ref);
    for (int lane = 0; lane < kWidth && node.child[lane] != DeformTree::kNone; ++lane) {
      pairs[static_cast<std::size_t>(count++)] = {
          pair.a,
          {node.child[lane], laneOf(box, lane)},
          std::max(pair.lower, static_cast<double>(bounds.lower[lane]))};
    }
    push(pairs, count);
  }

  void splitA(const PartPair& pair) {
    std::array<PartPair, kWidth> pairs;
    int count = 0;
    WideBox room;
    const WideBox& box = boxes_a_.boxes(pair.a.ref, room);
    const DeformTree::Node& node = a_.snapshot->tree->node(pair.a.ref);
    for (int lane = 0; lane < kWidth && node.child[lane] != DeformTree::kNone; ++lane) {
      const Part part{node.child[lane], laneOf(box, lane)};
      pairs[static_cast<std::size_t>(count++)] = {
          part, pair.b,
          std::max(pair.lower, lowerBound(makeProbeOf(part), pair.b.box.low, pair.b.box.high))};
    }
    push(pairs, count);
  }

  void leaves(const PartPair& pair) {
    int begin_a = 0, end_a = 0, begin_b = 0, end_b = 0;
    slotsOf(a_, pair.a, begin_a, end_a);
    slotsOf(b_, pair.b, begin_b, end_b);
    WideBox box_a;
    kernels_.triangles(*a_.snapshot->tree, a_.snapshot->vertices.data(), begin_a, end_a, box_a);
    for (int slot_a = begin_a; slot_a < end_a; ++slot_a) {
      const Part part{pair.a.ref, laneOf(box_a, slot_a - begin_a)};
      Bounds bounds;
      if (isWhole(b_)) {
        bounds.lower[0] = static_cast<float>(-kInfinity);  // it may be unbounded
      } else {
        kernels_.triangleBounds(makeProbeOf(part), *b_.snapshot->tree, b_.snapshot->vertices.data(),
                                begin_b, end_b, bounds);
      }
      leafAgainst(slot_a, begin_b, end_b, pair.lower, bounds);
      if (done()) return;
    }
  }

  // The plane across the shortest way so far, at the end of A: all that is beyond it is as far away
  // as it is from the plane. Triangles that share the nearest vertex or edge are as near as the
  // nearest, and most of them end here.
  void remember(const DistanceResult& nearest) {
    has_plane_ = isWhole(a_) && a_.rigid.tree == nullptr && b_.snapshot != nullptr &&
                 !half_space_ && !placement_.swept && nearest.distance.upper > 0;
    if (!has_plane_) return;
    plane_normal_ = nearest.normal.normalized();
    int hint = 0;
    const ConvexView& a = a_.rigid.view;
    const Vector3d last =
        placement_.X_BA0 * farthest(a, placement_.X_BA0.rotation.transpose() * plane_normal_, hint);
    // Two scalar products, their difference and the normal's length: some ten roundings each of
    // numbers that are no larger than this.
    const double size = extent_b_ + a.extent + a.radius + placement_.X_BA0.translation.lpNorm<1>();
    plane_offset_ =
        plane_normal_.dot(last) + a.radius + a.excess + placement_.slack + kRelativeRounding * size;
  }

  // Whether vertices, and what they span, are so far beyond that plane that they need no closer
  // look; they are settled then.
  bool isBeyondPlane(std::span<const std::int32_t> vertices) {
    if (!has_plane_) return false;
    double least = 0;
    if (!kernels_.leastAlong(plane_normal_.data(), b_.snapshot->vertices.data(), vertices, least))
      return false;
    const double lower = least - plane_offset_;
    if (!needless(lower)) return false;
    settle(lower);
    return true;
  }

  // One exact piece of A against the triangles of a leaf, nearest first.
  void leafAgainst(int slot_a, int begin_b, int end_b, double lower, Bounds& bounds) {
    const int count = end_b - begin_b;
    for (int round = 0; round < count; ++round) {
      int next = -1;
      for (int i = 0; i < count; ++i) {
        // Written so that those that are done, marked by NaN, fail.
        if (bounds.lower[i] == bounds.lower[i] &&
            (next < 0 || bounds.lower[i] < bounds.lower[next]))
          next = i;
      }
      const double least = std::max(lower, static_cast<double>(bounds.lower[next]));
      if (needless(least)) {
        settle(least);  // and all others are farther
        return;
      }
      bounds.lower[next] = std::numeric_limits<float>::quiet_NaN();
      if (slot_a == warm_a_ && begin_b + next == warm_b_) {
        settle(warm_lower_);
        continue;
      }
      if (slot_a < 0 && begin_b >= 0 && isBeyondPlane(b_.snapshot->tree->corners(begin_b + next)))
        continue;
      triangles(slot_a, begin_b + next);
      if (done()) return;
    }
  }

  // A pair of exact pieces; -1 is a convex shape as a whole. As in mesh_descent.cc.
  void triangles(int slot_a, int slot_b) {
    Vector3d corners_a[3], corners_b[3];
    const ConvexView view_a = viewOfSlot(a_, slot_a, corners_a),
                     view_b = viewOfSlot(b_, slot_b, corners_b);
    if (!isFinite(a_, corners_a) || !isFinite(b_, corners_b)) {
      // Vouched for, but where is it? Nor does the box of all vertices tell.
      settle(-kInfinity);
      result_.hull_lower = -kInfinity;
      result_.misplaced = true;
      return;
    }
    const bool depth = request_.depth && !placement_.swept;
    const DistanceResult r = askOfPieces(bar(), request_, depth, [&](double threshold) {
      if (a_.rigid.tree != nullptr) return mesh(a_.rigid, triangleSide(view_b), threshold, depth);
      if (b_.rigid.tree != nullptr) return mesh(triangleSide(view_a), b_.rigid, threshold, depth);
      return pieces(view_a, view_b, threshold, depth);
    });
    settle(r.distance.lower);
    if (!(r.distance.upper < result_.upper)) return;
    if (r.distance.upper <= 0 && result_.upper > 0) overlap_limit_ = visited_ + kDeeperNodes;
    result_.upper = r.distance.upper;
    setBar();
    result_.witness = r;
    remember(r);
    if (a_.rigid.tree == nullptr) result_.witness.triangle_a = triangleOf(a_, slot_a);
    if (b_.rigid.tree == nullptr) result_.witness.triangle_b = triangleOf(b_, slot_b);
  }

  // The pair of triangles that was closest last time: an upper end at once.
  void warmStart() {
    const auto slotOf = [](const DeformSide& side, int triangle) {
      if (isWhole(side)) return -1;
      const DeformTree& tree = *side.snapshot->tree;
      return triangle >= 0 && triangle < tree.triangleCount() ? tree.slotOf(triangle) : -2;
    };
    const int slot_a = slotOf(a_, cache_.triangle_a), slot_b = slotOf(b_, cache_.triangle_b);
    if (slot_a < -1 || slot_b < -1) return;
    const double lower = result_.lower;
    triangles(slot_a, slot_b);
    if (placement_.swept) return;
    warmed(slot_a, slot_b);
    result_.lower = lower;
  }

  // The pair, which was the first to be looked at, comes again in its turn; what is known of it as
  // well as is asked needs no second look then.
  void warmed(int slot_a, int slot_b) {
    if (result_.upper > 0 && result_.upper - result_.lower <= request_.tolerance) {
      warm_a_ = slot_a;
      warm_b_ = slot_b;
      warm_lower_ = result_.lower;
    }
  }

  const DeformSide& a_;
  const DeformSide& b_;
  const DescentPlacement& placement_;
  const DistanceRequest& request_;
  Scratch& scratch_;
  PairCache& cache_;
  const DeformKernels& kernels_;
  BoxSource boxes_a_, boxes_b_;
  DescentResult result_;
  double bar_ = kInfinity;  // but for sweeps, see bar()
  bool half_space_ = false;
  bool has_volumes_ = false;       // of B, beyond boxes
  Probe whole_probe_{};            // of a rigid A
  double extent_b_ = 0;            // of B's coordinates
  int warm_a_ = -2, warm_b_ = -2;  // slots of the pair that was looked at first; -2: none
  double warm_lower_ = 0;          // proven for it
  bool has_plane_ = false;
  Vector3d plane_normal_ = Vector3d::Zero();
  double plane_offset_ = 0;  // beyond which the plane is, along its normal
  int visited_ = 0;
  int below_ = 0;  // in hierarchies of rigid meshes; of the limit, too, but not of overlap_limit_
  bool complete_ = true;
  int overlap_limit_ = std::numeric_limits<int>::max();
  // Every pair that is taken off puts at most eight back, which are one level lower on one side.
  std::array<PartPair, (kWidth - 1) * (2 * DeformTree::kMaxDepth) + kWidth> stack_;
  std::size_t size_ = 0;
};

}  // namespace

DeformSide deformSide(const Shape& shape) {
  DeformSide side;
  if (shape.type() == ShapeType::kDeformable) {
    side.snapshot = &shape.deformable()->impl();
    side.low = side.snapshot->low;
    side.high = side.snapshot->high;
    side.extent = shape.extent();
    return side;
  }
  side.rigid = descentSide(shape);
  side.low = side.rigid.low;
  side.high = side.rigid.high;
  side.extent = side.rigid.extent;
  if (shape.type() == ShapeType::kConvexHull) {
    // The box of its vertices is tighter than that of the sphere around them.
    Vector3d low = shape.hull()->vertices()[0], high = low;
    for (const Vector3d& v : shape.hull()->vertices()) {
      low = low.cwiseMin(v);
      high = high.cwiseMax(v);
    }
    side.low = low.array() - shape.hull()->excess();
    side.high = high.array() + shape.hull()->excess();
  }
  return side;
}

namespace {

// What the ball around a rigid body proves, 0 or less where that is nothing: most questions about a
// threshold end here.
double ballLower(const DeformSide& a, const DeformSide& b, const DescentPlacement& placement) {
  if (a.snapshot != nullptr || !(a.rigid.radius < kInfinity) || !(b.extent < kInfinity)) return 0;
  Vector3d p = placement.X_BA0 * a.rigid.center;
  double radius = a.rigid.radius + placement.growth, moved = 0;
  if (placement.swept) {
    const Vector3d end = placement.X_BA1 * a.rigid.center;
    moved = placement.X_BA1.translation.norm();
    radius += 0.5 * (end - p).norm();
    p = 0.5 * (p + end);
  }
  const double outside = (b.low - p).cwiseMax(p - b.high).cwiseMax(0.0).norm();
  const double rounding = kRelativeRounding * (a.extent + b.extent + moved + radius +
                                               placement.X_BA0.translation.norm()) +
                          placement.slack;
  return outside - radius - rounding;
}

}  // namespace

DescentResult deformDescend(const DeformSide& a, const DeformSide& b,
                            const DescentPlacement& placement, const DistanceRequest& request,
                            Scratch& scratch, PairCache* cache) {
  if (request.threshold == request.threshold) {
    const double lower = ballLower(a, b, placement);
    if (lower > std::max(request.threshold, 0.0)) {
      DescentResult result;
      result.lower = result.hull_lower = lower;
      result.upper = kInfinity;
      return result;
    }
  }
  return DeformDescent(a, b, placement, request, scratch, *cache).run();
}

}  // namespace leeway::collision
