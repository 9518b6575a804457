#include "collision/face_parts.h"

#include <cmath>
#include <limits>

#include "leeway/collision/tolerances.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {
constexpr double kInfinity = std::numeric_limits<double>::infinity();
}  // namespace

Ball ballAround(std::span<const Polygon> faces) {
  Vector3d low = Vector3d::Constant(kInfinity), high = -low;
  for (const Polygon& face : faces)
    for (const Vector3d& p : face) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  Ball best{Vector3d::Zero(), kInfinity};
  Vector3d center = low + (high - low) / 2;
  // Large sets get fewer steps; any centre is right.
  std::size_t points = 0;
  for (const Polygon& face : faces) points += face.size();
  const int steps = points > 5000 ? 8 : 24;
  for (int step = 1; step <= steps; ++step) {
    const Vector3d* farthest = nullptr;
    double squared = -1;
    for (const Polygon& face : faces)
      for (const Vector3d& p : face)
        if ((p - center).squaredNorm() > squared) {
          squared = (p - center).squaredNorm();
          farthest = &p;
        }
    if (farthest == nullptr) break;  // no points, and no ball around them
    const double radius =
        std::sqrt(squared) * (1 + kRelativeRounding) + kRelativeRounding * center.lpNorm<1>();
    if (radius < best.radius) best = {center, radius};
    center += (*farthest - center) / (step + 2);
  }
  return best;
}

Polygon clipped(const Polygon& polygon, Eigen::Index axis, double at, double side) {
  Polygon result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double dp = side * (p[axis] - at), dq = side * (q[axis] - at);
    if (dp >= 0) result.push_back(p);
    if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) {
      Vector3d cut = p + (q - p) * (dp / (dp - dq));
      cut[axis] = at;
      result.push_back(cut);
    }
  }
  return result;
}

}  // namespace leeway::collision
