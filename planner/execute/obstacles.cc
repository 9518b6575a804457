#include "planner/execute/obstacles.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "collision/base/pose_check.h"
#include "leeway/robots/input_error.h"
#include "planner/base/clock.h"
#include "planner/base/did_you_mean.h"
#include "planner/base/tolerances.h"
#include "planner/execute/cloud_scene.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

using collision::Deformable;
using collision::Shape;
using collision::UpdateStatus;

/// A product of a speed bound and a time, rounded up, because rounding to nearest gives no bound.
/// NaN, the product of 0 m/s and an infinite time, becomes infinity.
double upwards(double x) { return x >= 0 ? x * (1 + kGrowthRounding) : kInfinity; }

constexpr Obstacles::Bound kNoBound{kInfinity, kInfinity};

}  // namespace

/// One obstacle: where it was last seen, and what is known of it from then on.
struct Obstacles::Followed {
  Followed(const Object& object, bool is_predicted, double seen_at, const Bound& given)
      : name(object.name),
        predicted(is_predicted),
        seen(seen_at),
        bound(given),
        speed_bound(given.speed) {}
  virtual ~Followed() = default;

  /// Whether it has a motion; bounds on the speed of its points in that motion [m/s], and on the
  /// rounding of their places [m].
  virtual bool hasMotion() const = 0;
  virtual double motionSpeed(double t0, double t1) const = 0;
  virtual double motionRounding(double t0, double t1) const = 0;
  /// Moves what was seen, or what is foreseen, along its motion to `time`.
  virtual UpdateStatus moveTo(double time) = 0;
  virtual UpdateStatus foresee(double time) = 0;

  virtual bool isSeenAs(const Sight& sight) const = 0;
  /// A bound on the speed of its points [m/s].
  virtual double pointSpeed(const Bound& of) const = 0;
  /// How far its points are from where they were last seen [m]; NaN as for jump().
  virtual double moved(const Sight& sight) const = 0;
  /// See Obstacles::jump().
  virtual double jump(const Sight& sight, double time) const { return pointsJump(sight, time); }
  /// The same by the bound on the speed of points alone.
  double pointsJump(const Sight& sight, double time) const {
    return moved(sight) - agedGrowth(time);
  }
  /// Takes a sight; throws std::invalid_argument where it makes no sense.
  virtual void see(const Sight& sight, double time, double speed) = 0;

  virtual std::variant<Shape, robots::Pose> asSeen() const = 0;
  virtual std::variant<Shape, robots::Pose> asForeseen() const = 0;
  virtual void describe(ObstacleUpdate& update) const = 0;

  double speedBetween(double t0, double t1) const {
    if (!predicted && std::isfinite(speed_bound)) return speed_bound;
    if (!hasMotion() || own) return kInfinity;
    return motionSpeed(t0, t1);
  }
  double agedGrowth(double time) const {
    if (time == seen) return 0;
    // Times of what was seen and of requests are rounded apart, as 10 * 0.02 is from their sum.
    const bool is_rounded = seen - time <= kSightTime * (1 + std::abs(seen));
    if (own && time < seen && !is_rounded)
      return time >= seen_before ? upwards(bound_before * (seen - time)) : kInfinity;
    const double from = std::min(seen, time), to = std::max(seen, time);
    const double rounding = own || !hasMotion() ? 0 : 2 * motionRounding(from, to);
    return upwards(speedBetween(from, to) * (to - from)) + rounding;
  }
  /// The bounds that hold between `seen` and a time.
  Bound boundTo(double time) const {
    if (own && time < seen) return time >= seen_before ? rates_before : kNoBound;
    const bool by_motion = predicted || (hasMotion() && !own && !std::isfinite(speed_bound));
    return by_motion ? kNoBound : bound;
  }

  std::string name;
  bool predicted;      ///< its motion is known after the last look
  double seen;         ///< when it was seen [s]
  Bound bound;         ///< the program's, with observations, or the problem's
  double speed_bound;  ///< of its points by that [m/s]
  bool own = false;    ///< the program has observed it
  // With `own`: when it was seen before that, and bounds from then until `seen`: on the speed of
  // its points, and as `bound`.
  double seen_before = 0, bound_before = 0;
  Bound rates_before;
};

