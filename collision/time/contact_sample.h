#pragma once

// What every search for a time of contact shares: samples of the motion, and requests.

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"
#include "leeway/collision/time_of_contact.h"

namespace leeway::collision {

/// What a distance query tells of one time of the motion.
struct ContactSample {
  double t = 0;
  DistanceResult distance;  ///< widened by the rounding of the poses
  double closing = 0;       ///< closing speed of the witness points; for predictions only
  /// Separation along distance.normal, as separationAlong() would give it; NaN where planes of that
  /// direction bound nothing later.
  double plane = std::numeric_limits<double>::quiet_NaN();
  /// From t on no two points of the bodies close faster.
  double speed = std::numeric_limits<double>::infinity();
};

inline bool isInContact(const ContactSample& sample, const ContactRequest& request) {
  return sample.distance.distance.upper <= request.margin;
}

/// Time that the gap takes to close at the sample's speed: a prediction, not a bound.
inline double timeToClose(double gap, const ContactSample& sample) {
  return sample.closing > 0 ? gap / sample.closing : std::numeric_limits<double>::infinity();
}

inline bool isInRange(const ContactRequest& request) {
  return request.time_tolerance > 0 && request.tolerance > 0 && request.end >= 0 &&
         request.end <= 1 && std::isfinite(request.margin);
}

/// The query of a sample. Without `depth` it has one only where the margin allows some.
inline DistanceRequest sampleRequest(const ContactRequest& request, double tolerance, bool depth) {
  DistanceRequest r;
  r.tolerance = tolerance;
  r.depth = depth || request.margin < 0;
  return r;
}

/// The query of a sweep over a part of the motion.
inline DistanceRequest sweepRequest(const ContactRequest& request) {
  DistanceRequest r;
  r.tolerance = kDefaultTolerance;
  r.threshold = request.margin;
  r.depth = false;
  return r;
}

/// Whether the normal is that of the bodies' nearest points: where their distance is known to
/// within a share, the angle between the two has a cosine of at least 1 less that share.
inline bool hasNormal(const DistanceResult& result) {
  return result.distance.lower > 0 &&
         result.distance.lower >= (1 - kContactNormalShare) * result.distance.upper;
}

/// Gives a result the normal that ContactResult promises. At the time of a contact the bodies
/// overlap, and a query that is not asked for a depth knows no normal; `before` is the last sample
/// that may have one.
template <typename Problem>
void settleNormal(Problem& problem, const ContactRequest& request, const ContactSample& before,
                  ContactResult& result) {
  Eigen::Vector3d& normal = result.distance.normal;
  if (request.margin < 0 || hasNormal(result.distance)) return;
  if (result.status != ContactStatus::kContact) {
    if (!(result.distance.distance.lower > 0)) normal.setZero();
    return;
  }
  if (hasNormal(before.distance)) {
    normal = before.distance.normal;
    return;
  }
  // Farther back the gap is wider, and the same accuracy says more of its direction.
  for (const double back : {0.0, 4.0, 64.0}) {
    const double t = result.time.lower - back * request.time_tolerance;
    if (!(t >= 0) || result.queries >= request.query_limit) break;
    ++result.queries;
    const ContactSample s = problem.sample(t, request.tolerance, false);
    if (!hasNormal(s.distance)) continue;
    normal = s.distance.normal;
    return;
  }
  normal.setZero();
  if (!problem.hasDepth() || result.queries >= request.query_limit) return;
  ++result.queries;
  normal = problem.sample(result.time.upper, request.tolerance, true).distance.normal;
}

inline void widen(DistanceResult& result, double slack) {
  result.distance.lower -= slack;
  result.distance.upper += slack;
}

}  // namespace leeway::collision
