#include "collision/mesh/descent/touching_triangles.h"

#include <algorithm>
#include <cmath>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/shapes/point_triangle.h"

namespace leeway::collision {
namespace {

/// The room of a candidate at a point that two triangles share, relative to that of one at a
/// segment.
constexpr double kPointShare = 0x1p-20;

/// Corners of the intersection of two triangles: a point, a segment or a polygon. Some occur twice.
struct Shared {
  static constexpr std::size_t kMost = 15;
  std::array<Vector, kMost> corner;
  std::size_t count = 0;

  void offer(const Vector& on_p, const Vector& on_q, double near) {
    if ((on_q - on_p).squaredNorm() <= near * near) corner[count++] = 0.5 * (on_p + on_q);
  }
  /// A point between all corners, whatever their weights.
  Vector middle() const {
    Vector sum = Vector::Zero();
    for (std::size_t i = 0; i < count; ++i) sum += corner[i];
    return sum / static_cast<double>(count);
  }
  /// The largest distance of a corner from `point`.
  double reach(const Vector& point) const {
    double squared = 0;
    for (std::size_t i = 0; i < count; ++i)
      squared = std::max(squared, (corner[i] - point).squaredNorm());
    return std::sqrt(squared);
  }
};

Shared sharedBy(const Vector* p, const Vector* q, double near) {
  Shared shared;
  for (int i = 0; i < 3; ++i) {
    shared.offer(p[i], closestPointOnTriangle(p[i], q[0], q[1], q[2]), near);
    shared.offer(closestPointOnTriangle(q[i], p[0], p[1], p[2]), q[i], near);
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      // The crossing of two edges that are not parallel.
      const Vector e = p[(i + 1) % 3] - p[i], f = q[(j + 1) % 3] - q[j], r = q[j] - p[i];
      const double ee = e.squaredNorm(), ff = f.squaredNorm(), ef = e.dot(f);
      const double area = ee * ff - ef * ef;
      if (!(area > kParallelEdgesSquared * ee * ff)) continue;
      const double s = (e.dot(r) * ff - f.dot(r) * ef) / area;
      const double t = (e.dot(r) * ef - f.dot(r) * ee) / area;
      if (!(s >= 0 && s <= 1 && t >= 0 && t <= 1)) continue;
      shared.offer(p[i] + s * e, q[j] + t * f, near);
    }
  }
  return shared;
}

/// The distance of a point in the triangle's plane from its edges.
double fromEdges(const Vector* t, const Vector& point) {
  double least = kInfinity;
  for (int i = 0; i < 3; ++i) {
    const Vector edge = t[(i + 1) % 3] - t[i];
    least = std::min(least, cross(edge, point - t[i]).norm() / edge.norm());
  }
  return least;
}

/// The way from `point`, which the triangle touches, into the triangle: towards a point inside it,
/// between the middle and the corner that is farthest behind the plane through `origin` with the
/// unit normal n. The point is also behind that plane, and the room is its depth there.
TouchingTriangles::Candidate behind(const Vector* t, const Vector& point, const Vector& n,
                                    const Vector& origin) {
  const double depth[3] = {n.dot(origin - t[0]), n.dot(origin - t[1]), n.dot(origin - t[2])};
  const auto deepest = std::max_element(depth, depth + 3) - depth;
  const double most = depth[deepest];
  if (!(most > 0)) return {point, Vector::Zero(), 0};
  const double of_middle = (depth[0] + depth[1] + depth[2]) / 3;
  const double share = 0.5 * (of_middle > 0 ? 1 : most / (most - of_middle));
  const Vector target = (1 - share) * t[deepest] + share / 3 * (t[0] + t[1] + t[2]);
  return {point, target - point, (1 - share) * most + share * of_middle};
}

}  // namespace

void TouchingTriangles::add(const Vector* p, const Vector* q) {
  Vector m = cross(p[1] - p[0], p[2] - p[0]), n = cross(q[1] - q[0], q[2] - q[0]);
  const double area_p = m.norm(), area_q = n.norm();
  if (!(area_p > kLeastToSquare && area_q > kLeastToSquare)) return;
  m /= area_p;
  n /= area_q;
  const double facing = m.dot(n);
  if (facing < -kSameNormal) return;  // back to back: solids that only touch here
  const Shared shared = sharedBy(p, q, near_);
  if (shared.count == 0) return;
  const Vector point = shared.middle();
  // A length below this is rounding.
  const double least = 4 * near_;
  if (facing > kSameNormal) {
    const double room = std::min(fromEdges(p, point), fromEdges(q, point));
    if (room > least) flush_.offer({point, -0.5 * room * (m + n), room});
  }
  // Triangles that share a segment are better candidates than those that share a point.
  const double reach = shared.reach(point);
  const auto offer = [&](List& list, Candidate candidate) {
    if (!(candidate.room > least)) return;
    candidate.room = std::min(candidate.room, std::max(reach, kPointShare * candidate.room));
    list.offer(candidate);
  };
  offer(on_a_, behind(p, point, n, q[0]));
  offer(on_b_, behind(q, point, m, p[0]));
}

void TouchingTriangles::List::offer(const Candidate& candidate) {
  // Descents may visit a pair twice.
  for (std::size_t i = 0; i < count; ++i) {
    if (kept[i].room == candidate.room && kept[i].point == candidate.point) return;
  }
  std::size_t at = count;
  if (count < kMost) {
    ++count;
  } else if (!(candidate.room > kept[kMost - 1].room)) {
    return;
  } else {
    at = kMost - 1;
  }
  for (; at > 0 && kept[at - 1].room < candidate.room; --at) kept[at] = kept[at - 1];
  kept[at] = candidate;
}

}  // namespace leeway::collision
