#pragma once

// Shared by all searches for a time of contact: samples of the motion, and requests.

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"
#include "leeway/collision/time_of_contact.h"

namespace leeway::collision {

/// The result of a distance query at one time of the motion.
struct ContactSample {
  double t = 0;
  DistanceResult distance;  ///< widened by the rounding of the poses
  double closing = 0;       ///< closing speed of the witness points; for predictions only
  /// Separation along distance.normal, as separationAlong() would compute it; NaN if planes of that
  /// direction give no bound at later times.
  double plane = std::numeric_limits<double>::quiet_NaN();
  /// From t on, no two points of the bodies close faster than this.
  double speed = std::numeric_limits<double>::infinity();
};

inline bool isInContact(const ContactSample& sample, const ContactRequest& request) {
  return sample.distance.distance.upper <= request.margin;
}

/// Time for closing the gap at the sample's speed: a prediction, not a bound.
inline double timeToClose(double gap, const ContactSample& sample) {
  return sample.closing > 0 ? gap / sample.closing : std::numeric_limits<double>::infinity();
}

inline bool isInRange(const ContactRequest& request) {
  return request.time_tolerance > 0 && request.tolerance > 0 && request.end >= 0 &&
         request.end <= 1 && std::isfinite(request.margin);
}

/// The query of a sample. Without `depth`, a depth is requested only if the margin allows one.
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

/// Whether the normal is that of the bodies' nearest points: if their distance is known to within a
/// share, the cosine of the angle between the two is at least 1 minus that share.
inline bool hasNormal(const DistanceResult& result) {
  return result.distance.lower > 0 &&
         result.distance.lower >= (1 - kContactNormalShare) * result.distance.upper;
}

/// Sets the normal that ContactResult guarantees. At the time of a contact the bodies overlap, and
/// a query without a depth returns no normal; `before` is the last sample that may have one.
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
  // Farther back the gap is wider, so the same accuracy determines the direction better.
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
