#include "collision/shapes/hull_of_part.h"

#include <algorithm>
#include <cmath>

#include "collision/base/exact_predicates.h"
#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/shapes/hull_builder.h"
#include "collision/shapes/hull_support.h"
#include "collision/shapes/size_limits.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/invalid_shape.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using Triangle = std::array<std::int32_t, 3>;

// Edges between facets that are not coplanar: the edges of the true polytope. Exact.
std::vector<std::array<std::int32_t, 2>> properEdges(std::span<const Vector3d> points,
                                                     const HullBuilder& hull) {
  std::vector<std::array<std::int32_t, 2>> edges;
  for (std::size_t i = 0; i < hull.facets().size(); ++i) {
    const Triangle& f = hull.facets()[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t from = f[k], to = f[(k + 1) % 3];
      if (from > to) continue;  // each edge only once
      const Triangle& other = hull.facets()[at(hull.adjacent()[i][k])];
      std::int32_t apex = other[0];
      for (const std::int32_t v : other) {
        if (v != from && v != to) apex = v;
      }
      if (orientation(points[at(f[0])], points[at(f[1])], points[at(f[2])], points[at(apex)]) !=
          0) {
        edges.push_back({from, to});
      }
    }
  }
  return edges;
}

// The corners of the true polytope, where three or more proper edges meet. A vertex with fewer lies
// within a flat face (no such edges) or a straight edge (two); another order of insertion would not
// have kept it.
std::vector<std::int32_t> corners(std::size_t count,
                                  const std::vector<std::array<std::int32_t, 2>>& edges) {
  std::vector<int> degree(count, 0);
  for (const auto& e : edges) {
    ++degree[at(e[0])];
    ++degree[at(e[1])];
  }
  std::vector<std::int32_t> result;
  for (std::size_t i = 0; i < count; ++i) {
    if (degree[i] >= 3) result.push_back(static_cast<std::int32_t>(i));
  }
  return result;
}

}  // namespace

ConvexHull::ConvexHull() = default;
ConvexHull::~ConvexHull() = default;

std::shared_ptr<const ConvexHull> ConvexHull::compute(std::span<const Vector3d> points) {
  if (points.empty()) throw InvalidShape("convex hull: no points; at least 1 is needed");
  requireSizes(points, "convex hull", "point");
  return hullOfPart(points);
}

std::shared_ptr<const ConvexHull> hullOfPart(std::span<const Vector3d> given) {
  std::vector<Vector3d> points(given.begin(), given.end());
  for (Vector3d& p : points) {
    for (int k = 0; k < 3; ++k) {
      if (std::abs(p[k]) < kSmallestExact) p[k] = 0;
    }
  }
  HullBuilder hull(points);
  std::vector<std::int32_t> kept = hull.vertices();
  if (hull.dimension() == 3) {
    std::vector<std::int32_t> extreme = corners(points.size(), properEdges(points, hull));
    if (extreme.size() < kept.size()) kept = std::move(extreme);
  }
  std::vector<Vector3d> vertices;
  vertices.reserve(kept.size());
  for (const std::int32_t i : kept) vertices.push_back(points[at(i)]);
  // Built again from the vertices alone, so that facets index them and no vertex is left within a
  // face.
  if (hull.dimension() == 3) hull = HullBuilder(vertices);

  std::shared_ptr<ConvexHull> result(new ConvexHull);
  result->facets_ = hull.facets();
  if (hull.dimension() == 3) result->makeNeighbours(properEdges(vertices, hull), vertices.size());
  result->vertices_.reserve(kept.size());
  for (const std::int32_t i : kept) result->vertices_.push_back(points[at(i)]);
  result->support_ = std::make_unique<const HullSupport>(*result);
  return result;
}

void ConvexHull::makeNeighbours(const std::vector<std::array<std::int32_t, 2>>& edges,
                                std::size_t count) {
  if (count < static_cast<std::size_t>(kClimbFrom)) return;
  std::vector<std::int32_t> begin(count + 1, 0);
  for (const auto& e : edges) {
    ++begin[at(e[0]) + 1];
    ++begin[at(e[1]) + 1];
  }
  for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
  std::vector<std::int32_t> list(edges.size() * 2), fill(begin.begin(), begin.end() - 1);
  for (const auto& e : edges) {
    list[at(fill[at(e[0])]++)] = e[1];
    list[at(fill[at(e[1])]++)] = e[0];
  }
  neighbour_begin_ = std::move(begin);
  neighbours_ = std::move(list);
}

}  // namespace leeway::collision
