#pragma once

#include "leeway/collision/query.h"

namespace leeway::collision {

/// Conditions of a request that an interval meets, as bits.
enum Conditions : unsigned {
  kOverlapProven = 1,    ///< overlap is proven and no depth is requested
  kNotAboveProven = 2,   ///< upper <= threshold
  kAboveProven = 4,      ///< lower > threshold
  kWithinTolerance = 8,  ///< width <= tolerance
};

/// Branch-free: the outcomes are unpredictable.
inline unsigned conditionsMet(const Interval& distance, const DistanceRequest& request) {
  const auto if_so = [](bool so, Conditions bit) { return static_cast<unsigned>(so) * bit; };
  return if_so(!request.depth & (distance.upper <= 0), kOverlapProven) |
         if_so(distance.upper <= request.threshold, kNotAboveProven) |
         if_so(distance.lower > request.threshold, kAboveProven) |
         if_so(distance.width() <= request.tolerance, kWithinTolerance);
}

/// Whether a threshold or a proven overlap settles the request, however wide the interval is.
inline bool isDecided(const Interval& distance, const DistanceRequest& request) {
  return (conditionsMet(distance, request) & (kOverlapProven | kNotAboveProven | kAboveProven)) !=
         0;
}

/// Whether the bodies are proven apart or proven to touch or overlap.
inline bool isSignKnown(const Interval& distance) {
  return (distance.lower > 0) | (distance.upper <= 0);
}

/// The status of an answer with this interval; kLimit if it meets no condition.
inline DistanceStatus statusOf(const Interval& distance, const DistanceRequest& request) {
  using enum DistanceStatus;
  static constexpr DistanceStatus kStatusOf[16] = {
      kLimit,          kOverlap,        kNotAboveThreshold, kNotAboveThreshold,
      kAboveThreshold, kAboveThreshold, kAboveThreshold,    kAboveThreshold,
      kConverged,      kConverged,      kConverged,         kConverged,
      kConverged,      kConverged,      kConverged,         kConverged};
  return kStatusOf[conditionsMet(distance, request)];
}

}  // namespace leeway::collision
