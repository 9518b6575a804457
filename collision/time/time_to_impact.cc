#include "leeway/collision/time_to_impact.h"

#include <algorithm>
#include <cmath>

#include "collision/base/tolerances.h"
#include "collision/scene/scene_access.h"

namespace leeway::collision {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// time + wait, rounded down.
double later(double time, double wait) {
  return wait == kInfinity ? kInfinity : std::nextafter(time + wait, -kInfinity);
}

/// Whether bounds that hold from `old_time` on include all that `now` allows from `time` on.
bool covers(const PointMotion& old, double old_time, const PointMotion& now, double time) {
  const double reached =
      std::min(old.speed_cap, old.speed + old.acceleration * std::max(0.0, time - old_time));
  return now.acceleration <= old.acceleration && now.speed_cap <= old.speed_cap &&
         std::min(now.speed, now.speed_cap) <= reached;
}

}  // namespace

PointMotion closing(const PointMotion& a, const PointMotion& b) {
  return {std::min(a.speed, a.speed_cap) + std::min(b.speed, b.speed_cap),
          a.acceleration + b.acceleration, a.speed_cap + b.speed_cap};
}

double timeToImpact(double gap, const PointMotion& closing) {
  const double cap = closing.speed_cap, a = closing.acceleration;
  // Written so that a NaN anywhere gives 0.
  if (!(gap > 0) || !(cap >= 0) || !(a >= 0) || !(closing.speed >= 0)) return 0;
  if (gap == kInfinity) return cap < kInfinity || a < kInfinity ? kInfinity : 0;
  const double v = std::min(closing.speed, cap);
  const auto down = [](double t) { return t * (1 - 16 * kUnitRoundoff); };
  if (cap == 0) return kInfinity;
  if (v == 0 && a == 0) return kInfinity;
  if (v >= cap || a == kInfinity) return down(gap / cap);
  // hypot() does not overflow where v * v would.
  const double t = gap / (v + std::hypot(v, std::sqrt(2 * a) * std::sqrt(gap))) * 2;
  const double reached = a * t + v;
  if (std::isnan(t)) return 0;
  if (!(reached > cap)) return down(std::min(t, std::numeric_limits<double>::max()));
  // Accelerates up to the cap, at t_cap; covers the rest at the cap.
  const double t_cap = (cap - v) / a;
  const double covered = v * t_cap + a * t_cap * t_cap / 2;
  const double rest = std::max(0.0, gap - covered * (1 + 16 * kUnitRoundoff));
  const double capped = t_cap + rest / cap;
  // Cancellation in `rest`: a few roundings of the gap, covered at the cap.
  return std::max(0.0, down(capped) - 16 * kUnitRoundoff * gap / cap);
}

ImpactSchedule::ImpactSchedule(const Scene& scene) : scene_(&scene) {
  const std::size_t pairs = scene.pairs().size(), bodies = scene.bodies().size();
  motions_.resize(bodies);
  for (std::size_t b = 0; b < bodies; ++b)
    if (scene.bodies()[b].moving) motions_[b].motion = {kInfinity, kInfinity, kInfinity};
  due_.assign(pairs, -kInfinity);
  heap_.resize(pairs);
  slot_.resize(pairs);
  looking_.resize(pairs);
  imminent_.resize(pairs);
  first_pair_.assign(bodies + 1, 0);
  for (const ScenePair& pair : scene.pairs()) {
    ++first_pair_[at(pair.body_a) + 1];
    ++first_pair_[at(pair.body_b) + 1];
  }
  for (std::size_t b = 0; b < bodies; ++b) first_pair_[b + 1] += first_pair_[b];
  pairs_of_body_.resize(2 * pairs);
  std::vector<std::int32_t> next(first_pair_.begin(), first_pair_.end() - 1);
  for (std::size_t p = 0; p < pairs; ++p) {
    place(p, static_cast<std::int32_t>(p));  // all due at once: any order is a heap
    const ScenePair& pair = scene.pairs()[p];
    pairs_of_body_[at(next[at(pair.body_a)]++)] = static_cast<std::int32_t>(p);
    pairs_of_body_[at(next[at(pair.body_b)]++)] = static_cast<std::int32_t>(p);
  }
}

PointMotion ImpactSchedule::motionAt(int body, double time) const {
  const TimedMotion& last = motions_[at(body)];
  PointMotion motion = last.motion;
  // The conditions keep 0 * infinity out: unbounded acceleration counts once time has passed.
  const double passed = time - last.time;
  if (passed > 0 && motion.acceleration > 0) motion.speed += motion.acceleration * passed;
  motion.speed = std::min(motion.speed, motion.speed_cap);
  return motion;
}