struct Obstacles::Deforming final : Followed {
  Deforming(const DeformingObstacle& obstacle, const Execution& execution)
      : Followed(obstacle.object,
                 obstacle.motion != nullptr && execution.foresight == Foresight::kMotion,
                 execution.start, {obstacle.speed_bound}),
        source(&obstacle),
        present(obstacle.mesh, obstacle.motion, obstacle.options),
        future(obstacle.mesh, obstacle.motion, obstacle.options) {}

  bool hasMotion() const override { return source->motion != nullptr; }
  double motionSpeed(double t0, double t1) const override {
    return source->motion->speedBound(t0, t1);
  }
  double motionRounding(double t0, double t1) const override {
    return source->motion->rounding(t0, t1);
  }
  UpdateStatus moveTo(double time) override { return present.update(time); }
  UpdateStatus foresee(double time) override { return future.update(time); }

  bool isSeenAs(const Sight& sight) const override { return sight.index() == 0; }
  double pointSpeed(const Bound& of) const override { return of.speed; }
  double moved(const Sight& sight) const override {
    const auto& vertices = std::get<0>(sight);
    const std::span<const Eigen::Vector3d> before = present.snapshot()->vertices();
    if (vertices.size() != before.size()) return kNaN;
    double most = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      const double distance = (vertices[i] - before[i]).norm();
      if (!(distance <= most)) most = distance;
      if (std::isnan(most)) return most;
    }
    return most;
  }
  void see(const Sight& sight, double time, double speed) override {
    const UpdateStatus status = present.update(std::get<0>(sight), time, speed);
    if (status != UpdateStatus::kUpdated)
      throw std::invalid_argument(fmt::format(
          "obstacle '{}': {}{}; {} finite vertices are expected", name, collision::toString(status),
          present.badVertex() >= 0 ? fmt::format(" (vertex {})", present.badVertex()) : "",
          source->mesh->vertexCount()));
  }

  std::variant<Shape, robots::Pose> asSeen() const override {
    return Shape::deformable(present.snapshot());
  }
  std::variant<Shape, robots::Pose> asForeseen() const override {
    return Shape::deformable(future.snapshot());
  }
  void describe(ObstacleUpdate& update) const override {
    update.strategy = collision::toString(present.statistics().strategy);
    update.reason = present.statistics().reason;
  }

  const DeformingObstacle* source;
  Deformable present, future;
};

struct Obstacles::Rigid : Followed {
  Rigid(const Object& object, const Execution& execution)
      : Followed(object, object.motion->poses && execution.foresight == Foresight::kMotion,
                 execution.start - object.motion->age,
                 {object.motion->speed_bound, object.motion->turn_bound}),
        poses(object.motion->poses),
        extent(extentOf(object)),
        present(object.X_WO),
        future(object.X_WO) {
    speed_bound = Rigid::pointSpeed(bound);
  }

  bool hasMotion() const override { return poses != nullptr; }
  double motionSpeed(double t0, double t1) const override {
    return poses->speedBound(t0, t1, extent);
  }
  double motionRounding(double t0, double t1) const override {
    return poses->rounding(t0, t1, extent);
  }
  UpdateStatus moveTo(double time) override { return place(time, present); }
  UpdateStatus foresee(double time) override { return place(time, future); }
  UpdateStatus place(double time, robots::Pose& X_WO) const {
    const robots::Pose X = poses->pose(time);
    if (!poseFault(X).empty()) return UpdateStatus::kNotFinite;
    X_WO = X;
    return UpdateStatus::kUpdated;
  }

  bool isSeenAs(const Sight& sight) const override { return sight.index() == 1; }
  double pointSpeed(const Bound& of) const override {
    return planner::pointSpeed(of.speed, of.turning, extent);
  }
  double moved(const Sight& sight) const override {
    const auto& X_WO = std::get<robots::Pose>(sight);
    if (!poseFault(X_WO).empty()) return kNaN;
    return (X_WO.translation - present.translation).norm() + chord(X_WO) * extent;
  }
  /// How far its rotation moves a unit vector at most: by 2 sin(angle / 2), which is this norm over
  /// the root of 2.
  double chord(const robots::Pose& X_WO) const {
    return (X_WO.rotation - present.rotation).norm() / std::sqrt(2.0);
  }
  double jump(const Sight& sight, double time) const override {
    const double of_points = pointsJump(sight, time);
    const auto* const X_WO = std::get_if<robots::Pose>(&sight);
    if (X_WO == nullptr || std::isnan(of_points)) return of_points;
    // One of the bounds may be broken where both together are not.
    const Bound most = boundTo(time);
    const auto beyond = [&](double change, double rate) {
      const double jumped = rate < kInfinity ? change - upwards(rate * std::abs(time - seen)) : 0;
      return jumped > kGuardJump ? jumped : -kInfinity;
    };
    const double angle = 2 * std::asin(std::min(1.0, chord(*X_WO) / 2));
    return std::max({of_points,
                     beyond((X_WO->translation - present.translation).norm(), most.speed),
                     beyond(angle, most.turning)});
  }
  void see(const Sight& sight, double, double) override {
    const auto& X_WO = std::get<robots::Pose>(sight);
    if (const std::string fault = poseFault(X_WO); !fault.empty())
      throw std::invalid_argument(fmt::format("the pose of '{}' {}", name, fault));
    present = X_WO;
  }

