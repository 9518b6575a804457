#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "collision/base/large_pages.h"
#include "collision/base/numbers.h"
#include "collision/base/parallel.h"
#include "collision/base/tolerances.h"
#include "collision/mesh/mesh_tree.h"
#include "collision/shapes/hull_builder.h"
#include "collision/shapes/hull_distance.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

using Triangle = std::array<std::int32_t, 3>;

constexpr int kBins = 16;
// From this depth on, nodes are halved, so that kMaxDepth holds for any mesh of 2^31 triangles.
constexpr int kFreePlanDepth = MeshTree::kMaxDepth - 34;

double halfArea(const Vector3d& low, const Vector3d& high) {
  const Vector3d d = high - low;
  return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
}

struct Box {
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity());
  Vector3d high = Vector3d::Constant(-std::numeric_limits<double>::infinity());
  std::int32_t count = 0;

  void add(const Vector3d& box_low, const Vector3d& box_high, std::int32_t n) {
    low = low.cwiseMin(box_low);
    high = high.cwiseMax(box_high);
    count += n;
  }
};

double segmentDistance(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d ab = b - a;
  const double squared = ab.squaredNorm();
  const double t = squared > 0 ? std::clamp(ab.dot(p - a) / squared, 0.0, 1.0) : 0.0;
  return (a + t * ab - p).norm();
}

// The box of a triangle.
struct TriangleBox {
  Vector3d low, high;

  Vector3d center() const { return 0.5 * low + 0.5 * high; }
};
using TriangleBoxes = std::pmr::vector<TriangleBox>;

TriangleBoxes boxesOf(std::span<const Vector3d> vertices, std::span<const Triangle> triangles) {
  TriangleBoxes boxes(largeArrays());
  boxes.reserve(triangles.size());
  for (const Triangle& t : triangles) {
    const Vector3d &a = vertices[at(t[0])], &b = vertices[at(t[1])], &c = vertices[at(t[2])];
    boxes.push_back({a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)});
  }
  return boxes;
}

// Not initialized until it has a triangle, because most nodes have fewer triangles than bins.
struct Bin {
  Vector3d low, high;
  std::int32_t count = 0;

  void add(const TriangleBox& box) {
    low = count == 0 ? box.low : Vector3d(low.cwiseMin(box.low));
    high = count == 0 ? box.high : Vector3d(high.cwiseMax(box.high));
    ++count;
  }
};

// The surface area heuristic with bins: the cut between two bins with the least sum of area times
// count on both sides, over three axes. Returns the axis, or -1 if all centres coincide.
int chooseCut(const TriangleBoxes& boxes, std::span<const std::int32_t> order, double& cut) {
  Vector3d from = boxes[at(order[0])].center(), to = from;
  for (const std::int32_t t : order) {
    from = from.cwiseMin(boxes[at(t)].center());
    to = to.cwiseMax(boxes[at(t)].center());
  }
  const Vector3d width = to - from;
  std::array<std::array<Bin, kBins>, 3> all_bins;
  for (const std::int32_t t : order) {
    const TriangleBox& box = boxes[at(t)];
    const Vector3d center = box.center();
    for (int axis = 0; axis < 3; ++axis) {
      if (!(width[axis] > 0)) continue;
      const double f = (center[axis] - from[axis]) / width[axis] * kBins;
      all_bins[at(axis)][at(std::clamp(static_cast<int>(f), 0, kBins - 1))].add(box);
    }
  }
  int best_axis = -1;
  double best = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (!(width[axis] > 0)) continue;
    const std::array<Bin, kBins>& bins = all_bins[at(axis)];
    std::array<double, kBins> right_cost{};
    Box right;
    for (std::size_t i = kBins - 1; i > 0; --i) {
      if (bins[i].count > 0) right.add(bins[i].low, bins[i].high, bins[i].count);
      right_cost[i] = right.count > 0 ? halfArea(right.low, right.high) * right.count : -1;
    }
    Box left;
    for (std::size_t i = 1; i < kBins; ++i) {
      if (bins[i - 1].count > 0) left.add(bins[i - 1].low, bins[i - 1].high, bins[i - 1].count);
      if (left.count == 0 || right_cost[i] < 0) continue;
      const double cost = halfArea(left.low, left.high) * left.count + right_cost[i];
      if (cost >= best) continue;
      best = cost;
      best_axis = axis;
      cut = from[axis] + width[axis] * static_cast<double>(i) / kBins;
    }
  }
  return best_axis;
}

