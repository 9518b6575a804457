// The least clearance along an edge, by branch and bound over pairs and intervals. The upper end is
// the least distance at some configuration. The lower end comes from sweeps; where bodies overlap,
// of which sweeps say nothing, from the distance at an interval's middle less how far the pair can
// move from it.

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/base/tolerances.h"
#include "planner/edge/edge_certifier_impl.h"

namespace leeway::planner {

/// The state of one search.
struct EdgeCertifier::Impl::ClearanceSearch {
  double tolerance, cutoff, wanted;
  bool is_limited = false;   ///< by the caller: where its work ends, so does the search
  double lower = kInfinity;  ///< of everything that is settled
  bool sweeps = true;        ///< sweeps may be asked
  bool swept = false;        ///< some pairs are settled by sweeps that miss containment
  EdgeClearance best{{kInfinity, kInfinity}, 0, -1, {}};

  /// A part of the edge with this lower bound cannot improve the minimum by more than the
  /// tolerance, or is far enough for the caller.
  double enough() const { return std::min(best.clearance.upper - tolerance, wanted); }
  bool isCutOff() const { return best.clearance.upper < cutoff; }
  void settle(double bound) { lower = std::min(lower, bound); }
};

/// The distance of one pair at one configuration: to within a quarter of the tolerance, or above
/// the least one known, which it lowers.
Interval EdgeCertifier::Impl::refineState(int slot, double t, const EdgePair& pair,
                                          ClearanceSearch& search) {
  collision::DistanceRequest request;
  request.tolerance = search.tolerance / 4;
  const double known = search.best.clearance.upper;
  if (std::isfinite(known)) request.threshold = known + pair.rounding;
  collision::DistanceResult result = stateDistance(slot, pair, request);
  if (result.status == collision::DistanceStatus::kNotAboveThreshold &&
      result.distance.width() > request.tolerance) {
    request.threshold = std::numeric_limits<double>::quiet_NaN();
    result = stateDistance(slot, pair, request);
  }
  result.distance.lower -= pair.rounding;
  result.distance.upper += pair.rounding;
  if (result.distance.upper < known) {
    search.best.clearance.upper = result.distance.upper;
    search.best.t = t;
    search.best.pair = pair.scene_pair;
    search.best.closest = result;
  }
  return result.distance;
}

/// All pairs at one configuration, in the order of their coarse bounds. Of many those within a
/// reach come first, which grows until it is beyond the least distance known.
void EdgeCertifier::Impl::searchState(int slot, double t, ClearanceSearch& search) {
  asked_pairs.clear();
  for (double reach = kFirstReach;; reach *= kReachGrowth) {
    const double known = search.best.clearance.upper;
    if (std::isfinite(known)) reach = std::max(known, 0.0) + most_rounding;
    const std::span<const int> near = nearPairs(slot, reach);
    searchPairs(slot, t, near, search);
    if (near.size() == frames.pairs().size() || near_pairs_full ||
        search.best.clearance.upper + most_rounding <= reach || search.isCutOff() || work.isSpent())
      return;
    asked_pairs = near_pairs;
  }
}

/// The pairs that balls leave within a reach of each other, at an edge without length that frames
/// have begun. Sixteen lanes for one configuration, and yet most pairs end there.
void EdgeCertifier::Impl::searchNearLanes(int slot, ClearanceSearch& search) {
  if (!lanes_fit || !lanes.begin(frames)) return;
  const double beyond = std::max(0.0, kRoughFirst - leastMargin());
  if (lanes.sweepBeyond(frames, asked, beyond).id >= 0 || lanes.isFull()) return;
  asked_pairs.clear();
  near_pairs.clear();
  for (const collision::LaneSweep::Open& pair : lanes.open()) near_pairs.push_back(pair.id);
  searchPairs(slot, 0, near_pairs, search);
}

/// Of some pairs those that have not been asked.
void EdgeCertifier::Impl::searchPairs(int slot, double t, std::span<const int> near,
                                      ClearanceSearch& search) {
  order.clear();
  for (const int p : near) {
    if (std::binary_search(asked_pairs.begin(), asked_pairs.end(), p)) continue;
    const EdgePair& pair = frames.pair(p);
    if (!isAsked(pair)) continue;
    if (frames.keepsGap(pair, search.best.clearance.upper + pair.rounding, t, t)) continue;
    const Eigen::Vector3d center = frames.inFrameOf(slot, pair.b, frames.center(slot, pair.a));
    const double lower = frames.piece(pair.b).bounds->coarse.lower(center) -
                         frames.piece(pair.a).bounds->outer.radius - pair.rounding;
    order.emplace_back(std::isnan(lower) ? -kInfinity : lower, p);
  }
  std::sort(order.begin(), order.end());
  for (const auto& [lower, p] : order) {
    if (lower >= search.best.clearance.upper || search.isCutOff() || work.isSpent()) break;
    refineState(slot, t, frames.pair(p), search);
  }
}

/// Lists the pairs that may come as near as the least distance known.
void EdgeCertifier::Impl::listWholeEdge(int start, int end, ClearanceSearch& search) {
  const double reach = std::max(search.best.clearance.upper, 0.0) + most_rounding;
  if (!listWholeEdge(start, end, reach)) search.settle(-kInfinity);
}

/// Settles the pairs of an interval that balls or sweeps prove to be far enough; the others stay in
/// [begin, end).
void EdgeCertifier::Impl::settlePairs(EdgeInterval& interval, ClearanceSearch& search) {
  ++statistics->intervals;
  startInterval();
  int kept = interval.begin;
  for (int i = interval.begin; i < interval.end; ++i) {
    const EdgePair& pair = frames.pair(open_pairs[at(i)]);
    double growth = 0;
    double lower = coarseSweep(interval, pair, growth) - pair.rounding;
    // A sweep bounds distances, not depths.
    if (lower < search.enough() && growth <= kSweepGrowth && search.enough() > 0 && search.sweeps) {
      search.swept = search.swept || !frames.isConvex(pair);
      lower = std::max(lower, sweep(interval, pair, growth, search.enough() + pair.rounding).lower -
                                  pair.rounding);
    }
    if (lower >= search.enough())
      search.settle(lower);
    else
      open_pairs[at(kept++)] = open_pairs[at(i)];
  }
  interval.end = kept;
}

/// Settles open pairs of an interval by their distance in its middle; the others stay in [begin,
/// end). `last`: all are settled.
void EdgeCertifier::Impl::settleFromMiddle(EdgeInterval& interval, int slot, bool last,
                                           ClearanceSearch& search) {
  int kept = interval.begin;
  for (int i = interval.begin; i < interval.end && !search.isCutOff(); ++i) {
    const EdgePair& pair = frames.pair(open_pairs[at(i)]);
    const Interval distance = refineState(slot, interval.t0 + interval.h / 2, pair, search);
    // Signed separation changes no faster than the pair's points move.
    double lower = distance.lower - interval.h / 2 * motionOf(interval, pair.motion).speed;
    bool settled = last || lower >= search.enough();
    // That does not hold for depths of a mesh: a turn may lock a body that a short way would part.
    // The bound of balls holds, but is loose; of a pair that is apart, halves may prove more.
    if (settled && lower <= 0 && !frames.isConvex(pair)) {
      double growth = 0;
      lower = std::min(lower, coarseSweep(interval, pair, growth) - pair.rounding);
      settled = last || distance.lower <= 0;
    }
    if (settled)
      search.settle(lower);
    else
      open_pairs[at(kept++)] = open_pairs[at(i)];
  }
  interval.end = kept;
}

EdgeClearance EdgeCertifier::edgeClearance(std::span<const double> a, std::span<const double> b,
                                           const ClearanceRequest& request) {
  ++statistics.edges;
  Impl& impl = *impl_;
  Impl::ClearanceSearch search{request.tolerance, request.cutoff, request.wanted,
                               request.work_limit > 0};
  const Impl::Asking asking(impl, request.pairs, -kInfinity);
  if (impl.leastMargin() == kInfinity) return search.best;  // there are no such pairs
  const std::int64_t work_limit = request.work_limit > 0 ? request.work_limit : kClearanceWork;
  impl.startWork(work_limit);
  impl.queries = 0;
  const int start = impl.frames.begin(a, b) ? impl.frames.place(0) : -1;
  const int end = start < 0 ? -1 : impl.frames.place(1);
  if (end < 0) {
    search.best.clearance.lower = -kInfinity;
    return search.best;
  }
  // What is wanted may be known without a single distance.
  const bool listed = std::isfinite(request.wanted) && impl.listNearLanes(search);
  if (!listed || !impl.intervals.empty()) {
    impl.searchState(end, 1, search);
    impl.searchState(start, 0, search);
    if (!listed && !impl.listNearLanes(search)) impl.listWholeEdge(start, end, search);
    impl.searchIntervals(search);
  }
  // Containment is decided at the ends, and changes where surfaces meet. So where they may have,
  // the search starts again without sweeps.
  if (search.swept && std::min(search.lower, search.best.clearance.upper) <= 0 &&
      !search.isCutOff()) {
    search.sweeps = false;
    impl.frames.release(end + 1);
    search.lower = kInfinity;
    statistics.work += impl.work.done;
    impl.startWork(work_limit);
    impl.listWholeEdge(start, end, search);
    impl.searchIntervals(search);
  }
  statistics.work += impl.work.done;
  search.best.clearance.lower =
      search.isCutOff() ? -kInfinity : std::min(search.lower, search.best.clearance.upper);
  return search.best;
}

EdgeClearance EdgeCertifier::nearest(std::span<const double> point, Pairs pairs, double known) {
  ++statistics.states;
  Impl& impl = *impl_;
  Impl::ClearanceSearch search{kRoughClearance, -kInfinity, kInfinity};
  const Impl::Asking asking(impl, pairs, -kInfinity);
  if (impl.leastMargin() == kInfinity) return search.best;  // there are no such pairs
  search.best.clearance = {-kInfinity, known};
  impl.startWork(kRoughWork);
  impl.queries = 0;
  const int slot = impl.frames.begin(point, point) ? impl.frames.place(0) : -1;
  if (slot >= 0) impl.searchNearLanes(slot, search);
  if (slot >= 0 && !(search.best.clearance.upper < known)) impl.searchState(slot, 0, search);
  statistics.work += impl.work.done;
  return search.best;
}

EdgeClearance EdgeCertifier::roughClearance(std::span<const double> a, std::span<const double> b,
                                            double most, Pairs pairs, bool once) {
  ++statistics.edges;
  Impl& impl = *impl_;
  Impl::ClearanceSearch search{kRoughClearance, -kInfinity, kInfinity};
  const Impl::Asking asking(impl, pairs, -kInfinity);
  if (impl.leastMargin() == kInfinity) return search.best;  // there are no such pairs
  impl.startWork(kRoughWork);
  impl.queries = 0;
  EdgeClearance& best = search.best;
  best.clearance.lower = -kInfinity;
  if (!impl.frames.begin(a, b) || !impl.lanes_fit || !impl.lanes.begin(impl.frames)) return best;
  const double least = impl.leastMargin();
  double beyond = std::max(0.0, most - least);
  const int passes = once ? 1 : kRoughPasses;
  for (int pass = 0; pass < passes && !impl.work.isSpent(); ++pass) {
    if (impl.sweepAskedBeyond(beyond).id >= 0 || impl.lanes.isFull()) break;
    if (impl.lanes.open().empty()) {
      best.clearance.lower = std::min(least + beyond, best.clearance.upper);
      best.keeps_margins = true;
      break;
    }
    impl.searchOpenLanes(EdgeLanes::wholeEdge(), 1, search);
    beyond = std::min(beyond, std::max(0.0, best.clearance.upper - least)) / 2;
  }
  statistics.work += impl.work.done;
  return best;
}

EdgeClearance EdgeCertifier::proveClearance(std::span<const double> a, std::span<const double> b,
                                            const ClearanceRequest& request) {
  ++statistics.edges;
  Impl& impl = *impl_;
  Impl::ClearanceSearch search{request.tolerance, -kInfinity, request.wanted};
  EdgeClearance& best = search.best;
  const Impl::Asking asking(impl, request.pairs, request.wanted);
  if (impl.leastMargin() == kInfinity) return best;  // there are no such pairs
  best.clearance.lower = -kInfinity;
  impl.work_limit = request.work_limit > 0 ? request.work_limit : impl.defaultWork();
  impl.smallest = 0;
  const EdgeCheck check = impl.decideEdge(a, b);
  if (check.verdict == Verdict::kFree) {
    best.clearance.lower = std::max(request.wanted, impl.leastMargin());
    best.keeps_margins = true;
    return best;
  }
  const int p = check.pair < 0 ? -1 : impl.last_named;
  if (p >= 0 && impl.isAsked(impl.frames.pair(p))) {
    impl.frames.release(0);
    impl.startWork(kDescentWork);
    impl.descend(p, check.t, search);
    statistics.work += impl.work.done;
  }
  return best;
}

void EdgeCertifier::Impl::descend(int p, double t, ClearanceSearch& search) {
  const EdgePair& pair = frames.pair(p);
  const auto look = [&](double at_t) {
    const double known = search.best.clearance.upper;
    const int slot = work.isSpent() ? -1 : frames.place(at_t);
    if (slot >= 0) refineState(slot, at_t, pair, search);
    return search.best.clearance.upper < known;
  };
  look(t);
  for (double step = kDescentStep; step >= kLeastDescentStep; step /= 2) {
    for (const double next : {t - step, t + step}) {
      if (!(next >= 0 && next <= 1) || !look(next)) continue;
      t = next;
      break;
    }
  }
}

collision::LaneSweep::Contact EdgeCertifier::Impl::sweepAskedBeyond(double beyond) {
  const collision::LaneSweep::Contact contact = lanes.sweepBeyond(frames, asked, beyond);
  if (contact.id >= 0) return contact;
  return lanes.searchPlanes();
}

/// Lists the lanes that are not proven to be far enough, and settles the rest. False, with nothing
/// settled, where lanes say nothing.
bool EdgeCertifier::Impl::listNearLanes(ClearanceSearch& search) {
  // Lanes bound no depths.
  if (search.isCutOff() || !(search.enough() > 0) || !std::isfinite(search.enough())) return false;
  if (!lanes_fit || !lanes.begin(frames)) return false;
  const double least = leastMargin();
  const EdgeLanes::Parts whole = EdgeLanes::wholeEdge();
  double beyond = 0;
  for (int pass = 0;; ++pass) {
    beyond = std::max(0.0, search.enough() - least);
    if (sweepAskedBeyond(beyond).id >= 0 || lanes.isFull()) return false;
    // A lower upper end leaves less open, and a pass costs less than intervals.
    const double known = search.best.clearance.upper;
    if (lanes.open().empty() || pass == kClearancePasses) break;
    searchOpenLanes(whole, kClearanceLooks, search);
    if (search.isCutOff()) return false;
    if (!(search.best.clearance.upper < known - search.tolerance)) break;
  }
  intervals.clear();
  open_pairs.clear();
  edge_parts.clear();
  part_pairs.clear();
  std::size_t next = 0;
  if (!listOpenLanes() || !listParts(whole) || !listPartsLeft(next)) return false;
  search.settle(least + beyond);
  return true;
}

/// The distances of the first `count` open pairs, in the middle of where they are open.
void EdgeCertifier::Impl::searchOpenLanes(const EdgeLanes::Parts& parts, int count,
                                          ClearanceSearch& search) {
  for (const collision::LaneSweep::Open& pair : lanes.open()) {
    if (--count < 0 || search.isCutOff()) return;
    const auto [from, width] = rangeOf(parts, pair.lanes);
    const int slot = frames.place(from + width / 2);
    if (slot < 0) return;
    refineState(slot, from + width / 2, frames.pair(pair.id), search);
  }
}

/// Settles the listed intervals, and the halves of what stays open, level by level.
void EdgeCertifier::Impl::searchIntervals(ClearanceSearch& search) {
  while (!intervals.empty() && !search.isCutOff()) {
    if (search.is_limited && work.isSpent()) {
      search.settle(-kInfinity);  // what is left would cost a distance each
      return;
    }
    next_intervals.clear();
    next_open_pairs.clear();
    for (EdgeInterval& interval : intervals) {
      settlePairs(interval, search);
      if (interval.begin == interval.end) continue;
      const int slot = frames.place(interval.t0 + interval.h / 2);
      if (slot < 0) {  // no slot is left, or a body is out of reach
        search.settle(-kInfinity);
        return;
      }
      const bool last = !hasRoomToSplit(at(interval.end - interval.begin)) ||
                        frames.used() + 1 >= kEdgeSlots || queries > kClearanceQueries ||
                        work.isSpent() || interval.level >= kDeepestLevel;
      settleFromMiddle(interval, slot, last, search);
      if (search.isCutOff()) return;
      split(interval, slot);
    }
    intervals.swap(next_intervals);
    open_pairs.swap(next_open_pairs);
  }
}

}  // namespace leeway::planner
