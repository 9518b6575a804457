#include "collision/deform/motion/bone_chain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/deform/motion/motion_input.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

double dot(const Vector4d& a, const Vector4d& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

// Scales first, because squares of tiny or huge numbers would under- or overflow.
Vector4d unit(const Vector4d& q) {
  const double largest = q.cwiseAbs().maxCoeff();
  const Vector4d scaled = q / largest;
  return scaled / std::sqrt(dot(scaled, scaled));
}

Eigen::Matrix3d matrix(const Vector4d& q) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  Eigen::Matrix3d R;
  R << 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),  //
      2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),   //
      2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y);
  return R;
}

// The product is written out, because the order of the sums must not depend on how Eigen is
// compiled.
Pose product(const Pose& a, const Pose& b) {
  Pose c;
  for (int k = 0; k < 3; ++k) {
    const Vector3d column(b.rotation(0, k), b.rotation(1, k), b.rotation(2, k));
    const Vector3d turned = rotated(a.rotation, column);
    for (int i = 0; i < 3; ++i) c.rotation(i, k) = turned[i];
  }
  c.translation = placed(a, b.translation);
  return c;
}

Pose inverse(const Pose& X) {
  return {X.rotation.transpose(), -rotatedBack(X.rotation, X.translation)};
}

double length(const Vector3d& v) { return std::sqrt(squaredLength(v)); }

}  // namespace

BoneChain::BoneChain(const SkinnedMotion& motion, KeyTrack track) : track_(std::move(track)) {
  std::vector<Pose> rest;
  std::vector<double> lengths;
  std::vector<int> depths;
  for (std::size_t b = 0; b < motion.bones.size(); ++b) {
    const SkinnedMotion::Bone& bone = motion.bones[b];
    const Pose local{matrix(unit(bone.rest.quaternion)), bone.rest.translation};
    const bool root = bone.parent < 0;
    const auto parent = static_cast<std::size_t>(root ? 0 : bone.parent);
    parents_.push_back(bone.parent);
    rest.push_back(root ? local : product(rest[parent], local));
    rest_inverse_.push_back(inverse(rest.back()));
    double longest = length(bone.rest.translation);
    for (const SkinnedMotion::Key& key : motion.keys)
      longest = std::max(longest, length(key.poses[b].translation));
    lengths.push_back(longest + (root ? 0 : lengths[parent]));
    depths.push_back(1 + (root ? 0 : depths[parent]));
    length_ = std::max(length_, lengths.back());
    depth_ = std::max(depth_, depths.back());
  }
  for (std::size_t i = 0; i < motion.keys.size(); ++i) {
    for (std::size_t b = 0; b < motion.bones.size(); ++b) {
      const SkinnedMotion::BonePose& pose = motion.keys[i].poses[b];
      Vector4d q = unit(pose.quaternion);
      // q and -q are the same rotation; selects the one with the shorter arc from the last key.
      if (i > 0 && dot(q, key(i - 1, b).quaternion) < 0) q = -q;
      keys_.push_back({pose.translation, q});
    }
  }
}

Pose BoneChain::interpolated(const KeyPlace& place, std::size_t bone) const {
  const Local& from = key(place.key, bone);
  if (!(place.share > 0)) return {matrix(from.quaternion), from.translation};
  const Local& to = key(place.key + 1, bone);
  const double s = place.share, r = 1 - s;
  Pose X;
  for (int k = 0; k < 3; ++k) X.translation[k] = r * from.translation[k] + s * to.translation[k];
  Vector4d q;
  for (int k = 0; k < 4; ++k) q[k] = r * from.quaternion[k] + s * to.quaternion[k];
  X.rotation = matrix(unit(q));  // |q|^2 >= 1/2: neighbours are at most a quarter turn apart
  return X;
}

