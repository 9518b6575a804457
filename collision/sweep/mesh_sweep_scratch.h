#pragma once

// Private to collision/: what sweepMesh() keeps in a Scratch.

#include <array>
#include <cmath>
#include <cstdint>

#include "collision/base/vector.h"
#include "collision/mesh/descent/box_gaps.h"

namespace leeway::collision {

struct SweepScratch {
  /// A part [number, number + 1] / 2^level of the motion.
  struct Time {
    std::int32_t level, number;

    double begin() const { return std::ldexp(number, -level); }
    double length() const { return std::ldexp(1.0, -level); }
  };

  /// What A does over it, in B's axes. A point v is within growth + slack of a segment that passes
  /// by half v halfway and goes as far as away v to either side.
  struct Stretch {
    Time time{-1, 0};
    Pose X_BA0, X_BA1;  ///< as they were told
    Pose half;          ///< their mean; no rotation
    Pose X_BM;          ///< a rigid placement near it, with the same origin
    Pose X_MB;
    Pose away;          ///< v's way from halfway to the end; no rotation
    double turn = 0;    ///< of away and half - X_BM, the rotations together stretch v so much
    double growth = 0;  ///< [m]
    double slack = 0;   ///< how far rounding of poses moves points besides [m]
    BoxSweep of_node;   ///< boxes of A in M
  };

  static constexpr int kStretches = 32;
  std::array<Stretch, kStretches> stretches;
};

}  // namespace leeway::collision
