#include "collision/mesh/box_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/base/parallel.h"
#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/mesh/obb_fit.h"

namespace leeway::collision {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// From this depth on, nodes are split by count, so that kMaxDepth holds for any mesh of 2^31
// triangles: each of the eight children has at most a quarter of the triangles.
constexpr int kFreeDepth = BoxTree::kMaxDepth - 17;
// The same limit above convex pieces, so that the triangles below them get as many levels.
constexpr int kFreePieceDepth = kFreeDepth - 17;

}  // namespace

// Triangles order[begin, end) and a box around them.
struct BoxTree::Cluster {
  std::int32_t begin = 0, end = 0;
  FittedBox box;
};

struct BoxTree::Input {
  std::pmr::vector<Vector3d> vertices{largeArrays()};  // relative to the origin
  std::span<const Triangle> triangles;
  std::span<const std::int32_t> slot_of;
  double extent = 0;
  std::pmr::vector<Vector3d> centroid{
      largeArrays()};  // of the triangle, or of its unit's triangles
  std::vector<std::int32_t> order;
  // For each triangle its unit, which is not split and is contiguous in `order`. Above the convex
  // pieces, each piece is one unit.
  std::vector<std::int32_t> unit;
  std::int32_t pieces = 0;

  std::int32_t firstPiece() const { return static_cast<std::int32_t>(triangles.size()); }
  std::int32_t unitAt(std::int32_t place) const { return unit[at(order[at(place)])]; }
  bool isOneUnit(const Cluster& cluster) const {
    return unitAt(cluster.begin) == unitAt(cluster.end - 1);
  }
  std::int32_t unitsIn(const Cluster& cluster) const {
    std::int32_t count = 1;
    for (std::int32_t place = cluster.begin + 1; place < cluster.end; ++place) {
      count += unitAt(place) != unitAt(place - 1) ? 1 : 0;
    }
    return count;
  }
  Vector3d middleOf(std::int32_t t) const {
    const Triangle& c = triangles[at(t)];
    return (vertices[at(c[0])] + vertices[at(c[1])] + vertices[at(c[2])]) / 3;
  }

  // Corner k of the triangle at a place in `order`.
  const Vector3d& corner(std::int32_t place, std::size_t k) const {
    return vertices[at(triangles[at(order[at(place)])][k])];
  }
};

// Builds a part of a tree: nodes in preorder, numbered from 0.
struct BoxTree::Builder {
  // Reserves room for the nodes of this many triangles; most nodes have three or four.
  Builder(Input& given, std::size_t triangles) : input(given) { nodes.reserve(2 + triangles / 3); }

  Input& input;
  std::pmr::vector<BoxNode> nodes{largeArrays()};
  std::vector<std::array<std::int32_t, 2>> piece_nodes;  // piece, its node
  ObbFit obb;

  void fit(Cluster& cluster) {
    obb.start(at(cluster.end - cluster.begin));
    for (std::int32_t place = cluster.begin; place < cluster.end; ++place) {
      for (std::size_t k = 0; k < 3; ++k) obb.add(input.corner(place, k));
    }
    cluster.box = obb.fit();
  }

