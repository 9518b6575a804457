#include "collision/deform/motion/cache_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/deform/motion/motion_input.h"
#include "leeway/collision/vertex_motion.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

constexpr MotionKind kCacheKind = MotionKind::kCache;

}  // namespace

CachedVertices::CachedVertices(CacheMotion motion)
    : VertexMotion(kCacheKind, motion.vertex_count, 2, motion.times),
      track_(std::move(motion.times), Interpolation::kLinear),
      positions_(std::move(motion.positions)) {
  for (const Vector3d& p : positions_) size_ = std::max(size_, p.cwiseAbs().maxCoeff());
  measureSegments();
}

void CachedVertices::parameters(double time, std::span<double> out) const {
  const KeyPlace place = track_.at(time);
  out[0] = static_cast<double>(place.key);
  out[1] = place.share;
}

void CachedVertices::vertices(std::span<const double> parameters, int first,
                              std::span<Vector3d> out) const {
  const Vector3d* from = frame(static_cast<std::size_t>(parameters[0])) + first;
  if (!(parameters[1] > 0)) {
    std::copy_n(from, out.size(), out.begin());
    return;
  }
  const double s = parameters[1], r = 1 - s;
  const Vector3d* to = from + vertexCount();
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (int k = 0; k < 3; ++k) out[i][k] = r * from[i][k] + s * to[i][k];
  }
}

double CachedVertices::speedBound(double t0, double t1) const {
  return track_.largest(speeds_, t0, t1);
}

// Between two frames vertices move along straight lines at constant speed.
double CachedVertices::accelerationBound(double t0, double t1) const {
  return t0 <= t1 && !track_.jumps(t0, t1) ? 0 : std::numeric_limits<double>::infinity();
}

double CachedVertices::rounding(double t0, double t1) const {
  if (!(t0 <= t1)) return std::numeric_limits<double>::infinity();
  return roundedUp(2 * (2 * kShareRounding + 8) * kUnitRoundoff * size_, 8);
}

void CachedVertices::measureSegments() {
  for (std::size_t i = 0; i < track_.segments(); ++i) {
    double longest_squared = 0;
    for (std::ptrdiff_t v = 0; v < vertexCount(); ++v) {
      longest_squared = std::max(longest_squared, squaredLength(frame(i + 1)[v] - frame(i)[v]));
    }
    // A difference is off by one unit, relative.
    speeds_.push_back(roundedUp(std::sqrt(longest_squared) * track_.rate(i), 16));
  }
}

std::shared_ptr<const VertexMotion> VertexMotion::cache(CacheMotion motion) {
  if (motion.vertex_count <= 0)
    refuse(kCacheKind, std::to_string(motion.vertex_count) + " vertices; at least 1 is needed");
  if (motion.times.empty()) refuse(kCacheKind, "no frames; at least 1 is needed");
  requireIncreasing(kCacheKind, motion.times);
  const auto count = static_cast<std::size_t>(motion.vertex_count);
  requireCount(kCacheKind, "the motion", motion.positions.size(), motion.times.size() * count,
               "positions (" + std::to_string(motion.times.size()) + " frames of " +
                   std::to_string(count) + " vertices)");
  for (std::size_t i = 0; i < motion.positions.size(); ++i) {
    if ((motion.positions[i].array().abs() <= kLargestMotion).all()) continue;
    for (int k = 0; k < 3; ++k) {
      requireUsable(kCacheKind,
                    "frame " + std::to_string(i / count) + ", vertex " + std::to_string(i % count),
                    motion.positions[i][k]);
    }
  }
  return std::make_shared<CachedVertices>(std::move(motion));
}

}  // namespace leeway::collision
