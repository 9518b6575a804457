#include "collision/mesh/topology/cracks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <vector>

#include "collision/base/exact_predicates.h"
#include "collision/base/numbers.h"
#include "collision/mesh/topology/components.h"
#include "leeway/collision/invalid_shape.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using Triangle = std::array<std::int32_t, 3>;

// Limits on the vertices that are tested: on average for each seam, and in total. About 2 ns each.
constexpr std::int64_t kSeamWork = 4096, kCrackWork = 200'000'000;

// Vertices, sorted along the axis of their largest extent.
class Vertices {
 public:
  Vertices(std::span<const Vector3d> vertices, std::size_t seams)
      : vertices_(vertices),
        work_(std::min(kSeamWork * static_cast<std::int64_t>(seams), kCrackWork)) {
    sorted_.resize(vertices.size());
    std::iota(sorted_.begin(), sorted_.end(), 0);
    Vector3d low = vertices[0], high = low;
    for (const Vector3d& v : vertices) {
      low = low.cwiseMin(v);
      high = high.cwiseMax(v);
    }
    (high - low).maxCoeff(&axis_);
    std::stable_sort(sorted_.begin(), sorted_.end(),
                     [&](std::int32_t a, std::int32_t b) { return key(a) < key(b); });
  }

  // Calls visit(v) for the vertices in the box of two points, grown by `distance`.
  template <class Visit>
  void forEachIn(const Vector3d& a, const Vector3d& b, double distance, const Visit& visit) {
    const Vector3d low = a.cwiseMin(b).array() - distance, high = a.cwiseMax(b).array() + distance;
    auto v = std::lower_bound(sorted_.begin(), sorted_.end(), low[axis_],
                              [&](std::int32_t i, double least) { return key(i) < least; });
    for (; v != sorted_.end() && key(*v) <= high[axis_]; ++v) {
      if (--work_ < 0) return;
      const Vector3d& p = vertices_[at(*v)];
      if ((low.array() <= p.array()).all() && (p.array() <= high.array()).all()) visit(*v);
    }
  }

 private:
  double key(std::int32_t v) const { return vertices_[at(v)][axis_]; }

  std::span<const Vector3d> vertices_;
  std::vector<std::int32_t> sorted_;
  Eigen::Index axis_ = 0;
  std::int64_t work_;
};

// The edges that leave each vertex, sorted by a component of their direction that few of them
// share.
class Rays {
 public:
  Rays(std::span<const Vector3d> vertices, std::span<const Triangle> triangles)
      : vertices_(vertices), begin_(vertices.size() + 1, 0) {
    std::vector<std::pair<std::int32_t, std::int32_t>> edges;
    for (const EdgeUse& e : sortedEdges(triangles, vertices.size()))
      if (edges.empty() || edges.back() != std::pair(e.low, e.high))
        edges.emplace_back(e.low, e.high);
    for (const auto& [a, b] : edges) {
      ++begin_[at(a) + 1];
      ++begin_[at(b) + 1];
    }
    for (std::size_t v = 0; v < vertices.size(); ++v) begin_[v + 1] += begin_[v];
    rays_.resize(at(begin_.back()));
    std::vector<std::int32_t> next(begin_.begin(), begin_.end() - 1);
    for (const auto& [a, b] : edges) {
      rays_[at(next[at(a)]++)] = {keyOf(a, b), b};
      rays_[at(next[at(b)]++)] = {keyOf(b, a), a};
    }
    for (std::size_t v = 0; v < vertices.size(); ++v)
      std::sort(rays_.begin() + begin_[v], rays_.begin() + begin_[v + 1],
                [](const Ray& l, const Ray& r) {
                  return l.key != r.key ? l.key < r.key : l.end < r.end;
                });
  }

