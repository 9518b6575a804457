#include "collision/mesh/mesh_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/parallel.h"
#include "collision/base/tolerances.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

// Visits the nodes of a plan in preorder: visit(node, begin, end, parent) with its slots, and with
// its parent if it is a right child, otherwise -1. Stops and returns false if the plan is not a
// binary tree over the slots of limited depth.
template <class Visit>
bool walk(const MeshTreePlanView& plan, const Visit& visit) {
  struct Right {
    std::int32_t parent, begin, end;
    int depth;
  };
  std::array<Right, MeshTree::kMaxDepth> waiting;  // at most one for each level above the node
  std::size_t size = 0;
  Right here{-1, 0, static_cast<std::int32_t>(plan.order.size()), 0};
  for (std::size_t id = 0; id < plan.nodes.size(); ++id) {
    visit(id, here.begin, here.end, here.parent);
    const std::int32_t split = plan.nodes[id].split;
    if (split >= 0) {
      if (split <= here.begin || split >= here.end || here.depth >= MeshTree::kMaxDepth)
        return false;
      waiting[size++] = {static_cast<std::int32_t>(id), split, here.end, here.depth + 1};
      here = {-1, here.begin, split, here.depth + 1};
      continue;
    }
    if (here.end - here.begin > MeshTree::kLeafTriangles) return false;
    if (size == 0) return id + 1 == plan.nodes.size();
    here = waiting[--size];
  }
  return false;
}

}  // namespace

bool isPlan(const MeshTreePlanView& plan, std::size_t vertices, std::size_t triangles) {
  if (plan.order.size() != triangles || triangles == 0) return false;
  std::vector<std::uint8_t> met(triangles, 0);
  for (const std::int32_t t : plan.order) {
    if (t < 0 || at(t) >= triangles || met[at(t)] != 0) return false;
    met[at(t)] = 1;
  }
  std::size_t core = 0;
  for (const MeshTreePlan::Node& node : plan.nodes) {
    if (node.core_count < 1 || node.core_count > MeshTree::kCoreVertices) return false;
    if (!(node.radius >= 0) || !std::isfinite(node.radius)) return false;
    if (!(node.excess >= 0) || !std::isfinite(node.excess)) return false;
    core += at(node.core_count);
  }
  if (core != plan.core.size()) return false;
  for (const std::int32_t v : plan.core) {
    if (v < 0 || at(v) >= vertices) return false;
  }
  return walk(plan, [](std::size_t, std::int32_t, std::int32_t, std::int32_t) {});
}

MeshTree::MeshTree(std::span<const Vector3d> vertices, std::span<const Triangle> triangles,
                   std::span<const std::int32_t> triangle_component, const MeshTreePlanView& plan,
                   std::shared_ptr<const ConvexHull> hull)
    : triangle_of_(plan.order.begin(), plan.order.end()), hull_(std::move(hull)) {
  std::vector<double> extents;
  inParallel(
      triangles.size() >= kWorthAThread,
      [&] {
        placeTriangles(vertices, triangles, triangle_component);
        makeNodes(plan, triangle_component);
      },
      [&] { extents = fillCores(plan, vertices); });
  for (std::size_t id = 0; id < nodes_.size(); ++id) nodes_[id].extent = extents[id];
}

void MeshTree::placeTriangles(std::span<const Vector3d> vertices,
                              std::span<const Triangle> triangles,
                              std::span<const std::int32_t> triangle_component) {
  const std::size_t count = triangles.size();
  slot_of_.resize(count);
  corners_.reserve(3 * count);
  double squared = 0;
  for (std::size_t slot = 0; slot < count; ++slot) {
    slot_of_[at(triangle_of_[slot])] = static_cast<std::int32_t>(slot);
    for (const std::int32_t v : triangles[at(triangle_of_[slot])]) {
      corners_.push_back(vertices[at(v)]);
      squared = std::max(squared, corners_.back().squaredNorm());
    }
  }
  extent_ = std::sqrt(squared) * (1 + kRelativeRounding);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t c = at(triangle_component[i]);
    if (c >= components_.size()) {
      components_.resize(
          c + 1, {Vector3d::Constant(std::numeric_limits<double>::infinity()),
                  Vector3d::Constant(-std::numeric_limits<double>::infinity()), Vector3d::Zero()});
    }
    for (const std::int32_t v : triangles[i]) {
      components_[c].low = components_[c].low.cwiseMin(vertices[at(v)]);
      components_[c].high = components_[c].high.cwiseMax(vertices[at(v)]);
    }
    components_[c].point = vertices[at(triangles[i][0])];
  }
}

