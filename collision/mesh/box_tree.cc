#include "collision/mesh/box_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/mesh/obb_fit.h"

namespace leeway::collision {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// From this depth on nodes are split by count, so that kMaxDepth holds for any mesh of 2^31
// triangles: each of the eight children has at most a quarter of the triangles.
constexpr int kFreeDepth = BoxTree::kMaxDepth - 17;
// Above convex pieces, so that the triangles below them get as many levels.
constexpr int kFreePieceDepth = kFreeDepth - 17;

std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

}  // namespace

// Triangles order[begin, end) and a box around them.
struct BoxTree::Cluster {
  std::int32_t begin = 0, end = 0;
  FittedBox box;
};

struct BoxTree::Input {
  std::span<const Vector3d> vertices;
  std::span<const Triangle> triangles;
  std::span<const std::int32_t> slot_of;
  double extent = 0;
  std::vector<Vector3d> centroid;  // of the triangle, or of its unit's triangles
  std::vector<std::int32_t> order;
  // Per triangle: its unit, which is not split and stands together in `order`. Above the convex
  // pieces each of them is one unit.
  std::vector<std::int32_t> unit;
  ObbFit obb;

  std::int32_t unitAt(std::int32_t at) const { return unit[index(order[index(at)])]; }
  bool isOneUnit(const Cluster& cluster) const {
    return unitAt(cluster.begin) == unitAt(cluster.end - 1);
  }
  std::int32_t unitsIn(const Cluster& cluster) const {
    std::int32_t count = 1;
    for (std::int32_t at = cluster.begin + 1; at < cluster.end; ++at) {
      count += unitAt(at) != unitAt(at - 1) ? 1 : 0;
    }
    return count;
  }
  Vector3d middleOf(std::int32_t t) const {
    const Triangle& c = triangles[index(t)];
    return (vertices[index(c[0])] + vertices[index(c[1])] + vertices[index(c[2])]) / 3;
  }

  // Corner k of the triangle at a place in `order`.
  const Vector3d& corner(std::int32_t at, std::size_t k) const {
    return vertices[index(triangles[index(order[index(at)])][k])];
  }

  void fit(Cluster& cluster) {
    obb.start(index(cluster.end - cluster.begin));
    for (std::int32_t at = cluster.begin; at < cluster.end; ++at) {
      for (std::size_t k = 0; k < 3; ++k) obb.add(corner(at, k));
    }
    cluster.box = obb.fit();
  }

  // Splits a cluster across its longest axis, at the mean of the centroids.
  void split(const Cluster& cluster, bool by_count, Cluster& left, Cluster& right) {
    int axis = 0;
    cluster.box.half.maxCoeff(&axis);
    const Vector3d along = cluster.box.axes.col(axis);
    const auto first = order.begin() + cluster.begin, last = order.begin() + cluster.end;
    auto middle = first;
    if (!by_count) {
      double mean = 0;
      for (auto at = first; at != last; ++at) mean += along.dot(centroid[index(*at)]);
      mean /= static_cast<double>(cluster.end - cluster.begin);
      // Stable, so that the order depends on the mesh alone.
      middle = std::stable_partition(
          first, last, [&](std::int32_t t) { return along.dot(centroid[index(t)]) < mean; });
    }
    if (middle == first || middle == last) {
      std::sort(first, last, [&](std::int32_t l, std::int32_t r) {
        const double cl = along.dot(centroid[index(l)]), cr = along.dot(centroid[index(r)]);
        if (cl != cr) return cl < cr;
        return std::pair(unit[index(l)], l) < std::pair(unit[index(r)], r);
      });
      middle = first;
      for (std::int32_t left_units = unitsIn(cluster) / 2; left_units > 0; --left_units) {
        const std::int32_t one = unit[index(*middle)];
        while (unit[index(*middle)] == one) ++middle;
      }
    }
    left.begin = cluster.begin;
    left.end = right.begin = static_cast<std::int32_t>(middle - order.begin());
    right.end = cluster.end;
    fit(left);
    fit(right);
  }
};

