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

/// Where a frame F on a link is along an edge, seen from a base B: another link, or the world. Has
/// buffers: one thread at a time. Allocates in the
/// constructor and where an edge is the first.
class FrameMotion {
 public:
  /// A frame that planned variables move. `base`: a link; -1: the world. O(joints^2).
  FrameMotion(const CompiledScene& scene, int link, const robots::Pose& X_LF, int base = -1);
  /// The same in a space, other variables as in `configuration`.
  FrameMotion(const ConfigurationSpace& space, std::vector<double> configuration, int link,
              const robots::Pose& X_LF, int base = -1);

  /// X_BF, the frame's pose seen from the base. O(joints).
  robots::Pose poseAt(std::span<const double> point);

  /// Begins with the edge from a to b, which must stay as they are until the last question.
  void begin(std::span<const double> a, std::span<const double> b);
  /// X_BF at t of the edge. O(joints).
  robots::Pose poseAt(double t);
  /// Bounds for any point of the edge between t0 and t1. The origin leaves the chord by at most
  /// A h^2 / 8, h = t1 - t0 and A its acceleration. So do the ends of unit vectors, whose
  /// acceleration is at most 1.5 W^2, where W is the sum of the joints' turns: |alpha| <= W^2 / 2
  /// as each joint's axis is turned by those below it, and |omega|^2 <= W^2. O(joints).
  ChordDeparture departure(double t0, double t1);
  /// A bound on the speed of the frame's origin anywhere on the edge, for t from 0 to 1 [m], from
  /// one for each of `parts`. O(joints * parts).
  double speed(int parts);
  /// Bounds how far the frame moves, from any configuration, if joints move by `difference`: its
  /// origin, and ends of unit vectors fixed to it. Ends the question about an edge. O(joints).
  ChordDeparture reach(std::span<const double> difference);
  /// Bound on rounding in all of these: of lengths [m], and relative to a unit vector.
  ChordDeparture rounding() const;

 private:
  const ConfigurationSpace* space_;
  int link_, base_;
  robots::Pose X_LF_;
  double size_ = 0;  ///< farthest coordinates that poses are computed from [m]
  robots::RelativeMotion motion_;
  std::vector<int> chain_, joints_;
  void move(std::span<const double> difference);

  std::span<const double> a_, b_;
  std::vector<double> dq_, variables_dq_, point_, q_;
  std::vector<robots::JointMotion> moved_;
  std::vector<robots::Pose> X_WL_;
  double turns_ = 0;
};

}  // namespace leeway::planner
