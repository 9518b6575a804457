#include "collision/mesh/mesh_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"
#include "collision/mesh/convex_pieces.h"
#include "collision/shapes/hull_builder.h"
#include "collision/shapes/hull_distance.h"
#include "collision/shapes/hull_of_part.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

// Queries test a leaf's triangles one by one.
constexpr std::int32_t kLeafTriangles = 2;
// A support function over this many points costs about as much as the rest of a GJK step.
constexpr int kCoreVertices = 32;
constexpr int kBins = 16;
// From this depth on nodes are halved, so that kMaxDepth holds for any mesh of 2^31 triangles.
constexpr int kFreeDepth = MeshTree::kMaxDepth - 34;

std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

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

}  // namespace

struct MeshTree::Input {
  std::span<const Vector3d> vertices;
  std::span<const Triangle> triangles;
  std::span<const std::int32_t> component;
  std::vector<Vector3d> low, high, center;  // boxes of triangles
  std::vector<std::int32_t> order;          // triangles, permuted as the tree grows
  std::vector<std::int32_t> stamp;          // per vertex: the node that has collected it
  std::vector<std::int32_t> collected;      // vertices of the node in hand
};

MeshTree::MeshTree(std::span<const Vector3d> vertices, std::span<const Triangle> triangles,
                   std::span<const std::int32_t> triangle_component) {
  Input input{vertices, triangles, triangle_component, {}, {}, {}, {}, {}, {}};
  const std::size_t count = triangles.size();
  input.stamp.assign(vertices.size(), -1);
  for (auto* part : {&input.low, &input.high, &input.center}) part->reserve(count);
  input.order.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d &a = vertices[index(triangles[i][0])], &b = vertices[index(triangles[i][1])],
                   &c = vertices[index(triangles[i][2])];
    input.low.push_back(a.cwiseMin(b).cwiseMin(c));
    input.high.push_back(a.cwiseMax(b).cwiseMax(c));
    input.center.push_back(0.5 * input.low.back() + 0.5 * input.high.back());
    input.order.push_back(static_cast<std::int32_t>(i));
  }
  nodes_.reserve(count);
  build(input, 0, static_cast<std::int32_t>(count), 0);
  triangle_of_ = input.order;
  slot_of_.assign(count, -1);
  corners_.reserve(3 * count);
  for (std::size_t slot = 0; slot < count; ++slot) {
    slot_of_[index(triangle_of_[slot])] = static_cast<std::int32_t>(slot);
    for (const std::int32_t v : triangles[index(triangle_of_[slot])]) {
      corners_.push_back(vertices[index(v)]);
      extent_ = std::max(extent_, corners_.back().norm());
    }
  }
  extent_ *= 1 + kRelativeRounding;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t c = index(triangle_component[i]);
    if (c >= components_.size()) {
      components_.resize(
          c + 1, {Vector3d::Constant(std::numeric_limits<double>::infinity()),
                  Vector3d::Constant(-std::numeric_limits<double>::infinity()), Vector3d::Zero()});
    }
    components_[c].low = components_[c].low.cwiseMin(input.low[i]);
    components_[c].high = components_[c].high.cwiseMax(input.high[i]);
    components_[c].point = vertices[index(triangles[i][0])];
  }
  hull_ = hullOfPart(vertices);
  nodes_.shrink_to_fit();
  core_.shrink_to_fit();
}

void MeshTree::makeBoxes(std::span<const Vector3d> vertices, std::span<const Triangle> triangles,
                         std::span<const ConvexPiece> pieces) {
  std::vector<std::int32_t> piece_of(triangles.size(), -1);
  for (const ConvexPiece& piece : pieces) {
    const auto number = static_cast<std::int32_t>(pieces_.size());
    for (const std::int32_t t : piece.triangles) piece_of[index(t)] = number;
    pieces_.push_back({piece.hull, viewOf(Shape::convexHull(piece.hull)), piece.excess});
  }
  boxes_ = std::make_unique<const BoxTree>(vertices, triangles, slot_of_, extent_, piece_of,
                                           pieceCount());
}

namespace {

// The surface area heuristic with bins: the cut between two bins with the least sum of area times
// count on both sides, over three axes. Returns the axis, or -1 when all centres coincide.
int chooseCut(const std::vector<Vector3d>& low, const std::vector<Vector3d>& high,
              const std::vector<Vector3d>& center, std::span<const std::int32_t> order,
              double& cut) {
  Vector3d from = center[index(order[0])], to = from;
  for (const std::int32_t t : order) {
    from = from.cwiseMin(center[index(t)]);
    to = to.cwiseMax(center[index(t)]);
  }
  int best_axis = -1;
  double best = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double width = to[axis] - from[axis];
    if (!(width > 0)) continue;
    std::array<Box, kBins> bins;
    for (const std::int32_t t : order) {
      const double f = (center[index(t)][axis] - from[axis]) / width * kBins;
      bins[static_cast<std::size_t>(std::clamp(static_cast<int>(f), 0, kBins - 1))].add(
          low[index(t)], high[index(t)], 1);
    }
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
      cut = from[axis] + width * static_cast<double>(i) / kBins;
    }
  }
  return best_axis;
}

}  // namespace

