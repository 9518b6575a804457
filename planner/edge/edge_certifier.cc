#include "leeway/planner/edge_certifier.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/mesh/descent/sweep_fronts.h"
#include "collision/scene/scene_access.h"
#include "planner/base/tolerances.h"
#include "planner/edge/edge_certifier_impl.h"

namespace leeway::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kAllLanes = (1U << collision::kLanes) - 1;

/// Pairs that are looked at more closely before planes are looked for, and looks at single
/// configurations of an edge before its pairs are swept [count].
constexpr int kLooks = 3;

/// What a pair has when an exact look has just found it in contact; see Impl::luck.
constexpr int kLuckOfLook = 2;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

EdgeCertifier::Impl::Impl(std::shared_ptr<const CompiledScene> compiled)
    : scene(std::move(compiled)),
      frames(scene, kEdgeSlots),
      lanes(frames),
      workspace(scene->scene()) {
  workspace.pose_error = scene->rounding();
  collision::countInto(collision::SceneAccess::scratch(workspace), work);
  lanes.countInto(work);
  frames.countInto(work);
  motion.resize(scene->motions().size());
  world_balls.resize(frames.pieces().size());
  shared_slots.resize(kSharedSlots + 1);
  const std::size_t lists =
      std::max<std::size_t>(kEdgeOpen, collision::kLanes * frames.pairs().size());
  for (std::vector<int>* list : {&open, &next_open}) list->reserve(lists);
  order.reserve(frames.pairs().size());
  edge_parts.reserve(kEdgeParts);
  part_pairs.reserve(lists);
  pass_pairs.reserve(frames.pairs().size());
  open_everywhere.reserve(frames.pairs().size());
  hopeful.assign(frames.pairs().size(), kSweepGrowth);
  failed_stamp.resize(frames.pairs().size());
  end_looked.resize(frames.pairs().size());
  stretches.reserve(kEdgeStretches);
  luck.assign(frames.pairs().size(), 0);
  closer_luck.assign(frames.pairs().size(), 0);
  closer_looks.reserve(kLooks);
  for (std::vector<EdgeInterval>* list : {&intervals, &next_intervals})
    list->reserve(kEdgeIntervals);
}

EdgeCertifier::EdgeCertifier(std::shared_ptr<const CompiledScene> scene)
    : impl_(std::make_unique<Impl>(std::move(scene))) {
  impl_->statistics = &statistics;
}
EdgeCertifier::~EdgeCertifier() = default;

const CompiledScene& EdgeCertifier::scene() const { return *impl_->scene; }

void EdgeCertifier::rebind(std::shared_ptr<const CompiledScene> scene) {
  impl_->frames.rebind(scene);
  impl_->lanes_fit = false;  // they hold shapes and margins of the scene before
  impl_->scene = std::move(scene);
  impl_->workspace.prepare(impl_->scene->scene());
  impl_->startInterval();  // balls of the intervals before are those of other shapes
}

Verdict EdgeCertifier::decide(std::span<const double> point) {
  ++statistics.states;
  Impl& impl = *impl_;
  impl.startWork();
  int pair = -1;
  if (!impl.frames.begin(point, point)) return Verdict::kUndecided;
  const int slot = impl.frames.place(0);
  return slot < 0 ? Verdict::kUndecided : impl.checkState(slot, 0, pair);
}

StateCheck EdgeCertifier::clearance(std::span<const double> point, double tolerance) {
  ++statistics.states;
  Impl& impl = *impl_;
  impl.startWork();
  StateCheck check;
  if (!impl.frames.begin(point, point)) return check;
  const int slot = impl.frames.place(0);
  if (slot < 0) return check;
  const std::span<const Pose> X_WL = impl.frames.links(slot);
  for (std::size_t b = 0; b < impl.scene->scene().bodies().size(); ++b) {
    const int link = impl.scene->bodyLink(static_cast<int>(b));
    if (link >= 0) impl.workspace.setPose(static_cast<int>(b), X_WL[at(link)]);
  }
  const std::uint64_t before = impl.workspace.statistics.exact;
  const collision::SceneResult result =
      collision::clearance(impl.scene->scene(), impl.workspace, tolerance);
  statistics.distance_queries += impl.workspace.statistics.exact - before;
  check.verdict = result.verdict;
  check.clearance = result.clearance;
  check.pair = result.pair;
  check.closest = result.closest;
  return check;
}

