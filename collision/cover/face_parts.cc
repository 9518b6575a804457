#include "collision/cover/face_parts.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

// The point that is farthest from the centre; null if there are no points.
const Vector3d* farthestFrom(const Vector3d& center, std::span<const Vector3d> points,
                             std::size_t stride, double& squared) {
  const Vector3d* farthest = nullptr;
  squared = -1;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const double s = (points[i] - center).squaredNorm();
    if (s > squared) {
      squared = s;
      farthest = &points[i];
    }
  }
  return farthest;
}

}  // namespace

Ball ballAround(std::span<const Vector3d> points) {
  Vector3d low = Vector3d::Constant(kInfinity), high = -low;
  for (const Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Ball best{Vector3d::Zero(), kInfinity};
  const auto radiusOf = [](const Vector3d& center, double squared) {
    return std::sqrt(squared) * (1 + kRelativeRounding) + kRelativeRounding * center.lpNorm<1>();
  };
  Vector3d center = low + (high - low) / 2;
  // Uses fewer steps for large sets, and a sample of the points for very large sets: any centre
  // gives a valid ball, once all points are in it.
  const int steps = points.size() > 5000 ? 8 : 24;
  const std::size_t stride = points.size() > 50000 ? points.size() / 10000 : 1;
  for (int step = 1; step <= steps; ++step) {
    double squared = 0;
    const Vector3d* const farthest = farthestFrom(center, points, stride, squared);
    if (farthest == nullptr) break;  // no points
    if (radiusOf(center, squared) < best.radius) best = {center, radiusOf(center, squared)};
    center += (*farthest - center) / (step + 2);
  }
  if (stride > 1) {
    double squared = 0;
    farthestFrom(best.center, points, 1, squared);
    best.radius = radiusOf(best.center, squared);
  }
  return best;
}

void Polygons::addClipped(std::span<const Vector3d> polygon, Eigen::Index axis, double at,
                          double side) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double dp = side * (p[axis] - at), dq = side * (q[axis] - at);
    if (dp >= 0) corners_.push_back(p);
    if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) {
      Vector3d cut = p + (q - p) * (dp / (dp - dq));
      cut[axis] = at;
      corners_.push_back(cut);
    }
  }
  if (corners_.size() > (ends_.empty() ? 0 : ends_.back())) ends_.push_back(corners_.size());
}

Polygons clipped(const Polygons& polygons, Eigen::Index axis, double at, double side) {
  Polygons kept;
  kept.reserve(polygons.size(), polygons.corners().size());
  for (std::size_t i = 0; i < polygons.size(); ++i) kept.addClipped(polygons[i], axis, at, side);
  return kept;
}

Polygons polygonsOf(const TriangleMesh& mesh) {
  Polygons triangles;
  triangles.reserve(mesh.triangles().size(), 3 * mesh.triangles().size());
  const auto corner = [&](std::int32_t i) { return mesh.vertices()[static_cast<std::size_t>(i)]; };
  for (const auto& t : mesh.triangles())
    triangles.add(std::array<Vector3d, 3>{corner(t[0]), corner(t[1]), corner(t[2])});
  return triangles;
}

}  // namespace leeway::collision
