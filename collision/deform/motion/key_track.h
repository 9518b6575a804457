#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "leeway/collision/vertex_motion.h"

namespace leeway::collision {

/// A time between keys: values are (1 - share) * value[key] + share * value[key + 1]. From the last
/// key on, the share is 0 and key + 1 must not be read.
struct KeyPlace {
  std::size_t key;
  double share;
};

/// Key times and the interpolation between them. Segment i is from key i to key i + 1.
class KeyTrack {
 public:
  /// `times` increases and is not empty [s].
  KeyTrack(std::vector<double> times, Interpolation interpolation);

  std::span<const double> times() const { return times_; }
  std::size_t segments() const { return times_.size() - 1; }

  /// The share is within kShareRounding * kUnitRoundoff of the exact one. O(log keys).
  KeyPlace at(double time) const;

  /// Interpolates between two rows, with one row for each key; a row has out.size() numbers. O(log
  /// keys).
  void blend(std::span<const std::vector<double>> rows, double time, std::span<double> out) const;

  /// Bounds of |ds/dt| [1/s] and |d2s/dt2| [1/s^2] within a segment, where s is the share, rounded
  /// up; the second is exactly 0 for kLinear.
  double rate(std::size_t segment) const;
  double rateChange(std::size_t segment) const;

  /// The largest entry among the segments that intersect [t0, t1]; 0 before the first key and after
  /// the last; infinite unless t0 <= t1.
  double largest(std::span<const double> of_segments, double t0, double t1) const;
  /// Whether speed may jump strictly between t0 and t1.
  bool jumps(double t0, double t1) const;

 private:
  std::vector<double> times_;
  Interpolation interpolation_;
};

}  // namespace leeway::collision