EdgeCheck EdgeCertifier::certify(std::span<const double> a, std::span<const double> b,
                                 const EdgeRequest& request) {
  ++statistics.edges;
  if (trace != nullptr) {
    trace->emplace_back(a.begin(), a.end());
    trace->emplace_back(b.begin(), b.end());
  }
  Impl& impl = *impl_;
  ++impl.edge;
  impl.work_limit = request.work_limit > 0     ? request.work_limit
                    : impl.frames.hasFlights() ? kFlightWork
                                               : kEdgeWork;
  impl.startWork(impl.work_limit);
  impl.smallest = request.smallest_interval;
  EdgeCheck check;
  if (!impl.frames.begin(a, b)) return check;
  const collision::SweepFronts fronts(collision::SceneAccess::scratch(impl.workspace));
  const bool by_lanes = impl.lanes_fit && impl.lanes.begin(impl.frames);
  check = by_lanes ? impl.certifyByLanes() : impl.certifyByLevels();
  if (check.verdict == Verdict::kFree)
    check.last_valid = 1;
  else if (request.last_valid)
    impl.findLastValid(request, check);
  return check;
}

EdgeRequest EdgeRequest::persistent() {
  EdgeRequest request;
  request.work_limit = kPersistentWork;
  return request;
}

const robots::MotionBound& EdgeCertifier::Impl::motionOf(const EdgeInterval& interval, int m) {
  MotionMemory& memory = motion[at(m)];
  if (memory.stamp == stamp) return memory.bound;
  // Each end speaks for the half of the interval that is next to it. Intervals of a level stand
  // side by side: what was the right end of the last one looked at is the left end of this.
  const double half = interval.h / 2;
  const robots::MotionBound left = memory.generation == frames.generation() &&
                                           memory.slot == interval.slot0 && memory.half == half
                                       ? memory.right
                                       : frames.motionNear(m, interval.slot0, half);
  memory.right = frames.motionNear(m, interval.slot1, half);
  memory.generation = frames.generation();
  memory.slot = interval.slot1;
  memory.half = half;
  memory.stamp = stamp;
  memory.bound = {std::max(left.speed, memory.right.speed),
                  std::max(left.acceleration, memory.right.acceleration)};
  return memory.bound;
}

const EdgeCertifier::Impl::SweptBall& EdgeCertifier::Impl::worldBall(const EdgeInterval& interval,
                                                                     const EdgePair& pair) {
  SweptBall& ball = world_balls[at(pair.a)];
  if (ball.stamp == stamp) return ball;
  ball = sweptBall(interval, pair, frames.center(interval.slot0, pair.a),
                   frames.center(interval.slot1, pair.a));
  return ball;
}

EdgeCertifier::Impl::SweptBall EdgeCertifier::Impl::sweptBall(const EdgeInterval& interval,
                                                              const EdgePair& pair,
                                                              const Eigen::Vector3d& c0,
                                                              const Eigen::Vector3d& c1) {
  // No point leaves the chord between its two places by more than h^2 A / 8.
  const double growth = interval.h * interval.h * motionOf(interval, pair.motion).acceleration / 8;
  const double radius =
      (c1 - c0).norm() / 2 + growth + frames.pieces()[at(pair.a)].bounds->outer.radius;
  return {(c0 + c1) / 2, radius, growth, stamp};
}

double EdgeCertifier::Impl::coarseSweep(const EdgeInterval& interval, const EdgePair& pair,
                                        double& growth) {
  const Piece& b = frames.pieces()[at(pair.b)];
  const SweptBall ball =
      b.link < 0
          ? worldBall(interval, pair)
          : sweptBall(
                interval, pair,
                frames.inFrameOf(interval.slot0, pair.b, frames.center(interval.slot0, pair.a)),
                frames.inFrameOf(interval.slot1, pair.b, frames.center(interval.slot1, pair.a)));
  growth = ball.growth;
  const double lower = b.bounds->coarse.lower(ball.center) - ball.radius;
  return std::isnan(lower) ? -kInfinity : lower;
}