  std::variant<Shape, robots::Pose> asSeen() const override { return present; }
  std::variant<Shape, robots::Pose> asForeseen() const override { return future; }
  void describe(ObstacleUpdate& update) const override {
    update.strategy = "pose";
    update.reason = "it is rigid";
  }

  std::shared_ptr<const collision::PoseMotion> poses;
  double extent;  ///< of its points from its origin [m]
  robots::Pose present, future;
};

/// A cloud: a rigid obstacle until another cloud takes its place.
struct Obstacles::Cloud final : Rigid {
  Cloud(const Object& object, const Problem& problem)
      : Rigid(object, problem.execution), own_scene(problem, object) {}

  bool isSeenAs(const Sight& sight) const override { return sight.index() != 0; }
  static const CloudSight* cloudOf(const Sight& sight) { return std::get_if<CloudSight>(&sight); }
  robots::Pose placeOf(const CloudSight& other) const { return other.X_WO.value_or(present); }

  double moved(const Sight& sight) const override {
    const CloudSight* const other = cloudOf(sight);
    if (other == nullptr)
      return carveFault(*own_scene.cloud(), std::get<robots::Pose>(sight)).empty()
                 ? Rigid::moved(sight)
                 : kNaN;
    return CloudScene::fault(other->cloud.get(), placeOf(*other)).empty() ? 0 : kNaN;
  }
  /// The bound of a cloud is one on the speed of its points.
  double jump(const Sight& sight, double time) const override { return pointsJump(sight, time); }
  void see(const Sight& sight, double time, double speed) override {
    if (const CloudSight* const other = cloudOf(sight)) {
      const robots::Pose X_WO = placeOf(*other);
      own_scene.replace(other->cloud, X_WO);
      present = X_WO;
      extent = extentOf(own_scene.standing(X_WO, 0));
      return;
    }
    const auto& X_WO = std::get<robots::Pose>(sight);
    if (poseFault(X_WO).empty()) own_scene.replace(own_scene.cloud(), X_WO);
    Rigid::see(sight, time, speed);
  }
  void describe(ObstacleUpdate& update) const override {
    update.strategy = "cloud";
    update.reason = "it is a cloud";
  }

  CloudScene own_scene;
};

Obstacles::Obstacles(const Problem& problem, std::shared_ptr<const CompiledScene> scene)
    : base_(std::move(scene)) {
  for (const DeformingObstacle& source : problem.world.deforming)
    add(std::make_unique<Deforming>(source, problem.execution));
  for (const Object& object : problem.world.objects) {
    if (!object.motion) continue;
    if (!object.cloud) {
      add(std::make_unique<Rigid>(object, problem.execution));
      continue;
    }
    auto cloud = std::make_unique<Cloud>(object, problem);
    clouds_.push_back(cloud.get());
    add(std::move(cloud));
  }
  if (!clouds_.empty()) base_ = std::make_shared<const CompiledScene>(withoutMovingClouds(problem));
  for (const std::unique_ptr<Followed>& obstacle : obstacles_) {
    if (isCloud(*obstacle)) continue;
    solids_.push_back(obstacle.get());
    bodies_.push_back(base_->scene().find(obstacle->name));
  }
  const auto isOfSolid = [this](const collision::ScenePair& pair) {
    return has(pair.body_a) || has(pair.body_b);
  };
  still_ = solids_.empty() ? base_ : base_->withPairs([&](const auto& p) { return !isOfSolid(p); });
  solid_scene_ = base_->withPairs(isOfSolid);
}

Obstacles::~Obstacles() = default;

