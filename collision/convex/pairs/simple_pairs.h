#pragma once

#include <limits>

#include "collision/base/triple.h"
#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Distances of the cores that decide the caller's threshold, with room for rounding; NaN: there is
/// none [m].
struct Goal {
  double above = std::numeric_limits<double>::quiet_NaN();
  double below = std::numeric_limits<double>::quiet_NaN();
  bool asked() const { return above == above; }
};

/// Two points of two cores that are apart, A's and B's, and a plane between the cores. In a frame
/// whose origin is B's.
struct Nearest {
  Triple point_a;
  double apart = 0;  ///< distance of the two points: an upper end of the cores' distance [m]
  Triple normal;     ///< unit, from A to B
  double plane = 0;  ///< along `normal` every point of B is beyond every one of A by this much [m]
  /// False: the way between the points is apart * normal, or next to it. True: it is `way`, because
  /// the search ended when a threshold was decided.
  bool early = false;
  Triple way;

  Triple wayToB() const { return early ? way : apart * normal; }
  /// Ends a search on these points.
  void settle(const Triple& a, const Triple& to_b, const Triple& n, double plane_along_n) {
    point_a = a;
    way = to_b;
    apart = std::sqrt(squared(to_b));
    normal = n;
    plane = plane_along_n;
    early = true;
  }
};

/// From B's frame to the world's axes.
inline void toWorld(const Eigen::Matrix3d& R_WB, Nearest& nearest) {
  nearest.point_a = rotated(R_WB, nearest.point_a);
  nearest.normal = rotated(R_WB, nearest.normal);
  if (nearest.early) nearest.way = rotated(R_WB, nearest.way);
}

struct VertexStart;  // simd/hull_pairs.h

/// distance() without answerSegments(), answerBoxPair() and answerHullPair(): their slow twin,
/// and what they go on to, for hulls from where a search has ended.
DistanceResult generalDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                               const DistanceRequest& request, Scratch& scratch, PairCache* cache,
                               const VertexStart* start = nullptr);

}  // namespace leeway::collision
