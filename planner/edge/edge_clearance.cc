// The least clearance along an edge: branch and bound over pairs and intervals. The upper end comes
// from configurations, the lower from sweeps and, where bodies overlap and sweeps say nothing, from
// the distance at an interval's middle less how far the pair can move from it.

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/base/tolerances.h"
#include "planner/edge/edge_certifier_impl.h"

namespace leeway::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

/// What one search carries.
struct EdgeCertifier::Impl::ClearanceSearch {
  double tolerance, cutoff;
  double lower = kInfinity;  // of everything that is settled
  bool sweeps = true;        // may be asked
  bool swept = false;        // some of it by sweeps of surfaces, which do not see what is inside
  EdgeClearance best{{kInfinity, kInfinity}, 0, -1, {}};

  /// From here on a part of the edge need not be looked at.
  double enough() const { return best.clearance.upper - tolerance; }
  bool cut() const { return best.clearance.upper < cutoff; }
  void settle(double bound) { lower = std::min(lower, bound); }
};

/// The distance of one pair at one configuration, as far as it can matter: exact to a quarter of
/// the tolerance, or above what is known.
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

/// All pairs at one configuration, those with the least coarse bound first.
void EdgeCertifier::Impl::searchState(int slot, double t, ClearanceSearch& search) {
  const std::span<const EdgePair> pairs = frames.pairs();
  order.clear();
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const EdgePair& pair = pairs[p];
    const Eigen::Vector3d center = frames.inFrameOf(slot, pair.b, frames.center(slot, pair.a));
    const double lower = frames.pieces()[at(pair.b)].bounds->coarse.lower(center) -
                         frames.pieces()[at(pair.a)].bounds->outer.radius - pair.rounding;
    order.emplace_back(std::isnan(lower) ? -kInfinity : lower, static_cast<int>(p));
  }
  std::sort(order.begin(), order.end());
  for (const auto& [lower, p] : order) {
    if (lower >= search.best.clearance.upper || search.cut() || work.isSpent()) break;
    refineState(slot, t, pairs[at(p)], search);
  }
}

/// Settles the pairs of an interval that cannot improve the minimum by more than the tolerance; the
/// others stay in [begin, end).
void EdgeCertifier::Impl::settlePairs(EdgeInterval& interval, ClearanceSearch& search) {
  ++statistics->intervals;
  startInterval();
  int kept = interval.begin;
  for (int i = interval.begin; i < interval.end; ++i) {
    const EdgePair& pair = frames.pairs()[at(open[at(i)])];
    double growth = 0;
    double lower = coarseSweep(interval, pair, growth) - pair.rounding;
    // A sweep tells distances, not depths: it is asked only for what is apart.
    if (lower < search.enough() && growth <= kSweepGrowth && search.enough() > 0 && search.sweeps) {
      search.swept = search.swept || !frames.isConvex(pair);
      lower = std::max(lower, sweep(interval, pair, growth, search.enough() + pair.rounding).lower -
                                  pair.rounding);
    }
    if (lower >= search.enough())
      search.settle(lower);
    else
      open[at(kept++)] = open[at(i)];
  }
  interval.end = kept;
}

/// Looks at the open pairs in the interval's middle; what that does not settle stays in [begin,
/// end). `last`: nothing may stay.
void EdgeCertifier::Impl::settleFromMiddle(EdgeInterval& interval, int slot, bool last,
                                           ClearanceSearch& search) {
  int kept = interval.begin;
  for (int i = interval.begin; i < interval.end && !search.cut(); ++i) {
    const EdgePair& pair = frames.pairs()[at(open[at(i)])];
    const Interval distance = refineState(slot, interval.t0 + interval.h / 2, pair, search);
    // Signed separation changes no faster than the pair's points move.
    double lower = distance.lower - interval.h / 2 * motionOf(interval, pair.motion).speed;
    bool settled = last || lower >= search.enough();
    // But not of a mesh that touches: a turn may lock what a short way would part. Convex bodies
    // around both do, loosely; where it is still apart, halves may prove that it stays so.
    if (settled && lower <= 0 && !frames.isConvex(pair)) {
      double growth = 0;
      lower = std::min(lower, coarseSweep(interval, pair, growth) - pair.rounding);
      settled = last || distance.lower <= 0;
    }
    if (settled)
      search.settle(lower);
    else
      open[at(kept++)] = open[at(i)];
  }
  interval.end = kept;
}