void Obstacles::add(std::unique_ptr<Followed> obstacle) {
  updates_.push_back({obstacle->name, {}, {}});
  obstacles_.push_back(std::move(obstacle));
}

bool Obstacles::has(int body) const {
  return std::find(bodies_.begin(), bodies_.end(), body) != bodies_.end();
}

bool Obstacles::isCloud(const Followed& obstacle) const {
  return std::find(clouds_.begin(), clouds_.end(), &obstacle) != clouds_.end();
}

std::shared_ptr<const CompiledScene> Obstacles::sceneOf(std::size_t group) const {
  return group == 0 ? solid_scene_ : clouds_[group - 1]->own_scene.scene();
}

bool Obstacles::arePredicted() const {
  return std::all_of(obstacles_.begin(), obstacles_.end(),
                     [](const auto& o) { return o->predicted; });
}

void Obstacles::look(double time) {
  for (std::size_t i = 0; i < obstacles_.size(); ++i) {
    Followed& o = *obstacles_[i];
    updates_[i].update_s = 0;
    if (o.hasMotion() && !o.own) {
      const Clock::time_point begin = Clock::now();
      const UpdateStatus status = o.moveTo(time);
      updates_[i].update_s = secondsSince(begin);
      if (status != UpdateStatus::kUpdated)
        throw robots::InputError(
            "", 0,
            fmt::format("obstacle '{}' at {} s: {}", o.name, time, collision::toString(status)));
      o.seen = time;
      if (isCloud(o)) with_clouds_ = nullptr;
    }
    o.describe(updates_[i]);
    updates_[i].seen = o.seen;
    updates_[i].predicted = o.predicted;
  }
}

Obstacles::Followed& Obstacles::find(const std::string& object, const Sight& seen) const {
  const auto o = std::find_if(obstacles_.begin(), obstacles_.end(),
                              [&](const auto& f) { return f->name == object; });
  if (o != obstacles_.end() && (*o)->isSeenAs(seen)) return **o;
  constexpr const char* kExpected[] = {"deforming obstacle", "object with a motion",
                                       "cloud with a motion"};
  std::string but;
  if (o == obstacles_.end()) {
    std::vector<std::string> names;
    for (const auto& f : obstacles_)
      if (f->isSeenAs(seen)) names.push_back(f->name);
    but = didYouMean(object, names);
  } else {
    but = (*o)->isSeenAs(robots::Pose()) ? "; that object is rigid, and its pose is expected"
                                         : "; that obstacle deforms, and its vertices are expected";
    if ((*o)->isSeenAs(CloudSight()))
      but = "; that object is a cloud, and balls or its pose are expected";
  }
  throw std::invalid_argument(
      fmt::format("there is no {} '{}'{}", kExpected[seen.index()], object, but));
}

double Obstacles::jump(const std::string& object, const Sight& seen, double time) const {
  return find(object, seen).jump(seen, time);
}

robots::Pose Obstacles::poseOf(const std::string& object) const {
  return std::get<robots::Pose>(find(object, robots::Pose()).asSeen());
}

double Obstacles::seenAt(const std::string& object, const Sight& seen) const {
  return find(object, seen).seen;
}

void Obstacles::requireNewer(const std::string& object, const Sight& seen, double time) const {
  const Followed& o = find(object, seen);
  if (!std::holds_alternative<CloudSight>(seen) || time >= o.seen || (o.hasMotion() && !o.own))
    return;
  throw std::invalid_argument(
      fmt::format("a cloud of '{}' seen at {} s, before the one of {} s; a later one is expected",
                  object, time, o.seen));
}

void Obstacles::requireBound(const std::string& object, const Bound& bound) {
  if (!(bound.speed >= 0))
    throw std::invalid_argument(fmt::format(
        "obstacle '{}': the speed bound is {}; at least 0 m/s is expected", object, bound.speed));
  if (!(bound.turning >= 0))
    throw std::invalid_argument(
        fmt::format("obstacle '{}': the turning bound is {}; at least 0 rad/s is expected", object,
                    bound.turning));
}

