// The least clearance along an edge, by branch and bound over pairs and intervals. The upper end is
// the least distance at some configuration. The lower end comes from sweeps. Sweeps do not bound
// depths, so if bodies overlap, the lower end is the distance at an interval's middle minus how far
// the pair can move from it. Among many obstacles, tasks are first rows of the scene's table:
// WorldSearch bounds a row by the boxes of static bodies, and lists its pairs in intervals that are
// short enough to leave few.

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/base/tolerances.h"
#include "planner/edge/edge_certifier_impl.h"

namespace leeway::planner {
namespace {

/// Nodes that are visited for a row over an interval, and pairs that are listed there, before the
/// interval is halved [count].
constexpr int kRowSteps = 128;
constexpr std::size_t kRowPairs = 32;

}  // namespace

/// One search, and the rule that settles its tasks.
class EdgeCertifier::Impl::ClearanceSearch {
 public:
  ClearanceSearch(Impl& impl, const ClearanceRequest& request)
      : impl_(impl),
        tolerance_(request.tolerance),
        cutoff_(request.cutoff),
        wanted_(request.wanted),
        is_limited_(request.work_limit > 0) {}

  EdgeClearance best{{kInfinity, kInfinity}, 0, -1, {}};

  bool isCutOff() const { return best.clearance.upper < cutoff_; }

  /// Searches the edge that frames have begun, with its ends placed.
  void searchEdge(int start, int end) {
    // The wanted clearance may be proven without computing a distance.
    const bool listed = std::isfinite(wanted_) && listNearIntervals();
    if (listed && impl_.queue.empty()) return;
    searchState(end, 1);
    searchState(start, 0);
    if (!listed && !listNearIntervals()) listWholeEdge(start, end);
    searchTasks();
  }
  /// Containment is decided at the ends, and changes where surfaces meet. If they may have met, the
  /// search starts again without sweeps.
  bool needsSearchWithoutSweeps() const {
    return swept_ && std::min(lower_, best.clearance.upper) <= 0 && !isCutOff();
  }
  void searchWithoutSweeps(int start, int end) {
    sweeps_ = false;
    lower_ = kInfinity;
    listWholeEdge(start, end);
    searchTasks();
  }
  double lowerEnd() const {
    return isCutOff() ? -kInfinity : std::min(lower_, best.clearance.upper);
  }

  /// Checks all pairs at one configuration, in the order of their coarse bounds.
  void searchState(int slot, double t) {
    searchPairs(slot, t, impl_.frames.edges().near_anywhere);
    if (!hasRows()) return;
    for (int row = 0; at(row) < impl_.frames.pairs().rows().size(); ++row) searchRow(slot, t, row);
  }

  /// Searches the pairs that balls leave within a reach of each other, for an edge without length
  /// that frames have begun. It uses sixteen lanes for one configuration, but most pairs end there.
  void searchNearPairs(int slot) {
    if (!impl_.lanes.begin(impl_.frames)) return;
    const double beyond = std::max(0.0, kRoughFirst - impl_.leastMargin());
    if (impl_.lanes.sweepBeyond(impl_.frames, impl_.asked, beyond).id >= 0 || impl_.lanes.isFull())
      return;
    impl_.near_pairs.clear();
    for (const collision::LaneSweep::Open& pair : impl_.lanes.open())
      impl_.near_pairs.push_back(pair.id);
    searchPairs(slot, 0, impl_.near_pairs);
  }

  /// Computes the distances of the first `count` pairs that a pass over the whole edge left open,
  /// in the middle of their open intervals.
  void searchOpenIntervals(int count) {
    for (const collision::LaneSweep::Open& pair : impl_.lanes.open()) {
      if (--count < 0 || isCutOff()) return;
      const double t = EdgeLanes::wholeEdge().rangeOf(pair.intervals).middle();
      const int slot = impl_.frames.place(t);
      if (slot < 0) return;
      refine(slot, t, impl_.frames.pair(pair.id));
    }
  }

