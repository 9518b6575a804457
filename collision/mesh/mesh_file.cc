#include "collision/mesh/mesh_file.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/base/parallel.h"
#include "collision/mesh/topology/cycles.h"
#include "collision/shapes/hull_file.h"
#include "collision/shapes/size_limits.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using Triangle = TriangleMesh::Triangle;

bool areCorners(const std::vector<Triangle>& triangles, std::size_t vertices) {
  return std::all_of(triangles.begin(), triangles.end(), [&](const Triangle& t) {
    return std::all_of(t.begin(), t.end(), [&](std::int32_t v) {
      return v >= 0 && static_cast<std::size_t>(v) < vertices;
    });
  });
}

// Whether each component has a triangle, and each triangle one of the components.
bool areComponents(const std::vector<std::int32_t>& of_triangle, std::size_t count) {
  std::vector<std::uint8_t> met(count, 0);
  for (const std::int32_t c : of_triangle) {
    if (c < 0 || static_cast<std::size_t>(c) >= count) return false;
    met[static_cast<std::size_t>(c)] = 1;
  }
  return std::find(met.begin(), met.end(), 0) == met.end();
}

bool areFlags(const std::vector<std::uint8_t>& flags) {
  return std::all_of(flags.begin(), flags.end(), [](std::uint8_t f) { return f <= 1; });
}

bool areWeights(const std::vector<std::uint64_t>& weights, std::size_t triangles) {
  return (weights.empty() || weights.size() == triangles) &&
         std::all_of(weights.begin(), weights.end(),
                     [](std::uint64_t w) { return w < kCyclePrime; });
}

// As TriangleMesh::make() requires.
bool areSizes(const std::vector<Vector3d>& vertices) {
  try {
    requireSizes(vertices, "mesh", "vertex");
    return true;
  } catch (const InvalidShape&) {
    return false;
  }
}

bool isSize(double size) { return size >= 0 && std::isfinite(size); }

// A column of a BoxNode. (Nodes are a third empty, and they are the largest part of a file.)
struct BoxColumn {
  float center[3], axis[3][3], half[3], radius;
  std::int32_t child;
};

void packBoxes(std::span<const BoxNode> nodes, ByteWriter& to) {
  std::vector<std::uint8_t> counts;
  std::vector<BoxColumn> columns;
  counts.reserve(nodes.size());
  columns.reserve(5 * nodes.size());
  for (const BoxNode& node : nodes) {
    counts.push_back(static_cast<std::uint8_t>(node.count));
    for (std::int32_t i = 0; i < node.count; ++i) {
      BoxColumn& column = columns.emplace_back();
      for (int k = 0; k < 3; ++k) {
        column.center[k] = node.center[k][i];
        column.half[k] = node.half[k][i];
        for (int j = 0; j < 3; ++j) column.axis[k][j] = node.axis[k][j][i];
      }
      column.radius = node.radius[i];
      column.child = node.child[i];
    }
  }
  to.array(counts);
  to.array(columns);
}

// Null if counts and columns do not match, or are not a tree of the mesh.
std::unique_ptr<const BoxTree> boxesOf(std::span<const std::uint8_t> counts,
                                       std::span<const BoxColumn> columns, std::size_t triangles,
                                       int pieces) {
  // A branching tree has at most this many.
  if (counts.size() > triangles + static_cast<std::size_t>(pieces) + 1) return nullptr;
  std::pmr::vector<BoxNode> nodes(largeArrays());
  nodes.reserve(counts.size());
  std::size_t next = 0;
  for (const std::uint8_t count : counts) {
    if (count > BoxNode::kWidth || count > columns.size() - next) return nullptr;
    BoxNode& node = nodes.emplace_back();
    node.count = count;
    for (std::int32_t i = 0; i < count; ++i) {
      const BoxColumn& column = columns[next++];
      for (int k = 0; k < 3; ++k) {
        node.center[k][i] = column.center[k];
        node.half[k][i] = column.half[k];
        for (int j = 0; j < 3; ++j) node.axis[k][j][i] = column.axis[k][j];
      }
      node.radius[i] = column.radius;
      node.child[i] = column.child;
    }
  }
  if (next != columns.size()) return nullptr;
  return BoxTree::fromNodes(std::move(nodes), triangles, pieces);
}

struct PackedPiece {
  std::shared_ptr<const ConvexHull> hull;
  double excess;
};

// False if the hulls are invalid.
bool unpackPieces(ByteReader& from, int count, std::vector<PackedPiece>& pieces) {
  for (int i = 0; i < count; ++i) {
    std::shared_ptr<const ConvexHull> hull = unpackHull(from);
    const auto excess = from.value<double>();
    if (hull == nullptr || !isSize(excess)) return false;
    pieces.push_back({std::move(hull), excess});
  }
  return true;
}

}  // namespace

