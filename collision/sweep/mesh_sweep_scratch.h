#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <type_traits>

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
    Pose away;          ///< (X_BA1 - X_BA0) / 2: displacement from the middle; not a rotation
    Pose boxes_half, boxes_away;  ///< the same for boxes, in their coordinates (MeshBody::origin())
    Pose X_BM;                    ///< a rigid placement close to boxes_half, with its origin
    Pose X_MB;
    double turn = 0;       ///< |away v| + |half v - X_BM v| <= turn |v|, by their rotations alone
    double growth = 0;     ///< distance of points from their chords [m]
    double slack = 0;      ///< rounding of the poses: how far it moves points [m]
    double box_slack = 0;  ///< the same for boxes
    BoxSweep of_node;      ///< of boxes of A, in M
  };

  static constexpr int kStretches = 32;
  using Stretches = std::array<Stretch, kStretches>;

  /// Begins a sweep: all stretches are without an interval.
  Stretches& begin() {
    // Constructed at the first sweep, because few threads sweep meshes, and 20 kB take a tenth of
    // the time of making a certifier.
    if (!constructed_) std::construct_at(&room_.stretches);
    constructed_ = true;
    for (Stretch& s : room_.stretches) s.time.level = -1;
    return room_.stretches;
  }

 private:
  union Room {
    Room() : none() {}  // constructs no stretches
    char none;
    Stretches stretches;
  };
  static_assert(std::is_trivially_destructible_v<Stretches>);
  Room room_;
  bool constructed_ = false;
};

}  // namespace leeway::collision
