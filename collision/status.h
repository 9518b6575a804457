#pragma once

#include "leeway/collision/distance.h"

namespace leeway::collision {

/// Is the request met by a threshold or by a proven overlap? How far exactly is not asked then.
inline bool isDecided(const Interval& distance, const DistanceRequest& request) {
  // (All of these in one: which of them holds is not foreseen.)
  return (distance.lower > request.threshold) | (distance.upper <= request.threshold) |
         (!request.depth & (distance.upper <= 0));
}

/// Is it proven on which side of contact the bodies are?
inline bool isSignKnown(const Interval& distance) {
  return (distance.lower > 0) | (distance.upper <= 0);
}

/// What an interval is worth to a request.
inline DistanceStatus statusOf(const Interval& distance, const DistanceRequest& request) {
  using enum DistanceStatus;
  DistanceStatus status = (!request.depth & (distance.upper <= 0)) ? kOverlap : kLimit;
  status = distance.upper <= request.threshold ? kNotAboveThreshold : status;
  status = distance.lower > request.threshold ? kAboveThreshold : status;
  return distance.width() <= request.tolerance ? kConverged : status;
}

}  // namespace leeway::collision
