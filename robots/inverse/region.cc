#include "robots/inverse/region.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "collision/base/numbers.h"
#include "collision/base/pose_check.h"
#include "collision/base/sine_cosine.h"
#include "robots/inverse/arc_tangent.h"

namespace leeway::robots {

namespace {

using collision::kTwoPi;

/// Sweeps over three angles. Near a pitch of pi/2 they gain little and leave the angle to the
/// nearest rotation too large.
constexpr int kRotationSweeps = 12;

bool isFull(const std::pair<double, double>& range) { return range.second - range.first >= kTwoPi; }
bool isExact(const std::pair<double, double>& range) { return range.first == range.second; }

/// Rotation about coordinate axis k.
Eigen::Matrix3d turnAbout(int k, double angle) {
  double s, c;
  collision::sineCosine(angle, s, c);
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R(i, i) = R(j, j) = c;
  R(j, i) = s;
  R(i, j) = -s;
  return R;
}

struct NearestRotation {
  Eigen::Vector3d angles;
  std::array<bool, 3> inside;
  Eigen::Vector3d turn;  ///< from the rotation of the angles to R
};

/// Finds angles in the ranges whose rotation is near R, from `start`: each sweep sets one angle
/// after the other to its best value while the others stay. The trace of R^T Rz Ry Rx is A cos + B
/// sin + C in each angle. The trace is not used for a decision, because it cannot distinguish
/// angles below 1e-8 from 0.
NearestRotation descend(const PreparedRegion& region, const Eigen::Matrix3d& R,
                        const Eigen::Vector3d& start) {
  NearestRotation best;
  bool all_inside = true;
  for (int k = 0; k < 3; ++k) {
    bool& inside = best.inside[at(k)];
    best.angles(k) = nearestAngle(start(k), region.rpy[at(k)], inside);
    all_inside = all_inside && inside;
  }
  double moved = all_inside ? 0 : 1;
  for (int sweep = 0; sweep < kRotationSweeps && moved > 1e-13; ++sweep) {
    moved = 0;
    for (int k = 0; k < 3; ++k) {
      const auto& range = region.rpy[at(k)];
      if (isExact(range)) continue;
      const auto traceAt = [&](double angle) {
        Eigen::Vector3d a = best.angles;
        a(k) = angle;
        return R.cwiseProduct(rotationOf(a)).sum();
      };
      // A + C, C - A and B + C.
      const double t0 = traceAt(0), t1 = traceAt(std::numbers::pi),
                   t2 = traceAt(std::numbers::pi / 2);
      const double c = (t0 + t1) / 2;
      const double angle = nearestAngle(arcTangent(t2 - c, t0 - c), range, best.inside[at(k)]);
      moved = std::max(moved, std::fabs(angle - best.angles(k)));
      best.angles(k) = angle;
    }
  }
  best.turn = rotationVector(R * rotationOf(best.angles).transpose());
  return best;
}

/// Each rotation has two triples of angles; returns the one that is closer after descent.
NearestRotation nearestRotation(const PreparedRegion& region, const Eigen::Matrix3d& R) {
  const double pi = std::numbers::pi;
  const Eigen::Vector3d angles = rollPitchYaw(R);
  const NearestRotation first = descend(region, R, angles);
  if (first.turn.squaredNorm() < 1e-24) return first;
  const NearestRotation second =
      descend(region, R, {angles(0) + pi, pi - angles(1), angles(2) + pi});
  return second.turn.squaredNorm() < first.turn.squaredNorm() ? second : first;
}

/// The quaternion xyzw of R, with the largest component positive (Shepperd 1978).
Eigen::Vector4d quaternionOf(const Eigen::Matrix3d& R) {
  const double trace = (R(0, 0) + R(1, 1)) + R(2, 2);
  const double all[4] = {R(0, 0), R(1, 1), R(2, 2), trace};
  const int k = static_cast<int>(std::max_element(all, all + 4) - all);
  Eigen::Vector4d q;
  if (k == 3) {
    const double w = 1 + trace;  // 4 w^2
    q << R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1), w;
  } else {
    const int i = k, j = (k + 1) % 3, l = (k + 2) % 3;
    q(i) = 1 + 2 * R(i, i) - trace;
    q(j) = R(j, i) + R(i, j);
    q(l) = R(l, i) + R(i, l);
    q(3) = R(l, j) - R(j, l);
  }
  return q / std::sqrt(q.squaredNorm());
}

}  // namespace

double nearestAngle(double angle, const std::pair<double, double>& range, bool& inside) {
  if (isExact(range)) {
    inside = false;
    return range.first;
  }
  // The first equal angle that is not below the lower end.
  const double turned = angle - kTwoPi * std::floor((angle - range.first) / kTwoPi);
  inside = turned <= range.second;
  if (inside) return std::max(turned, range.first);
  return turned - range.second <= range.first + kTwoPi - turned ? range.second : range.first;
}

Eigen::Vector3d rollPitchYaw(const Eigen::Matrix3d& R) {
  const double across = std::sqrt(R(0, 0) * R(0, 0) + R(1, 0) * R(1, 0));
  const double pitch = arcTangent(-R(2, 0), across);
  if (!(across > 1e-12))  // the entries that distinguish roll from yaw are rounding
    return {0, pitch, arcTangent(-R(0, 1), R(1, 1))};
  return {arcTangent(R(2, 1), R(2, 2)), pitch, arcTangent(R(1, 0), R(0, 0))};
}