Interval EdgeCertifier::Impl::sweep(const EdgeInterval& interval, const EdgePair& pair,
                                    double growth, double threshold, int nodes) {
  collision::DistanceRequest request;
  request.threshold = threshold;
  request.depth = false;
  if (nodes > 0) request.node_limit = nodes;
  ++queries;
  ++statistics->distance_queries;
  const collision::Shape& a = frames.pieces()[at(pair.a)].geometry->shape;
  const collision::Shape& b = frames.pieces()[at(pair.b)].geometry->shape;
  Interval distance =
      collision::sweptDistance(a, frames.relative(interval.slot0, pair),
                               frames.relative(interval.slot1, pair), growth, b, request,
                               collision::SceneAccess::scratch(workspace),
                               &collision::SceneAccess::cache(workspace, pair.scene_pair))
          .distance;
  // Where depth is allowed, a body inside a mesh may be at the edge's end, and come too deep
  // without a meeting of surfaces. Below zero the sweep's bound is that of the hulls and holds as
  // it is.
  if (threshold < pair.rounding && distance.lower > 0 && !frames.isConvex(pair)) {
    request.threshold = pair.rounding;
    if (!(distance.lower > pair.rounding &&
          stateDistance(interval.slot0, pair, request).distance.lower > pair.rounding))
      distance.lower = -kInfinity;
  }
  return distance;
}

int EdgeCertifier::Impl::slotAt(double t) {
  const double place = t * kSharedSlots;
  if (place != std::floor(place)) return frames.place(t);
  SharedSlot& shared = shared_slots[static_cast<std::size_t>(place)];
  if (shared.slot < 0 || shared.generation != frames.generation())
    shared = {frames.generation(), frames.place(t)};
  return shared.slot;
}

class EdgeCertifier::Impl::PairPlacements final : public collision::Placements {
 public:
  PairPlacements(Impl& impl, const EdgePair& pair) : impl_(impl), pair_(pair) {}
  bool at(double t, Pose& X_BA) override {
    const int slot = impl_.slotAt(t);
    if (slot < 0) return false;
    X_BA = impl_.frames.relative(slot, pair_);
    return true;
  }

 private:
  Impl& impl_;
  const EdgePair& pair_;
};

collision::MeshSweepResult EdgeCertifier::Impl::sweepSurfaces(const EdgeInterval& interval,
                                                              const EdgePair& pair) {
  ++statistics->distance_queries;
  collision::MeshSweepRequest request;
  request.t0 = interval.t0;
  request.h = interval.h;
  request.bend = motionOf(interval, pair.motion).acceleration / 8;
  request.threshold = pair.threshold;
  request.least_motion = kSmallestMotion;
  request.least_time = smallest;
  const int mark = frames.used();
  PairPlacements placements(*this, pair);
  const collision::MeshSweepResult result =
      collision::sweepMesh(frames.pieces()[at(pair.a)].geometry->shape, placements,
                           frames.pieces()[at(pair.b)].geometry->shape, request,
                           collision::SceneAccess::scratch(workspace));
  // Its short parts took places that nobody asks for again: a few of these would be all there are.
  if (result.status == collision::MeshSweepStatus::kUndecided) frames.release(mark);
  return result;
}

bool EdgeCertifier::Impl::examine(EdgeInterval& interval, std::vector<int>& list, int& offender,
                                  double& t) {
  ++statistics->intervals;
  startInterval();
  int kept = interval.begin;
  for (int i = interval.begin; i < interval.end; ++i) {
    const int p = list[at(i)];
    const EdgePair& pair = frames.pairs()[at(p)];
    if (work.isSpent()) {
      list[at(kept++)] = p;
      continue;
    }
    double growth = 0;
    if (coarseSweep(interval, pair, growth) > pair.threshold ||
        frames.keepsGap(pair, interval.t0, interval.t0 + interval.h))
      continue;
    if (pair.by_surfaces) {
      const collision::MeshSweepResult result = sweepSurfaces(interval, pair);
      if (result.status == collision::MeshSweepStatus::kFree) continue;
      if (result.status == collision::MeshSweepStatus::kContact) {
        offender = p;
        t = result.t;
        for (; i < interval.end; ++i) list[at(kept++)] = list[at(i)];
        interval.end = kept;
        return false;
      }
    } else if (growth <= hopeful[at(p)]) {
      const Interval distance = sweep(interval, pair, growth, pair.threshold,
                                      growth > kDeepSweepGrowth ? kShallowNodes : 0);
      if (distance.lower > pair.threshold) {
        hopeful[at(p)] = std::min(std::max(hopeful[at(p)], growth) * kHopeRegained, kSweepGrowth);
        continue;
      }
      // What a sweep of more work would have proven says nothing of growths.
      if (!work.isSpent())
        hopeful[at(p)] = std::max({growth * kHopeLost, hopeful[at(p)] / 2, kLeastHope});
      failed_stamp[at(p)] = stamp;
      if (distance.upper <= pair.threshold) {
        offender = p;
        // At one end or the other.
        const bool at_begin = exactState(interval.slot0, pair) == Pair::kNotFree;
        t = at_begin ? interval.t0 : interval.t0 + interval.h;
        for (; i < interval.end; ++i)
          list[at(kept++)] = list[at(i)];  // this one and those not looked at
        interval.end = kept;
        return false;
      }
    }
    list[at(kept++)] = p;
  }
  interval.end = kept;
  return true;
}

