#pragma once

#include <span>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/robots/motion_bound.h"

namespace leeway::planner {

/// How far a frame departs, over a part of an edge, from the chord of its places at both ends.
struct ChordDeparture {
  double origin = 0;  ///< of its origin [m]
  double tips = 0;    ///< of the ends of unit vectors fixed to it, from its rotation alone
};

/// Where a frame on a link is along an edge. Has buffers: one thread at a time. Allocates in the
/// constructor and where an edge is the first.
class FrameMotion {
 public:
  /// A frame that planned variables move. O(joints^2).
  FrameMotion(const CompiledScene& scene, int link, const robots::Pose& X_LF);

  /// The frame's pose in the world. O(joints).
  robots::Pose poseAt(std::span<const double> point);

  /// Begins with the edge from a to b, which must stay as they are until the last question.
  void begin(std::span<const double> a, std::span<const double> b);
  /// The frame's pose at t of the edge. O(joints).
  robots::Pose poseAt(double t);
  /// Bounds for any point of the edge between t0 and t1. The origin leaves the chord by at most
  /// A h^2 / 8, h = t1 - t0 and A its acceleration. So do the ends of unit vectors, whose
  /// acceleration is at most 1.5 W^2, where W is the sum of the joints' turns: |alpha| <= W^2 / 2
  /// as each joint's axis is turned by those below it, and |omega|^2 <= W^2. O(joints).
  ChordDeparture departure(double t0, double t1);
  /// Bound on rounding in all of these: of lengths [m], and relative to a unit vector.
  ChordDeparture rounding() const;

 private:
  const CompiledScene* scene_;
  int link_;
  robots::Pose X_LF_;
  robots::RelativeMotion motion_;
  std::vector<int> chain_, joints_;
  std::span<const double> a_, b_;
  std::vector<double> dq_, variables_dq_, point_, q_;
  std::vector<robots::JointMotion> moved_;
  std::vector<robots::Pose> X_WL_;
  double turns_ = 0;
};

}  // namespace leeway::planner