void BoneChain::skinningMatrices(double time, std::span<double> out) const {
  const KeyPlace place = track_.at(time);
  // Computes X_MB(t) of all bones, parents first, then multiplies by X_MB(rest)^-1.
  for (std::size_t b = 0; b < parents_.size(); ++b) {
    Pose X = interpolated(place, b);
    if (parents_[b] >= 0) {
      const double* parent = out.data() + 12 * parents_[b];
      Pose X_MP;
      for (int k = 0; k < 9; ++k) X_MP.rotation(k / 3, k % 3) = parent[k];
      X_MP.translation = {parent[9], parent[10], parent[11]};
      X = product(X_MP, X);
    }
    for (int k = 0; k < 9; ++k)
      out[12 * b + static_cast<std::size_t>(k)] = X.rotation(k / 3, k % 3);
    for (int k = 0; k < 3; ++k) out[12 * b + 9 + static_cast<std::size_t>(k)] = X.translation[k];
  }
  for (std::size_t b = 0; b < parents_.size(); ++b) {
    double* numbers = out.data() + 12 * b;
    Pose X;
    for (int k = 0; k < 9; ++k) X.rotation(k / 3, k % 3) = numbers[k];
    X.translation = {numbers[9], numbers[10], numbers[11]};
    X = product(X, rest_inverse_[b]);
    for (int k = 0; k < 9; ++k) numbers[k] = X.rotation(k / 3, k % 3);
    for (int k = 0; k < 3; ++k) numbers[9 + k] = X.translation[k];
  }
}

Vector3d BoneChain::inBone(int bone, const Vector3d& rest) const {
  return placed(rest_inverse_[static_cast<std::size_t>(bone)], rest);
}

// clang-format off
// From a bone up to the root. A frame that turns with w (rate of change w') about an origin that moves
// with v (rate v') carries a point at distance r, which moves in it with V (rate A):
//   speed         <= v + w r + V
//   acceleration  <= v' + (w^2 + w') r + 2 w V + A
//   distance from the parent's origin <= |translation| + r
// The unit quaternion between two keys an angle h apart moves along their great circle by an angle a(s):
//   a' = sin h / |q|^2,  |q|^2 = 1 - 2 s (1 - s) (1 - cos h) >= cos^2(h / 2),
// so with T = tan(h / 2) = |q1 - q0| / |q1 + q0|
//   a' <= 2 T,  |a''| = sin h |d|q|^2 / ds| / |q|^4 <= 8 T^3,
// and the rotation turns by twice that angle: w <= 4 T s', w' <= 16 T^3 s'^2 + 4 T s''.
// clang-format on
BoneChain::Rates BoneChain::rates(std::size_t segment, std::span<const double> reaches) const {
  const double rate = track_.rate(segment), change = track_.rateChange(segment);
  Rates worst{0, 0};
  for (std::size_t bone = 0; bone < parents_.size(); ++bone) {
    if (reaches[bone] < 0) continue;
    double reach = reaches[bone], speed = 0, acceleration = 0;
    for (int b = static_cast<int>(bone); b >= 0; b = parents_[static_cast<std::size_t>(b)]) {
      const Local& from = key(segment, static_cast<std::size_t>(b));
      const Local& to = key(segment + 1, static_cast<std::size_t>(b));
      const double moved = length(to.translation - from.translation);
      const Vector4d difference = to.quaternion - from.quaternion,
                     sum = to.quaternion + from.quaternion;
      // Unit vectors are off by 8 units a coordinate, which 64 cover.
      const double tangent =
          std::sqrt(dot(difference, difference)) / std::sqrt(dot(sum, sum)) + 64 * kUnitRoundoff;
      const double turn = 4 * tangent * rate;
      const double turn_change =
          16 * tangent * tangent * tangent * rate * rate + 4 * tangent * change;
      acceleration += moved * change + (turn * turn + turn_change) * reach + 2 * turn * speed;
      speed += moved * rate + turn * reach;
      reach += std::max(length(from.translation), length(to.translation));
    }
    // A rate overflows if keys are very close. 0 times it is NaN, which is not a bound.
    worst.speed = std::max(worst.speed, speed >= 0 ? speed : kInfinity);
    worst.acceleration = std::max(worst.acceleration, acceleration >= 0 ? acceleration : kInfinity);
  }
  const double operations = 32.0 * depth_ + 32;
  return {roundedUp(worst.speed, operations), roundedUp(worst.acceleration, operations)};
}

// In units of kUnitRoundoff:
//   - a blended quaternion: sqrt(2) times the error of the share (16), three for the blend, over a
//     length of at least sqrt(1/2), and 6 to normalise it: 40;
//   - its rotation matrix, in norm: four times that and 12 roundings: 180;
//   - a product of two matrices adds 12.
// A skinning matrix consists of two chains of up to `depth` of these, and is applied once. Every
// length in them is at most the reach plus twice the chain's translations, each off by 40.
double BoneChain::rounding(double reach) const {
  return roundedUp(2 * (256.0 * depth_ + 64) * kUnitRoundoff * (reach + 2 * length_), 16);
}

}  // namespace leeway::collision