EdgeCheck EdgeCertifier::Impl::told(Verdict verdict, int p, double t) {
  EdgeCheck check;
  check.verdict = verdict;
  check.pair = p < 0 ? -1 : frames.pairs()[at(p)].scene_pair;
  check.t = t;
  if (verdict == Verdict::kNotFree && p >= 0) {
    killer = p;
    luck[at(p)] = std::max(luck[at(p)], 1);
    closer_luck[at(p)] = 1;
  }
  return check;
}

EdgeCheck EdgeCertifier::Impl::certifyByLanes() {
  const collision::LaneSweep::Contact contact = lanes.sweep();
  const EdgeLanes::Parts parts = EdgeLanes::wholeEdge();
  if (contact.id >= 0)
    return told(Verdict::kNotFree, contact.id, parts.from[contact.lane] + parts.width / 2);
  lanes.closeGaps(frames);
  if (lanes.open().empty()) return told(Verdict::kFree, -1, 0);
  const EdgeCheck closer = lookCloser(parts);
  if (closer.verdict != Verdict::kFree) return closer;
  const collision::LaneSweep::Contact parted = lanes.part();
  if (parted.id >= 0)
    return told(Verdict::kNotFree, parted.id, parts.from[parted.lane] + parts.width / 2);
  if (lanes.open().empty()) return told(Verdict::kFree, -1, 0);
  if (work.isSpent()) return told(Verdict::kUndecided, lanes.open().front().id, 0);
  looks = 0;
  const EdgeCheck open_check = checkOpen(parts);
  if (open_check.verdict != Verdict::kFree) return open_check;
  open_everywhere.clear();
  for (const collision::LaneSweep::Open& pair : lanes.open())
    if (pair.lanes == kAllLanes && !frames.isConvex(frames.pairs()[at(pair.id)]))
      open_everywhere.push_back(pair.id);
  intervals.clear();
  open.clear();
  edge_parts.clear();
  part_pairs.clear();
  if (!listOpenLanes() || !listParts(parts)) return told(Verdict::kUndecided, -1, 0);
  if (const std::optional<EdgeCheck> check = certifyParts()) return *check;
  if (!mergeIntervals()) return told(Verdict::kUndecided, -1, 0);
  if (intervals.empty()) return told(Verdict::kFree, -1, 0);
  if (work.isSpent())
    return told(Verdict::kUndecided, open[at(intervals.front().begin)], intervals.front().t0);
  const EdgeCheck inside = checkInside();
  return inside.verdict == Verdict::kFree ? certifyIntervals() : inside;
}

EdgeCheck EdgeCertifier::Impl::lookCloser(const EdgeLanes::Parts& parts) {
  // A contact between the middles of lanes, or where only more points tell it, is found for less
  // than planes are looked for. What the last look at a pair found in contact is asked exactly,
  // too.
  closer_looks.clear();
  for (const collision::LaneSweep::Open& o : lanes.open()) {
    if (closer_luck[at(o.id)] < 0) continue;
    if (closer_looks.size() == kLooks || work.isSpent()) break;
    const auto [from, width] = rangeOf(parts, o.lanes);
    if (const std::optional<double> t = lanes.meet(o.id, from, width))
      return told(Verdict::kNotFree, o.id, *t);
    --closer_luck[at(o.id)];
    closer_looks.push_back({o.id, from, width, luck[at(o.id)] >= kLuckOfLook});
    if (!closer_looks.back().exact) continue;
    const EdgeCheck look = lookAt(o.id, from + width / 2);
    if (look.verdict != Verdict::kFree) return look;
  }
  return told(Verdict::kFree, -1, 0);
}

std::pair<double, double> EdgeCertifier::Impl::rangeOf(const EdgeLanes::Parts& parts,
                                                       std::uint32_t open_lanes) {
  double from = 1, to = 0;  // parts do not always stand in the order of time
  for (int lane = 0; lane < collision::kLanes; ++lane) {
    if ((open_lanes >> lane & 1U) == 0) continue;
    from = std::min(from, parts.from[lane]);
    to = std::max(to, parts.from[lane] + parts.width);
  }
  return {from, to - from};
}

