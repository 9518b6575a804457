#pragma once

// Private to collision/: the side of a closed surface on which a point lies, by the winding number.

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>

#include "collision/base/exact_predicates.h"
#include "collision/base/tolerances.h"
#include "collision/mesh/topology/cycles.h"

namespace leeway::collision {

/// The position of a point relative to a closed surface.
enum class Side : unsigned char { kOutside, kInside, kUnknown };

enum class Crossing : signed char { kIn = -1, kNone = 0, kOut = 1, kIrregular = 2 };

/// A winding number, or a sum of those of several cycles with their weights, modulo kCyclePrime.
class Winding {
 public:
  /// `weight` is below kCyclePrime. Irregular crossings are ignored.
  void add(Crossing crossing, std::uint64_t weight) {
    if (crossing == Crossing::kOut) sum_ += weight;
    if (crossing == Crossing::kIn) sum_ += kCyclePrime - weight;
    if (sum_ >= kCyclePrime) sum_ -= kCyclePrime;
  }
  bool isZero() const { return sum_ == 0; }

 private:
  std::uint64_t sum_ = 0;
};

/// A segment that decides inside or outside leaves the component's box by this share of its size,
/// and is tilted by multiples of it. This is enough to miss the edges and vertices of axis-aligned
/// parts at once.
inline constexpr double kSegmentTilt = 1.0 / 1024;

/// How the segment from p to a point q that is not on the triangle crosses the triangle: outwards,
/// inwards or not at all. Irregular if it meets an edge or a vertex, lies in the plane, or starts
/// on the triangle. Exact.
inline Crossing crossing(const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                         const Eigen::Vector3d* v) {
  const int side_p = orientation(v[0], v[1], v[2], p), side_q = orientation(v[0], v[1], v[2], q);
  if (side_p == side_q && side_p != 0) return Crossing::kNone;
  if (side_p == 0 && side_q == 0) {
    // The segment lies in the triangle's plane; or the triangle has no area and bounds nothing, so
    // its neighbours count.
    return collinear(v[0], v[1], v[2]) ? Crossing::kNone : Crossing::kIrregular;
  }
  int positive = 0, negative = 0;
  for (int k = 0; k < 3; ++k) {
    const int side = orientation(p, q, v[k], v[(k + 1) % 3]);
    positive += side > 0 ? 1 : 0;
    negative += side < 0 ? 1 : 0;
  }
  if (positive > 0 && negative > 0) return Crossing::kNone;
  if (positive + negative < 3) return Crossing::kIrregular;
  if (side_q == 0) return Crossing::kNone;       // the line meets the plane in q, off the triangle
  if (side_p == 0) return Crossing::kIrregular;  // p is on it
  return side_p < 0 ? Crossing::kOut : Crossing::kIn;
}

/// The side of a component within the box [low, high]. `winding_number(q, winding)` counts the
/// crossings of the segment from the point to q, outside the box; false if one is irregular.
template <class WindingNumber>
Side sideByWinding(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                   const Eigen::Vector3d& point, const WindingNumber& winding_number) {
  if (!((low.array() <= point.array()).all() && (point.array() <= high.array()).all()))
    return Side::kOutside;
  Eigen::Vector3d p = point;
  for (int k = 0; k < 3; ++k) {
    if (p[k] != 0 && std::abs(p[k]) < kSmallestExact)
      return Side::kUnknown;  // the predicates would not be exact
  }
  const Eigen::Vector3d size = high - low;
  const double tilt = kSegmentTilt * size.maxCoeff();
  // Segments nearly along an axis have thin boxes and meet few nodes. The shortest way out is tried
  // first.
  for (int attempt = 0; attempt < 4; ++attempt) {
    std::array<bool, 6> tried{};
    for (int turn = 0; turn < 6; ++turn) {
      int best = -1;
      double shortest = 0;
      for (int way = 0; way < 6; ++way) {
        if (tried[static_cast<std::size_t>(way)]) continue;
        const int axis = way / 2;
        const double length = way % 2 == 0 ? high[axis] - p[axis] : p[axis] - low[axis];
        if (best >= 0 && length >= shortest) continue;
        best = way;
        shortest = length;
      }
      tried[static_cast<std::size_t>(best)] = true;
      const int axis = best / 2;
      Eigen::Vector3d q = p;
      q[axis] = best % 2 == 0 ? high[axis] + tilt : low[axis] - tilt;
      q[(axis + 1) % 3] += tilt * (0.37 + attempt);
      q[(axis + 2) % 3] += tilt * (0.71 + attempt * attempt);
      Winding winding;
      if (winding_number(q, winding)) return winding.isZero() ? Side::kOutside : Side::kInside;
    }
  }
  return Side::kUnknown;
}

}  // namespace leeway::collision
