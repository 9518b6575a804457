#include "leeway/collision/triangle_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "collision/exact.h"
#include "collision/hull_excess.h"
#include "collision/mesh_tree.h"
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

// A use of an edge by a triangle, in the direction low -> high or the reverse.
struct EdgeUse {
  std::int32_t low, high, triangle;
  bool forward;
};

bool collapsed(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

std::vector<EdgeUse> sortedEdges(const std::vector<Triangle>& triangles) {
  std::vector<EdgeUse> edges;
  edges.reserve(3 * triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    // A triangle with a repeated corner uses an edge in both directions: its neighbours match
    // without it.
    if (collapsed(triangles[i])) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t from = triangles[i][k], to = triangles[i][(k + 1) % 3];
      edges.push_back(
          {std::min(from, to), std::max(from, to), static_cast<std::int32_t>(i), from < to});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const EdgeUse& a, const EdgeUse& b) {
    if (a.low != b.low) return a.low < b.low;
    if (a.high != b.high) return a.high < b.high;
    return a.triangle < b.triangle;
  });
  return edges;
}

class Components {
 public:
  Components(const std::vector<Vector3d>& vertices, std::vector<Triangle>& triangles)
      : vertices_(vertices), triangles_(triangles), parent_(triangles.size()) {
    std::iota(parent_.begin(), parent_.end(), 0);
    const std::vector<EdgeUse> edges = sortedEdges(triangles);
    connect(edges);
    number();
    orient();
    joinCollapsed();
  }

  std::vector<std::int32_t> component;  // per triangle
  std::vector<std::uint8_t> closed;     // per component

 private:
  struct Link {
    std::int32_t triangle;
    bool same_direction;  // both triangles use the edge in the same direction: one of them must be
                          // turned
  };

  std::int32_t root(std::int32_t t) {
    while (parent_[index(t)] != t) t = parent_[index(t)] = parent_[index(parent_[index(t)])];
    return t;
  }

  void unite(std::int32_t a, std::int32_t b) {
    a = root(a);
    b = root(b);
    if (a != b) parent_[index(std::max(a, b))] = std::min(a, b);
  }

  void connect(const std::vector<EdgeUse>& edges) {
    links_.resize(triangles_.size());
    broken_.assign(triangles_.size(), 0);
    for (std::size_t i = 0; i < edges.size();) {
      std::size_t end = i + 1;
      while (end < edges.size() && edges[end].low == edges[i].low &&
             edges[end].high == edges[i].high)
        ++end;
      for (std::size_t k = i; k < end; ++k) {
        unite(edges[i].triangle, edges[k].triangle);
        if (end - i != 2) broken_[index(edges[k].triangle)] = 1;
      }
      if (end - i == 2) {
        const bool same = edges[i].forward == edges[i + 1].forward;
        links_[index(edges[i].triangle)].push_back({edges[i + 1].triangle, same});
        links_[index(edges[i + 1].triangle)].push_back({edges[i].triangle, same});
      }
      i = end;
    }
  }

  void number() {
    component.assign(triangles_.size(), -1);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const std::int32_t r = root(static_cast<std::int32_t>(i));
      if (index(r) == i) {
        component[i] = static_cast<std::int32_t>(closed.size());
        closed.push_back(collapsed(triangles_[i]) ? 0 : 1);
      }
      component[i] = component[index(r)];  // a root is the lowest triangle of its component
      if (broken_[i] != 0) closed[index(component[i])] = 0;
    }
  }

  // Flood fill: turns triangles so that neighbours agree; a component where they cannot is not a
  // solid.
  void orient() {
    std::vector<signed char> turned(triangles_.size(), -1);
    std::vector<std::int32_t> queue;
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const std::int32_t c = component[i];
      if (closed[index(c)] == 0 || turned[i] >= 0) continue;
      turned[i] = 0;
      queue.assign(1, static_cast<std::int32_t>(i));
      bool consistent = true;
      for (std::size_t k = 0; k < queue.size(); ++k) {
        for (const Link& link : links_[index(queue[k])]) {
          const auto wanted =
              static_cast<signed char>(turned[index(queue[k])] ^ (link.same_direction ? 1 : 0));
          signed char& other = turned[index(link.triangle)];
          if (other >= 0) {
            consistent = consistent && other == wanted;
            continue;
          }
          other = wanted;
          queue.push_back(link.triangle);
        }
      }
      if (!consistent) {
        closed[index(c)] = 0;
        continue;
      }
      turn(queue, turned);
    }
  }

  void turn(const std::vector<std::int32_t>& triangles, const std::vector<signed char>& turned) {
    for (const std::int32_t t : triangles) {
      if (turned[index(t)] == 1) std::swap(triangles_[index(t)][1], triangles_[index(t)][2]);
    }
    const Vector3d origin = vertices_[index(triangles_[index(triangles[0])][0])];
    double volume = 0;  // its sign only: what is inside does not depend on it
    for (const std::int32_t t : triangles) {
      const Triangle& v = triangles_[index(t)];
      volume += (vertices_[index(v[0])] - origin)
                    .dot((vertices_[index(v[1])] - origin).cross(vertices_[index(v[2])] - origin));
    }
    if (volume >= 0) return;
    for (const std::int32_t t : triangles)
      std::swap(triangles_[index(t)][1], triangles_[index(t)][2]);
  }

  // A triangle with a repeated corner belongs to a component that has this corner, if there is one.
  void joinCollapsed() {
    std::vector<std::int32_t> of_vertex(vertices_.size(), -1);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (collapsed(triangles_[i])) continue;
      for (const std::int32_t v : triangles_[i]) {
        if (of_vertex[index(v)] < 0) of_vertex[index(v)] = component[i];
      }
    }
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (!collapsed(triangles_[i])) continue;
      for (const std::int32_t v : triangles_[i]) {
        if (of_vertex[index(v)] >= 0) component[i] = of_vertex[index(v)];
      }
    }
    // Number the components that are left anew.
    std::vector<std::int32_t> renumbered(closed.size(), -1);
    std::vector<std::uint8_t> kept;
    for (std::int32_t& c : component) {
      if (renumbered[index(c)] < 0) {
        renumbered[index(c)] = static_cast<std::int32_t>(kept.size());
        kept.push_back(closed[index(c)]);
      }
      c = renumbered[index(c)];
    }
    closed = std::move(kept);
  }

  const std::vector<Vector3d>& vertices_;
  std::vector<Triangle>& triangles_;
  std::vector<std::int32_t> parent_;
  std::vector<std::vector<Link>> links_;
  std::vector<std::uint8_t> broken_;
};

}  // namespace

std::shared_ptr<const TriangleMesh> TriangleMesh::make(std::span<const Vector3d> vertices,
                                                       std::span<const Triangle> triangles) {
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
  Components components(mesh->vertices_, mesh->triangles_);
  mesh->triangle_component_ = std::move(components.component);
  mesh->component_closed_ = std::move(components.closed);
  mesh->tree_ = std::make_unique<const MeshTree>(mesh->vertices_, mesh->triangles_,
                                                 mesh->triangle_component_);
  mesh->hull_excess_ = collision::hullExcess(mesh->vertices_, *mesh->tree_);
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