EdgeCheck EdgeCertifier::Impl::lookAt(int p, double t) {
  const int slot = frames.place(t);
  if (slot < 0) return told(Verdict::kUndecided, p, t);
  if (exactState(slot, frames.pairs()[at(p)]) == Pair::kNotFree) {
    luck[at(p)] = kLuckOfLook;
    return told(Verdict::kNotFree, p, t);
  }
  --luck[at(p)];
  return told(Verdict::kFree, -1, 0);
}

EdgeCheck EdgeCertifier::Impl::checkOpen(const EdgeLanes::Parts& parts) {
  // What collides without being seen in lanes most often does so in the middle of where it is near.
  // Pairs that are always near and hardly ever collide are not looked at.
  for (const collision::LaneSweep::Open& o : lanes.open()) {
    if (o.apart || luck[at(o.id)] < 0) continue;
    if (looks >= kLooks || work.isSpent()) break;
    const auto [from, width] = rangeOf(parts, o.lanes);
    // Planes may have left a pair open over the same range: the same looks would find the same.
    const auto same = [&, from = from, width = width](const CloserLook& look) {
      return look.pair == o.id && look.from == from && look.width == width;
    };
    const auto before = std::find_if(closer_looks.begin(), closer_looks.end(), same);
    const bool again = before != closer_looks.end();
    if (again && before->exact) continue;
    ++looks;
    if (!again) {
      if (const std::optional<double> t = lanes.meet(o.id, from, width))
        return told(Verdict::kNotFree, o.id, *t);
    }
    const EdgeCheck look = lookAt(o.id, from + width / 2);
    if (look.verdict != Verdict::kFree) return look;
  }
  return told(Verdict::kFree, -1, 0);
}

EdgeCheck EdgeCertifier::Impl::checkInside() {
  // A pair that is certified by balls or planes anywhere is apart there, and cannot come to be
  // inside one another without a meeting of surfaces; the others are looked at once.
  int end = -1;
  for (const int p : open_everywhere) {
    if (std::find(open.begin(), open.end(), p) == open.end()) continue;
    if (end < 0) end = frames.place(1);
    if (end < 0) return told(Verdict::kUndecided, p, 1);
    const Pair found = exactState(end, frames.pairs()[at(p)]);
    if (found != Pair::kFree)
      return told(found == Pair::kNotFree ? Verdict::kNotFree : Verdict::kUndecided, p, 1);
  }
  return told(Verdict::kFree, -1, 0);
}

bool EdgeCertifier::Impl::listParts(const EdgeLanes::Parts& parts) {
  if (open.size() + lanes.open().size() * collision::kLanes > open.capacity()) return false;
  for (int first = 0; first < collision::kLanes; first += parts.share) {
    if (!listWideOpen(parts, first)) return false;
    for (int lane = first; lane < first + parts.share; ++lane)
      if (!listLane(parts, lane, first)) return false;
  }
  return true;
}

bool EdgeCertifier::Impl::isWideOpen(const collision::LaneSweep::Open& pair, int first,
                                     int share) const {
  const std::uint32_t mask = ((1U << share) - 1) << first;
  return share > 1 && 2 * std::popcount(pair.lanes & mask) > share;
}

bool EdgeCertifier::Impl::listWideOpen(const EdgeLanes::Parts& parts, int first) {
  bool has_interval = false;
  for (const collision::LaneSweep::Open& pair : lanes.open()) {
    if (!isWideOpen(pair, first, parts.share)) continue;
    if (!has_interval && !addInterval(parts.from[first], parts.width * parts.share)) return false;
    has_interval = true;
    open.push_back(pair.id);
    intervals.back().end = static_cast<int>(open.size());
  }
  return true;
}

bool EdgeCertifier::Impl::listLane(const EdgeLanes::Parts& parts, int lane, int first) {
  const bool is_whole = parts.share == 1;  // listOpenLanes() has the others
  if (part_pairs.size() + lanes.open().size() > part_pairs.capacity()) return false;
  const auto begin = static_cast<int>(part_pairs.size());
  bool has_interval = false;
  for (const collision::LaneSweep::Open& pair : lanes.open()) {
    if ((pair.lanes >> lane & 1U) == 0 || isWideOpen(pair, first, parts.share)) continue;
    if (is_whole ? isForParts(pair) : pair.apart) {
      part_pairs.push_back(pair.id);
    } else if (!is_whole) {
      if (!has_interval && !addInterval(parts.from[lane], parts.width)) return false;
      has_interval = true;
      open.push_back(pair.id);
      intervals.back().end = static_cast<int>(open.size());
    }
  }
  const auto end = static_cast<int>(part_pairs.size());
  if (begin == end) return true;
  if (edge_parts.size() == edge_parts.capacity()) return false;
  edge_parts.push_back({parts.from[lane], parts.width, begin, end});
  return true;
}

