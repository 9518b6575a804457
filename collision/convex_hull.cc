#include "leeway/collision/convex_hull.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "collision/exact.h"
#include "collision/hull_builder.h"
#include "collision/point_triangle.h"
#include "leeway/collision/shape.h"
#include "leeway/collision/tolerances.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using Triangle = std::array<std::int32_t, 3>;

std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

void requireUsable(std::span<const Vector3d> points) {
  if (points.empty()) throw InvalidShape("convex hull: no points; at least 1 is needed");
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      if (std::abs(points[i][k]) <= kLargestCoordinate) continue;
      throw InvalidShape("convex hull: point " + std::to_string(i) + " has the coordinate " +
                         std::to_string(points[i][k]) + "; finite numbers up to 1e60 are accepted");
    }
  }
}

// Edges of the hull between facets that are not coplanar: those of the true polytope. Exact.
std::vector<std::array<std::int32_t, 2>> properEdges(std::span<const Vector3d> points,
                                                     const HullBuilder& hull) {
  std::vector<std::array<std::int32_t, 2>> edges;
  for (std::size_t i = 0; i < hull.facets().size(); ++i) {
    const Triangle& f = hull.facets()[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t from = f[k], to = f[(k + 1) % 3];
      if (from > to) continue;  // once an edge
      const Triangle& other = hull.facets()[index(hull.adjacent()[i][k])];
      std::int32_t apex = other[0];
      for (const std::int32_t v : other) {
        if (v != from && v != to) apex = v;
      }
      if (orientation(points[index(f[0])], points[index(f[1])], points[index(f[2])],
                      points[index(apex)]) != 0) {
        edges.push_back({from, to});
      }
    }
  }
  return edges;
}

// The corners of the true polytope: three or more proper edges meet there. A vertex with fewer lies within a flat face
// (none) or a straight edge (two), where inserting in another order would not have kept it.
std::vector<std::int32_t> corners(std::size_t count,
                                  const std::vector<std::array<std::int32_t, 2>>& edges) {
  std::vector<int> degree(count, 0);
  for (const auto& e : edges) {
    ++degree[index(e[0])];
    ++degree[index(e[1])];
  }
  std::vector<std::int32_t> result;
  for (std::size_t i = 0; i < count; ++i) {
    if (degree[i] >= 3) result.push_back(static_cast<std::int32_t>(i));
  }
  return result;
}

// A lower bound on the distance of the origin from the hull of `points`: the largest of (direction . point)'s minima
// over a few directions, improved by Wolfe-like steps. Any unit direction proves its own value.
double distanceFromOrigin(std::span<const Vector3d> points) {
  Vector3d nearest = Vector3d::Zero();
  for (const Vector3d& p : points) nearest += p / static_cast<double>(points.size());
  double best = 0;
  for (int step = 0; step < 64; ++step) {
    const double length = nearest.norm();
    if (!(length > 0)) break;
    const Vector3d direction = nearest / length;
    double support = std::numeric_limits<double>::infinity();
    const Vector3d* lowest = nullptr;
    for (const Vector3d& p : points) {
      const double value = direction.dot(p);
      if (value < support) {
        support = value;
        lowest = &p;
      }
    }
    best = std::max(best, support);
    if (best >= 0.5 * length) break;  // within a factor of 2 is good enough
    // Frank-Wolfe: the point of the segment from `nearest` to the lowest point that is closest to the origin.
    const Vector3d edge = *lowest - nearest;
    const double squared = edge.squaredNorm();
    if (!(squared > 0)) break;
    nearest += std::clamp(-nearest.dot(edge) / squared, 0.0, 1.0) * edge;
  }
  return best;
}

}  // namespace

std::shared_ptr<const ConvexHull> ConvexHull::compute(std::span<const Vector3d> given) {
  requireUsable(given);
  // Coordinates too small for the exact predicates become 0, and what that moves is the excess.
  std::vector<Vector3d> points(given.begin(), given.end());
  double moved = 0;
  for (Vector3d& p : points) {
    for (int k = 0; k < 3; ++k) {
      if (p[k] == 0 || std::abs(p[k]) >= kSmallestExact) continue;
      p[k] = 0;
      moved = 4 * kSmallestExact;
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
  for (const std::int32_t i : kept) vertices.push_back(points[index(i)]);
  // Once more over the vertices alone: facets are numbered by them then, and none is left within a face.
  if (hull.dimension() == 3) hull = HullBuilder(vertices);

  std::shared_ptr<ConvexHull> result(new ConvexHull);
  result->facets_ = hull.facets();
  if (hull.dimension() == 3) result->makeNeighbours(properEdges(vertices, hull), vertices);
  result->vertices_.reserve(kept.size());
  for (const std::int32_t i : kept) result->vertices_.push_back(given[index(i)]);
  result->excess_ = moved;
  return result;
}

// Why lists are dropped: a climber stops where no neighbour is better by more than rounding. Let w be the best vertex
// and v where it stopped. w - v lies in the cone of the n - v, and s (w - v) in the hull of v and its
// neighbours for s up to dist(v, hull(neighbours)) / |w - v|; so (w - v) . d <= delta / s. Where v stands out
// of its neighbours' hull by little, the climber can stop on the wrong side of the whole body.
void ConvexHull::makeNeighbours(const std::vector<std::array<std::int32_t, 2>>& edges,
                                std::span<const Vector3d> vertices) {
  if (vertices.size() < static_cast<std::size_t>(kMinClimbVertices)) return;
  std::vector<std::int32_t> begin(vertices.size() + 1, 0);
  for (const auto& e : edges) {
    ++begin[index(e[0]) + 1];
    ++begin[index(e[1]) + 1];
  }
  for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
  std::vector<std::int32_t> list(edges.size() * 2), fill(begin.begin(), begin.end() - 1);
  for (const auto& e : edges) {
    list[index(fill[index(e[0])]++)] = e[1];
    list[index(fill[index(e[1])]++)] = e[0];
  }
  Vector3d low = vertices[0], high = vertices[0];
  for (const Vector3d& v : vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const double diameter = (high - low).norm();
  double gain = 1;
  std::vector<Vector3d> around;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    around.clear();
    for (std::int32_t k = begin[i]; k < begin[i + 1]; ++k) {
      around.push_back(vertices[index(list[index(k)])] - vertices[i]);
    }
    // Rounding of the bound itself: a few units in the last place of the diameter.
    const double distance = distanceFromOrigin(around) - 1e-15 * (low.cwiseAbs().maxCoeff() + high.cwiseAbs().maxCoeff());
    if (!(distance * kMaxClimbGain > diameter)) return;
    gain = std::max(gain, diameter / distance);
  }
  climb_gain_ = gain * (1 + kRelativeRounding);
  neighbour_begin_ = std::move(begin);
  neighbours_ = std::move(list);
}

std::span<const std::int32_t> ConvexHull::neighbours(std::int32_t i) const {
  if (neighbour_begin_.empty()) return {};
  const auto begin = index(neighbour_begin_[index(i)]), end = index(neighbour_begin_[index(i) + 1]);
  return {neighbours_.data() + begin, end - begin};
}

}  // namespace leeway::collision
