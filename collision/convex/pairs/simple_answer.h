#pragma once

#include <cmath>

#include "collision/base/pose_check.h"
#include "collision/base/status.h"
#include "collision/base/tolerances.h"
#include "collision/convex/pairs/closed_form.h"
#include "collision/convex/pairs/simple_pairs.h"

namespace leeway::collision {

// From the nearest points of two cores to an answer; also spheres and capsules, which need nothing
// else. Inline, because a call costs as much as their arithmetic.

// clang-format off
// Rounding, in units of u L with u = kUnitRoundoff and L >= extent A + extent B + |t|, of points and planes
// given the frame that they are made in: a box's, whose rounding kPoseRounding covers, or the world's axes.
//
//   point: halves 1 or 2, the translation 1, sums 3, their difference 1, its norm 3                < 10
//   a box's point, rotated to the world's axes: 3 sqrt(3) of the extent in place of the halves     < 14
//   plane of segments: dot products 3, with a unit vector's own length 4, three sums 3             < 16
//   plane of boxes (box_overlap.cc)                                                                < 22
//
// kClosedFormRounding covers all of them.
// clang-format on

/// Data of a pair besides the cores' nearest points.
struct PairFrame {
  const Pose& X_WA;
  const Pose& X_WB;
  double extent_a, extent_b;  // of the cores
  double radius_a, radius_b;
};

/// An answer in registers: plain numbers, so that the caller's result is written only once.
struct PairAnswer {
  Interval found;
  DistanceStatus status;
  Triple point_a, point_b, normal;