  /// The distance of pair p near t, by descent.
  void descend(int p, double t) {
    const EdgePair& pair = impl_.frames.pair(p);
    const auto look = [&](double at_t) {
      const double known = best.clearance.upper;
      const int slot = impl_.work.isSpent() ? -1 : impl_.frames.place(at_t);
      if (slot >= 0) refine(slot, at_t, pair);
      return best.clearance.upper < known;
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

  /// EdgeLanes::sweepBeyond() for the pairs in question, then planes if pairs stay open. False if a
  /// contact is found or more pairs are near than there is room for.
  bool sweepBeyond(double beyond) {
    return impl_.lanes.sweepBeyond(impl_.frames, impl_.asked, beyond).id < 0 &&
           impl_.lanes.searchPlanes().id < 0 && !impl_.lanes.isFull();
  }

  // The rule for EdgeQueue::subdivide().

  /// Settles the tasks that balls or sweeps prove to be far enough.
  bool sweep(EdgeInterval& interval) {
    if (is_limited_ && impl_.queue.startsLevel() && impl_.work.isSpent()) {
      settle(-kInfinity);  // each remaining task would cost a distance
      return false;
    }
    ++impl_.statistics->intervals;
    impl_.queries.startInterval();
    impl_.queue.keep(interval, [&](int p) {
      const double lower = lowerOver(interval, impl_.frames.pair(p));
      return isOpen(lower >= enough(), lower);
    });
    return true;
  }

  bool look(EdgeInterval& interval, int slot) {
    if (slot < 0) {  // no slot is left, or a body is out of reach
      settle(-kInfinity);
      return false;
    }
    const bool last = !impl_.queue.hasRoom(interval) || impl_.frames.used() + 1 >= kEdgeSlots ||
                      impl_.queries.count > kClearanceQueries || impl_.work.isSpent() ||
                      interval.level >= kDeepestLevel;
    settleFromMiddle(interval, slot, last);
    return !isCutOff();
  }

 private:
  /// A part of the edge with this lower bound cannot improve the minimum by more than the
  /// tolerance, or is far enough for the caller.
  double enough() const { return std::min(best.clearance.upper - tolerance_, wanted_); }
  void settle(double bound) { lower_ = std::min(lower_, bound); }
  bool isOpen(bool is_settled, double lower) {
    if (is_settled) settle(lower);
    return !is_settled;
  }

  /// A lower bound on a pair's separation over an interval, at least enough() if that is cheap.
  double lowerOver(const EdgeInterval& interval, const EdgePair& pair) {
    double growth = 0;
    double lower = impl_.queries.coarseSweep(interval, pair, growth) - pair.rounding;
    // A sweep bounds distances, not depths.
    if (lower < enough() && growth <= kSweepGrowth && enough() > 0 && sweeps_) {
      swept_ = swept_ || !impl_.frames.isConvex(pair);
      lower = std::max(
          lower, impl_.queries.hullSweep(interval, pair, growth, enough() + pair.rounding).lower -
                     pair.rounding);
    }
    return lower;
  }

  /// Computes the distance of one pair at one configuration: to within a quarter of the tolerance,
  /// or proves it above the least known distance, which it may lower.
  Interval refine(int slot, double t, const EdgePair& pair) {
    collision::DistanceRequest request;
    request.tolerance = tolerance_ / 4;
    const double known = best.clearance.upper;
    if (std::isfinite(known)) request.threshold = known + pair.rounding;
    collision::DistanceResult result = impl_.queries.distanceAt(slot, pair, request);
    if (result.status == collision::DistanceStatus::kNotAboveThreshold &&
        result.distance.width() > request.tolerance) {
      request.threshold = std::numeric_limits<double>::quiet_NaN();
      result = impl_.queries.distanceAt(slot, pair, request);
    }
    result.distance.lower -= pair.rounding;
    result.distance.upper += pair.rounding;
    if (result.distance.upper < known) {
      best.clearance.upper = result.distance.upper;
      best.t = t;
      best.pair = pair.scene_pair;
      best.closest = result;
      nearest_ = pair;
    }
    return result.distance;
  }

  /// Checks some pairs.
  void searchPairs(int slot, double t, std::span<const int> near) {
    impl_.order.clear();
    for (const int p : near) {
      const EdgePair& pair = impl_.frames.pair(p);
      if (!impl_.asked.has(pair)) continue;
      if (impl_.frames.keepsGap(pair, best.clearance.upper + pair.rounding, t, t)) continue;
      const Eigen::Vector3d center =
          impl_.frames.inFrameOf(slot, pair.b, impl_.frames.center(slot, pair.a));
      const double lower = impl_.frames.piece(pair.b).bounds().coarse.lower(center) -
                           impl_.frames.piece(pair.a).bounds().outer.radius - pair.rounding;
      impl_.order.emplace_back(std::isnan(lower) ? -kInfinity : lower, p);
    }
    std::sort(impl_.order.begin(), impl_.order.end());
    for (const auto& [lower, p] : impl_.order) {
      if (lower >= best.clearance.upper || isCutOff() || impl_.work.isSpent()) break;
      refine(slot, t, impl_.frames.pair(p));
    }
  }

  /// Whether pairs of the scene's table are in question and too many to list.
  bool hasRows() const { return impl_.world != nullptr && impl_.asked.pairs != Pairs::kSelf; }

  /// Checks the pairs of a row at one configuration, nearest first.
  void searchRow(int slot, double t, int row) {
    const int piece = impl_.frames.pairs().rows()[at(row)].piece;
    // The nearest pair of a neighbouring configuration is likely to be near here, too.
    if (best.pair >= 0 && !nearest_.is_self && nearest_.a == piece) refine(slot, t, nearest_);
    const WorldSearch::Result found = impl_.world->search.run(
        at(row), {slot, slot, 0}, std::numeric_limits<int>::max(), impl_.work,
        [&] { return best.clearance.upper - tolerance_ / 4; },
        [&](int p) {
          refine(slot, t, impl_.frames.pair(p));
          return !isCutOff();
        });
    // A mesh may contain what was not visited.
    if (!found.complete && !isCutOff() && !impl_.frames.piece(piece).shape().isConvex())
      settle(-kInfinity);
  }

  /// Lists the pairs that may come as near as the least known distance.
  void listWholeEdge(int start, int end) {
    // Rows are swept. Depths are searched among pairs: those near contact are few.
    if (hasRows() && sweeps_ && enough() > 0) return listRows(start, end);
    const double reach = std::max(best.clearance.upper, 0.0) + impl_.frames.pairs().mostRounding();
    if (!impl_.takeWholeEdge(start, end, reach)) settle(-kInfinity);
  }

  void listRows(int start, int end) {
    impl_.takeListed(start, end);
    impl_.world->rows.takeWholeEdge(start, end, [&](const EdgeInterval&, auto& rows) {
      rows.clear();
      for (std::size_t row = 0; row < impl_.frames.pairs().rows().size(); ++row)
        rows.push_back(static_cast<int>(row));
    });
    RowRule rule(*this);
    impl_.world->rows.subdivide(EdgeQueue::Order::kByLevel, rule);
    // A contact was found on the way: boxes bound no depths.
    if (!isCutOff() && !(enough() > 0)) listWholeEdge(start, end);
  }

  /// The rule for the tasks of rows: settles those that are far enough, and lists the pairs of
  /// those that leave few.
  class RowRule {
   public:
    explicit RowRule(ClearanceSearch& search) : search_(search), impl_(search.impl_) {}

    bool sweep(EdgeInterval& interval) {
      if (!(search_.enough() > 0)) return false;
      if (impl_.world->rows.startsLevel()) {
        before_ = after_;
        after_ = kInfinity;
      }
      ++impl_.statistics->intervals;
      impl_.queries.startInterval();
      lower_ = kInfinity;
      impl_.world->rows.keep(interval, [&](int row) { return !settles(interval, row); });
      after_ = std::min(after_, lower_);
      if (!impl_.work.isSpent()) return !search_.isCutOff();
      search_.settle(std::min(before_, after_));
      return false;
    }

    bool look(EdgeInterval& interval, int slot) {
      if (slot >= 0)
        for (const int row : impl_.world->rows.pairs(interval))
          search_.searchRow(slot, interval.middle(), row);
      if (slot < 0 || !impl_.world->rows.hasRoom(interval) ||
          impl_.frames.used() + 1 >= kEdgeSlots || interval.level >= kDeepestLevel ||
          impl_.queries.count > kClearanceQueries) {
        search_.settle(lower_);
        interval.end = interval.begin;
      }
      return !search_.isCutOff();
    }

   private:
    /// Bounds a row over an interval. False if its halves may prove more.
    bool settles(const EdgeInterval& interval, int row) {
      const EdgePairs::Row& of = impl_.frames.pairs().rows()[at(row)];
      const robots::MotionBound& motion = impl_.queries.motionOf(interval, of.motion);
      const double growth = interval.h * interval.h * motion.acceleration / 8;
      const bool stands = interval.h * motion.speed <= search_.tolerance_;
      const int steps = stands                  ? std::numeric_limits<int>::max()
                        : growth > kSweepGrowth ? 0
                                                : kRowSteps;
      search_.swept_ =
          search_.swept_ || (steps > 0 && !impl_.frames.piece(of.piece).shape().isConvex());
      collision::SpareVector<int>& near = impl_.near_pairs;
      near.clear();
      double nearest = kInfinity;
      const auto [lower, complete] = impl_.world->search.run(
          at(row), {interval.slot0, interval.slot1, growth}, steps, impl_.work,
          [&] { return search_.enough(); },
          [&](int p) {
            const double over = search_.lowerOver(interval, impl_.frames.pair(p));
            nearest = std::min(nearest, over);
            if (over < search_.enough()) near.push_back(p);
            return near.size() < (stands ? near.capacity() : kRowPairs);
          });
      if (complete) {
        for (const int p : near) {
          if (impl_.queue.add(p, interval.t0, interval.h, interval.level)) continue;
          search_.settle(nearest);
          break;
        }
        // The least bound of pairs that are not listed.
        search_.settle(near.empty() ? std::min(lower, nearest) : std::min(lower, search_.enough()));
        return true;
      }
      lower_ = std::min({lower_, lower, nearest});
      if (stands) search_.settle(std::min(lower, nearest));
      return stands;
    }

    ClearanceSearch& search_;
    Impl& impl_;
    double before_ = -kInfinity, after_ = -kInfinity;  // bounds of open tasks, by level
    double lower_ = kInfinity;                         // of open tasks of the current interval
  };

  /// Lists the intervals that are not proven to be far enough, and settles the rest. False, with
  /// nothing settled, if lanes do not apply.
  bool listNearIntervals() {
    // Lanes do not bound depths.
    if (isCutOff() || !(enough() > 0) || !std::isfinite(enough())) return false;
    if (!impl_.lanes.begin(impl_.frames)) return false;
    const double least = impl_.leastMargin();
    double beyond = 0;
    for (int pass = 0;; ++pass) {
      beyond = std::max(0.0, enough() - least);
      if (!sweepBeyond(beyond)) return false;
      // A lower upper end leaves fewer pairs open, and a pass costs less than intervals.
      const double known = best.clearance.upper;
      if (impl_.lanes.open().empty() || pass == kClearancePasses) break;
      searchOpenIntervals(kClearanceLooks);
      if (isCutOff()) return false;
      if (!(best.clearance.upper < known - tolerance_)) break;
    }
    if (!impl_.parts.begin() || !impl_.parts.addTasks()) return false;
    settle(least + beyond);
    return true;
  }

  void searchTasks() {
    if (!isCutOff()) impl_.queue.subdivide(EdgeQueue::Order::kByLevel, *this);
  }

  /// Settles tasks by their distance in the interval's middle. `last`: all are settled.
  void settleFromMiddle(EdgeInterval& interval, int slot, bool last) {
    impl_.queue.keep(interval, [&](int p) {
      if (isCutOff()) return true;
      const EdgePair& pair = impl_.frames.pair(p);
      const Interval distance = refine(slot, interval.middle(), pair);
      // Signed separation changes no faster than the pair's points move.
      double lower =
          distance.lower - interval.h / 2 * impl_.queries.motionOf(interval, pair.motion).speed;
      bool settled = last || lower >= enough();
      // This does not hold for depths of a mesh: a turn may lock a body that a short translation
      // would separate. The bound of balls holds, but is loose. If the pair is apart, the halves
      // may prove more.
      if (settled && lower <= 0 && !impl_.frames.isConvex(pair)) {
        double growth = 0;
        lower = std::min(lower, impl_.queries.coarseSweep(interval, pair, growth) - pair.rounding);
        settled = last || distance.lower <= 0;
      }
      return isOpen(settled, lower);
    });
  }

  Impl& impl_;
  double tolerance_, cutoff_, wanted_;
  bool is_limited_;           // by the caller: the search ends at the work limit
  double lower_ = kInfinity;  // of all settled tasks
  EdgePair nearest_{};        // that of best.pair
  bool sweeps_ = true;        // sweeps are allowed
  bool swept_ = false;        // sweeps that miss containment settled some pairs
};

EdgeClearance EdgeCertifier::edgeClearance(std::span<const double> a, std::span<const double> b,
                                           const ClearanceRequest& request) {
  ++statistics.edges;
  Impl& impl = *impl_;
  Impl::ClearanceSearch search(impl, request);
  EdgeClearance& best = search.best;
  // Points that were cropped from clouds may be this near.
  const double most = request.pairs == Pairs::kSelf ? kInfinity : impl.scene->completeWithin();
  {
    const Impl::Asking asking(impl, {.pairs = request.pairs});
    if (impl.leastMargin() == kInfinity) {  // there are no such pairs
      best.clearance.lower = most;
      return best;
    }
    impl.startWork(request.work_limit > 0 ? request.work_limit : kClearanceWork);
    impl.queries.count = 0;
    const int start = impl.frames.begin(a, b) ? impl.frames.place(0) : -1;
    const int end = start < 0 ? -1 : impl.frames.place(1);
    if (end < 0) {
      best.clearance.lower = -kInfinity;
      return best;
    }
    search.searchEdge(start, end);
    if (search.needsSearchWithoutSweeps()) {
      impl.frames.release(end + 1);
      statistics.work += impl.work.done;
      impl.startWork(impl.work.limit);
      search.searchWithoutSweeps(start, end);
    }
    statistics.work += impl.work.done;
    best.clearance.lower = std::min(search.lowerEnd(), most);
  }
  // Where limits end the search, the proofs of a certificate may bound more.
  const bool is_short = best.clearance.upper > 0 && best.clearance.upper < kInfinity &&
                        best.clearance.lower < best.clearance.upper / 2 && !search.isCutOff() &&
                        !(best.clearance.lower >= std::min(request.wanted, most)) &&
                        (request.work_limit == 0 || request.work_limit >= kClearanceWork);
  for (int fall = 0; is_short && fall <= kProofTries; ++fall) {
    const double wanted =
        std::min((1 - kLeastShare) * best.clearance.upper, kRoughMost) * std::pow(kProofFall, fall);
    if (wanted <= best.clearance.lower) break;
    const EdgeClearance proven =
        proveClearance(a, b, {.wanted = wanted, .work_limit = kProofWork, .pairs = request.pairs});
    if (!proven.keeps_margins) continue;
    best.clearance.lower = std::max(best.clearance.lower, std::min(proven.clearance.lower, most));
    break;
  }
  return best;
}

EdgeClearance EdgeCertifier::nearest(std::span<const double> point, Pairs pairs, double known) {
  ++statistics.states;
  Impl& impl = *impl_;
  Impl::ClearanceSearch search(impl, {.tolerance = kRoughClearance});
  const Impl::Asking asking(impl, {.pairs = pairs});
  if (impl.leastMargin() == kInfinity) return search.best;  // there are no such pairs
  search.best.clearance = {-kInfinity, known};
  impl.startWork(kRoughWork);
  const int slot = impl.frames.begin(point, point) ? impl.frames.place(0) : -1;
  if (slot >= 0) search.searchNearPairs(slot);
  if (slot >= 0 && !(search.best.clearance.upper < known)) search.searchState(slot, 0);
  statistics.work += impl.work.done;
  return search.best;
}

EdgeClearance EdgeCertifier::roughClearance(std::span<const double> a, std::span<const double> b,
                                            double most, Pairs pairs, bool once) {
  ++statistics.edges;
  Impl& impl = *impl_;
  Impl::ClearanceSearch search(impl, {.tolerance = kRoughClearance});
  const Impl::Asking asking(impl, {.pairs = pairs});
  if (impl.leastMargin() == kInfinity) return search.best;  // there are no such pairs
  impl.startWork(kRoughWork);
  EdgeClearance& best = search.best;
  best.clearance.lower = -kInfinity;
  if (!impl.frames.begin(a, b) || !impl.lanes.begin(impl.frames)) return best;
  const double least = impl.leastMargin();
  double beyond = std::max(0.0, most - least);
  const int passes = once ? 1 : kRoughPasses;
  for (int pass = 0; pass < passes && !impl.work.isSpent(); ++pass) {
    if (!search.sweepBeyond(beyond)) break;
    if (impl.lanes.open().empty()) {
      best.clearance.lower = std::min(least + beyond, best.clearance.upper);
      best.keeps_margins = true;
      break;
    }
    search.searchOpenIntervals(1);
    beyond = std::min(beyond, std::max(0.0, best.clearance.upper - least)) / 2;
  }
  statistics.work += impl.work.done;
  return best;
}

EdgeClearance EdgeCertifier::proveClearance(std::span<const double> a, std::span<const double> b,
                                            const ClearanceRequest& request) {
  ++statistics.edges;
  Impl& impl = *impl_;
  Impl::ClearanceSearch search(impl, {.tolerance = request.tolerance});
  EdgeClearance& best = search.best;
  const Impl::Asking asking(impl, {request.pairs, request.wanted});
  if (impl.leastMargin() == kInfinity) return best;  // there are no such pairs
  best.clearance.lower = -kInfinity;
  impl.startWork(request.work_limit > 0 ? request.work_limit : impl.defaultWork());
  impl.queries.least_interval = 0;
  if (!impl.frames.begin(a, b)) return best;
  const EdgeCheck check = impl.decideEdge();
  if (check.verdict == Verdict::kFree) {
    best.clearance.lower = std::max(request.wanted, impl.leastMargin());
    best.keeps_margins = true;
    return best;
  }
  const int p = check.pair < 0 ? -1 : impl.last_named;
  if (p >= 0 && impl.asked.has(impl.frames.pair(p))) {
    impl.frames.release(0);
    impl.startWork(kDescentWork);
    search.descend(p, check.t);
    statistics.work += impl.work.done;
  }
  return best;
}

}  // namespace leeway::planner
