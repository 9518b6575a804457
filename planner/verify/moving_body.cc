#include "planner/verify/moving_body.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "leeway/robots/input_error.h"
#include "planner/base/tolerances.h"
#include "planner/validate/checks.h"

namespace leeway::planner::verification {
namespace {

using collision::PoseMotion;
using Eigen::Vector3d;
using robots::Pose;

/// Beyond this, rounding of angles is not bounded [rad].
constexpr double kMostTurned = 1e5;
/// Shapes that are kept, because all pairs of an edge look at its middle first.
constexpr std::size_t kMostShapes = 16;

/// A product of a bound and a time [s], rounded up; 0 where one of them is 0.
double upTo(double bound, double time) {
  return time > 0 && bound > 0 ? bound * time * (1 + kVerifyRounding) : 0;
}

/// The turn from one rotation to another in the world: a unit axis and an angle from 0 to pi.
struct Turn {
  Vector3d axis = Vector3d::UnitZ();
  double angle = 0;
};

Turn turnBetween(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to) {
  Eigen::Quaterniond q(Eigen::Matrix3d(to * from.transpose()));
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (!(sine > 0)) return {};
  return {q.vec() / sine, 2 * std::atan2(sine, q.w())};
}

double distanceOf(const Pose& a, const Pose& b) { return (a.translation - b.translation).norm(); }

}  // namespace

MovingBody::MovingBody(const DeformingObstacle& obstacle, const Execution& execution)
    : name_(obstacle.object.name), execution_(execution), deforming_(&obstacle) {
  collision::DeformOptions options;
  options.strategy = collision::DeformStrategy::kRefit;
  present_.emplace(obstacle.mesh, nullptr, options);
}

MovingBody::MovingBody(const Object& object, const Execution& execution)
    : name_(object.name), execution_(execution), object_(&object) {}

std::size_t MovingBody::vertexCount() const {
  return static_cast<std::size_t>(deforming_->mesh->vertexCount());
}

Sighting MovingBody::lookedAt(double time) const {
  Sighting known;
  known.time = time;
  const bool has_motion =
      isRigid() ? object_->motion->poses != nullptr : deforming_->motion != nullptr;
  known.kind = !has_motion                                  ? Sighting::Kind::kSeen
               : execution_.foresight == Foresight::kMotion ? Sighting::Kind::kFollows
                                                            : Sighting::Kind::kLooked;
  if (isRigid()) {
    known.speed = object_->motion->speed_bound;
    known.turning = object_->motion->turn_bound;
    if (!has_motion) {
      known.X_WO = object_->X_WO;
      known.time = execution_.start - object_->motion->age;
    }
    return known;
  }
  known.speed = deforming_->speed_bound;
  if (!has_motion) known.time = execution_.start;
  return known;
}

MovingBody::Rates MovingBody::ratesBetween(double t0, double t1, double reach) const {
  const PoseMotion& motion = *object_->motion->poses;
  Rates most;
  const auto add = [&](double speed, double turning) {
    most.speed = std::max(most.speed, speed);
    most.turning = std::max(most.turning, turning);
    most.of_points = std::max(most.of_points, speed + turning * reach);
  };
  if (motion.isSteady()) {
    add(motion.velocity().norm(), motion.angularVelocity().norm());
    return most;
  }
  const std::vector<PoseMotion::Key>& keys = motion.keyPoses();
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (keys[i].time < t0 || keys[i - 1].time > t1) continue;
    const double duration = keys[i].time - keys[i - 1].time;
    const Turn turn = turnBetween(keys[i - 1].X_WB.rotation, keys[i].X_WB.rotation);
    add(distanceOf(keys[i].X_WB, keys[i - 1].X_WB) / duration, turn.angle / duration);
  }
  return most;
}

double MovingBody::motionSpeed(double t0, double t1, double reach) const {
  if (!isRigid()) return deforming_->motion->speedBound(t0, t1);
  return ratesBetween(t0, t1, reach).of_points * (1 + kVerifyRounding);
}

