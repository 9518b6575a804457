#include "collision/convex/pairs/segment_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"
#include "collision/convex/pairs/closed_form.h"
#include "collision/shapes/point_triangle.h"

namespace leeway::collision {

bool offerSegments(const ConvexView& a, const Pose& X_BA, const ConvexView& b, Progress& progress) {
  const Vector half_a = X_BA.rotation.col(2) * a.size.z();
  const Vector half_b(0, 0, b.size.z());
  double s_a = 0, s_b = 0;
  nearestOnSegments(tripleOf(X_BA.translation), tripleOf(half_a), {}, tripleOf(half_b), s_a, s_b);
  const Vector p = X_BA.translation + s_a * half_a;
  const Vector w = s_b * half_b - p;
  const double norm = w.norm();
  ++progress.iterations;
  progress.offerWitness(norm, w, p);
  // The lowest point of the difference along n: its centre minus both half segments.
  const auto offer = [&](const Vector& n) {
    const double value =
        -n.dot(X_BA.translation) - std::abs(n.dot(half_a)) - std::abs(n.dot(half_b));
    progress.offerLower(value, n);
  };
  if (norm > 0) offer(w / norm);
  if (progress.enough()) return true;
  // (Nearly) crossing segments: the common perpendicular is the better direction.
  Vector across = cross(half_a, half_b);
  const double across_squared = across.squaredNorm();
  // (A smaller square has lost digits.)
  if (!(across_squared > kLeastSquare)) return false;
  across /= std::sqrt(across_squared);
  offer(across.dot(w) < 0 ? Vector(-across) : across);
  return progress.enough();
}

bool offerSegmentAndBox(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                        Progress& progress) {
  const Vector half_a = X_BA.rotation.col(2) * a.size.z();
  const double s = nearestToBox(tripleOf(X_BA.translation), tripleOf(half_a), tripleOf(b.size));
  const Vector p = X_BA.translation + s * half_a;
  const Vector w = p.cwiseMin(b.size).cwiseMax(-b.size) - p;
  const double norm = w.norm();
  if (!(norm > 0)) return false;
  ++progress.iterations;
  progress.offerWitness(norm, w, p);
  const Vector n = w / norm;
  progress.offerLower(-n.dot(X_BA.translation) - std::abs(n.dot(half_a)) - n.cwiseAbs().dot(b.size),
                      n);
  return progress.enough();
}

bool offerTriangle(const ConvexView& a, const Pose& X_BA, const ConvexView& b, Progress& progress) {
  const Vector* t = b.points;
  const bool segment = a.core == Core::kSegment;
  const Vector center = X_BA.translation,
               half = segment ? Vector(X_BA.rotation.col(2) * a.size.z()) : Vector(0, 0, 0);
  double least_squared = std::numeric_limits<double>::infinity();
  ++progress.iterations;
  const auto offer = [&](const Vector& p, const Vector& q) {
    const Vector w = q - p;
    const double squared = w.squaredNorm();
    if (!(squared < least_squared)) return false;
    least_squared = squared;
    if (!(squared > 0)) return false;
    const double norm = std::sqrt(squared);
    const Vector n = w / norm;
    progress.offerWitness(norm, w, p);
    const double lowest = std::min(n.dot(t[0]), std::min(n.dot(t[1]), n.dot(t[2])));
    progress.offerLower(lowest - n.dot(center) - std::abs(n.dot(half)), n);
    return progress.enough();
  };
  const auto offerEnd = [&](const Vector& p) {
    return offer(p, closestPointOnTriangle(p, t[0], t[1], t[2]));
  };
  if (!segment) return offerEnd(center);
  // Starts with the end that is closer to the triangle.
  const Vector away = center - b.center;
  const double sign = away.dot(half) > 0 ? -1 : 1;
  if (offerEnd(center + sign * half)) return true;
  for (int i = 0; i < 3; ++i) {
    const Vector middle = 0.5 * (t[i] + t[(i + 1) % 3]), half_edge = 0.5 * (t[(i + 1) % 3] - t[i]);
    double s = 0, s_edge = 0;
    nearestOnSegments(tripleOf(center), tripleOf(half), tripleOf(middle), tripleOf(half_edge), s,
                      s_edge);
    if (offer(center + s * half, middle + s_edge * half_edge)) return true;
  }
  return offerEnd(center - sign * half);
}

}  // namespace leeway::collision
