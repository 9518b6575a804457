#include "leeway/collision/triangle_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "collision/components.h"
#include "collision/convex_pieces.h"
#include "collision/hull_excess.h"
#include "collision/mesh_tree.h"
#include "leeway/collision/ball_cover.h"
#include "leeway/collision/shape.h"
#include "leeway/collision/tolerances.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using Triangle = TriangleMesh::Triangle;

std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

void requireUsable(std::span<const Vector3d> vertices, std::span<const Triangle> triangles) {
  if (triangles.empty()) throw InvalidShape("mesh: no triangles; at least 1 is needed");
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      if (std::abs(vertices[i][k]) <= kLargestCoordinate) continue;
      throw InvalidShape("mesh: vertex " + std::to_string(i) + " has the coordinate " +
                         std::to_string(vertices[i][k]) +
                         "; finite numbers up to 1e60 are accepted");
    }
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (const std::int32_t v : triangles[i]) {
      if (v >= 0 && index(v) < vertices.size()) continue;
      throw InvalidShape("mesh: triangle " + std::to_string(i) + " names vertex " +
                         std::to_string(v) + "; 0 to " + std::to_string(vertices.size()) +
                         " - 1 are there");
    }
  }
}

// Vertices that are equal become one, in the order of their first use; unused ones go.
void weld(std::span<const Vector3d> given, std::span<const Triangle> given_triangles,
          std::vector<Vector3d>& vertices, std::vector<Triangle>& triangles) {
  std::vector<std::int32_t> order(given.size());
  std::iota(order.begin(), order.end(), 0);
  const auto before = [&](std::int32_t l, std::int32_t r) {
    const Vector3d &a = given[index(l)], &b = given[index(r)];
    for (int k = 0; k < 3; ++k) {
      if (a[k] != b[k]) return a[k] < b[k];
    }
    return l < r;
  };
  std::sort(order.begin(), order.end(), before);
  std::vector<std::int32_t> first(given.size());  // the first vertex with the same coordinates
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && given[index(order[i])] == given[index(order[i - 1])];
    first[index(order[i])] = same ? first[index(order[i - 1])] : order[i];
  }
  std::vector<std::int32_t> number(given.size(), -1);
  triangles.reserve(given_triangles.size());
  for (const Triangle& t : given_triangles) {
    Triangle welded{};
    for (std::size_t k = 0; k < 3; ++k) {
      std::int32_t& n = number[index(first[index(t[k])])];
      if (n < 0) {
        n = static_cast<std::int32_t>(vertices.size());
        vertices.push_back(given[index(first[index(t[k])])]);
      }
      welded[k] = n;
    }
    triangles.push_back(welded);
  }
}

}  // namespace

std::shared_ptr<const TriangleMesh> TriangleMesh::make(std::span<const Vector3d> vertices,
                                                       std::span<const Triangle> triangles,
                                                       bool decompose) {
  requireUsable(vertices, triangles);
  std::shared_ptr<TriangleMesh> mesh(new TriangleMesh);
  // Coordinates below what the exact predicates take become 0: 1e-70 m is far below any rounding of
  // a query.
  std::vector<Vector3d> clean(vertices.begin(), vertices.end());
  for (Vector3d& v : clean) {
    for (int k = 0; k < 3; ++k) {
      if (std::abs(v[k]) < kSmallestExact) v[k] = 0;
    }
  }
  weld(clean, triangles, mesh->vertices_, mesh->triangles_);
  MeshComponents components = findComponents(mesh->vertices_, mesh->triangles_);
  mesh->triangle_component_ = std::move(components.component);
  mesh->component_closed_ = std::move(components.closed);
  auto tree =
      std::make_unique<MeshTree>(mesh->vertices_, mesh->triangles_, mesh->triangle_component_);
  MeshTree& made = *tree;
  mesh->tree_ = std::move(tree);
  mesh->hull_excess_ = collision::hullExcess(mesh->vertices_, made);
  ConvexPieces pieces;
  pieces.summary.use = PieceSummary::Use::kNotAsked;
  if (decompose) pieces = convexPieces(*mesh);
  mesh->pieces_ = pieces.summary;
  made.makeBoxes(mesh->vertices_, mesh->triangles_, pieces.pieces);
  return mesh;
}

TriangleMesh::~TriangleMesh() = default;

int TriangleMesh::closedComponentCount() const {
  return static_cast<int>(std::count(component_closed_.begin(), component_closed_.end(), 1));
}

std::size_t TriangleMesh::bytes() const {
  return sizeof(*this) + vertices_.capacity() * sizeof(Vector3d) +
         triangles_.capacity() * sizeof(Triangle) +
         triangle_component_.capacity() * sizeof(std::int32_t) + component_closed_.capacity() +
         tree_->bytes();
}

}  // namespace leeway::collision
