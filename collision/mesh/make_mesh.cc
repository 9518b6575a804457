#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "collision/base/large_pages.h"
#include "collision/base/numbers.h"
#include "collision/base/parallel.h"
#include "collision/base/tolerances.h"
#include "collision/mesh/convex_pieces.h"
#include "collision/mesh/hull_excess.h"
#include "collision/mesh/mesh_file.h"
#include "collision/mesh/mesh_tree.h"
#include "collision/mesh/topology/components.h"
#include "collision/mesh/topology/cracks.h"
#include "collision/shapes/bounding_sphere.h"
#include "collision/shapes/hull_of_part.h"
#include "collision/shapes/size_limits.h"
#include "leeway/collision/shape.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using Triangle = TriangleMesh::Triangle;

void requireUsable(std::span<const Vector3d> vertices, std::span<const Triangle> triangles) {
  if (triangles.empty()) throw InvalidShape("mesh: no triangles; at least 1 is needed");
  requireSizes(vertices, "mesh", "vertex");
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (const std::int32_t v : triangles[i]) {
      if (v >= 0 && at(v) < vertices.size()) continue;
      throw InvalidShape("mesh: triangle " + std::to_string(i) + " names vertex " +
                         std::to_string(v) + "; 0 to " + std::to_string(vertices.size()) +
                         " - 1 are there");
    }
  }
}

// For each vertex, the first one with equal coordinates, where 0 and -0 are equal. Uses a hash
// table with open addressing, at most half full. The result does not depend on the table's order.
std::vector<std::int32_t> firstEqual(std::span<const Vector3d> given) {
  std::vector<std::int32_t> first(given.size());
  std::pmr::vector<std::int32_t> table(std::bit_ceil(2 * given.size() + 1), -1, largeArrays());
  const std::size_t mask = table.size() - 1;
  for (std::size_t i = 0; i < given.size(); ++i) {
    std::uint64_t hash = 0;
    for (int k = 0; k < 3; ++k) {
      // -0 + 0 is 0. An odd factor keeps all bits; the shift mixes high bits into low ones.
      hash = (hash ^ std::bit_cast<std::uint64_t>(given[i][k] + 0.0)) * 0x9e3779b97f4a7c15U;
      hash ^= hash >> 32;
    }
    std::size_t place = static_cast<std::size_t>(hash * 0xd6e8feb86659fd93U >> 20) & mask;
    while (table[place] >= 0 && given[at(table[place])] != given[i]) place = (place + 1) & mask;
    if (table[place] < 0) table[place] = static_cast<std::int32_t>(i);
    first[i] = table[place];
  }
  return first;
}

// Merges equal vertices, in the order of their first use, and drops unused ones.
void weld(std::span<const Vector3d> given, std::span<const Triangle> given_triangles,
          std::vector<Vector3d>& vertices, std::vector<Triangle>& triangles) {
  const std::vector<std::int32_t> first = firstEqual(given);
  std::vector<std::int32_t> number(given.size(), -1);
  triangles.reserve(given_triangles.size());
  for (const Triangle& t : given_triangles) {
    Triangle welded{};
    for (std::size_t k = 0; k < 3; ++k) {
      std::int32_t& n = number[at(first[at(t[k])])];
      if (n < 0) {
        n = static_cast<std::int32_t>(vertices.size());
        vertices.push_back(given[at(first[at(t[k])])]);
      }
      welded[k] = n;
    }
    triangles.push_back(welded);
  }
}

std::string shortText(double length) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, length, std::chars_format::general, 3);
  return {text, end.ptr};
}

// Throws InvalidShape for a weld that is not small against the facets of an open part: it would
// join corners of one facet, and could fold the surface onto itself instead of closing it. Parts of
// fewer facets than a solid has are looked at together.
void requireSmallWeld(std::span<const Vector3d> vertices, std::span<const Triangle> triangles,
                      const MeshComponents& components, double weld) {
  struct Facet {
    std::int32_t part;
    double height, area;  // the least height
  };
  std::vector<std::int32_t> size(components.closed.size(), 0);
  for (const std::int32_t c : components.component) ++size[at(c)];
  std::vector<Facet> facets;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const std::int32_t part = components.component[i];
    if (components.closed[at(part)] != 0) continue;
    const Vector3d &a = vertices[at(triangles[i][0])], &b = vertices[at(triangles[i][1])],
                   &c = vertices[at(triangles[i][2])];
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const double area = 0.5 * (b - a).cross(c - a).norm();
    if (longest > 0) facets.push_back({size[at(part)] < 4 ? -1 : part, 2 * area / longest, area});
  }
  std::sort(facets.begin(), facets.end(), [](const Facet& a, const Facet& b) {
    return a.part != b.part ? a.part < b.part : a.height < b.height;
  });
  for (std::size_t begin = 0, end = 0; begin < facets.size(); begin = end) {
    double all = 0, lower = 0;  // area of the part; of its lowest facets
    for (end = begin; end < facets.size() && facets[end].part == facets[begin].part; ++end)
      all += facets[end].area;
    for (std::size_t i = begin; i < end; ++i) {
      lower += facets[i].area;
      if (!(lower > kWeldedShare * all)) continue;
      const double most = facets[i].height / kWeldHeights;
      if (weld <= most) break;
      throw InvalidShape("mesh: weld is " + shortText(weld) +
                         " m, which is not small against the facets; at most " +
                         shortText(0.99 * most) + " m is expected");
    }
  }
}

