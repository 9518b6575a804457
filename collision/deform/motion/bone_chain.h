#pragma once

#include <span>
#include <vector>

#include "collision/deform/motion/key_track.h"
#include "leeway/collision/pose.h"
#include "leeway/collision/vertex_motion.h"

namespace leeway::collision {

/// A hierarchy of bones, parents before children, with key poses interpolated in the parents'
/// frames.
class BoneChain {
 public:
  /// `motion` has been checked; its quaternions need not be unit vectors.
  BoneChain(const SkinnedMotion& motion, KeyTrack track);

  int count() const { return static_cast<int>(parents_.size()); }
  const KeyTrack& track() const { return track_; }

  /// Computes the bones' matrices X_MB(t) X_MB(rest)^-1 in the mesh's frame M: 12 numbers each, the
  /// rotation row by row, then the translation. Never allocates. O(bones).
  void skinningMatrices(double time, std::span<double> out) const;

  /// A point of the mesh at rest, in a bone's rest frame.
  Eigen::Vector3d inBone(int bone, const Eigen::Vector3d& rest) const;

  /// Bounds of speed [m/s] and acceleration [m/s^2] in a segment, for any point within reaches[b]
  /// of the origin of the bone b that it is fixed to. Bones with a negative reach carry no point.
  struct Rates {
    double speed, acceleration;
  };
  Rates rates(std::size_t segment, std::span<const double> reaches) const;

  /// A bound on how far rounding moves the image of a point within `reach` of the mesh's origin
  /// under a skinning matrix, applied in double precision [m].
  double rounding(double reach) const;

 private:
  struct Local {
    Eigen::Vector3d translation;
    Eigen::Vector4d quaternion;  // unit, x y z w
  };
  const Local& key(std::size_t key, std::size_t bone) const {
    return keys_[key * parents_.size() + bone];
  }
  Pose interpolated(const KeyPlace& place, std::size_t bone) const;

  KeyTrack track_;
  std::vector<int> parents_;
  std::vector<Pose> rest_inverse_;  // X_BM at rest
  std::vector<Local> keys_;         // key by key; quaternions of neighbours have a product >= 0
  double length_ = 0;               // largest sum of translations along a chain [m]
  int depth_ = 0;                   // bones in the longest chain
};

}  // namespace leeway::collision
