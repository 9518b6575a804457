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

/// The query of a sample.
inline DistanceRequest sampleRequest(const ContactRequest& request, double tolerance) {
  DistanceRequest r;
  r.tolerance = tolerance;
  r.depth = request.margin < 0;
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

inline void widen(DistanceResult& result, double slack) {
  result.distance.lower -= slack;
  result.distance.upper += slack;
}

}  // namespace leeway::collision