  void writeTo(DistanceResult& result) const {
    write(found, result.distance);
    result.status = status;
    write(point_a, result.point_a);
    write(point_b, result.point_b);
    write(normal, result.normal);
    // (Neighbours in memory, so that one store writes both and one load reads them.)
    result.iterations = 1;
    result.triangle_a = -1;
  }
};

/// Makes the answer from nearest points of the cores. False if it meets no condition of the
/// request, or if poses or sizes are out of range.
inline __attribute__((always_inline)) bool answer(const PairFrame& frame, const Nearest& nearest,
                                                  const DistanceRequest& request, PairCache* cache,
                                                  PairAnswer& answer) {
  const PoseCheck check = checkRotationsQuickly(frame.X_WA.rotation, frame.X_WB.rotation);
  const double radii = frame.radius_a + frame.radius_b;
  // |t| <= apart + both extents. (Written so that few operations wait for the root in `apart`.)
  const double share = check.departure + (kClosedFormRounding + kPoseRounding) * kUnitRoundoff;
  const double extents = 2 * (frame.extent_a + frame.extent_b);
  const double size = nearest.apart + (extents + kLeastSum);
  const double rounding =
      share * nearest.apart + (share * (extents + kLeastSum) + 4 * kUnitRoundoff * radii);
  const Interval found = {(nearest.plane - radii) - rounding, (nearest.apart - radii) + rounding};
  // False for NaN; a translation that is not finite gives a size that is not finite.
  if (!(check.rotations && nearest.apart > 64 * kUnitRoundoff * size && size <= kFarthest)) {
    return false;
  }
  answer.status = DistanceStatus::kConverged;
  if (!(found.width() <= request.tolerance && isSignKnown(found))) {
    if (!isDecided(found, request)) return false;
    answer.status = statusOf(found, request);
  }
  answer.found = found;
  const Triple& n = nearest.normal;
  const Triple core = tripleOf(frame.X_WB.translation) + nearest.point_a;
  const Triple along = nearest.early ? (1 / nearest.apart) * nearest.way : n;
  answer.point_a = core + frame.radius_a * along;
  answer.point_b = core + (nearest.apart - frame.radius_b) * along;
  answer.normal = n;
  if (cache != nullptr) write(rotatedBack(frame.X_WB.rotation, n), cache->direction_B);
  return true;
}

/// The signed separation of two spheres or capsules (kSegment: a capsule) that are apart, by closed
/// forms from the world poses (Lumelsky 1985), in the world's axes. False if a closed form is not
/// enough: cores that overlap or nearly do, sizes out of range, tolerances below rounding, invalid
/// poses, no iteration allowed. The interval is computed from points of both bodies and a
/// supporting plane, however they were found: near-parallel segments may get poor points, and the
/// plane then makes the interval wide. O(1).
template <bool kSegmentA, bool kSegmentB>
inline __attribute__((always_inline)) bool answerSegments(const Shape& a, const Pose& X_WA,
                                                          const Shape& b, const Pose& X_WB,
                                                          const DistanceRequest& request,
                                                          PairCache* cache, PairAnswer& found) {
  if (request.iteration_limit <= 0) return false;
  const double extent_a = kSegmentA ? a.halfLength() : 0, extent_b = kSegmentB ? b.halfLength() : 0;
  const Eigen::Matrix3d &R = X_WA.rotation, &S = X_WB.rotation;
  const Triple d = tripleOf(X_WA.translation) - tripleOf(X_WB.translation);
  Nearest nearest;
  nearest.point_a = d;
  if constexpr (kSegmentA && kSegmentB) {
    // One lane for each axis.
    const BodyLanes x = {R(0, 2), S(0, 2)}, y = {R(1, 2), S(1, 2)}, z = {R(2, 2), S(2, 2)};
    const auto along = [&](const Triple& v) __attribute__((always_inline)) {
      return x * BodyLanes{v.x, v.x} + y * BodyLanes{v.y, v.y} + z * BodyLanes{v.z, v.z};
    };
    const BodyLanes along_d = along(d);
    double s_a = 0, s_b = 0;
    nearestOnAxes(x[0] * x[1] + y[0] * y[1] + z[0] * z[1], along_d[0], along_d[1], extent_a,
                  extent_b, s_a, s_b);
    nearest.point_a = {d.x + s_a * x[0], d.y + s_a * y[0], d.z + s_a * z[0]};
    const Triple w = Triple{s_b * x[1], s_b * y[1], s_b * z[1]} - nearest.point_a;
    nearest.apart = std::sqrt(squared(w));
    const double per = 1 / nearest.apart;
    nearest.normal = per * w;
    // (Divided last, so that the sums need not wait for the root.)
    const BodyLanes reach = along(w);
    nearest.plane =
        per * (-dot(w, d) - (std::abs(reach[0]) * extent_a + std::abs(reach[1]) * extent_b));
  } else {
    Triple w = -d, half = {0, 0, 0};
    if constexpr (kSegmentA) {
      half = extent_a * column(R, 2);
      nearest.point_a = d - nearestOnSegment(d, half) * half;
      w = -nearest.point_a;
    } else if constexpr (kSegmentB) {
      half = extent_b * column(S, 2);
      w = nearestOnSegment(d, half) * half - d;
    }
    nearest.apart = nearest.plane = std::sqrt(squared(w));
    const double per = 1 / nearest.apart;
    nearest.normal = per * w;
    // For a point the distance is that of the plane. For a segment, the normal of a short vector is
    // not perpendicular to it, and callers rely on the plane.
    if constexpr (kSegmentA || kSegmentB)
      nearest.plane = per * (-dot(w, d) - std::abs(dot(w, half)));
  }
  return answer({X_WA, X_WB, extent_a, extent_b, a.radius(), b.radius()}, nearest, request, cache,
                found);
}

/// The signed separation of a box or cylinder that is apart from a box, cylinder, sphere or
/// capsule. Returns false, with `result` unchanged, in the cases of answerSegments(), for other
/// shapes, and for a few pairs of features that no closed form covers. O(1).
bool answerBoxPair(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                   const DistanceRequest& request, PairCache* cache, DistanceResult& result);

}  // namespace leeway::collision