double MovingBody::motionRounding(double t0, double t1, double reach) const {
  if (!isRigid()) return 2 * deforming_->motion->rounding(t0, t1);
  const PoseMotion& motion = *object_->motion->poses;
  const PoseMotion::Key& first = motion.keyPoses().front();
  double size = 1 + reach, turned = 0;
  for (const PoseMotion::Key& key : motion.keyPoses())
    size = std::max(size, 1 + reach + key.X_WB.translation.norm());
  if (motion.isSteady()) {
    const double since = std::max(std::abs(t0 - first.time), std::abs(t1 - first.time));
    size += motion.velocity().norm() * since;
    turned = motion.angularVelocity().norm() * since;
  }
  return turned <= kMostTurned ? kVerifyRounding * (size + turned * reach) : kInfinity;
}

Pose MovingBody::poseAt(double time) const {
  const PoseMotion& motion = *object_->motion->poses;
  const std::vector<PoseMotion::Key>& keys = motion.keyPoses();
  if (motion.isSteady()) {
    const Pose& X = keys.front().X_WB;
    const double since = time - keys.front().time, rate = motion.angularVelocity().norm();
    if (!(rate > 0)) return {X.rotation, X.translation + since * motion.velocity()};
    return {rotationAbout(motion.angularVelocity() / rate, rate * since) * X.rotation,
            X.translation + since * motion.velocity()};
  }
  std::size_t next = 0;
  while (next < keys.size() && keys[next].time <= time) ++next;
  if (next == 0) return keys.front().X_WB;
  if (next == keys.size()) return keys.back().X_WB;
  const PoseMotion::Key &a = keys[next - 1], &b = keys[next];
  const double share = (time - a.time) / (b.time - a.time);
  const Turn turn = turnBetween(a.X_WB.rotation, b.X_WB.rotation);
  return {rotationAbout(turn.axis, share * turn.angle) * a.X_WB.rotation,
          a.X_WB.translation + share * (b.X_WB.translation - a.X_WB.translation)};
}

Pose MovingBody::poseOf(const Sighting& known, double time) const {
  if (!isRigid()) return deforming_->object.X_WO;
  if (known.kind == Sighting::Kind::kSeen) return known.X_WO;
  return poseAt(known.kind == Sighting::Kind::kFollows ? time : known.time);
}

std::vector<Vector3d> MovingBody::verticesOf(const Sighting& known, double time) const {
  if (known.vertices) return *known.vertices;
  if (known.kind == Sighting::Kind::kSeen) {
    const auto& shape = deforming_->object.geometries.front().shape;
    const std::span<const Vector3d> vertices = shape.deformable()->vertices();
    return {vertices.begin(), vertices.end()};
  }
  std::vector<Vector3d> vertices(vertexCount());
  deforming_->motion->evaluate(known.kind == Sighting::Kind::kFollows ? time : known.time,
                               vertices);
  return vertices;
}

const collision::Shape& MovingBody::shapeOf(const Sighting& known, double time) {
  const double when = known.kind == Sighting::Kind::kFollows ? time : known.time;
  const std::pair<const void*, double> key(known.vertices.get(), when);
  const auto found = shapes_.find(key);
  if (found != shapes_.end()) return found->second;
  if (shapes_.size() >= kMostShapes) shapes_.clear();
  const collision::UpdateStatus status = present_->update(verticesOf(known, time), when);
  if (status != collision::UpdateStatus::kUpdated)
    throw robots::InputError(
        "", 0, fmt::format("obstacle '{}' at {} s: {}", name_, when, collision::toString(status)));
  return shapes_.emplace(key, collision::Shape::deformable(present_->snapshot())).first->second;
}

