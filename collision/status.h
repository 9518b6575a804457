#pragma once

#include "leeway/collision/distance.h"

namespace leeway::collision {

/// Is the request met by a threshold or by a proven overlap? How far exactly is not asked then.
inline bool isDecided(const Interval& distance, const DistanceRequest& request) {
  return distance.lower > request.threshold || distance.upper <= request.threshold ||
         (!request.depth && distance.upper <= 0);
}

/// Is it proven on which side of contact the bodies are?
inline bool isSignKnown(const Interval& distance) {
  return distance.lower > 0 || distance.upper <= 0;
}

/// What an interval is worth to a request.
inline DistanceStatus statusOf(const Interval& distance, const DistanceRequest& request) {
  if (distance.width() <= request.tolerance) return DistanceStatus::kConverged;
  if (distance.lower > request.threshold) return DistanceStatus::kAboveThreshold;
  if (distance.upper <= request.threshold) return DistanceStatus::kNotAboveThreshold;
  if (!request.depth && distance.upper <= 0) return DistanceStatus::kOverlap;
  return DistanceStatus::kLimit;
}

}  // namespace leeway::collision