EdgeClearance EdgeCertifier::edgeClearance(std::span<const double> a, std::span<const double> b,
                                           double tolerance, double cutoff) {
  ++statistics.edges;
  Impl& impl = *impl_;
  Impl::ClearanceSearch search{tolerance, cutoff};
  if (impl.frames.pairs().empty()) return search.best;
  impl.startWork(kClearanceCost);
  impl.queries = 0;
  const int start = impl.frames.begin(a, b) ? impl.frames.place(0) : -1;
  const int end = start < 0 ? -1 : impl.frames.place(1);
  if (end < 0) {
    search.best.clearance.lower = -kInfinity;
    return search.best;
  }
  impl.searchState(end, 1, search);
  impl.searchState(start, 0, search);
  if (!impl.listNearLanes(search)) impl.listWholeEdge(start, end);
  impl.searchIntervals(search);
  // What is inside a mesh at one place of an edge that touches it may not be at its end: then
  // sweeps are not asked.
  if (search.swept && std::min(search.lower, search.best.clearance.upper) <= 0 && !search.cut()) {
    search.sweeps = false;
    impl.frames.release(end + 1);
    search.lower = kInfinity;
    impl.startWork(kClearanceCost);
    impl.listWholeEdge(start, end);
    impl.searchIntervals(search);
  }
  search.best.clearance.lower =
      search.cut() ? -kInfinity : std::min(search.lower, search.best.clearance.upper);
  return search.best;
}

void EdgeCertifier::Impl::listWholeEdge(int start, int end) {
  open.clear();
  for (std::size_t p = 0; p < frames.pairs().size(); ++p) open.push_back(static_cast<int>(p));
  intervals.clear();
  intervals.push_back({start, end, 0, 1, 0, static_cast<int>(open.size()), 0});
}

bool EdgeCertifier::Impl::listNearLanes(ClearanceSearch& search) {
  // Lanes know nothing of depths.
  if (search.cut() || !(search.enough() > 0) || !std::isfinite(search.enough())) return false;
  if (!lanes_fit || !lanes.begin(frames)) return false;
  double least = kInfinity;
  for (const EdgePair& pair : frames.pairs())
    least = std::min(least, pair.threshold - pair.rounding);
  const EdgeLanes::Parts whole = EdgeLanes::wholeEdge();
  double beyond = 0;
  for (int pass = 0;; ++pass) {
    beyond = std::max(0.0, search.enough() - least);
    if (lanes.sweepBeyond(beyond).id >= 0) return false;
    // The nearer the upper end is to the truth, the less is open: a pass costs less than intervals.
    const double known = search.best.clearance.upper;
    if (lanes.open().empty() || pass == kClearancePasses) break;
    searchOpenLanes(whole, kClearanceLooks, search);
    if (search.cut()) return false;
    if (!(search.best.clearance.upper < known - search.tolerance)) break;
  }
  intervals.clear();
  open.clear();
  edge_parts.clear();
  part_pairs.clear();
  std::size_t next = 0;
  if (!listOpenLanes() || !listParts(whole) || !listPartsLeft(next)) return false;
  search.settle(least + beyond);
  return true;
}

void EdgeCertifier::Impl::searchOpenLanes(const EdgeLanes::Parts& parts, int count,
                                          ClearanceSearch& search) {
  for (const collision::LaneSweep::Open& pair : lanes.open()) {
    if (--count < 0 || search.cut()) return;
    const auto [from, width] = rangeOf(parts, pair.lanes);
    const int slot = frames.place(from + width / 2);
    if (slot < 0) return;
    refineState(slot, from + width / 2, frames.pairs()[at(pair.id)], search);
  }
}

void EdgeCertifier::Impl::searchIntervals(ClearanceSearch& search) {
  while (!intervals.empty() && !search.cut()) {
    next_intervals.clear();
    next_open.clear();
    for (EdgeInterval& interval : intervals) {
      settlePairs(interval, search);
      if (interval.begin == interval.end) continue;
      const int slot = frames.place(interval.t0 + interval.h / 2);
      if (slot < 0) {  // out of places or reach: nothing is known of the rest
        search.settle(-kInfinity);
        return;
      }
      const auto count = static_cast<std::size_t>(interval.end - interval.begin);
      const bool full = next_open.size() + 2 * count > next_open.capacity() ||
                        next_intervals.size() + 2 > next_intervals.capacity() ||
                        frames.used() + 1 >= kEdgeSlots;
      settleFromMiddle(
          interval, slot,
          full || queries > kClearanceWork || work.isSpent() || interval.level >= kDeepestLevel,
          search);
      if (search.cut()) return;
      split(interval, slot);
    }
    intervals.swap(next_intervals);
    open.swap(next_open);
  }
}

void EdgeCertifier::Impl::split(const EdgeInterval& interval, int slot) {
  const int count = interval.end - interval.begin;
  if (count == 0) return;
  const double h = interval.h / 2;
  for (int half = 0; half < 2; ++half) {
    const auto begin = static_cast<int>(next_open.size());
    next_open.insert(next_open.end(), open.begin() + interval.begin, open.begin() + interval.end);
    next_intervals.push_back({half == 0 ? interval.slot0 : slot, half == 0 ? slot : interval.slot1,
                              interval.t0 + half * h, h, begin, begin + count, interval.level + 1});
  }
}

}  // namespace leeway::planner