  // Splits a cluster across its longest axis, at the mean of the centroids.
  void split(const Cluster& cluster, bool by_count, Cluster& left, Cluster& right) {
    int axis = 0;
    cluster.box.half.maxCoeff(&axis);
    const Vector3d along = cluster.box.axes.col(axis);
    const auto first = input.order.begin() + cluster.begin,
               last = input.order.begin() + cluster.end;
    auto middle = first;
    if (!by_count) {
      double mean = 0;
      for (auto t = first; t != last; ++t) mean += along.dot(input.centroid[at(*t)]);
      mean /= static_cast<double>(cluster.end - cluster.begin);
      // Stable, so that the order depends only on the mesh.
      middle = std::stable_partition(
          first, last, [&](std::int32_t t) { return along.dot(input.centroid[at(t)]) < mean; });
    }
    if (middle == first || middle == last) {
      std::sort(first, last, [&](std::int32_t l, std::int32_t r) {
        const double cl = along.dot(input.centroid[at(l)]), cr = along.dot(input.centroid[at(r)]);
        if (cl != cr) return cl < cr;
        return std::pair(input.unit[at(l)], l) < std::pair(input.unit[at(r)], r);
      });
      middle = first;
      for (std::int32_t left_units = input.unitsIn(cluster) / 2; left_units > 0; --left_units) {
        const std::int32_t one = input.unit[at(*middle)];
        while (input.unit[at(*middle)] == one) ++middle;
      }
    }
    left.begin = cluster.begin;
    left.end = right.begin = static_cast<std::int32_t>(middle - input.order.begin());
    right.end = cluster.end;
    fit(left);
    fit(right);
  }

  // The `child` of the cluster's box: a leaf, or a node, which is built here.
  std::int32_t childFor(const Cluster& cluster, int depth, bool in_piece) {
    if (cluster.end - cluster.begin == 1) return ~input.slot_of[at(input.order[at(cluster.begin)])];
    if (in_piece || !input.isOneUnit(cluster)) return build(cluster, depth, in_piece);
    const std::int32_t number = input.unitAt(cluster.begin);
    // Below it, each triangle is a unit.
    for (std::int32_t place = cluster.begin; place < cluster.end; ++place) {
      const std::int32_t t = input.order[at(place)];
      input.unit[at(t)] = input.pieces + t;
      input.centroid[at(t)] = input.middleOf(t);
    }
    const std::int32_t node = build(cluster, depth, true);
    piece_nodes.push_back({number, node});
    return ~(input.firstPiece() + number);
  }

  std::int32_t build(const Cluster& whole, int depth, bool in_piece) {
    const auto id = static_cast<std::int32_t>(nodes.size());
    nodes.emplace_back();
    const bool by_count = depth >= (in_piece || input.pieces == 0 ? kFreeDepth : kFreePieceDepth);
    std::vector<Cluster> clusters = parts(whole, by_count);
    for (std::size_t i = 0; i < clusters.size(); ++i) {
      setColumn(nodes[at(id)], static_cast<int>(i), clusters[i], input);
    }
    nodes[at(id)].count = static_cast<std::int32_t>(clusters.size());
    const auto children = [&](Builder& builder, std::size_t from, std::size_t to) {
      std::vector<std::int32_t> result;
      for (std::size_t i = from; i < to; ++i)
        result.push_back(builder.childFor(clusters[i], depth + 1, in_piece));
      return result;
    };
    // Large parts are built in separate threads and then put in their places.
    const auto count = at(whole.end - whole.begin);
    std::size_t middle = clusters.size();
    if (count >= std::max(kWorthAThread, input.triangles.size() / 8)) {
      middle = 0;
      while (at(clusters[middle].begin - whole.begin) < count / 2 && middle + 1 < clusters.size())
        ++middle;
    }
    Builder other(input, middle < clusters.size() ? at(whole.end - clusters[middle].begin) : 0);
    std::vector<std::int32_t> first, second;
    inParallel(
        middle < clusters.size(), [&] { first = children(*this, 0, middle); },
        [&] { second = children(other, middle, clusters.size()); });
    std::copy(first.begin(), first.end(), nodes[at(id)].child);
    std::transform(second.begin(), second.end(), nodes[at(id)].child + middle,
                   [&](std::int32_t child) { return shifted(child); });
    append(other);
    return id;
  }

