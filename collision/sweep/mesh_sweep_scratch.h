#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "collision/base/vector.h"
#include "collision/mesh/descent/box_gaps.h"

namespace leeway::collision {

/// The data of sweepMesh() in a Scratch.
struct SweepScratch {
  /// The interval [number, number + 1] / 2^level of the motion.
  struct Time {
    std::int32_t level, number;

    double begin() const { return std::ldexp(number, -level); }
    double length() const { return std::ldexp(1.0, -level); }
  };

  /// A's motion over an interval, in B's axes: a point v of A stays within growth + slack of the
  /// segment from half v - away v to half v + away v.
  struct Stretch {
    Time time{-1, 0};
    Pose X_BA0, X_BA1;  ///< at both ends, as given
    Pose half;          ///< their mean; not a rotation
    Pose X_BM;          ///< a rigid placement close to `half`, with its origin
    Pose X_MB;
    Pose away;          ///< (X_BA1 - X_BA0) / 2: displacement from the middle; not a rotation
    double turn = 0;    ///< |away v| + |half v - X_BM v| <= turn |v|, by their rotations alone
    double growth = 0;  ///< distance of points from their chords [m]
    double slack = 0;   ///< rounding of the poses: how far it moves points [m]
    BoxSweep of_node;   ///< of boxes of A, in M
  };

  static constexpr int kStretches = 32;
  std::array<Stretch, kStretches> stretches;
};

}  // namespace leeway::collision