Place MovingBody::at(const Sighting& known, double time, double half, const Sphere& sphere_O) {
  Place place;
  place.X_WO = poseOf(known, time);
  if (!isRigid()) place.shape = &shapeOf(known, time);
  const double reach = sphere_O.center.norm() + sphere_O.radius;
  const double from = time - half, to = time + half;
  const bool follows = known.kind == Sighting::Kind::kFollows;
  const bool is_bounded = std::isfinite(known.speed) && std::isfinite(known.turning);
  if (follows) {
    place.speed = motionSpeed(from, to, reach);
  } else {
    // A step begins at the earliest when the obstacle was seen.
    const double age = std::max(0.0, time - known.time);
    place.speed = known.kind == Sighting::Kind::kSeen || is_bounded
                      ? known.speed + upTo(known.turning, reach)
                      : motionSpeed(known.time, to, reach);
    place.grown = upTo(place.speed, age);
    if (is_bounded) place.nearer = known.speed * age * (1 - kVerifyRounding);
  }
  place.slack = kVerifyRounding * (1 + reach + place.X_WO.translation.norm());
  if (known.kind != Sighting::Kind::kSeen)
    place.slack += motionRounding(follows ? from : known.time, to, reach);
  // Rounding of the time.
  place.slack += upTo(place.speed, 8 * std::numeric_limits<double>::epsilon() * std::abs(time));
  return place;
}

std::string MovingBody::departure(const Sighting& before, const Sighting& now) {
  if (now.cloud != before.cloud) return {};
  const bool follows = before.kind == Sighting::Kind::kFollows;
  if (!follows && now.time < before.time) return apart(now, before, before.time, "a sight before");
  return apart(before, now, now.time,
               follows ? "where its motion has it" : "where it was seen before");
}

std::string MovingBody::departureOfMotion(const Sighting& seen, double time) {
  if (seen.cloud) return {};
  Sighting motion;  // follows
  motion.time = time;
  return apart(seen, motion, time, "where it was seen");
}

std::string MovingBody::carvedElsewhere(const Sighting& seen) const {
  if (!isRigid() || !object_->cloud || seen.cloud) return {};
  return carveFault(*object_->cloud, seen.X_WO);
}

/// How much farther from a first sighting a second one is, at `time`, than bounds from the first on
/// allow. Empty if it is not.
std::string MovingBody::apart(const Sighting& first, const Sighting& second, double time,
                              const char* from) {
  Rates bound{first.speed, first.turning};
  const bool is_bounded = std::isfinite(bound.speed) && std::isfinite(bound.turning);
  if (first.kind == Sighting::Kind::kFollows) {
    bound = {0, 0};
  } else if (first.kind == Sighting::Kind::kLooked && !is_bounded) {
    bound = isRigid() ? ratesBetween(first.time, time)
                      : Rates{deforming_->motion->speedBound(first.time, time), 0};
  }
  const double age = time - first.time;
  double rounding = kGuardJump;
  for (const Sighting* sighting : {&first, &second})
    if (sighting->kind != Sighting::Kind::kSeen)
      rounding += motionRounding(std::min(first.time, time), std::max(first.time, time), 1);
  double moved = 0, turned = 0;
  if (isRigid()) {
    const Pose a = poseOf(first, time), b = poseOf(second, time);
    moved = distanceOf(a, b);
    turned = turnBetween(a.rotation, b.rotation).angle;
  } else {
    const std::vector<Vector3d> a = verticesOf(first, time), b = verticesOf(second, time);
    for (std::size_t i = 0; i < a.size(); ++i) moved = std::max(moved, (a[i] - b[i]).norm());
  }
  if (const double most = upTo(bound.speed, age); moved > most + rounding)
    return fmt::format("is {} m from {}; at most {} m is allowed by its speed bound", moved, from,
                       most);
  if (const double most = upTo(bound.turning, age); turned > most + rounding)
    return fmt::format(
        "is turned by {} rad from {}; at most {} rad is allowed by its turning bound", turned, from,
        most);
  return {};
}

}  // namespace leeway::planner::verification