  // Repeatedly halves the largest part.
  std::vector<Cluster> parts(const Cluster& whole, bool by_count) {
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
      split(clusters[largest], by_count, left, right);
      clusters[largest] = left;
      clusters.insert(clusters.begin() + static_cast<std::ptrdiff_t>(largest) + 1, right);
    }
    return clusters;
  }

  // The number of a part's child after the part is appended to these nodes.
  std::int32_t shifted(std::int32_t child) const {
    return child >= 0 ? child + static_cast<std::int32_t>(nodes.size()) : child;
  }
  void append(const Builder& part) {
    for (const auto& [piece, node] : part.piece_nodes)
      piece_nodes.push_back({piece, shifted(node)});
    const std::size_t before = nodes.size();
    const auto offset = shifted(0);
    nodes.insert(nodes.end(), part.nodes.begin(), part.nodes.end());
    for (std::size_t id = before; id < nodes.size(); ++id) {
      for (std::int32_t column = 0; column < nodes[id].count; ++column) {
        if (nodes[id].child[column] >= 0) nodes[id].child[column] += offset;
      }
    }
  }
};

BoxTree::BoxTree(std::span<const Vector3d> vertices, const Vector3d& origin,
                 std::span<const Triangle> triangles, std::span<const std::int32_t> slot_of,
                 double extent, std::span<const std::int32_t> piece_of, int pieces)
    : piece_node_(static_cast<std::size_t>(pieces), -1),
      first_piece_(static_cast<std::int32_t>(triangles.size())) {
  if (!(extent > 0)) return;  // all points are equal
  Input input;
  input.triangles = triangles;
  input.slot_of = slot_of;
  input.extent = extent;
  input.pieces = pieces;
  // (Their rounding is a unit of the extent, and is in the boxes.)
  input.vertices.reserve(vertices.size());
  for (const Vector3d& vertex : vertices) input.vertices.push_back(vertex - origin);
  input.centroid.reserve(triangles.size());
  input.unit.reserve(triangles.size());
  std::vector<Vector3d> sum(at(pieces), Vector3d::Zero());
  std::vector<double> count(at(pieces), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    input.centroid.push_back(input.middleOf(static_cast<std::int32_t>(t)));
    input.unit.push_back(piece_of[t] >= 0 ? piece_of[t]
                                          : static_cast<std::int32_t>(at(pieces) + t));
    if (piece_of[t] < 0) continue;
    sum[at(piece_of[t])] += input.centroid[t];
    ++count[at(piece_of[t])];
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (piece_of[t] >= 0) input.centroid[t] = sum[at(piece_of[t])] / count[at(piece_of[t])];
  }
  input.order.resize(triangles.size());
  std::iota(input.order.begin(), input.order.end(), 0);
  std::stable_sort(input.order.begin(), input.order.end(), [&](std::int32_t l, std::int32_t r) {
    return input.unit[at(l)] < input.unit[at(r)];
  });
  Builder builder(input, triangles.size());
  builder.nodes.emplace_back();
  Cluster whole;
  whole.end = static_cast<std::int32_t>(triangles.size());
  builder.fit(whole);
  setColumn(builder.nodes[0], 0, whole, input);
  const std::int32_t child = builder.childFor(whole, 0, false);
  builder.nodes[0].child[0] = child;
  builder.nodes[0].count = 1;
  nodes_ = std::move(builder.nodes);
  for (const auto& [piece, node] : builder.piece_nodes) piece_node_[at(piece)] = node;
  setReach();
}

void BoxTree::setReach() {
  double squared = 0;
  for (const BoxNode& node : nodes_) {
    for (std::int32_t column = 0; column < node.count; ++column) {
      double sum = 0;
      for (const auto& center : node.center)
        sum += static_cast<double>(center[column]) * static_cast<double>(center[column]);
      squared = std::max(squared, sum);
    }
  }
  reach_ = std::sqrt(squared) * kOutwards;
}