bool EdgeCertifier::Impl::addInterval(double from, double width) {
  const int first = slotAt(from), last = slotAt(from + width);
  if (first < 0 || last < 0 || intervals.size() == intervals.capacity()) return false;
  const auto size = static_cast<int>(open.size());
  intervals.push_back({first, last, from, width, size, size, 0});
  return true;
}

EdgeLanes::Parts EdgeCertifier::Impl::takeParts(std::size_t& next) {
  // One, two or four of the same width, each divided to fill all lanes.
  const double width = edge_parts[next].width;
  std::size_t count = 1;
  while (count < std::min<std::size_t>(4, edge_parts.size() - next) &&
         edge_parts[next + count].width == width)
    ++count;
  const int share = collision::kLanes / (count == 3 ? 4 : static_cast<int>(count));
  EdgeLanes::Parts parts;
  parts.width = width / share;
  parts.share = share;
  pass_pairs.clear();
  for (std::size_t k = 0; k < count; ++k, ++next) {
    const EdgePart& part = edge_parts[next];
    const int lane = static_cast<int>(k) * share;
    for (int i = 0; i < share; ++i) parts.from[lane + i] = part.from + i * parts.width;
    const std::uint32_t mask = ((1U << share) - 1) << lane;
    for (int i = part.begin; i < part.end; ++i) {
      const int id = part_pairs[at(i)];
      const auto known = std::find_if(pass_pairs.begin(), pass_pairs.end(),
                                      [id](const auto& pair) { return pair.id == id; });
      if (known == pass_pairs.end())
        pass_pairs.push_back({id, mask});
      else
        known->lanes |= mask;
    }
  }
  return parts;
}

std::optional<EdgeCheck> EdgeCertifier::Impl::certifyParts() {
  std::size_t next = 0;
  for (int passes = 0; next < edge_parts.size() && passes < kLanePasses; ++passes) {
    if (edge_parts[next].width <= kFinestPart) break;
    if (work.isSpent())
      return told(Verdict::kUndecided, part_pairs[at(edge_parts[next].begin)],
                  edge_parts[next].from);
    const EdgeLanes::Parts parts = takeParts(next);
    const collision::LaneSweep::Contact met = lanes.sweepParts(parts, pass_pairs);
    if (met.id >= 0) return told(Verdict::kNotFree, met.id, parts.from[met.lane] + parts.width / 2);
    const EdgeCheck check = checkOpen(parts);
    if (check.verdict != Verdict::kFree) return check;
    if (!listParts(parts)) return told(Verdict::kUndecided, -1, parts.from[0]);
  }
  if (!listPartsLeft(next)) return told(Verdict::kUndecided, -1, edge_parts[next].from);
  return std::nullopt;
}

bool EdgeCertifier::Impl::listPartsLeft(std::size_t& next) {
  for (; next < edge_parts.size(); ++next) {
    const EdgePart& part = edge_parts[next];
    if (!addInterval(part.from, part.width) ||
        open.size() + at(part.end - part.begin) > open.capacity())
      return false;
    open.insert(open.end(), part_pairs.begin() + part.begin, part_pairs.begin() + part.end);
    intervals.back().end = static_cast<int>(open.size());
  }
  return true;
}

std::size_t EdgeCertifier::Impl::mergeStretches() {
  std::sort(stretches.begin(), stretches.end(), [](const Stretch& x, const Stretch& y) {
    return x.pair != y.pair ? x.pair < y.pair : x.from < y.from;
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < stretches.size();) {
    Stretch merged = stretches[i++];
    const EdgePair& pair = frames.pairs()[at(merged.pair)];
    // Of the whole edge at once; it falls with the square of the width.
    const double growth = lanes.growth(pair.motion) * collision::kLanes * collision::kLanes;
    const auto fits = [&](const Stretch& next) {
      const double width = merged.width + next.width;
      return next.pair == merged.pair && next.from == merged.from + merged.width &&
             width * width * growth <= kMergedAgainGrowth;
    };
    while (!pair.by_surfaces && i < stretches.size() && fits(stretches[i]))
      merged.width += stretches[i++].width;
    stretches[kept++] = merged;
  }
  return kept;
}

bool EdgeCertifier::Impl::mergeIntervals() {
  if (intervals.size() < 2 || open.size() > stretches.capacity()) return true;
  stretches.clear();
  for (const EdgeInterval& interval : intervals)
    for (int i = interval.begin; i < interval.end; ++i)
      stretches.push_back({open[at(i)], interval.t0, interval.h});
  const std::size_t kept = mergeStretches();
  if (kept == stretches.size()) return true;
  stretches.resize(kept);
  std::sort(stretches.begin(), stretches.end(), [](const Stretch& x, const Stretch& y) {
    return x.from != y.from     ? x.from < y.from
           : x.width != y.width ? x.width > y.width
                                : x.pair < y.pair;
  });
  intervals.clear();
  open.clear();
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    const Stretch& s = stretches[i];
    const bool begins =
        i == 0 || s.from != stretches[i - 1].from || s.width != stretches[i - 1].width;
    if (begins && !addInterval(s.from, s.width)) return false;
    open.push_back(s.pair);
    intervals.back().end = static_cast<int>(open.size());
  }
  return true;
}

