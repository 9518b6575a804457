#include "collision/mesh/topology/cracks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <vector>

#include "collision/base/exact_predicates.h"
#include "collision/base/numbers.h"

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

}  // namespace leeway::collision