// Adds the triangles that close cracks, and finds the components afterwards. Triangles of one round
// may end at vertices that lie on other edges, which further rounds handle.
MeshComponents closeCracks(std::span<const Vector3d> vertices, std::vector<Triangle>& triangles,
                           double weld) {
  constexpr int kRounds = 8;
  const std::size_t given = triangles.size();
  addOverlapFillers(vertices, triangles);  // before any triangles are joined to patches
  MeshComponents components = findComponents(vertices, triangles);
  if (weld > 0 && components.open_edges > 0) {
    requireSmallWeld(vertices, triangles, components, weld);
    components = findComponents(vertices, triangles, weld);
  }
  std::set<Triangle> added;
  for (int round = 0; round < kRounds && components.open_edges > 0; ++round) {
    const std::size_t before = triangles.size();
    for (const Triangle& filler : crackFillers(vertices, components.seams, weld)) {
      Triangle corners = filler;
      std::sort(corners.begin(), corners.end());
      if (added.insert(corners).second) triangles.push_back(filler);
    }
    if (triangles.size() == before) break;
    components = findComponents(vertices, triangles, weld);
  }
  // Removes those that close nothing.
  std::size_t kept = given;
  for (std::size_t i = given; i < triangles.size(); ++i) {
    if (components.closes(i)) triangles[kept++] = triangles[i];
  }
  if (kept == triangles.size()) return components;
  triangles.resize(kept);
  return findComponents(vertices, triangles, weld);
}

}  // namespace

std::shared_ptr<const TriangleMesh> TriangleMesh::make(std::span<const Vector3d> vertices,
                                                       std::span<const Triangle> triangles,
                                                       const MeshOptions& options) {
  return MeshFile::build(vertices, triangles, options).mesh;
}

BuiltMesh MeshFile::build(std::span<const Vector3d> vertices, std::span<const Triangle> triangles,
                          const MeshOptions& options, const Meanwhile& meanwhile,
                          const Checkpoint& checkpoint) {
  const auto pause = [&] {
    if (checkpoint) checkpoint();
  };
  requireUsable(vertices, triangles);
  if (!(options.weld >= 0 && options.weld <= kLargestSize))
    throw InvalidShape("mesh: weld is " + std::to_string(options.weld) +
                       "; 0 or a distance in metres is needed");
  std::shared_ptr<TriangleMesh> mesh(new TriangleMesh);
  // Coordinates too small for the exact predicates become 0, because 1e-70 m is far below the
  // rounding of any query.
  std::pmr::vector<Vector3d> clean(vertices.begin(), vertices.end(), largeArrays());
  for (Vector3d& v : clean) {
    for (int k = 0; k < 3; ++k) {
      if (std::abs(v[k]) < kSmallestExact) v[k] = 0;
    }
  }
  weld(clean, triangles, mesh->vertices_, mesh->triangles_);
  MeshComponents components;
  if (options.solid) {
    components = closeCracks(mesh->vertices_, mesh->triangles_, options.weld);
  } else {
    components = findComponents(mesh->vertices_, mesh->triangles_);
    components.leaveOpen();
  }
  mesh->triangle_component_ = std::move(components.component);
  mesh->component_closed_ = std::move(components.closed);
  mesh->winding_weight_ = std::move(components.weight);
  mesh->open_edges_ = components.open_edges;
  const bool is_large = mesh->triangles_.size() >= kWorthAThread;
  pause();
  MeshTreePlan plan;
  std::shared_ptr<const ConvexHull> hull;
  inParallel(
      is_large, [&] { plan = planTree(mesh->vertices_, mesh->triangles_); },
      [&] { hull = hullOfPart(mesh->vertices_); });
  pause();
  auto tree = std::make_unique<MeshTree>(mesh->vertices_, mesh->triangles_,
                                         mesh->triangle_component_, plan, std::move(hull));
  MeshTree& made = *tree;
  mesh->tree_ = std::move(tree);
  inParallel(
      is_large,
      [&] {
        pause();
        ConvexPieces pieces;
        pieces.summary.use = PieceSummary::Use::kNotAsked;
        if (options.decompose) pieces = convexPieces(*mesh);
        mesh->pieces_ = pieces.summary;
        pause();
        made.makeBoxes(mesh->vertices_, mesh->triangles_, pieces.pieces);
      },
      [&] {
        mesh->hull_excess_ = hullExcess(mesh->vertices_, made);
        pause();
        if (meanwhile) meanwhile(mesh);
      });
  return {std::move(mesh), std::move(plan)};
}

TriangleMesh::~TriangleMesh() = default;

int TriangleMesh::closedComponentCount() const {
  return static_cast<int>(std::count(component_closed_.begin(), component_closed_.end(), 1));
}

std::size_t TriangleMesh::bytes() const {
  return sizeof(*this) + vertices_.size() * sizeof(Vector3d) +
         triangles_.size() * sizeof(Triangle) + triangle_component_.size() * sizeof(std::int32_t) +
         component_closed_.size() + winding_weight_.size() * sizeof(std::uint64_t) + tree_->bytes();
}

// Defined here because shapes/ does not depend on meshes.
Shape Shape::mesh(std::shared_ptr<const TriangleMesh> mesh) {
  if (!mesh || mesh->vertices().empty()) {
    throw InvalidShape("mesh: it has no triangles; at least one is needed");
  }
  const BoundingSphere sphere = sphereAround(mesh->vertices());
  Shape shape;
  shape.type_ = ShapeType::kMesh;
  shape.bounding_center_ = sphere.center;
  shape.setReach(sphere.radius, sphere.extent);
  shape.mesh_ = std::move(mesh);
  return shape;
}

}  // namespace leeway::collision
