#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/time_of_contact.h"
#include "leeway/collision/vertex_motion.h"

namespace leeway::collision {

/// Where a rigid body is at any time. Immutable; safe to use from many threads. Times [s], poses
/// X_WB. The counterpart of VertexMotion.
class PoseMotion {
 public:
  struct Key {
    double time = 0;  // [s]
    Pose X_WB;
  };

  /// The motion through key poses. Between two keys the body's origin moves on a straight line
  /// while the body turns about an axis, the shorter way, both at constant speed. Before the first
  /// key and after the last the body rests there. Throws InvalidMotion without keys, for times that
  /// do not increase, for numbers that are not finite or exceed 1e9, for a matrix that is not a
  /// rotation, and for two keys that are half a turn apart, within kHalfTurn: the way is not known
  /// then. O(keys).
  static std::shared_ptr<const PoseMotion> keys(std::vector<Key> keys);

  /// The motion at constant velocity that passes `at`: of the origin [m/s], and about an axis
  /// through the origin [rad/s], both in the world. It has no begin and no end. Throws
  /// InvalidMotion as keys() does.
  static std::shared_ptr<const PoseMotion> steady(const Key& at, const Eigen::Vector3d& velocity,
                                                  const Eigen::Vector3d& angular_velocity);

  /// The pose at `time`. Its rotation is orthogonal up to rounding(). NaN for a time that is not
  /// finite. Never throws or allocates. O(log keys).
  Pose pose(double time) const;
  /// No point within `reach` [m] of the body's origin is faster than this from t0 to t1, t0 <= t1
  /// [m/s]. Never throws or allocates. O(log keys + keys between).
  double speedBound(double t0, double t1, double reach) const;
  /// No point within `reach` of the origin, placed by pose() at a time from t0 to t1, is farther
  /// than this from its exact place [m]. Infinite where the body has turned by more than 1e5 rad
  /// since its key. Never throws or allocates. O(log keys + keys between).
  double rounding(double t0, double t1, double reach) const;

  bool isSteady() const { return is_steady_; }
  /// The arguments of keys() or steady(): the key poses (one for a steady motion), with rotations
  /// made orthogonal up to rounding, and the velocities of a steady motion [m/s], [rad/s]; zero for
  /// a motion with keys.
  const std::vector<Key>& keyPoses() const { return keys_; }
  const Eigen::Vector3d& velocity() const { return velocity_; }
  const Eigen::Vector3d& angularVelocity() const { return angular_velocity_; }

  /// Keys whose rotations are within this of half a turn are refused [rad].
  static constexpr double kHalfTurn = 1e-6;

 private:
  /// The motion from one key to the next.
  struct Stretch {
    Eigen::Vector3d start, velocity;  // of the origin [m], [m/s]
    AxisTurn turn;                    // whose parameter is the time since the key [s]
  };
  PoseMotion() = default;
  std::size_t stretchAt(double time) const;

  bool is_steady_ = false;
  std::vector<Key> keys_;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero(), angular_velocity_ = Eigen::Vector3d::Zero();
  std::vector<double> starts_;  // of the stretches [s]; the first also holds for earlier times
  std::vector<Stretch> stretches_;
};

}  // namespace leeway::collision