  // Calls visit(ends) for the edges of a vertex that have one direction, shortest first, if there
  // are several.
  template <class Visit>
  void forEachLine(std::int32_t v, const Visit& visit) {
    const std::int32_t end = begin_[at(v) + 1];
    seen_.assign(at(end - begin_[at(v)]), 0);
    for (std::int32_t i = begin_[at(v)]; i < end; ++i) {
      if (seen_[at(i - begin_[at(v)])] != 0) continue;
      line_.assign(1, rays_[at(i)].end);
      for (std::int32_t k = i + 1; k < end && rays_[at(k)].key - rays_[at(i)].key <= kSame; ++k) {
        if (!isSame(v, rays_[at(i)].end, rays_[at(k)].end)) continue;
        seen_[at(k - begin_[at(v)])] = 1;
        line_.push_back(rays_[at(k)].end);
      }
      if (line_.size() < 2) continue;
      std::sort(line_.begin(), line_.end(), [&](std::int32_t a, std::int32_t b) {
        return length(v, a) != length(v, b) ? length(v, a) < length(v, b) : a < b;
      });
      visit(std::span<const std::int32_t>(line_));
    }
  }

  // The nearest end of an edge from v that lies between v and `end`, or `end` if there is none.
  std::int32_t nextTowards(std::int32_t v, std::int32_t end) {
    const double key = keyOf(v, end);
    std::int32_t nearest = end;
    const auto own = rays_.begin() + begin_[at(v)], own_end = rays_.begin() + begin_[at(v) + 1];
    for (auto r = std::lower_bound(own, own_end, key - kSame,
                                   [](const auto&ray, double least) { return ray.key < least; });
         r != own_end && r->key <= key + kSame; ++r)
      if (length(v, r->end) < length(v, nearest) && isSame(v, end, r->end)) nearest = r->end;
    return nearest;
  }

 private:
  struct Ray {
    double key;
    std::int32_t end;
  };
  // More than rounding changes a key.
  static constexpr double kSame = 1e-12;

  double keyOf(std::int32_t from, std::int32_t to) const {
    const Vector3d way = vertices_[at(to)] - vertices_[at(from)];
    return Vector3d(0.5388159060803247, 0.6180339887498949, 0.5724334022399462).dot(way) /
           way.stableNorm();
  }
  double length(std::int32_t a, std::int32_t b) const {
    return (vertices_[at(b)] - vertices_[at(a)]).stableNorm();
  }
  // Whether the ways from v to a and to b have exactly the same direction.
  bool isSame(std::int32_t v, std::int32_t a, std::int32_t b) {
    if (--work_ < 0)
      throw InvalidShape("mesh: too many edges of a vertex have nearly the same direction");
    const Vector3d &from = vertices_[at(v)], &p = vertices_[at(a)], &q = vertices_[at(b)];
    return ((p - from).array() * (q - from).array() >= 0).all() && collinear(from, p, q);
  }

  std::span<const Vector3d> vertices_;
  std::vector<std::int32_t> begin_;  // of each vertex, in rays_
  std::vector<Ray> rays_;
  std::vector<std::uint8_t> seen_;
  std::vector<std::int32_t> line_;
  std::int64_t work_ = kCrackWork;
};

// The triangles of one round of addOverlapFillers(), without those that are there.
std::vector<Triangle> overlapFillers(std::span<const Vector3d> vertices,
                                     std::span<const Triangle> triangles) {
  Rays rays(vertices, triangles);
  std::vector<Triangle> fillers;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const auto v = static_cast<std::int32_t>(i);
    rays.forEachLine(v, [&](std::span<const std::int32_t> ends) {
      for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
        std::int32_t before = ends[k];
        while (before != ends[k + 1]) {
          const std::int32_t next = rays.nextTowards(before, ends[k + 1]);
          fillers.push_back({v, before, next});
          before = next;
        }
      }
    });
  }
  if (fillers.empty()) return fillers;
  const auto sorted = [](Triangle t) {
    std::sort(t.begin(), t.end());
    return t;
  };
  for (Triangle& t : fillers) t = sorted(t);
  std::sort(fillers.begin(), fillers.end());
  fillers.erase(std::unique(fillers.begin(), fillers.end()), fillers.end());
  std::vector<std::uint8_t> is_there(fillers.size(), 0);
  for (const Triangle& t : triangles) {
    const auto found = std::lower_bound(fillers.begin(), fillers.end(), sorted(t));
    if (found != fillers.end() && *found == sorted(t))
      is_there[static_cast<std::size_t>(found - fillers.begin())] = 1;
  }
  std::vector<Triangle> missing;
  for (std::size_t i = 0; i < fillers.size(); ++i)
    if (is_there[i] == 0) missing.push_back(fillers[i]);
  return missing;
}

}  // namespace

