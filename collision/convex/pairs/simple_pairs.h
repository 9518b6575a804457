#pragma once

#include <limits>

#include "collision/base/triple.h"
#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Distances of the cores that decide the caller's threshold, with room for rounding [m]; NaN if
/// there is no threshold.
struct Goal {
  double above = std::numeric_limits<double>::quiet_NaN();  ///< farther is above the threshold
  double below = std::numeric_limits<double>::quiet_NaN();  ///< nearer is not above it
  bool asked() const { return above == above; }
};

/// Nearest points of two cores that are apart, and a plane between them, in a frame with B's
/// origin.
struct Nearest {
  Triple point_a;
  double apart = 0;  ///< distance of the two points: an upper end of the cores' distance [m]
  Triple normal;     ///< unit, from A to B
  double plane = 0;  ///< along `normal`, all of B is beyond all of A by this: the lower end [m]
  /// The search ended at a decided threshold: the vector from A's point to B's is `way`. Otherwise
  /// it is apart * normal, up to rounding.
  bool early = false;
  Triple way;

  Triple wayToB() const { return early ? way : apart * normal; }
  /// Ends a search early, at these points.
  void settle(const Triple& a, const Triple& to_b, const Triple& n, double plane_along_n) {
    point_a = a;
    way = to_b;
    apart = std::sqrt(squared(to_b));
    normal = n;
    plane = plane_along_n;
    early = true;
  }
};

/// Rotates from B's frame to the world's axes.
inline void toWorld(const Eigen::Matrix3d& R_WB, Nearest& nearest) {
  nearest.point_a = rotated(R_WB, nearest.point_a);
  nearest.normal = rotated(R_WB, nearest.normal);
  if (nearest.early) nearest.way = rotated(R_WB, nearest.way);
}

struct VertexStart;  // convex/hull_pairs.h

/// distance() without answerSegments(), answerBoxPair() and answerHullPair(). It is their fallback,
/// which for hulls continues from the end of a search (`start`), and their slow twin in tests.
DistanceResult generalDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                               const DistanceRequest& request, Scratch& scratch, PairCache* cache,
                               const VertexStart* start = nullptr);

}  // namespace leeway::collision