BoxTree::BoxTree(std::span<const Vector3d> vertices, std::span<const Triangle> triangles,
                 std::span<const std::int32_t> slot_of, double extent,
                 std::span<const std::int32_t> piece_of, int pieces)
    : piece_node_(static_cast<std::size_t>(pieces), -1),
      first_piece_(static_cast<std::int32_t>(triangles.size())) {
  if (!(extent > 0)) return;  // of one point
  Input input{vertices, triangles, slot_of, extent, {}, {}, {}, {}};
  input.centroid.reserve(triangles.size());
  input.unit.reserve(triangles.size());
  std::vector<Vector3d> sum(index(pieces), Vector3d::Zero());
  std::vector<double> count(index(pieces), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    input.centroid.push_back(input.middleOf(static_cast<std::int32_t>(t)));
    input.unit.push_back(piece_of[t] >= 0 ? piece_of[t]
                                          : static_cast<std::int32_t>(index(pieces) + t));
    if (piece_of[t] < 0) continue;
    sum[index(piece_of[t])] += input.centroid[t];
    ++count[index(piece_of[t])];
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (piece_of[t] >= 0) input.centroid[t] = sum[index(piece_of[t])] / count[index(piece_of[t])];
  }
  input.order.resize(triangles.size());
  std::iota(input.order.begin(), input.order.end(), 0);
  std::stable_sort(input.order.begin(), input.order.end(), [&](std::int32_t l, std::int32_t r) {
    return input.unit[index(l)] < input.unit[index(r)];
  });
  nodes_.reserve(2 + triangles.size() / 6);
  nodes_.emplace_back();
  Cluster whole;
  whole.end = static_cast<std::int32_t>(triangles.size());
  input.fit(whole);
  setLane(0, 0, whole, input);
  const std::int32_t child = childFor(input, whole, 0, false);
  nodes_[0].child[0] = child;
  nodes_[0].count = 1;
  nodes_.shrink_to_fit();
}

// The `child` of the cluster's box: a leaf, or a node that is built.
std::int32_t BoxTree::childFor(Input& input, const Cluster& cluster, int depth, bool in_piece) {
  if (cluster.end - cluster.begin == 1)
    return ~input.slot_of[index(input.order[index(cluster.begin)])];
  if (in_piece || !input.isOneUnit(cluster)) return build(input, cluster, depth, in_piece);
  const std::int32_t number = input.unitAt(cluster.begin);
  // Below it each triangle is a unit.
  for (std::int32_t at = cluster.begin; at < cluster.end; ++at) {
    const std::int32_t t = input.order[index(at)];
    input.unit[index(t)] = static_cast<std::int32_t>(piece_node_.size()) + t;
    input.centroid[index(t)] = input.middleOf(t);
  }
  const std::int32_t node = build(input, cluster, depth, true);
  piece_node_[index(number)] = node;
  return ~(first_piece_ + number);
}

std::int32_t BoxTree::build(Input& input, const Cluster& whole, int depth, bool in_piece) {
  const auto id = static_cast<std::int32_t>(nodes_.size());
  nodes_.emplace_back();
  const bool by_count = depth >= (in_piece || piece_node_.empty() ? kFreeDepth : kFreePieceDepth);
  std::vector<Cluster> clusters{whole};
  while (clusters.size() < BoxNode::kWidth) {
    std::size_t largest = clusters.size();
    double most = -1;
    for (std::size_t i = 0; i < clusters.size(); ++i) {
      const double size =
          by_count ? static_cast<double>(input.unitsIn(clusters[i])) : clusters[i].box.halfArea();
      if (input.isOneUnit(clusters[i]) || !(size > most)) continue;
      most = size;
      largest = i;
    }
    if (largest == clusters.size()) break;
    Cluster left, right;
    input.split(clusters[largest], by_count, left, right);
    clusters[largest] = left;
    clusters.insert(clusters.begin() + static_cast<std::ptrdiff_t>(largest) + 1, right);
  }
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    setLane(id, static_cast<int>(i), clusters[i], input);
    const std::int32_t child = childFor(input, clusters[i], depth + 1, in_piece);
    nodes_[index(id)].child[i] = child;
  }
  nodes_[index(id)].count = static_cast<std::int32_t>(clusters.size());
  return id;
}

// The box in single precision: along the rounded axes, around the rounded centre, and as large as
// every corner needs.
void BoxTree::setLane(std::int32_t id, int lane, const Cluster& cluster, const Input& input) {
  BoxNode& node = nodes_[index(id)];
  Vector3d center, half = Vector3d::Zero();
  Matrix3d axes;
  for (int k = 0; k < 3; ++k) {
    node.center[k][lane] = static_cast<float>(cluster.box.center[k]);
    center[k] = static_cast<double>(node.center[k][lane]);
    for (int i = 0; i < 3; ++i) {
      node.axis[k][i][lane] = static_cast<float>(cluster.box.axes(i, k));
      axes(i, k) = static_cast<double>(node.axis[k][i][lane]);
    }
  }
  for (std::int32_t at = cluster.begin; at < cluster.end; ++at) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d p = axes.transpose() * (input.corner(at, k) - center);
      half = half.cwiseMax(p.cwiseAbs());
    }
  }
  double squared = 0;
  for (int k = 0; k < 3; ++k) {
    node.half[k][lane] = floatAbove(half[k] + kRelativeRounding * input.extent);
    squared += half[k] * half[k];
  }
  node.radius[lane] = static_cast<float>(std::sqrt(squared));
}

OrientedBox BoxNode::box(int lane) const {
  OrientedBox box;
  for (int k = 0; k < 3; ++k) {
    box.center[k] = center[k][lane];
    box.half[k] = half[k][lane];
    for (int i = 0; i < 3; ++i) box.axis[k][i] = axis[k][i][lane];
  }
  return box;
}

}  // namespace leeway::collision
