#include "collision/shapes/hull_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "collision/base/exact_predicates.h"
#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/shapes/point_triangle.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

double squaredDistance(const Vector3d& point, std::span<const Vector3d> points,
                       const std::array<std::int32_t, 3>& f) {
  return (point -
          closestPointOnTriangle(point, points[at(f[0])], points[at(f[1])], points[at(f[2])]))
      .squaredNorm();
}

// An upper bound on a point's distance from its computed square.
double roundedOut(double squared, const Vector3d& point) {
  const double size = point.cwiseAbs().maxCoeff();
  return std::sqrt(squared) * (1 + kRelativeRounding) + size * kRelativeRounding;
}

}  // namespace

double distanceFromHull(const Eigen::Vector3d& point, std::span<const Eigen::Vector3d> points,
                        const HullBuilder& hull) {
  double best = std::numeric_limits<double>::infinity();
  bool outside = false;
  for (const auto& f : hull.facets()) {
    const Vector3d &a = points[at(f[0])], &b = points[at(f[1])], &c = points[at(f[2])];
    if (!outside) outside = orientation(a, b, c, point) > 0;
    best = std::min(best, squaredDistance(point, points, f));
  }
  return outside ? roundedOut(best, point) : 0;
}

double largestDistanceFromHull(std::span<const Eigen::Vector3d> points, const HullBuilder& hull) {
  struct Outside {
    std::int32_t point;
    double squared;  // of its distance from the nearest facet tested so far; at first from its own
                     // facet
  };
  std::vector<Outside> outside;
  outside.reserve(hull.outside().size());
  for (std::size_t i = 0; i < hull.outside().size(); ++i) {
    const std::int32_t p = hull.outside()[i];
    const auto& f = hull.facets()[at(hull.outsideOf()[i])];
    outside.push_back({p, squaredDistance(points[at(p)], points, f)});
  }
  double largest = 0;
  const auto include = [&](Outside& o) {
    // Rounding up is monotonic, so one facet that is close enough excludes the point.
    const Vector3d& point = points[at(o.point)];
    if (roundedOut(o.squared, point) <= largest) return;
    for (const auto& f : hull.facets()) {
      const double squared = squaredDistance(point, points, f);
      if (squared >= o.squared) continue;
      o.squared = squared;
      if (roundedOut(squared, point) <= largest) return;
    }
    largest = roundedOut(o.squared, point);
  };
  // Starts with the farthest one, because it excludes most others.
  const auto far =
      std::max_element(outside.begin(), outside.end(),
                       [](const Outside& l, const Outside& r) { return l.squared < r.squared; });
  if (far != outside.end()) include(*far);
  for (Outside& o : outside) include(o);
  return largest;
}

}  // namespace leeway::collision
