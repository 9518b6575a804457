#pragma once

#include <cmath>

#include "collision/base/pose_check.h"
#include "collision/base/status.h"
#include "collision/base/tolerances.h"
#include "collision/convex/pairs/closed_form.h"
#include "collision/convex/pairs/simple_pairs.h"

namespace leeway::collision {

// How the nearest points of two cores become an answer, and the pairs that have no more to do than
// that: spheres and capsules. Inline, because a call costs as much as their arithmetic.

// Rounding, in units of u L with u = kUnitRoundoff and L >= extent A + extent B + |t|, of points
// and planes given the frames that they are made in: a box's frame, made with what kPoseRounding
// covers, or the world's axes. Points: halves 1 or 2 units, the translation 1, sums 3, their
// difference 1, its norm 3: less than 10; a box's point that is turned to the world's axes 3
// sqrt(3) of the extent instead of the halves: less than 14. Planes of segments: dot products 3,
// with a unit vector's own length 4 and three sums 3: less than 16; of boxes less than 22 (see
// box_overlap.cc). kClosedFormRounding covers all of them.

/// What a query knows of its pair besides the cores' nearest points.
struct PairFrame {
  const Pose& X_WA;
  const Pose& X_WB;
  double extent_a, extent_b;  // of the cores
  double radius_a, radius_b;
};

/// What an answer is made of: plain numbers, so that a result is written once and where the caller
/// wants it.
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
    // (Beside each other in memory: together they are written, and read, in one piece.)
    result.iterations = 1;
    result.triangle_a = -1;
  }
};

/// False when this does not do.
inline __attribute__((always_inline)) bool answer(const PairFrame& frame, const Nearest& nearest,
                                                  const DistanceRequest& request, PairCache* cache,
                                                  PairAnswer& answer) {
  const PoseCheck check = checkRotationsQuickly(frame.X_WA.rotation, frame.X_WB.rotation);
  const double radii = frame.radius_a + frame.radius_b;
  // |t| <= apart + both extents. (What waits for the root of `apart` is kept short.)
  const double share = check.departure + (kClosedFormRounding + kPoseRounding) * kUnitRoundoff;
  const double extents = 2 * (frame.extent_a + frame.extent_b);
  const double size = nearest.apart + extents;
  const double rounding = share * nearest.apart + (share * extents + 4 * kUnitRoundoff * radii);
  const Interval found = {(nearest.plane - radii) - rounding, (nearest.apart - radii) + rounding};
  // Written so that NaN fails; a translation that is not finite gives no finite size.
  if (!(check.rotations && nearest.apart > 64 * kUnitRoundoff * size &&
        size + radii >= kSmallestScale && size + radii <= kLargestScale)) {
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

/// The signed separation of two spheres or capsules that are apart (kSegment: a capsule), by closed
/// forms from the world poses: no view, search or simplex is made. False where a closed form is not
/// enough: cores that overlap or nearly do, sizes beyond the scale, tolerances below rounding, no
/// iteration allowed. The interval rests on points of both bodies and on a supporting plane, as
/// everywhere; how they were guessed is of no matter. Poses that are none give false. O(1).
///
/// Along the world's axes: neither frame is needed. After Lumelsky (1985); near parallel the points
/// can be poor, which the plane tells.
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
    // Both axes, side by side.
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
    // (Divided last, it need not wait for the root.)
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
    // From a point the distance itself errs by little; but the normal of a short way is not at a
    // right angle to the segment, and callers rely on the plane.
    if constexpr (kSegmentA || kSegmentB)
      nearest.plane = per * (-dot(w, d) - std::abs(dot(w, half)));
  }
  return answer({X_WA, X_WB, extent_a, extent_b, a.radius(), b.radius()}, nearest, request, cache,
                found);
}

/// The signed separation of two boxes or cylinders that are apart, or of one of them and a sphere
/// or capsule. False, with nothing written to `result`, where a closed form is not enough: as
/// answerSegments(), and for other shapes and a few features that meet in none of the ways that are
/// looked at.
bool answerBoxPair(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                   const DistanceRequest& request, PairCache* cache, DistanceResult& result);

}  // namespace leeway::collision