Eigen::Matrix3d rotationOf(const Eigen::Vector3d& angles) {
  double sr, cr, sp, cp, sy, cy;
  collision::sineCosine(angles(0), sr, cr);
  collision::sineCosine(angles(1), sp, cp);
  collision::sineCosine(angles(2), sy, cy);
  Eigen::Matrix3d R;
  R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,   //
      -sp, cp * sr, cp * cr;
  return R;
}

Eigen::Vector3d rotationVector(const Eigen::Matrix3d& R) {
  Eigen::Vector4d q = quaternionOf(R);
  if (q(3) < 0) q = -q;
  const Eigen::Vector3d v = q.head<3>();
  const double sine = std::sqrt(v.squaredNorm());
  if (!(sine > 1e-150)) return Eigen::Vector3d::Zero();
  return (2 * arcTangent(sine, q(3)) / sine) * v;
}

PreparedRegion::PreparedRegion(const PoseRegion& region)
    : position(region.position), rpy(region.rpy) {
  exact_turn = isExact(rpy[0]) && isExact(rpy[1]) && isExact(rpy[2]);
  any_turn = isFull(rpy[0]) && isFull(rpy[1]) && isFull(rpy[2]);
  target = exact_turn ? rotationOf({rpy[0].first, rpy[1].first, rpy[2].first})
                      : Eigen::Matrix3d::Identity();
}

RegionError regionError(const PreparedRegion& region, const Pose& X_RF) {
  RegionError error;
  for (int k = 0; k < 3; ++k) {
    const auto& [low, high] = region.position[at(k)];
    const double p = X_RF.translation(k);
    error.position(k) = p < low ? p - low : p > high ? p - high : p - p;  // NaN stays NaN
    error.free_position[at(k)] = p > low && p < high;
  }
  if (region.any_turn) {
    error.free_turns = 3;
    for (int k = 0; k < 3; ++k) error.free_axis[at(k)] = Eigen::Vector3d::Unit(k);
    return error;
  }
  if (region.exact_turn) {
    error.turn = rotationVector(X_RF.rotation * region.target.transpose());
    return error;
  }
  const NearestRotation nearest = nearestRotation(region, X_RF.rotation);
  error.turn = nearest.turn;
  // Yaw turns about z, pitch about the turned y, roll about the frame's own x.
  for (int k = 2; k >= 0; --k) {
    if (!nearest.inside[at(k)]) continue;
    Eigen::Vector3d axis = k == 2   ? Eigen::Vector3d(Eigen::Vector3d::UnitZ())
                           : k == 1 ? Eigen::Vector3d(turnAbout(2, nearest.angles(2)).col(1))
                                    : Eigen::Vector3d(rotationOf(nearest.angles).col(0));
    for (int i = 0; i < error.free_turns; ++i) {
      const Eigen::Vector3d& other = error.free_axis[at(i)];
      axis -= axis.dot(other) * other;
    }
    const double length = std::sqrt(axis.squaredNorm());
    if (length > 1e-6) error.free_axis[at(error.free_turns++)] = axis / length;
  }
  return error;
}

namespace {

std::string shown(double x) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, x).ptr};
}

bool isRigid(const Pose& X) { return collision::isPose(X) && X.rotation.determinant() > 0; }

}  // namespace

std::optional<std::string> regionFault(const Model& model, const PoseRegion& region) {
  if (region.link < 0 || at(region.link) >= model.links.size())
    return "link is " + std::to_string(region.link) + "; a link of the model, 0 to " +
           std::to_string(static_cast<int>(model.links.size()) - 1) + ", is expected";
  if (region.base < -1 || region.base >= static_cast<int>(model.links.size()) ||
      region.base == region.link)
    return "base is " + std::to_string(region.base) +
           "; another link of the model, or -1 for the world, is expected";
  if (!isRigid(region.X_LF) || !isRigid(region.X_WR))
    return "a frame is not finite, or its matrix is no rotation; an orthonormal, right-handed one "
           "is expected";
  for (const auto& [ranges, what] : {std::pair(&region.position, "position"), {&region.rpy, "rpy"}})
    for (const auto& [from, to] : *ranges)
      if (!(from <= to) || !std::isfinite(from) || !std::isfinite(to))
        return std::string(what) + " from " + shown(from) + " to " + shown(to) +
               "; a finite range, lower end first, is expected";
  for (const auto& [tolerance, what] : {std::pair(region.position_tolerance, "position_tolerance"),
                                        {region.angle_tolerance, "angle_tolerance"}})
    if (!(tolerance >= kLeastPoseTolerance) || !std::isfinite(tolerance))
      return std::string(what) + " is " + shown(tolerance) + "; at least " +
             shown(kLeastPoseTolerance) + ", which rounding comes near, is expected";
  return std::nullopt;
}

PoseError poseError(const PoseRegion& region, const Pose& X_WL) {
  const PreparedRegion prepared(region);
  const RegionError error = regionError(prepared, region.X_WR.inverse() * (X_WL * region.X_LF));
  return {std::sqrt(error.position.squaredNorm()), std::sqrt(error.turn.squaredNorm())};
}

PoseRegion PoseRegion::exact(int link, const Pose& X_LF, const Pose& X_WR, const Pose& X_RF) {
  PoseRegion region;
  region.link = link;
  region.X_LF = X_LF;
  // Angles are less exact than a rotation: near a pitch of 90 degrees they are 1e-7 off.
  region.X_WR = X_WR * X_RF;
  region.position.fill({0, 0});
  region.rpy.fill({0, 0});
  return region;
}

}  // namespace leeway::robots
