#include "planner/execute/obstacles.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/robots/input_error.h"
#include "planner/base/clock.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

using collision::Deformable;
using collision::Shape;
using collision::UpdateStatus;

/// A product of a speed bound and a time, rounded up, because rounding to nearest gives no bound.
/// NaN, the product of 0 m/s and an infinite time, becomes infinity.
double upwards(double x) { return x >= 0 ? x * (1 + kGrowthRounding) : kInfinity; }

}  // namespace

Obstacles::Obstacles(const Problem& problem, const CompiledScene& scene) {
  for (const DeformingObstacle& source : problem.world.deforming) {
    const bool predicted =
        source.motion != nullptr && problem.execution.foresight == Foresight::kMotion;
    bodies_.push_back(scene.scene().find(source.object.name));
    obstacles_.push_back({source.object.name, &source, predicted,
                          Deformable(source.mesh, source.motion, source.options),
                          Deformable(source.mesh, source.motion, source.options),
                          problem.execution.start, source.speed_bound});
    updates_.push_back({source.object.name, {}, {}, 0});
  }
}

bool Obstacles::has(int body) const {
  return std::find(bodies_.begin(), bodies_.end(), body) != bodies_.end();
}

std::shared_ptr<const CompiledScene> Obstacles::pairsOfOthers(const CompiledScene& scene) const {
  return scene.withPairs(
      [&](const collision::ScenePair& pair) { return !has(pair.body_a) && !has(pair.body_b); });
}

std::shared_ptr<const CompiledScene> Obstacles::pairsOfThese(const CompiledScene& scene) const {
  return scene.withPairs(
      [&](const collision::ScenePair& pair) { return has(pair.body_a) || has(pair.body_b); });
}

bool Obstacles::arePredicted() const {
  return std::all_of(obstacles_.begin(), obstacles_.end(),
                     [](const Followed& o) { return o.predicted; });
}

void Obstacles::look(double time) {
  for (std::size_t i = 0; i < obstacles_.size(); ++i) {
    Followed& o = obstacles_[i];
    updates_[i].update_s = 0;
    if (o.source->motion != nullptr && !o.own) {
      const Clock::time_point begin = Clock::now();
      const UpdateStatus status = o.present.update(time);
      updates_[i].update_s = secondsSince(begin);
      if (status != UpdateStatus::kUpdated)
        throw robots::InputError(
            "", 0,
            fmt::format("obstacle '{}' at {} s: {}", o.object, time, collision::toString(status)));
      o.seen = time;
    }
    const collision::UpdateStatistics& statistics = o.present.statistics();
    updates_[i].strategy = collision::toString(statistics.strategy);
    updates_[i].reason = statistics.reason;
  }
}

std::size_t Obstacles::indexOf(const std::string& object) const {
  const auto o = std::find_if(obstacles_.begin(), obstacles_.end(),
                              [&](const Followed& f) { return f.object == object; });
  if (o == obstacles_.end())
    throw std::invalid_argument("there is no deforming obstacle '" + object + "'");
  return static_cast<std::size_t>(o - obstacles_.begin());
}

double Obstacles::jump(const std::string& object, std::span<const Eigen::Vector3d> vertices,
                       double time) const {
  const Followed& o = obstacles_[indexOf(object)];
  const std::span<const Eigen::Vector3d> before = o.present.snapshot()->vertices();
  double most = 0;
  for (std::size_t i = 0; i < std::min(before.size(), vertices.size()); ++i) {
    const double moved = (vertices[i] - before[i]).norm();
    if (!(moved <= most)) most = moved;
    if (std::isnan(most)) return most;
  }
  return most - agedGrowth(o, time);
}