void Obstacles::set(const std::string& object, const Sight& seen, double time, const Bound& bound) {
  Followed& o = find(object, seen);
  requireBound(object, bound);
  // Between the two observations the earlier bound held, unless the obstacle jumped. The balls of
  // two clouds do not correspond: before its time a cloud says nothing.
  const bool kept = time >= o.seen && !std::holds_alternative<CloudSight>(seen) &&
                    o.jump(seen, time) <= kGuardJump;
  const double bound_before = kept ? o.speedBetween(o.seen, time) : kInfinity;
  const Bound rates_before = kept ? o.boundTo(time) : kNoBound;
  const double speed = o.pointSpeed(bound);
  o.see(seen, time, speed);
  o.bound_before = bound_before;
  o.rates_before = rates_before;
  o.seen_before = o.seen;
  o.own = true;
  o.predicted = false;
  o.bound = bound;
  o.speed_bound = speed;
  o.seen = time;
  if (isCloud(o)) with_clouds_ = nullptr;
}

bool Obstacles::widens(const std::string& object, const Sight& seen, const Bound& bound) const {
  const Followed& o = find(object, seen);
  if (std::holds_alternative<CloudSight>(seen)) return true;
  const bool by_motion = o.predicted || (o.hasMotion() && !o.own && !std::isfinite(o.speed_bound));
  return by_motion || !(o.pointSpeed(bound) <= o.speed_bound);
}

Obstacles::Replacements Obstacles::seen(double growth) const {
  Replacements all;
  for (std::size_t i = 0; i < solids_.size(); ++i)
    all.push_back({bodies_[i], 0, solids_[i]->asSeen(), growth});
  return all;
}

std::shared_ptr<const CompiledScene> Obstacles::world(double growth) {
  const auto withClouds = [&](double by) {
    std::vector<Object> standing;
    for (const Cloud* cloud : clouds_)
      standing.push_back(cloud->own_scene.standing(cloud->present, by));
    return standing.empty() ? base_ : base_->withObjects(standing);
  };
  if (growth > 0) return withClouds(growth)->withShapes(seen(growth));
  if (!with_clouds_) with_clouds_ = withClouds(0);
  return with_clouds_->withShapes(seen(0));
}

std::shared_ptr<const CompiledScene> Obstacles::seenIn(std::size_t group) const {
  if (group == 0) return solid_scene_->withShapes(seen(0));
  const Cloud& cloud = *clouds_[group - 1];
  return cloud.own_scene.at(cloud.present);
}

Obstacles::Bounded Obstacles::bounded(Followed& o, double t0, double t1) {
  const double middle = t0 + (t1 - t0) / 2;
  if (!o.predicted) {
    const double growth = std::max(o.agedGrowth(t0), o.agedGrowth(t1));
    return {o.asSeen(), {growth, growth == kInfinity ? kInfinity : o.agedGrowth(middle)}};
  }
  if (o.foresee(middle) != UpdateStatus::kUpdated) return {o.asSeen(), {kInfinity, kInfinity}};
  const double half = std::max(middle - t0, t1 - middle);
  return {o.asForeseen(),
          {upwards(o.speedBetween(t0, t1) * half) + 2 * o.motionRounding(t0, t1),
           2 * o.motionRounding(middle, middle)}};
}

Obstacles::Growth Obstacles::growthOf(std::size_t number, double t0, double t1) {
  return bounded(*obstacles_[number], t0, t1).growth;
}

Obstacles::Placement Obstacles::place(std::size_t group, double t0, double t1, bool with_middle) {
  Placement placed;
  if (group > 0) {
    Cloud& cloud = *clouds_[group - 1];
    const Bounded where = bounded(cloud, t0, t1);
    const auto there = cloud.own_scene.at(std::get<robots::Pose>(where.now));
    const auto grown = [&](double by) { return by > 0 ? there->withMarginsGrown(by) : there; };
    placed.growth = where.growth.most;
    placed.growth_at_middle = where.growth.at_middle;
    placed.grown = grown(where.growth.most);
    if (with_middle) placed.middle = grown(where.growth.at_middle);
    return placed;
  }
  Replacements grown, middle;
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    const Bounded where = bounded(*solids_[i], t0, t1);
    placed.growth = std::max(placed.growth, where.growth.most);
    placed.growth_at_middle = std::max(placed.growth_at_middle, where.growth.at_middle);
    grown.push_back({bodies_[i], 0, where.now, where.growth.most});
    middle.push_back({bodies_[i], 0, where.now, where.growth.at_middle});
  }
  placed.grown = solid_scene_->withShapes(grown);
  if (with_middle) placed.middle = solid_scene_->withShapes(middle);
  return placed;
}

}  // namespace leeway::planner