std::vector<Triangle> crackFillers(std::span<const Vector3d> vertices,
                                   std::span<const std::pair<std::int32_t, std::int32_t>> seams,
                                   double distance) {
  std::vector<Triangle> fillers;
  if (seams.empty()) return fillers;
  Vertices near(vertices, seams.size());
  const auto add = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
    if (a != b && b != c && c != a) fillers.push_back({a, b, c});
  };
  // 1. A vertex of a seam represents the vertices near it that have no representative yet.
  std::vector<std::int32_t> stand_in(vertices.size());
  std::iota(stand_in.begin(), stand_in.end(), 0);
  if (distance > 0) {
    std::vector<std::uint8_t> is_settled(vertices.size(), 0);
    const auto settle = [&](std::int32_t v) {
      if (is_settled[at(v)] != 0) return;
      is_settled[at(v)] = 1;
      near.forEachIn(vertices[at(v)], vertices[at(v)], distance, [&](std::int32_t w) {
        if (is_settled[at(w)] != 0 || !((vertices[at(w)] - vertices[at(v)]).norm() <= distance))
          return;
        is_settled[at(w)] = 1;
        stand_in[at(w)] = v;
      });
    };
    for (const auto& [a, b] : seams) {
      settle(a);
      settle(b);
    }
  }
  // 2. Two triangles move an edge to the edge of its representatives, and a fan cuts that edge at
  //    the representatives that lie on it.
  std::vector<std::pair<double, std::int32_t>> on_edge;
  for (const auto& [a, b] : seams) {
    const std::int32_t A = stand_in[at(a)], B = stand_in[at(b)];
    add(a, b, B);
    add(a, B, A);
    if (A == B) continue;
    const Vector3d &from = vertices[at(A)], &to = vertices[at(B)];
    const Vector3d way = to - from;
    on_edge.clear();
    near.forEachIn(from, to, distance, [&](std::int32_t v) {
      if (v == A || v == B || stand_in[at(v)] != v) return;
      const Vector3d& p = vertices[at(v)];
      const double along = (p - from).dot(way);
      if (!(along > 0 && along < way.squaredNorm())) return;
      const bool is_on = distance > 0 ? (p - from).cross(way).norm() <= distance * way.norm()
                                      : collinear(from, to, p);
      if (is_on) on_edge.emplace_back(along, v);
    });
    if (on_edge.empty()) continue;
    std::sort(on_edge.begin(), on_edge.end());
    std::int32_t before = on_edge[0].second;
    for (std::size_t k = 1; k < on_edge.size(); ++k) {
      add(A, before, on_edge[k].second);
      before = on_edge[k].second;
    }
    add(A, before, B);
  }
  return fillers;
}

void addOverlapFillers(std::span<const Vector3d> vertices, std::vector<Triangle>& triangles) {
  // The edges of new triangles may overlap, too.
  for (;;) {
    const std::vector<Triangle> fillers = overlapFillers(vertices, triangles);
    if (fillers.empty()) return;
    triangles.insert(triangles.end(), fillers.begin(), fillers.end());
  }
}

}  // namespace leeway::collision