std::int32_t MeshTree::build(Input& input, std::int32_t begin, std::int32_t end, int depth) {
  const auto id = static_cast<std::int32_t>(nodes_.size());
  nodes_.emplace_back();
  MeshNode node;
  node.right = -1;
  node.triangle_begin = begin;
  node.triangle_end = end;
  bound(input, node);
  nodes_[index(id)] = node;
  if (end - begin <= kLeafTriangles) return id;

  const auto first = input.order.begin() + begin, last = input.order.begin() + end;
  auto middle = first + (end - begin) / 2;
  double cut = 0;
  int axis = -1;
  if (depth < kFreeDepth) {
    axis = chooseCut(input.low, input.high, input.center,
                     {&*first, static_cast<std::size_t>(end - begin)}, cut);
  }
  if (axis >= 0) {
    // Stable, so that the order depends on the mesh alone.
    const auto parted = std::stable_partition(
        first, last, [&](std::int32_t t) { return input.center[index(t)][axis] < cut; });
    if (parted != first && parted != last) middle = parted;
  } else {
    Vector3d size = node.high - node.low;
    size.maxCoeff(&axis);
    std::sort(first, last, [&](std::int32_t l, std::int32_t r) {
      const double cl = input.center[index(l)][axis], cr = input.center[index(r)][axis];
      return cl != cr ? cl < cr : l < r;
    });
  }
  const auto split = static_cast<std::int32_t>(middle - input.order.begin());
  build(input, begin, split, depth + 1);
  const std::int32_t right = build(input, split, end, depth + 1);
  nodes_[index(id)].right = right;
  return id;
}

void MeshTree::bound(Input& input, MeshNode& node) {
  Box box;
  input.collected.clear();
  const auto stamp = static_cast<std::int32_t>(nodes_.size());
  node.component = input.component[index(input.order[index(node.triangle_begin)])];
  for (std::int32_t slot = node.triangle_begin; slot < node.triangle_end; ++slot) {
    const std::int32_t t = input.order[index(slot)];
    box.add(input.low[index(t)], input.high[index(t)], 1);
    if (input.component[index(t)] != node.component) node.component = -1;
    for (const std::int32_t v : input.triangles[index(t)]) {
      if (input.stamp[index(v)] == stamp) continue;
      input.stamp[index(v)] = stamp;
      input.collected.push_back(v);
    }
  }
  node.low = box.low;
  node.high = box.high;
  node.center = 0.5 * box.low + 0.5 * box.high;
  node.radius = 0;
  for (const std::int32_t v : input.collected) {
    node.radius = std::max(node.radius, (input.vertices[index(v)] - node.center).norm());
  }
  const double size = std::max(node.low.cwiseAbs().maxCoeff(), node.high.cwiseAbs().maxCoeff());
  node.radius = node.radius * (1 + kRelativeRounding) + size * kRelativeRounding;
  makeCore(input, node);
}

void MeshTree::makeCore(Input& input, MeshNode& node) {
  std::vector<Vector3d> points;
  points.reserve(input.collected.size());
  for (const std::int32_t v : input.collected) points.push_back(input.vertices[index(v)]);
  node.core_begin = static_cast<std::int32_t>(core_.size());
  node.excess = 0;
  if (points.size() <= static_cast<std::size_t>(kCoreVertices)) {
    // All points instead of their hull's corners. Most nodes are so small: finding the corners
    // would dominate the build, and support functions are as fast over all points (measured).
    core_.insert(core_.end(), points.begin(), points.end());
  } else {
    const HullBuilder hull(points, kCoreVertices);
    std::vector<std::int32_t> kept = hull.vertices();
    node.excess = largestDistanceFromHull(points, hull);
    if (kept.size() > static_cast<std::size_t>(kCoreVertices)) {
      // A flat part, to which the builder's limit does not apply. Every n-th point of the outline
      // is kept; those between two of them are no farther from the hull than from the edge between
      // the two.
      const std::vector<std::int32_t>& outline = hull.outline();
      const std::size_t step = (outline.size() + kCoreVertices - 1) / kCoreVertices;
      kept.clear();
      for (std::size_t i = 0; i < outline.size(); ++i) {
        const std::size_t from = i / step * step,
                          to = from + step < outline.size() ? from + step : 0;
        if (i == from) kept.push_back(outline[i]);
        node.excess = std::max(
            node.excess, segmentDistance(points[index(outline[i])], points[index(outline[from])],
                                         points[index(outline[to])]));
      }
      if (node.excess > 0) {
        const double size =
            std::max(node.low.cwiseAbs().maxCoeff(), node.high.cwiseAbs().maxCoeff());
        node.excess = node.excess * (1 + kRelativeRounding) + size * kRelativeRounding;
      }
    }
    for (const std::int32_t i : kept) core_.push_back(points[index(i)]);
  }
  node.core_count = static_cast<std::int32_t>(core_.size()) - node.core_begin;
  double extent = 0;
  for (std::int32_t i = 0; i < node.core_count; ++i) {
    extent = std::max(extent, core_[index(node.core_begin + i)].norm());
  }
  node.extent = extent * (1 + kRelativeRounding);
}

std::size_t MeshTree::bytes() const {
  std::size_t pieces = pieces_.capacity() * sizeof(Piece);
  for (const Piece& piece : pieces_) {
    pieces += piece.hull->vertices().size_bytes() + piece.hull->facets().size_bytes();
  }
  return pieces + sizeof(*this) + nodes_.capacity() * sizeof(MeshNode) +
         (core_.capacity() + corners_.capacity()) * sizeof(Vector3d) +
         (triangle_of_.capacity() + slot_of_.capacity()) * sizeof(std::int32_t) +
         components_.capacity() * sizeof(Component) + boxes_->bytes() +
         hull_->vertices().size() * sizeof(Vector3d) + hull_->facets().size() * sizeof(Triangle);
}

}  // namespace leeway::collision
