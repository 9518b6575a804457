#include "collision/mesh/topology/cracks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <vector>

#include "collision/base/exact_predicates.h"
#include "collision/base/numbers.h"
#include "collision/mesh/topology/components.h"

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

std::vector<std::pair<std::int32_t, std::int32_t>> overlappingEdges(
    std::span<const Vector3d> vertices, std::span<const Triangle> triangles) {
  // The edges of each vertex, by a component of their direction that few of them share. Rounding
  // changes it by less than kSame.
  constexpr double kSame = 1e-12;
  const Vector3d component(0.5388159060803247, 0.6180339887498949, 0.5724334022399462);
  struct Ray {
    double key;
    std::int32_t end;
  };
  std::vector<std::pair<std::int32_t, std::int32_t>> edges;
  for (const EdgeUse& e : sortedEdges(triangles, vertices.size()))
    if (edges.empty() || edges.back() != std::pair(e.low, e.high))
      edges.emplace_back(e.low, e.high);
  std::vector<std::int32_t> begin(vertices.size() + 1, 0);
  for (const auto& [a, b] : edges) {
    ++begin[at(a) + 1];
    ++begin[at(b) + 1];
  }
  for (std::size_t v = 0; v < vertices.size(); ++v) begin[v + 1] += begin[v];
  std::vector<Ray> rays(at(begin.back()));
  std::vector<std::int32_t> next(begin.begin(), begin.end() - 1);
  for (const auto& [a, b] : edges) {
    const Vector3d way = vertices[at(b)] - vertices[at(a)];
    const double key = component.dot(way) / way.stableNorm();
    rays[at(next[at(a)]++)] = {key, b};
    rays[at(next[at(b)]++)] = {-key, a};
  }
  std::vector<std::pair<std::int32_t, std::int32_t>> found;
  auto work = static_cast<std::int64_t>(rays.size()) * kSeamWork;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const std::span<Ray> own(rays.data() + begin[v], rays.data() + begin[v + 1]);
    std::sort(own.begin(), own.end(), [](const Ray& l, const Ray& r) {
      return l.key != r.key ? l.key < r.key : l.end < r.end;
    });
    const Vector3d& from = vertices[v];
    for (std::size_t i = 0; i < own.size(); ++i) {
      for (std::size_t k = i + 1; k < own.size() && own[k].key - own[i].key <= kSame; ++k) {
        if (--work < 0) return found;
        const Vector3d a = vertices[at(own[i].end)] - from, b = vertices[at(own[k].end)] - from;
        if (!(a.dot(b) > 0) || !collinear(from, vertices[at(own[i].end)], vertices[at(own[k].end)]))
          continue;
        const auto w = static_cast<std::int32_t>(v);
        found.push_back(
            std::minmax(w, a.squaredNorm() < b.squaredNorm() ? own[k].end : own[i].end));
      }
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace leeway::collision