bool EdgeCertifier::Impl::isAskedOver(const collision::LaneSweep::Open& pair, int lane,
                                      int width) const {
  const auto block = [](int first, int count) { return ((1U << count) - 1) << first; };
  const std::uint32_t lanes_asked = block(lane, width);
  if (!frames.pairs()[at(pair.id)].by_surfaces)
    return (pair.lanes & lanes_asked) != 0 && mergedLanes(pair) == width;
  // Long parts are halved where that pays while they are swept: the widest blocks that are open.
  if ((pair.lanes & lanes_asked) != lanes_asked) return false;
  if (width == collision::kLanes) return true;
  const std::uint32_t wider = block(lane & ~(2 * width - 1), 2 * width);
  return (pair.lanes & wider) != wider;
}

int EdgeCertifier::Impl::mergedLanes(const collision::LaneSweep::Open& pair) const {
  double growth = lanes.growth(frames.pairs()[at(pair.id)].motion);
  int width = 1;
  while (width < collision::kLanes && 4 * growth <= kMergedGrowth) {
    growth *= 4;
    width *= 2;
  }
  return width;
}

bool EdgeCertifier::Impl::listOpenLanes() {
  int slots[collision::kLanes + 1];
  std::fill(std::begin(slots), std::end(slots), -1);
  // Widest first: blocks of lanes, each with the pairs that are asked over so many at once.
  for (int width = collision::kLanes, level = 0; width >= 1; width /= 2, ++level) {
    for (int lane = 0; lane < collision::kLanes; lane += width) {
      const auto begin = static_cast<int>(open.size());
      for (const collision::LaneSweep::Open& pair : lanes.open())
        if (!isForParts(pair) && isAskedOver(pair, lane, width)) open.push_back(pair.id);
      const auto end = static_cast<int>(open.size());
      if (begin == end) continue;
      constexpr double h = 1.0 / collision::kLanes;
      for (const int i : {lane, lane + width}) {
        if (slots[i] < 0) slots[i] = slotAt(i * h);
        if (slots[i] < 0) return false;
      }
      intervals.push_back(
          {slots[lane], slots[lane + width], lane * h, width * h, begin, end, level});
    }
  }
  return true;
}

EdgeCheck EdgeCertifier::Impl::certifyByLevels() {
  const int end = frames.place(1);
  int offender = -1;
  // The end decides most edges; it also settles for all of a certified edge that nothing is inside
  // a solid.
  const Verdict at_end = end < 0 ? Verdict::kUndecided : checkState(end, 1, offender);
  if (at_end != Verdict::kFree) return told(at_end, offender, 1);
  const int start = frames.place(0);
  if (start < 0) return told(Verdict::kUndecided, -1, 0);

  open.clear();
  for (std::size_t p = 0; p < frames.pairs().size(); ++p) open.push_back(static_cast<int>(p));
  intervals.clear();
  intervals.push_back({start, end, 0, 1, 0, static_cast<int>(open.size()), 0});
  return certifyIntervals();
}