// Plans a part of a tree.
class Planner {
 public:
  // `order`: triangles, permuted as the tree grows. All arguments must outlive this object.
  Planner(std::span<const Vector3d> vertices, std::span<const Triangle> triangles,
          const TriangleBoxes& boxes, std::span<std::int32_t> order)
      : vertices_(vertices),
        triangles_(triangles),
        boxes_(boxes),
        order_(order),
        stamp_(vertices.size(), -1) {}

  // Reserves room for the nodes of this many triangles: usually as many nodes as triangles, with 8
  // points each.
  void reserve(std::size_t count) {
    nodes_.reserve(count + count / 4);
    core_.reserve(8 * count);
  }

  // Builds node by node in preorder, so that each left child follows its parent. Large parts are
  // planned in separate threads and then put in their places.
  void build(std::int32_t begin, std::int32_t end, int depth) {
    const std::size_t id = nodes_.size();
    nodes_.push_back(bound(begin, end));
    if (end - begin <= MeshTree::kLeafTriangles) return;
    const std::int32_t split = part(begin, end, depth);
    nodes_[id].split = split;
    if (at(end - begin) < std::max(kWorthAThread, triangles_.size() / 8)) {
      build(begin, split, depth + 1);
      build(split, end, depth + 1);
      return;
    }
    Planner right(vertices_, triangles_, boxes_, order_);
    right.reserve(at(end - split));
    inParallel(
        true, [&] { build(begin, split, depth + 1); }, [&] { right.build(split, end, depth + 1); });
    nodes_.insert(nodes_.end(), right.nodes_.begin(), right.nodes_.end());
    core_.insert(core_.end(), right.core_.begin(), right.core_.end());
  }

  std::vector<MeshTreePlan::Node> takeNodes() { return std::move(nodes_); }
  std::vector<std::int32_t> takeCore() { return std::move(core_); }

 private:
  // Splits the slots in two and returns the start of the second part.
  std::int32_t part(std::int32_t begin, std::int32_t end, int depth) {
    const auto first = order_.begin() + begin, last = order_.begin() + end;
    auto middle = first + (end - begin) / 2;
    double cut = 0;
    int axis = -1;
    if (depth < kFreePlanDepth) {
      axis = chooseCut(boxes_, {&*first, static_cast<std::size_t>(end - begin)}, cut);
    }
    if (axis >= 0) {
      // Stable, so that the order depends only on the mesh.
      const auto parted = std::stable_partition(
          first, last, [&](std::int32_t t) { return boxes_[at(t)].center()[axis] < cut; });
      if (parted != first && parted != last) middle = parted;
    } else {
      const Box box = boxOf(begin, end);
      (box.high - box.low).maxCoeff(&axis);
      std::sort(first, last, [&](std::int32_t l, std::int32_t r) {
        const double cl = boxes_[at(l)].center()[axis], cr = boxes_[at(r)].center()[axis];
        return cl != cr ? cl < cr : l < r;
      });
    }
    return static_cast<std::int32_t>(middle - order_.begin());
  }

  Box boxOf(std::int32_t begin, std::int32_t end) const {
    Box box;
    for (std::int32_t slot = begin; slot < end; ++slot) {
      const std::int32_t t = order_[at(slot)];
      box.add(boxes_[at(t)].low, boxes_[at(t)].high, 1);
    }
    return box;
  }