// The box in single precision: along the rounded axes, around the rounded centre, and large enough
// for every corner.
void BoxTree::setColumn(BoxNode& node, int column, const Cluster& cluster, const Input& input) {
  Vector3d center, half = Vector3d::Zero();
  Matrix3d axes;
  for (int k = 0; k < 3; ++k) {
    node.center[k][column] = static_cast<float>(cluster.box.center[k]);
    center[k] = static_cast<double>(node.center[k][column]);
    for (int i = 0; i < 3; ++i) {
      node.axis[k][i][column] = static_cast<float>(cluster.box.axes(i, k));
      axes(i, k) = static_cast<double>(node.axis[k][i][column]);
    }
  }
  for (std::int32_t place = cluster.begin; place < cluster.end; ++place) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d p = axes.transpose() * (input.corner(place, k) - center);
      half = half.cwiseMax(p.cwiseAbs());
    }
  }
  double squared = 0;
  for (int k = 0; k < 3; ++k) {
    node.half[k][column] = floatAbove(half[k] + kRelativeRounding * input.extent);
    squared += half[k] * half[k];
  }
  node.radius[column] = static_cast<float>(std::sqrt(squared));
}

// Checks the nodes of a file, in preorder.
struct BoxTree::Check {
  BoxTree& tree;
  std::vector<std::uint8_t> met;  // triangles
  std::size_t next = 0;           // the next node

  bool node(int depth, bool in_piece) {
    if (depth > kMaxDepth || next >= tree.nodes_.size()) return false;
    const BoxNode& here = tree.nodes_[next++];
    if (here.count < 1 || here.count > BoxNode::kWidth || !isFinite(here)) return false;
    for (std::int32_t column = 0; column < here.count; ++column) {
      if (!child(here.child[column], depth, in_piece)) return false;
    }
    return true;
  }

  bool child(std::int32_t child, int depth, bool in_piece) {
    if (child >= 0) return at(child) == next && node(depth + 1, in_piece);
    const std::size_t slot = at(~child);
    if (slot < met.size()) {
      if (met[slot] != 0) return false;
      met[slot] = 1;
      return true;
    }
    const std::size_t piece = slot - met.size();
    if (in_piece || piece >= tree.piece_node_.size() || tree.piece_node_[piece] >= 0) return false;
    tree.piece_node_[piece] = static_cast<std::int32_t>(next);
    return node(depth + 1, true);
  }

  static bool isFinite(const BoxNode& node) {
    // A sum of products with 0 is 0, or NaN if a factor is not finite.
    float sum = 0;
    for (int column = 0; column < BoxNode::kWidth; ++column) {
      for (int k = 0; k < 3; ++k) {
        sum += 0 * node.center[k][column] + 0 * node.half[k][column];
        for (int i = 0; i < 3; ++i) sum += 0 * node.axis[k][i][column];
      }
      sum += 0 * node.radius[column];
    }
    return sum == 0;
  }
};

std::unique_ptr<const BoxTree> BoxTree::fromNodes(std::pmr::vector<BoxNode> nodes,
                                                  std::size_t triangles, int pieces) {
  std::unique_ptr<BoxTree> tree(new BoxTree);
  tree->nodes_ = std::move(nodes);
  tree->piece_node_.assign(at(pieces), -1);
  tree->first_piece_ = static_cast<std::int32_t>(triangles);
  if (tree->nodes_.empty()) return tree;
  Check check{*tree, std::vector<std::uint8_t>(triangles, 0)};
  if (tree->nodes_[0].count != 1 || !check.node(0, false) || check.next != tree->nodes_.size())
    return nullptr;
  const auto is = [](auto value) { return [value](auto v) { return v == value; }; };
  if (std::any_of(check.met.begin(), check.met.end(), is(0))) return nullptr;
  const std::vector<std::int32_t>& of_pieces = tree->piece_node_;
  if (std::any_of(of_pieces.begin(), of_pieces.end(), is(-1))) return nullptr;
  tree->setReach();
  return tree;
}

OrientedBox BoxNode::box(int column) const {
  OrientedBox box;
  for (int k = 0; k < 3; ++k) {
    box.center[k] = center[k][column];
    box.half[k] = half[k][column];
    for (int i = 0; i < 3; ++i) box.axis[k][i] = axis[k][i][column];
  }
  return box;
}

}  // namespace leeway::collision