void MeshTree::makeNodes(const MeshTreePlanView& plan,
                         std::span<const std::int32_t> triangle_component) {
  nodes_.reserve(plan.nodes.size());
  std::int32_t core = 0;
  walk(plan, [&](std::size_t id, std::int32_t begin, std::int32_t end, std::int32_t parent) {
    const MeshTreePlan::Node& planned = plan.nodes[id];
    MeshNode& node = nodes_.emplace_back();
    node.radius = planned.radius;
    node.excess = planned.excess;
    node.core_begin = core;
    node.core_count = planned.core_count;
    core += planned.core_count;
    node.right = -1;
    node.triangle_begin = begin;
    node.triangle_end = end;
    if (parent >= 0) nodes_[at(parent)].right = static_cast<std::int32_t>(id);
  });
  // Children before parents.
  for (std::size_t id = nodes_.size(); id-- > 0;) {
    MeshNode& node = nodes_[id];
    if (node.isLeaf()) {
      const Vector3d* const first = corners(node.triangle_begin);
      node.low = node.high = first[0];
      node.component = triangle_component[at(triangleOf(node.triangle_begin))];
      for (std::int32_t slot = node.triangle_begin; slot < node.triangle_end; ++slot) {
        for (int k = 0; k < 3; ++k) {
          node.low = node.low.cwiseMin(corners(slot)[k]);
          node.high = node.high.cwiseMax(corners(slot)[k]);
        }
        if (triangle_component[at(triangleOf(slot))] != node.component) node.component = -1;
      }
    } else {
      const MeshNode &left = nodes_[id + 1], &right = nodes_[at(node.right)];
      node.low = left.low.cwiseMin(right.low);
      node.high = left.high.cwiseMax(right.high);
      node.component = left.component == right.component ? left.component : -1;
    }
    node.center = 0.5 * node.low + 0.5 * node.high;
  }
}

// Returns each node's extent.
std::vector<double> MeshTree::fillCores(const MeshTreePlanView& plan,
                                        std::span<const Vector3d> vertices) {
  std::vector<double> extents;
  extents.reserve(plan.nodes.size());
  core_.reserve(plan.core.size());
  for (const MeshTreePlan::Node& node : plan.nodes) {
    double squared = 0;
    for (std::int32_t i = 0; i < node.core_count; ++i) {
      core_.push_back(vertices[at(plan.core[core_.size()])]);
      squared = std::max(squared, core_.back().squaredNorm());
    }
    extents.push_back(std::sqrt(squared) * (1 + kRelativeRounding));
  }
  return extents;
}

void MeshTree::makeBoxes(std::span<const Vector3d> vertices, std::span<const Triangle> triangles,
                         std::span<const ConvexPiece> pieces) {
  std::vector<std::int32_t> piece_of(triangles.size(), -1);
  for (std::size_t number = 0; number < pieces.size(); ++number) {
    for (const std::int32_t t : pieces[number].triangles)
      piece_of[at(t)] = static_cast<std::int32_t>(number);
    addPiece(pieces[number].hull, pieces[number].excess);
  }
  boxes_ = std::make_unique<const BoxTree>(vertices, middle(), triangles, slot_of_, extent_,
                                           piece_of, pieceCount());
}

bool MeshTree::takeBoxes(std::unique_ptr<const BoxTree> boxes) {
  boxes_ = std::move(boxes);
  // (BoxTree makes no nodes for a single point.)
  return boxes_ != nullptr && boxes_->usable() == (extent_ > 0);
}

void MeshTree::addPiece(std::shared_ptr<const ConvexHull> hull, double excess) {
  const ConvexView view = viewOf(Shape::convexHull(hull));
  pieces_.push_back({std::move(hull), view, excess});
}

std::size_t MeshTree::bytes() const {
  std::size_t pieces = pieces_.size() * sizeof(Piece);
  for (const Piece& piece : pieces_) {
    pieces += piece.hull->vertices().size_bytes() + piece.hull->facets().size_bytes();
  }
  return pieces + sizeof(*this) + nodes_.size() * sizeof(MeshNode) +
         (core_.size() + corners_.size()) * sizeof(Vector3d) +
         (triangle_of_.size() + slot_of_.size()) * sizeof(std::int32_t) +
         components_.size() * sizeof(Component) + boxes_->bytes() +
         hull_->vertices().size() * sizeof(Vector3d) + hull_->facets().size() * sizeof(Triangle);
}

}  // namespace leeway::collision
