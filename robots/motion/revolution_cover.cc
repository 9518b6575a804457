#include "robots/motion/revolution_cover.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "collision/base/numbers.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"
#include "robots/base/tolerances.h"

namespace leeway::robots {
namespace {

using collision::Shape;
using collision::ShapeType;
using Eigen::Vector3d;

/// Radius of each of kGapSlices slices of equal thickness along z.
struct Slices {
  double low = 0, thickness = 0, slack = 0;  // [m]
  std::array<double, kGapSlices> radius{};

  int index(double z) const {
    return static_cast<int>(std::clamp((z - low) / thickness, 0.0, kGapSlices - 1.0));
  }
};

/// The corners of a shape's triangles, three for each; empty where it has none.
std::vector<Vector3d> triangleCorners(const Geometry& g) {
  std::vector<Vector3d> corners;
  const auto add = [&](std::span<const Vector3d> vertices,
                       std::span<const std::array<std::int32_t, 3>> triangles) {
    for (const std::array<std::int32_t, 3>& t : triangles)
      for (const std::int32_t v : t) corners.push_back(g.X_BG * vertices[at(v)]);
  };
  if (g.shape.type() == ShapeType::kMesh)
    add(g.shape.mesh()->vertices(), g.shape.mesh()->triangles());
  if (g.shape.type() == ShapeType::kConvexHull)
    add(g.shape.hull()->vertices(), g.shape.hull()->facets());
  return corners;
}

Slices sliced(const std::vector<Vector3d>& corners) {
  double low = corners.front().z(), high = low, size = 0;
  for (const Vector3d& p : corners) {
    low = std::min(low, p.z());
    high = std::max(high, p.z());
    size = std::max(size, p.lpNorm<1>());
  }
  Slices slices;
  const double slack = kGapSlack * (1 + size);
  slices.low = low;
  slices.slack = slack;
  slices.thickness = (high - low) / kGapSlices + slack;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    // The part of a triangle within a slice has its corners on the triangle's edges.
    const Vector3d &p = corners[i], &q = corners[i % 3 == 2 ? i - 2 : i + 1];
    const double rise = q.z() - p.z();
    const int last = slices.index(std::max(p.z(), q.z()) + slack);
    for (int k = slices.index(std::min(p.z(), q.z()) - slack); k <= last; ++k) {
      double from = 0, to = 1;
      if (std::abs(rise) > kGapLevel) {
        from = std::clamp((low + k * slices.thickness - slack - p.z()) / rise, 0.0, 1.0);
        to = std::clamp((low + (k + 1) * slices.thickness + slack - p.z()) / rise, 0.0, 1.0);
      }
      for (const double t : {from, to}) {
        const Vector3d x = p + t * (q - p);
        double& radius = slices.radius[at(k)];
        radius = std::max(radius, std::hypot(x.x(), x.y()) + slack);
      }
    }
  }
  return slices;
}

/// Appends a cylinder for each run of slices of nearly one radius.
void appendCylinders(const Slices& slices, std::vector<Geometry>& cylinders) {
  const auto& radius = slices.radius;
  for (int k = 0; k < kGapSlices;) {
    double most = radius[at(k)], least = most;
    int end = k + 1;
    for (; end < kGapSlices; ++end) {
      most = std::max(most, radius[at(end)]);
      least = std::min(least, radius[at(end)]);
      if (most - least > kLeastGap) break;
    }
    const double r = *std::max_element(radius.begin() + k, radius.begin() + end);
    if (r > 0) {
      Pose X;
      X.translation.z() = slices.low + 0.5 * (k + end) * slices.thickness;
      const double half_length = (end - k) * slices.thickness / 2 + 2 * slices.slack;
      cylinders.push_back({Shape::cylinder(r, half_length), X, ""});
    }
    k = end;
  }
}

}  // namespace

bool areTriangles(std::span<const Geometry> geometries) {
  return std::all_of(geometries.begin(), geometries.end(), [](const Geometry& g) {
    return g.shape.type() == ShapeType::kMesh || g.shape.type() == ShapeType::kConvexHull;
  });
}

std::optional<std::vector<Geometry>> revolutionCover(std::span<const Geometry> geometries) {
  std::vector<Geometry> cylinders;
  for (const Geometry& g : geometries) {
    const std::vector<Vector3d> corners = triangleCorners(g);
    if (corners.empty()) return std::nullopt;
    // Cylinders are no larger than other shapes.
    if (std::any_of(corners.begin(), corners.end(), [](const Vector3d& p) {
          return p.lpNorm<1>() > 0.5 * collision::kLargestSize;
        }))
      return std::nullopt;
    appendCylinders(sliced(corners), cylinders);
  }
  return cylinders;
}

double axisReach(const Geometry& g) {
  const Vector3d center = g.X_BG * g.shape.boundingCenter();
  return (std::hypot(center.x(), center.y()) + g.shape.boundingRadius()) * (1 + kGapSlack);
}

}  // namespace leeway::robots
