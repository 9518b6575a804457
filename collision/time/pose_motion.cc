#include "leeway/collision/pose_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "collision/base/greatest.h"
#include "collision/base/numbers.h"
#include "collision/base/pose_check.h"
#include "collision/base/tolerances.h"
#include "collision/deform/motion/motion_input.h"

namespace leeway::collision {
namespace {

/// Up to here sineCosine() is proven to round as rounding() assumes [rad].
constexpr double kLargestTurn = 1e5;

void requireNumber(bool holds, const std::string& what) {
  if (!holds) throw InvalidMotion(what);
}

bool isSmall(double x) { return std::abs(x) <= kLargestSize; }
bool isSmall(const Eigen::Vector3d& v) { return (v.array().abs() <= kLargestSize).all(); }

/// Returns the key with its rotation made orthogonal, so that motions meet at keys.
PoseMotion::Key checked(PoseMotion::Key key, const std::string& where) {
  const std::string limit = "; finite numbers up to 1e9 are expected";
  requireNumber(isSmall(key.time), where + ".time is " + shown(key.time) + " s" + limit);
  requireNumber(isSmall(key.X_WB.translation), where + ": the position is out of range" + limit);
  requireNumber(isPose(key.X_WB) && key.X_WB.rotation.determinant() > 0,
                where + ": the orientation is not a rotation; a right-handed one is expected");
  key.X_WB.rotation = Eigen::Quaterniond(key.X_WB.rotation).normalized().toRotationMatrix();
  return key;
}

}  // namespace

std::shared_ptr<const PoseMotion> PoseMotion::keys(std::vector<Key> keys) {
  requireNumber(!keys.empty(), "keys is empty; at least one is expected");
  const std::shared_ptr<PoseMotion> motion(new PoseMotion());
  const auto where = [](std::size_t i) { return "keys[" + std::to_string(i) + "]"; };
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keys[i] = checked(keys[i], where(i));
    const Pose& X = keys[i].X_WB;
    motion->starts_.push_back(keys[i].time);
    motion->stretches_.push_back({X.translation, Eigen::Vector3d::Zero(),
                                  AxisTurn(X.rotation, Eigen::Vector3d::UnitZ(), 0)});
    if (i == 0) continue;
    const Key& before = keys[i - 1];
    const double duration = keys[i].time - before.time;
    requireNumber(duration > 0, where(i) +
                                    ".time is not after that of the key before; times that "
                                    "increase are expected");
    const AxisTurn turn(before.X_WB.rotation, X.rotation);
    requireNumber(turn.angle() < std::numbers::pi - kHalfTurn,
                  where(i) +
                      " is half a turn from the key before, and may be reached either way; "
                      "a key between them is expected");
    Stretch& stretch = motion->stretches_[i - 1];
    stretch.velocity = (X.translation - before.X_WB.translation) / duration;
    stretch.turn = AxisTurn(before.X_WB.rotation, turn.axis(), turn.angle() / duration);
    requireNumber(isSmall(stretch.velocity) && isSmall(stretch.turn.angle()),
                  where(i) + " is too soon after the key before; speeds up to 1e9 are expected");
  }
  motion->keys_ = std::move(keys);
  return motion;
}

std::shared_ptr<const PoseMotion> PoseMotion::steady(const Key& at, const Eigen::Vector3d& velocity,
                                                     const Eigen::Vector3d& angular_velocity) {
  const Key key = checked(at, "the key");
  requireNumber(isSmall(velocity),
                "the velocity is out of range; finite numbers up to 1e9 m/s are expected");
  requireNumber(
      isSmall(angular_velocity),
      "the angular velocity is out of range; finite numbers up to 1e9 rad/s are expected");
  const std::shared_ptr<PoseMotion> motion(new PoseMotion());
  const double rate = angular_velocity.norm();
  const Eigen::Vector3d axis =
      rate > 0 ? Eigen::Vector3d(angular_velocity.normalized()) : Eigen::Vector3d::UnitZ();
  motion->is_steady_ = true;
  motion->keys_ = {key};
  motion->velocity_ = velocity;
  motion->angular_velocity_ = angular_velocity;
  motion->starts_ = {key.time};
  motion->stretches_ = {{key.X_WB.translation, velocity, AxisTurn(key.X_WB.rotation, axis, rate)}};
  return motion;
}

std::size_t PoseMotion::stretchAt(double time) const {
  const auto next = std::upper_bound(starts_.begin(), starts_.end(), time);
  return next == starts_.begin() ? 0 : static_cast<std::size_t>(next - starts_.begin()) - 1;
}

Pose PoseMotion::pose(double time) const {
  const std::size_t i = stretchAt(time);
  const Stretch& stretch = stretches_[i];
  double since = time - starts_[i];
  if (!is_steady_ && since < 0) since = 0;
  return {stretch.turn.at(since), stretch.start + since * stretch.velocity};
}

double PoseMotion::speedBound(double t0, double t1, double reach) const {
  if (!is_steady_ && t1 <= starts_.front()) return 0;
  double most = 0;
  for (std::size_t i = stretchAt(t0), last = stretchAt(t1); i <= last; ++i) {
    const double turning = stretches_[i].turn.angle();
    most = greatest(most, stretches_[i].velocity.norm() + (turning > 0 ? turning * reach : 0));
  }
  return most * (1 + 64 * kUnitRoundoff);
}

double PoseMotion::rounding(double t0, double t1, double reach) const {
  double most = 0;
  for (std::size_t i = stretchAt(t0), last = stretchAt(t1); i <= last; ++i) {
    const Stretch& stretch = stretches_[i];
    const double to = i == last ? t1 : starts_[i + 1];
    const double since = is_steady_ ? greatest(std::abs(t0 - starts_[i]), std::abs(to - starts_[i]))
                                    : greatest(0, to - starts_[i]);
    const double turned = stretch.turn.angle() * since;
    if (!(turned <= kLargestTurn)) return kInfinity;
    // About thirty operations for each coordinate; times and angles round by their size, too.
    most = greatest(most, (3 + turned) * reach + stretch.start.norm() +
                              stretch.velocity.norm() * (since + std::abs(starts_[i])));
  }
  return kMotionRounding * most;
}

}  // namespace leeway::collision