  // The next node: its sphere and core. Collects the vertices of its triangles, each once.
  MeshTreePlan::Node bound(std::int32_t begin, std::int32_t end) {
    collected_.clear();
    const auto stamp = static_cast<std::int32_t>(nodes_.size());
    for (std::int32_t slot = begin; slot < end; ++slot) {
      for (const std::int32_t v : triangles_[at(order_[at(slot)])]) {
        if (stamp_[at(v)] == stamp) continue;
        stamp_[at(v)] = stamp;
        collected_.push_back(v);
      }
    }
    const Box box = boxOf(begin, end);
    const Vector3d center = 0.5 * box.low + 0.5 * box.high;
    double squared = 0;
    for (const std::int32_t v : collected_) {
      squared = std::max(squared, (vertices_[at(v)] - center).squaredNorm());
    }
    const double size = std::max(box.low.cwiseAbs().maxCoeff(), box.high.cwiseAbs().maxCoeff());
    MeshTreePlan::Node node;
    node.radius = std::sqrt(squared) * (1 + kRelativeRounding) + size * kRelativeRounding;
    const std::size_t before = core_.size();
    node.excess = addCore(size);
    node.core_count = static_cast<std::int32_t>(core_.size() - before);
    return node;
  }

  // Appends the core of the collected vertices and returns its excess. `size`: their largest
  // coordinate.
  double addCore(double size) {
    if (collected_.size() <= static_cast<std::size_t>(MeshTree::kCoreVertices)) {
      // Uses all points instead of their hull's corners. Most nodes are this small: finding the
      // corners would dominate the build, and support functions are equally fast over all points
      // (measured).
      core_.insert(core_.end(), collected_.begin(), collected_.end());
      return 0;
    }
    points_.clear();
    for (const std::int32_t v : collected_) points_.push_back(vertices_[at(v)]);
    const HullBuilder hull(points_, MeshTree::kCoreVertices);
    std::vector<std::int32_t> kept = hull.vertices();
    double excess = largestDistanceFromHull(points_, hull);
    if (kept.size() > static_cast<std::size_t>(MeshTree::kCoreVertices)) {
      // A flat part, to which the builder's limit does not apply. Every n-th point of the outline
      // is kept. The points between two kept ones are no farther from the hull than from the edge
      // between those two.
      const std::vector<std::int32_t>& outline = hull.outline();
      const std::size_t step =
          (outline.size() + MeshTree::kCoreVertices - 1) / MeshTree::kCoreVertices;
      kept.clear();
      for (std::size_t i = 0; i < outline.size(); ++i) {
        const std::size_t from = i / step * step,
                          to = from + step < outline.size() ? from + step : 0;
        if (i == from) kept.push_back(outline[i]);
        excess =
            std::max(excess, segmentDistance(points_[at(outline[i])], points_[at(outline[from])],
                                             points_[at(outline[to])]));
      }
      if (excess > 0) excess = excess * (1 + kRelativeRounding) + size * kRelativeRounding;
    }
    for (const std::int32_t i : kept) core_.push_back(collected_[at(i)]);
    return excess;
  }

  std::span<const Vector3d> vertices_;
  std::span<const Triangle> triangles_;
  const TriangleBoxes& boxes_;
  std::span<std::int32_t> order_;
  std::vector<std::int32_t> stamp_;      // per vertex: the node that has collected it
  std::vector<std::int32_t> collected_;  // vertices of the current node
  std::vector<Vector3d> points_;         // their coordinates
  std::vector<MeshTreePlan::Node> nodes_;
  std::vector<std::int32_t> core_;
};

}  // namespace

MeshTreePlan planTree(std::span<const Vector3d> vertices, std::span<const Triangle> triangles) {
  const TriangleBoxes boxes = boxesOf(vertices, triangles);
  MeshTreePlan plan;
  plan.order.resize(triangles.size());
  std::iota(plan.order.begin(), plan.order.end(), 0);
  Planner planner(vertices, triangles, boxes, plan.order);
  planner.reserve(triangles.size());
  planner.build(0, static_cast<std::int32_t>(triangles.size()), 0);
  plan.nodes = planner.takeNodes();
  plan.core = planner.takeCore();
  return plan;
}

}  // namespace leeway::collision
