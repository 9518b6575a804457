#pragma once

#include "leeway/collision/query.h"

namespace leeway::collision {

/// What an interval tells of a request, in one number: which of these hold nobody can foretell, and
/// each would be a branch.
enum Tells : unsigned {
  kTellsOverlap = 1,   ///< proven, and no depth was asked
  kTellsNotAbove = 2,  ///< the threshold
  kTellsAbove = 4,
  kTellsNarrow = 8,  ///< width within the tolerance
};
inline unsigned whatTells(const Interval& distance, const DistanceRequest& request) {
  const auto if_so = [](bool so, Tells tells) { return static_cast<unsigned>(so) * tells; };
  return if_so(!request.depth & (distance.upper <= 0), kTellsOverlap) |
         if_so(distance.upper <= request.threshold, kTellsNotAbove) |
         if_so(distance.lower > request.threshold, kTellsAbove) |
         if_so(distance.width() <= request.tolerance, kTellsNarrow);
}

/// Is the request met by a threshold or by a proven overlap? How far exactly is not asked then.
inline bool isDecided(const Interval& distance, const DistanceRequest& request) {
  return (whatTells(distance, request) & (kTellsOverlap | kTellsNotAbove | kTellsAbove)) != 0;
}

/// Is it proven on which side of contact the bodies are?
inline bool isSignKnown(const Interval& distance) {
  return (distance.lower > 0) | (distance.upper <= 0);
}

/// What an interval is worth to a request.
inline DistanceStatus statusOf(const Interval& distance, const DistanceRequest& request) {
  using enum DistanceStatus;
  static constexpr DistanceStatus kWorth[16] = {
      kLimit,          kOverlap,        kNotAboveThreshold, kNotAboveThreshold,
      kAboveThreshold, kAboveThreshold, kAboveThreshold,    kAboveThreshold,
      kConverged,      kConverged,      kConverged,         kConverged,
      kConverged,      kConverged,      kConverged,         kConverged};
  return kWorth[whatTells(distance, request)];
}

}  // namespace leeway::collision