void Obstacles::set(const std::string& object, std::span<const Eigen::Vector3d> vertices,
                    double time, double speed_bound) {
  Followed* const o = &obstacles_[indexOf(object)];
  if (!(speed_bound >= 0))
    throw std::invalid_argument(fmt::format(
        "obstacle '{}': the speed bound is {}; at least 0 m/s is expected", object, speed_bound));
  // Between the two observations the earlier bound held, unless the obstacle jumped.
  const bool kept = time >= o->seen && jump(object, vertices, time) <= kGuardJump;
  const double bound_before = kept ? speedBetween(*o, o->seen, time) : kInfinity;
  const UpdateStatus status = o->present.update(vertices, time, speed_bound);
  if (status != UpdateStatus::kUpdated)
    throw std::invalid_argument(fmt::format(
        "obstacle '{}': {}{}; {} finite vertices are expected", object, collision::toString(status),
        o->present.badVertex() >= 0 ? fmt::format(" (vertex {})", o->present.badVertex()) : "",
        o->source->mesh->vertexCount()));
  o->bound_before = bound_before;
  o->seen_before = o->seen;
  o->own = true;
  o->predicted = false;
  o->speed_bound = speed_bound;
  o->seen = time;
}

bool Obstacles::widens(const std::string& object, double speed_bound) const {
  const Followed& o = obstacles_[indexOf(object)];
  const bool by_motion =
      o.predicted || (o.source->motion != nullptr && !o.own && !std::isfinite(o.speed_bound));
  return by_motion || !(speed_bound <= o.speed_bound);
}

double Obstacles::speedBetween(const Followed& o, double t0, double t1) const {
  if (!o.predicted && std::isfinite(o.speed_bound)) return o.speed_bound;
  if (o.source->motion == nullptr || o.own) return kInfinity;
  return o.source->motion->speedBound(t0, t1);
}

double Obstacles::agedGrowth(const Followed& o, double time) const {
  if (time == o.seen) return 0;
  if (o.own && time < o.seen)
    return time >= o.seen_before ? upwards(o.bound_before * (o.seen - time)) : kInfinity;
  const double from = std::min(o.seen, time), to = std::max(o.seen, time);
  const double rounding =
      o.own || o.source->motion == nullptr ? 0 : 2 * o.source->motion->rounding(from, to);
  return upwards(speedBetween(o, from, to) * (to - from)) + rounding;
}

Obstacles::Replacements Obstacles::seen(double growth) const {
  Replacements shapes;
  for (std::size_t i = 0; i < obstacles_.size(); ++i)
    shapes.push_back({bodies_[i], 0, Shape::deformable(obstacles_[i].present.snapshot()), growth});
  return shapes;
}

Obstacles::Replacements Obstacles::during(double t0, double t1) {
  Replacements shapes;
  const double middle = t0 + (t1 - t0) / 2;
  for (std::size_t i = 0; i < obstacles_.size(); ++i) {
    Followed& o = obstacles_[i];
    if (!o.predicted) {
      shapes.push_back({bodies_[i], 0, Shape::deformable(o.present.snapshot()),
                        std::max(agedGrowth(o, t0), agedGrowth(o, t1))});
      continue;
    }
    if (o.future.update(middle) != UpdateStatus::kUpdated) {
      shapes.push_back({bodies_[i], 0, Shape::deformable(o.present.snapshot()), kInfinity});
      continue;
    }
    const double half = std::max(middle - t0, t1 - middle);
    const double growth =
        upwards(speedBetween(o, t0, t1) * half) + 2 * o.source->motion->rounding(t0, t1);
    shapes.push_back({bodies_[i], 0, Shape::deformable(o.future.snapshot()), growth});
  }
  return shapes;
}

Obstacles::Replacements Obstacles::atMiddle(Replacements shapes, double t0, double t1) const {
  const double middle = t0 + (t1 - t0) / 2;
  for (std::size_t i = 0; i < obstacles_.size(); ++i) {
    const Followed& o = obstacles_[i];
    if (shapes[i].growth == kInfinity) continue;
    shapes[i].growth =
        o.predicted ? 2 * o.source->motion->rounding(middle, middle) : agedGrowth(o, middle);
  }
  return shapes;
}

}  // namespace leeway::planner