EdgeCheck EdgeCertifier::Impl::certifyIntervals() {
  int offender = -1;
  double t = 0;
  while (!intervals.empty()) {
    next_intervals.clear();
    next_open.clear();
    for (EdgeInterval& interval : intervals) {
      if (!examine(interval, open, offender, t)) return told(Verdict::kNotFree, offender, t);
      if (interval.begin == interval.end) continue;
      if (work.isSpent())
        return told(Verdict::kUndecided, open[at(interval.begin)], interval.t0 + interval.h / 2);
      // Edges of a planner's tree come from where it is free and often end in contact.
      const Verdict at_end = checkEnd(interval, offender);
      if (at_end != Verdict::kFree) return told(at_end, offender, 1);
      const double middle = interval.t0 + interval.h / 2;
      const int first = open[at(interval.begin)];
      if (interval.level >= kDeepestLevel || interval.h <= smallest)
        return told(Verdict::kUndecided, first, middle);
      if (interval.h * motionOf(interval, frames.pairs()[at(first)].motion).speed < kSmallestMotion)
        return told(Verdict::kUndecided, first, middle);
      const int slot = frames.place(middle);
      if (slot < 0) return told(Verdict::kUndecided, first, middle);
      const Verdict here = checkMiddle(interval, slot, offender);
      if (here != Verdict::kFree) return told(here, offender, middle);
      const auto count = static_cast<std::size_t>(interval.end - interval.begin);
      if (next_open.size() + 2 * count > next_open.capacity() ||
          next_intervals.size() + 2 > next_intervals.capacity())
        return told(Verdict::kUndecided, first, middle);
      split(interval, slot);
    }
    intervals.swap(next_intervals);
    open.swap(next_open);
  }
  return told(Verdict::kFree, -1, 0);
}

Verdict EdgeCertifier::Impl::checkEnd(const EdgeInterval& interval, int& offender) {
  if (interval.t0 + interval.h < 1) return Verdict::kFree;
  for (int i = interval.begin; i < interval.end; ++i) {
    offender = open[at(i)];
    if (failed_stamp[at(offender)] != stamp || end_looked[at(offender)] == edge) continue;
    end_looked[at(offender)] = edge;
    const Pair found = exactState(interval.slot1, frames.pairs()[at(offender)]);
    if (found == Pair::kOpen) return Verdict::kUndecided;
    if (found == Pair::kNotFree) return Verdict::kNotFree;
  }
  return Verdict::kFree;
}

Verdict EdgeCertifier::Impl::checkMiddle(const EdgeInterval& interval, int slot, int& offender) {
  for (int i = interval.begin; i < interval.end; ++i) {
    offender = open[at(i)];
    const EdgePair& pair = frames.pairs()[at(offender)];
    Pair found = coarseState(slot, pair);
    // What a sweep has failed to prove is near enough to be asked exactly. Contacts are found soon;
    // that there is none, smaller intervals have to prove anyway.
    if (found == Pair::kOpen && failed_stamp[at(offender)] == stamp && !work.isSpent()) {
      found = exactState(slot, pair, kLookNodes);
    }
    if (found == Pair::kNotFree) return Verdict::kNotFree;
  }
  return Verdict::kFree;
}

void EdgeCertifier::Impl::findLastValid(const EdgeRequest&, EdgeCheck& check) {
  frames.release(0);
  startWork(work_limit);
  check.last_valid = 0;
  int offender = -1;
  const int start = frames.place(0), end = frames.place(1);
  if (start < 0 || checkState(start, 0, offender) != Verdict::kFree || end < 0) return;
  open.clear();
  for (std::size_t p = 0; p < frames.pairs().size(); ++p) open.push_back(static_cast<int>(p));
  certifyPrefix({start, end, 0, 1, 0, static_cast<int>(open.size()), 0}, check);
}

bool EdgeCertifier::Impl::certifyPrefix(EdgeInterval interval, EdgeCheck& check) {
  int offender = -1;
  double t = 0;
  // Where one of the ends is in contact, the part before it may still be certified.
  examine(interval, open, offender, t);
  if (interval.begin == interval.end) {
    check.last_valid = interval.t0 + interval.h;
    return true;
  }
  if (interval.level >= kLastValidLevel || work.isSpent() || interval.h <= smallest) return false;
  const auto count = static_cast<std::size_t>(interval.end - interval.begin);
  const int mark = frames.used();
  const std::size_t top = open.size();
  const int slot = frames.place(interval.t0 + interval.h / 2);
  if (slot < 0 || top + count > open.capacity()) return false;
  bool certified = true;
  for (int half = 0; half < 2 && certified; ++half) {
    open.resize(top);
    open.insert(open.end(), open.begin() + interval.begin, open.begin() + interval.end);
    const double h = interval.h / 2;
    const EdgeInterval part{half == 0 ? interval.slot0 : slot,
                            half == 0 ? slot : interval.slot1,
                            interval.t0 + half * h,
                            h,
                            static_cast<int>(top),
                            static_cast<int>(top + count),
                            interval.level + 1};
    certified = certifyPrefix(part, check);
  }
  open.resize(top);
  frames.release(mark);
  return certified;
}

}  // namespace leeway::planner
