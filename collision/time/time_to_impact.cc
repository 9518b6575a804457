#include "leeway/collision/time_to_impact.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/base/greatest.h"
#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/lanes/obstacle_boxes.h"
#include "collision/scene/scene_access.h"

namespace leeway::collision {
namespace {

/// A box with this reach contains everything [m].
constexpr auto kBeyondAll = static_cast<double>(kFar);

/// time + wait, rounded down.
double later(double time, double wait) {
  return wait == kInfinity ? kInfinity : std::nextafter(time + wait, -kInfinity);
}

/// Whether all magnitudes are valid; false for NaN.
bool isMotion(const PointMotion& m) {
  return m.speed >= 0 && m.acceleration >= 0 && m.speed_cap >= 0;
}

/// The greatest speed of a motion. Without acceleration, it is the present speed.
double fastest(const PointMotion& m) {
  return m.acceleration == 0 ? std::min(m.speed, m.speed_cap) : m.speed_cap;
}

/// Whether bounds that hold from `old_time` on include all motions that `now` allows from `time`
/// on.
bool covers(const PointMotion& old, double old_time, const PointMotion& now, double time) {
  // The conditions avoid 0 * infinity, because a fixed body has never moved.
  const double passed = time - old_time;
  const double gained = passed > 0 && old.acceleration > 0 ? old.acceleration * passed : 0;
  const double reached = std::min(old.speed_cap, old.speed + gained);
  return isMotion(now) && now.acceleration <= old.acceleration && now.speed_cap <= old.speed_cap &&
         std::min(now.speed, now.speed_cap) <= reached;
}

}  // namespace

PointMotion closing(const PointMotion& a, const PointMotion& b) {
  // In a sum, a negative number would be hidden.
  if (!isMotion(a) || !isMotion(b)) return {kNaN, kNaN, kNaN};
  return {std::min(a.speed, a.speed_cap) + std::min(b.speed, b.speed_cap),
          a.acceleration + b.acceleration, fastest(a) + fastest(b)};
}

double timeToImpact(double gap, const PointMotion& closing) {
  const double cap = closing.speed_cap, a = closing.acceleration;
  // A NaN in any of these gives 0.
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
  // Rounding from cancellation in `rest`: a few roundings of the gap, covered at the cap.
  return std::max(0.0, down(capped) - 16 * kUnitRoundoff * gap / cap);
}

ImpactSchedule::ImpactSchedule(const Scene& scene) : scene_(&scene) {
  const ScenePairs& pairs = scene.pairs();
  const std::size_t bodies = scene.bodies().size(), listed = pairs.listedCount();
  const std::size_t rows = pairs.rows().size(), items = listed + rows;
  motions_.resize(bodies);
  for (std::size_t b = 0; b < bodies; ++b)
    if (scene.bodies()[b].moving) motions_[b].motion = {kInfinity, kInfinity, kInfinity};
  if (rows > 0) {
    is_moved_still_.assign(bodies, 0);
    moved_still_.reserve(bodies - at(pairs.firstStill()));
  }
  due_.assign(items, -kInfinity);
  heap_.resize(items);
  slot_.resize(items);
  looking_.resize(items);
  imminent_.resize(listed + std::min(pairs.size() - listed, kMostNamed));
  first_item_.assign(bodies + 1, 0);
  // Calls visit(body, item) for each item of each body.
  const auto forEach = [&](const auto& visit) {
    for (std::size_t p = 0; p < listed; ++p) {
      visit(pairs[p].body_a, p);
      visit(pairs[p].body_b, p);
    }
    for (std::size_t row = 0; row < rows; ++row) visit(pairs.rows()[row].body, listed + row);
  };
  forEach([&](int body, std::size_t) { ++first_item_[at(body) + 1]; });
  for (std::size_t b = 0; b < bodies; ++b) first_item_[b + 1] += first_item_[b];
  items_of_body_.resize(at(first_item_[bodies]));
  std::vector<std::int32_t> next(first_item_.begin(), first_item_.end() - 1);
  forEach([&](int body, std::size_t item) {
    items_of_body_[at(next[at(body)]++)] = static_cast<std::int32_t>(item);
  });
  for (std::size_t item = 0; item < items; ++item)
    place(item, static_cast<std::int32_t>(item));  // all are due at once, so any order is a heap
  for (std::size_t row = 0; row < rows; ++row) {
    std::int32_t first = -1;
    for (std::size_t place = 0; pairs.rows()[row].count > 0 && first < 0; ++place)
      first = pairs.numberOf(row, place);
    next_of_row_.push_back(first);
    if (first < 0) setDue(static_cast<std::int32_t>(listed + row), kInfinity);
  }
}

bool ImpactSchedule::isEmptyRow(std::int32_t item) const {
  const std::size_t listed = scene_->pairs().listedCount();
  return at(item) >= listed && next_of_row_[at(item) - listed] < 0;
}

std::size_t ImpactSchedule::itemOf(int pair) const {
  const ScenePairs& pairs = scene_->pairs();
  const std::size_t listed = pairs.listedCount();
  return at(pair) < listed ? at(pair) : listed + pairs.placeOf(at(pair)).row;
}

PointMotion ImpactSchedule::motionAt(int body, double time) const {
  const TimedMotion& last = motions_[at(body)];
  PointMotion motion = last.motion;
  // The conditions avoid 0 * infinity: unbounded acceleration counts only after some time has
  // passed.
  const double passed = time - last.time;
  if (passed > 0 && motion.acceleration > 0) motion.speed += motion.acceleration * passed;
  motion.speed = std::min(motion.speed, motion.speed_cap);
  return motion;
}

PointMotion ImpactSchedule::fastestStill(double time) const {
  PointMotion most{0, 0, 0};
  for (const std::int32_t body : moved_still_) {
    const PointMotion motion = motionAt(body, time);
    if (!isMotion(motion)) return {kNaN, kNaN, kNaN};
    most = {greatest(most.speed, motion.speed), greatest(most.acceleration, motion.acceleration),
            greatest(most.speed_cap, motion.speed_cap)};
  }
  return most;
}

void ImpactSchedule::setMotion(int body, const PointMotion& motion, double time) {
  TimedMotion& last = motions_[at(body)];
  const bool covered = covers(last.motion, last.time, motion, time);
  last = {motion, std::max(last.time, time)};
  if (covered) return;
  // A time of NaN also makes an item due.
  const auto hasten = [&](std::int32_t item) {
    if (!(due_[at(item)] <= time) && !isEmptyRow(item)) setDue(item, time);
  };
  for (std::int32_t i = first_item_[at(body)]; i < first_item_[at(body) + 1]; ++i)
    hasten(items_of_body_[at(i)]);
  const ScenePairs& pairs = scene_->pairs();
  if (pairs.places() == 0 || body < pairs.firstStill()) return;
  if (scene_->bodies()[at(body)].size() == 0) return;
  if (!std::exchange(is_moved_still_[at(body)], true)) moved_still_.push_back(body);
  for (std::size_t row = 0; row < pairs.rows().size(); ++row)
    hasten(static_cast<std::int32_t>(pairs.listedCount() + row));
}

double ImpactSchedule::look(int p, double time, double horizon, Workspace& workspace,
                            bool& violated) {
  const ScenePair& pair = scene_->pairs()[at(p)];
  const PointMotion motion = closing(motionAt(pair.body_a, time), motionAt(pair.body_b, time));
  const double coarse = coarseLowerBound(*scene_, workspace, p) - pair.margin;
  const double due = later(time, timeToImpact(coarse, motion));
  ++statistics.looks;
  // Coarse bounds postpone the pair by long enough, so no exact query is needed yet.
  if (due >= time + kImpactHorizons * horizon && due > time) return due;
  DistanceRequest request;
  request.tolerance = std::max(kImpactTolerance, kImpactShare * std::max(0.0, coarse));
  request.depth = pair.margin < 0;
  const DistanceResult result = pairDistance(*scene_, workspace, p, request);
  ++statistics.exact;
  violated = result.distance.upper <= pair.margin;
  return std::max(due, later(time, timeToImpact(result.distance.lower - pair.margin, motion)));
}

double ImpactSchedule::lookAtRow(std::size_t row, double time, double horizon, Workspace& workspace,
                                 ImpactReport& report) {
  const ScenePairs& pairs = scene_->pairs();
  const ScenePairs::Row& of = pairs.rows()[row];
  const double end = time + horizon, margin = of.most;
  const PointMotion motion = closing(motionAt(of.body, time), fastestStill(time));
  const double radius = SceneAccess::bounds(*scene_, of.body, of.geometry).outer.radius;
  // The reach of the motions until the row is due again, and then up to the first pair.
  const double wait = kImpactHorizons * horizon;
  double reach =
      std::min(motion.speed_cap * wait, (motion.speed + motion.acceleration * wait) * wait);
  if (!(reach < kBeyondAll)) reach = 0;
  reach = std::max({reach, std::min(radius, kBeyondAll), kImpactTolerance});  // above 0, because it
                                                                              // doubles
  const std::size_t first = imminent_count_;
  const int imminent_before = report.imminent;
  double due = kInfinity;
  bool found = false;
  const auto look_at = [&](std::int32_t pair) {
    bool violated = false;
    double pair_due = look(pair, time, horizon, workspace, violated);
    if (std::isnan(pair_due)) pair_due = -kInfinity;
    if (pair_due < end || violated) addImminent(pair, report);
    if (violated) ++report.violated;
    if (!found || pair_due < due) next_of_row_[row] = pair;
    due = std::min(due, pair_due);
    found = true;
    return true;
  };
  for (;; reach *= 2) {
    forEachNearInRow(*scene_, workspace, row,
                     std::isnan(margin) ? kInfinity : std::max(margin, 0.0) + reach, look_at);
    if (found || !(reach < kBeyondAll)) break;
  }
  const double due_of_others = later(time, timeToImpact(reach, motion));
  if (due_of_others < end) {
    // The speed of some body is not bounded.
    imminent_count_ = first;
    report.imminent = imminent_before;
    for (std::size_t place = 0; place < pairs.places(); ++place)
      if (const std::int32_t pair = pairs.numberOf(row, place); pair >= 0)
        addImminent(pair, report);
  } else {
    std::sort(imminent_.begin() + static_cast<std::ptrdiff_t>(first),
              imminent_.begin() + static_cast<std::ptrdiff_t>(imminent_count_));
  }
  return std::min(due, due_of_others);
}

void ImpactSchedule::addImminent(std::int32_t pair, ImpactReport& report) {
  ++report.imminent;
  if (imminent_count_ < imminent_.size()) imminent_[imminent_count_++] = pair;
}

ImpactReport ImpactSchedule::advance(double time, double horizon, Workspace& workspace) {
  ++statistics.advances;
  if (horizon < 0) horizon = 0;
  const double end = time + horizon;
  ImpactReport report;
  imminent_count_ = 0;
  if (std::isnan(end)) {
    report.safe_until = -kInfinity;
    return report;
  }
  // All due items are removed before any is put back, so that one that stays due is checked once.
  std::size_t count = 0;
  while (!heap_.empty() && due_[at(heap_.front())] < end) {
    looking_[count++] = heap_.front();
    setDue(heap_.front(), kInfinity);
  }
  std::sort(looking_.begin(), looking_.begin() + static_cast<std::ptrdiff_t>(count));
  const std::size_t listed = scene_->pairs().listedCount();
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t item = looking_[i];
    if (at(item) >= listed) {
      setDue(item, lookAtRow(at(item) - listed, time, horizon, workspace, report));
      continue;
    }
    bool violated = false;
    const double due = look(item, time, horizon, workspace, violated);
    setDue(item, due);
    if (due < end || violated) addImminent(item, report);
    if (violated) ++report.violated;
  }
  report.safe_until = safeUntil();
  if (!heap_.empty())
    report.next_pair =
        at(heap_.front()) < listed ? heap_.front() : next_of_row_[at(heap_.front()) - listed];
  return report;
}