void MeshFile::pack(const BuiltMesh& built, ByteWriter& to) {
  const TriangleMesh& mesh = *built.mesh;
  const MeshTree& tree = *mesh.tree_;
  const MeshTreePlan& plan = built.plan;
  to.reserve(mesh.vertices_.size() * sizeof(Vector3d) +
             mesh.triangles_.size() * (sizeof(Triangle) + 2 * sizeof(std::int32_t)) +
             plan.nodes.size() * sizeof(MeshTreePlan::Node) +
             plan.core.size() * sizeof(std::int32_t) +
             5 * sizeof(BoxColumn) * tree.boxes().nodes().size());
  to.array(mesh.vertices_);
  to.array(mesh.triangles_);
  to.array(mesh.triangle_component_);
  to.array(mesh.component_closed_);
  to.array(mesh.winding_weight_);
  to.value(static_cast<std::uint64_t>(mesh.open_edges_));
  to.array(plan.order);
  to.array(plan.nodes);
  to.array(plan.core);
  packHull(tree.hull(), to);
  to.value(mesh.hull_excess_);
  to.value(static_cast<std::int32_t>(mesh.pieces_.use));
  to.value(mesh.pieces_.pieces);
  to.value(mesh.pieces_.loose_triangles);
  to.value(mesh.pieces_.excess);
  for (int i = 0; i < tree.pieceCount(); ++i) {
    packHull(tree.pieceHull(i), to);
    to.value(tree.pieceExcess(i));
  }
  packBoxes(tree.boxes().nodes(), to);
}

std::shared_ptr<TriangleMesh> MeshFile::unpack(ByteReader& from) {
  std::shared_ptr<TriangleMesh> mesh(new TriangleMesh);
  mesh->vertices_ = from.array<Vector3d>();
  mesh->triangles_ = from.array<Triangle>();
  mesh->triangle_component_ = from.array<std::int32_t>();
  mesh->component_closed_ = from.array<std::uint8_t>();
  mesh->winding_weight_ = from.array<std::uint64_t>();
  mesh->open_edges_ = static_cast<std::size_t>(from.value<std::uint64_t>());
  MeshTreePlanView plan;
  plan.order = from.view<std::int32_t>();
  plan.nodes = from.view<MeshTreePlan::Node>();
  plan.core = from.view<std::int32_t>();
  const std::size_t count = mesh->triangles_.size();
  if (from.failed() || count == 0 || !areSizes(mesh->vertices_) ||
      !areCorners(mesh->triangles_, mesh->vertices_.size()) ||
      mesh->triangle_component_.size() != count || !areFlags(mesh->component_closed_) ||
      !areComponents(mesh->triangle_component_, mesh->component_closed_.size()) ||
      !areWeights(mesh->winding_weight_, count) || !isPlan(plan, mesh->vertices_.size(), count))
    return nullptr;
  std::shared_ptr<const ConvexHull> hull = unpackHull(from);
  mesh->hull_excess_ = from.value<double>();
  const auto use = from.value<std::int32_t>();
  mesh->pieces_.pieces = from.value<int>();
  mesh->pieces_.loose_triangles = from.value<int>();
  mesh->pieces_.excess = from.value<double>();
  if (hull == nullptr || !isSize(mesh->hull_excess_) || !isSize(mesh->pieces_.excess) || use < 0 ||
      use > static_cast<std::int32_t>(PieceSummary::Use::kNotAsked) || mesh->pieces_.pieces < 0 ||
      static_cast<std::size_t>(mesh->pieces_.pieces) > count)
    return nullptr;
  mesh->pieces_.use = static_cast<PieceSummary::Use>(use);
  std::vector<PackedPiece> pieces;
  if (!unpackPieces(from, mesh->pieces_.pieces, pieces)) return nullptr;
  const std::span<const std::uint8_t> counts = from.view<std::uint8_t>();
  const std::span<const BoxColumn> columns = from.view<BoxColumn>();
  if (from.failed()) return nullptr;
  std::unique_ptr<MeshTree> tree;
  std::unique_ptr<const BoxTree> boxes;
  inParallel(
      count >= kWorthAThread,
      [&] {
        tree = std::make_unique<MeshTree>(mesh->vertices_, mesh->triangles_,
                                          mesh->triangle_component_, plan, std::move(hull));
      },
      [&] { boxes = boxesOf(counts, columns, count, mesh->pieces_.pieces); });
  try {
    for (PackedPiece& piece : pieces) tree->addPiece(std::move(piece.hull), piece.excess);
  } catch (const InvalidShape&) {
    return nullptr;
  }
  if (!tree->takeBoxes(std::move(boxes))) return nullptr;
  mesh->tree_ = std::move(tree);
  return mesh;
}

void MeshFile::setCover(const TriangleMesh& mesh, std::shared_ptr<const BallCover> cover) {
  std::call_once(mesh.cover_once_, [&] { mesh.cover_ = std::move(cover); });
}

}  // namespace leeway::collision