void ImpactSchedule::setMotion(int body, const PointMotion& motion, double time) {
  TimedMotion& last = motions_[at(body)];
  const bool covered = covers(last.motion, last.time, motion, time);
  last = {motion, std::max(last.time, time)};
  if (covered) return;
  for (std::int32_t i = first_pair_[at(body)]; i < first_pair_[at(body) + 1]; ++i) {
    const std::int32_t pair = pairs_of_body_[at(i)];
    if (due_[at(pair)] > time) setDue(pair, time);
  }
}

double ImpactSchedule::look(int p, double time, double horizon, Workspace& workspace,
                            bool& violated) {
  const ScenePair& pair = scene_->pairs()[at(p)];
  const PointMotion motion = closing(motionAt(pair.body_a, time), motionAt(pair.body_b, time));
  const double coarse = coarseLowerBound(*scene_, workspace, p) - pair.margin;
  const double due = later(time, timeToImpact(coarse, motion));
  ++statistics.looks;
  // Coarse bounds put the pair off for long enough: no exact query yet.
  if (due >= time + kImpactHorizons * horizon && due > time) return due;
  DistanceRequest request;
  request.tolerance = std::max(kImpactTolerance, kImpactShare * std::max(0.0, coarse));
  request.depth = pair.margin < 0;
  const DistanceResult result = pairDistance(*scene_, workspace, p, request);
  ++statistics.exact;
  violated = result.distance.upper <= pair.margin;
  return std::max(due, later(time, timeToImpact(result.distance.lower - pair.margin, motion)));
}

ImpactReport ImpactSchedule::advance(double time, double horizon, Workspace& workspace) {
  ++statistics.advances;
  const double end = time + std::max(0.0, horizon);
  ImpactReport report;
  imminent_count_ = 0;
  if (std::isnan(end)) {
    report.safe_until = -kInfinity;
    return report;
  }
  // All due pairs are taken out before any goes back: one that stays due is looked at once.
  std::size_t count = 0;
  while (!heap_.empty() && due_[at(heap_.front())] < end) {
    looking_[count++] = heap_.front();
    setDue(heap_.front(), kInfinity);
  }
  std::sort(looking_.begin(), looking_.begin() + static_cast<std::ptrdiff_t>(count));
  for (std::size_t i = 0; i < count; ++i) {
    bool violated = false;
    const double due = look(looking_[i], time, horizon, workspace, violated);
    setDue(looking_[i], due);
    if (due < end || violated) imminent_[imminent_count_++] = looking_[i];
    if (violated) ++report.violated;
  }
  report.imminent = static_cast<int>(imminent_count_);
  report.safe_until = safeUntil();
  report.next_pair = heap_.empty() ? -1 : heap_.front();
  return report;
}

double ImpactSchedule::safeUntil() const {
  return heap_.empty() ? kInfinity : due_[at(heap_.front())];
}

bool ImpactSchedule::before(std::int32_t a, std::int32_t b) const {
  return due_[at(a)] != due_[at(b)] ? due_[at(a)] < due_[at(b)] : a < b;
}

void ImpactSchedule::place(std::size_t slot, std::int32_t pair) {
  heap_[slot] = pair;
  slot_[at(pair)] = static_cast<std::int32_t>(slot);
}

void ImpactSchedule::setDue(std::int32_t pair, double due) {
  // NaN proves nothing: due now.
  due_[at(pair)] = std::isnan(due) ? -kInfinity : due;
  siftUp(at(slot_[at(pair)]));
  siftDown(at(slot_[at(pair)]));
}

void ImpactSchedule::siftUp(std::size_t slot) {
  const std::int32_t pair = heap_[slot];
  while (slot > 0 && before(pair, heap_[(slot - 1) / 2])) {
    place(slot, heap_[(slot - 1) / 2]);
    slot = (slot - 1) / 2;
  }
  place(slot, pair);
}

void ImpactSchedule::siftDown(std::size_t slot) {
  const std::int32_t pair = heap_[slot];
  for (std::size_t child; (child = 2 * slot + 1) < heap_.size(); slot = child) {
    if (child + 1 < heap_.size() && before(heap_[child + 1], heap_[child])) ++child;
    if (!before(heap_[child], pair)) break;
    place(slot, heap_[child]);
  }
  place(slot, pair);
}

}  // namespace leeway::collision