double ImpactSchedule::safeUntil() const {
  return heap_.empty() ? kInfinity : due_[at(heap_.front())];
}

bool ImpactSchedule::before(std::int32_t a, std::int32_t b) const {
  return due_[at(a)] != due_[at(b)] ? due_[at(a)] < due_[at(b)] : a < b;
}

void ImpactSchedule::place(std::size_t slot, std::int32_t item) {
  heap_[slot] = item;
  slot_[at(item)] = static_cast<std::int32_t>(slot);
}

void ImpactSchedule::setDue(std::int32_t item, double due) {
  // NaN proves nothing, so the item is due now.
  due_[at(item)] = std::isnan(due) ? -kInfinity : due;
  siftUp(at(slot_[at(item)]));
  siftDown(at(slot_[at(item)]));
}

void ImpactSchedule::siftUp(std::size_t slot) {
  const std::int32_t item = heap_[slot];
  while (slot > 0 && before(item, heap_[(slot - 1) / 2])) {
    place(slot, heap_[(slot - 1) / 2]);
    slot = (slot - 1) / 2;
  }
  place(slot, item);
}

void ImpactSchedule::siftDown(std::size_t slot) {
  const std::int32_t item = heap_[slot];
  for (std::size_t child; (child = 2 * slot + 1) < heap_.size(); slot = child) {
    if (child + 1 < heap_.size() && before(heap_[child + 1], heap_[child])) ++child;
    if (!before(heap_[child], item)) break;
    place(slot, heap_[child]);
  }
  place(slot, item);
}

}  // namespace leeway::collision
