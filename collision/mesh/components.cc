#include "collision/mesh/components.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "collision/base/numbers.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using Triangle = std::array<std::int32_t, 3>;

bool collapsed(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

class Components {
 public:
  Components(std::span<const Vector3d> vertices, std::vector<Triangle>& triangles)
      : vertices_(vertices), triangles_(triangles), parent_(triangles.size()) {
    std::iota(parent_.begin(), parent_.end(), 0);
    const std::vector<EdgeUse> edges = sortedEdges(triangles, vertices.size());
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
    bool same_direction;  // of both triangles along the edge: one of them must be flipped
  };
  // Across the edges that a triangle shares with exactly one other.
  struct Links {
    std::array<Link, 3> link;
    std::size_t count = 0;
    void add(const Link& l) { link[count++] = l; }
    std::span<const Link> all() const { return {link.data(), count}; }
  };

  std::int32_t root(std::int32_t t) {
    while (parent_[at(t)] != t) t = parent_[at(t)] = parent_[at(parent_[at(t)])];
    return t;
  }

  void unite(std::int32_t a, std::int32_t b) {
    a = root(a);
    b = root(b);
    if (a != b) parent_[at(std::max(a, b))] = std::min(a, b);
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
        if (end - i != 2) broken_[at(edges[k].triangle)] = 1;
      }
      if (end - i == 2) {
        const bool same = edges[i].forward == edges[i + 1].forward;
        links_[at(edges[i].triangle)].add({edges[i + 1].triangle, same});
        links_[at(edges[i + 1].triangle)].add({edges[i].triangle, same});
      }
      i = end;
    }
  }

  void number() {
    component.assign(triangles_.size(), -1);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const std::int32_t r = root(static_cast<std::int32_t>(i));
      if (at(r) == i) {
        component[i] = static_cast<std::int32_t>(closed.size());
        closed.push_back(collapsed(triangles_[i]) ? 0 : 1);
      }
      component[i] = component[at(r)];  // the root, its lowest triangle, has its number already
      if (broken_[i] != 0) closed[at(component[i])] = 0;
    }
  }

  // Flood fill: flips triangles so that neighbours agree; a component where they cannot is no
  // solid.
  void orient() {
    std::vector<signed char> turned(triangles_.size(), -1);
    std::vector<std::int32_t> queue;
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const std::int32_t c = component[i];
      if (closed[at(c)] == 0 || turned[i] >= 0) continue;
      turned[i] = 0;
      queue.assign(1, static_cast<std::int32_t>(i));
      bool consistent = true;
      for (std::size_t k = 0; k < queue.size(); ++k) {
        for (const Link& link : links_[at(queue[k])].all()) {
          const auto wanted =
              static_cast<signed char>(turned[at(queue[k])] ^ (link.same_direction ? 1 : 0));
          signed char& other = turned[at(link.triangle)];
          if (other >= 0) {
            consistent = consistent && other == wanted;
            continue;
          }
          other = wanted;
          queue.push_back(link.triangle);
        }
      }
      if (!consistent) {
        closed[at(c)] = 0;
        continue;
      }
      turn(queue, turned);
    }
  }

  void turn(const std::vector<std::int32_t>& triangles, const std::vector<signed char>& turned) {
    for (const std::int32_t t : triangles) {
      if (turned[at(t)] == 1) std::swap(triangles_[at(t)][1], triangles_[at(t)][2]);
    }
    const Vector3d origin = vertices_[at(triangles_[at(triangles[0])][0])];
    double volume = 0;  // only its sign is used, and what is inside does not depend on that
    for (const std::int32_t t : triangles) {
      const Triangle& v = triangles_[at(t)];
      volume += (vertices_[at(v[0])] - origin)
                    .dot((vertices_[at(v[1])] - origin).cross(vertices_[at(v[2])] - origin));
    }
    if (volume >= 0) return;
    for (const std::int32_t t : triangles) std::swap(triangles_[at(t)][1], triangles_[at(t)][2]);
  }

  // A triangle with a repeated corner joins a component that has one of its corners, if any.
  void joinCollapsed() {
    std::vector<std::int32_t> of_vertex(vertices_.size(), -1);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (collapsed(triangles_[i])) continue;
      for (const std::int32_t v : triangles_[i]) {
        if (of_vertex[at(v)] < 0) of_vertex[at(v)] = component[i];
      }
    }
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (!collapsed(triangles_[i])) continue;
      for (const std::int32_t v : triangles_[i]) {
        if (of_vertex[at(v)] >= 0) component[i] = of_vertex[at(v)];
      }
    }
    // Renumber the components that are left.
    std::vector<std::int32_t> renumbered(closed.size(), -1);
    std::vector<std::uint8_t> kept;
    for (std::int32_t& c : component) {
      if (renumbered[at(c)] < 0) {
        renumbered[at(c)] = static_cast<std::int32_t>(kept.size());
        kept.push_back(closed[at(c)]);
      }
      c = renumbered[at(c)];
    }
    closed = std::move(kept);
  }

  std::span<const Vector3d> vertices_;
  std::vector<Triangle>& triangles_;
  std::vector<std::int32_t> parent_;
  std::vector<Links> links_;
  std::vector<std::uint8_t> broken_;
};

}  // namespace

std::vector<EdgeUse> sortedEdges(std::span<const Triangle> triangles, std::size_t vertices) {
  std::vector<std::int32_t> begin(vertices + 1, 0);
  const auto forEachEdge = [&](const auto& visit) {
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const Triangle& t = triangles[i];
      if (collapsed(t)) continue;
      for (std::size_t k = 0; k < 3; ++k) visit(i, k, t[k], t[(k + 1) % 3]);
    }
  };
  forEachEdge([&](std::size_t, std::size_t, std::int32_t from, std::int32_t to) {
    ++begin[at(std::min(from, to)) + 1];
  });
  for (std::size_t v = 0; v < vertices; ++v) begin[v + 1] += begin[v];
  std::vector<EdgeUse> edges(at(begin.back()));
  std::vector<std::int32_t> next(begin.begin(), begin.end() - 1);
  forEachEdge([&](std::size_t i, std::size_t k, std::int32_t from, std::int32_t to) {
    const std::int32_t low = std::min(from, to);
    edges[at(next[at(low)]++)] = {low, std::max(from, to), static_cast<std::int32_t>(i),
                                  static_cast<std::int32_t>(k), from < to};
  });
  for (std::size_t v = 0; v < vertices; ++v) {
    std::sort(edges.begin() + begin[v], edges.begin() + begin[v + 1],
              [](const EdgeUse& a, const EdgeUse& b) {
                return a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
              });
  }
  return edges;
}

MeshComponents findComponents(std::span<const Vector3d> vertices,
                              std::vector<Triangle>& triangles) {
  Components components(vertices, triangles);
  return {std::move(components.component), std::move(components.closed)};
}

}  // namespace leeway::collision
