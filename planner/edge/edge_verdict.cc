// Verdicts by exact sweeps of tasks, halved until every pair is decided: adaptive bisection as in
// Schwarzer, Saha and Latombe 2005, see EdgeCertifier.

#include <algorithm>

#include "planner/base/tolerances.h"
#include "planner/edge/edge_certifier_impl.h"

namespace leeway::planner {

bool EdgeCertifier::Impl::takeWholeEdge(int start, int end, double reach) {
  queries.startInterval();
  const std::span<const int> anywhere = frames.edges().near_anywhere;
  const bool are_all = frames.edges().areAllNear();
  bool has_room = true;
  queue.takeWholeEdge(
      start, end, [&](const EdgeInterval& whole, collision::SpareVector<int>& open) {
        open.assign(anywhere.begin(), anywhere.end());
        for (std::size_t row = 0; !are_all && row < frames.pairs().rows().size(); ++row) {
          // No point is farther than this from its position at the nearer end.
          const double way = queries.motionOf(whole, frames.pairs().rows()[row].motion).speed / 2;
          for (const int slot : {start, end})
            has_room = has_room && frames.nearInRow(row, slot, reach + way, open);
        }
        if (!are_all) {
          std::sort(open.begin(), open.end());
          open.erase(std::unique(open.begin(), open.end()), open.end());
        }
        std::erase_if(open, [&](int p) { return !asked.has(frames.pair(p)); });
      });
  return has_room;
}

void EdgeCertifier::Impl::takeListed(int start, int end) {
  queue.takeWholeEdge(start, end, [&](const EdgeInterval&, collision::SpareVector<int>& open) {
    open.clear();
    for (const int p : frames.edges().near_anywhere)
      if (asked.has(frames.pair(p))) open.push_back(p);
  });
}

std::optional<PairVerdict> EdgeCertifier::Impl::sweepTasks(EdgeInterval& interval) {
  ++statistics->intervals;
  queries.startInterval();
  std::optional<PairVerdict> contact;
  queue.keep(interval, [&](int p) {
    if (contact) return true;  // not checked
    double t = 0;
    const PairState state = queries.sweep(interval, p, t);
    if (state == PairState::kNotFree) contact = {Verdict::kNotFree, p, t};
    return state != PairState::kFree;
  });
  return contact;
}

std::optional<PairVerdict> EdgeCertifier::Impl::checkContainment() {
  // A pair that balls or planes separated anywhere is apart there. One body cannot get inside the
  // other unless their surfaces meet.
  int end = -1;
  for (const EdgeInterval& interval : queue.intervals()) {
    if (interval.t0 > 0) continue;
    for (const int p : queue.pairs(interval)) {
      if (queue.widthOf(p) < 1 || frames.isConvex(frames.pair(p))) continue;
      if (end < 0) end = frames.place(1);
      const PairState state = end < 0 ? PairState::kOpen : queries.exactState(end, frames.pair(p));
      if (state == PairState::kNotFree) return PairVerdict{Verdict::kNotFree, p, 1};
      if (state == PairState::kOpen) return PairVerdict{Verdict::kUndecided, p, 1};
    }
  }
  return std::nullopt;
}

/// Ends at the first pair that is not free, or that limits leave open.
class EdgeCertifier::Impl::VerdictRule {
 public:
  explicit VerdictRule(Impl& impl) : impl_(impl) {}
  PairVerdict verdict{Verdict::kFree};

  bool sweep(EdgeInterval& interval) {
    if (const auto contact = impl_.sweepTasks(interval)) return endWith(*contact);
    if (interval.isSettled()) return true;
    const int first = impl_.queue.pairs(interval).front();
    undecided_ = {Verdict::kUndecided, first, interval.middle()};
    if (impl_.work.isSpent()) return endWith(undecided_);
    // A planner's edges start in free space and often end in contact.
    if (const auto at_end = checkEnd(interval)) return endWith(*at_end);
    if (interval.level >= kDeepestLevel || interval.h <= impl_.queries.least_interval)
      return endWith(undecided_);
    const double speed = impl_.queries.motionOf(interval, impl_.frames.pair(first).motion).speed;
    return !(interval.h * speed < kSmallestMotion) || endWith(undecided_);
  }

  bool look(EdgeInterval& interval, int slot) {
    if (slot < 0) return endWith(undecided_);
    if (const auto contact = checkMiddle(interval, slot)) return endWith(*contact);
    return impl_.queue.hasRoom(interval) || endWith(undecided_);
  }

 private:
  bool endWith(const PairVerdict& end) {
    verdict = end;
    return false;
  }

  /// Checks, at the edge's end, the pairs whose sweep of the last interval failed; once per edge
  /// and pair.
  std::optional<PairVerdict> checkEnd(const EdgeInterval& interval) {
    if (interval.t0 + interval.h < 1) return std::nullopt;
    for (const int p : impl_.queue.pairs(interval)) {
      PairMemory& known = impl_.memory.of(p);
      if (known.sweep_failed != impl_.queries.interval() || known.end_checked == impl_.edge)
        continue;
      known.end_checked = impl_.edge;
      const PairState state = impl_.queries.exactState(interval.slot1, impl_.frames.pair(p));
      if (state == PairState::kNotFree) return PairVerdict{Verdict::kNotFree, p, 1};
      if (state == PairState::kOpen) return PairVerdict{Verdict::kUndecided, p, 1};
    }
    return std::nullopt;
  }

  /// Checks an interval's open pairs at its middle, placed in `slot`. Undecided pairs stay open.
  std::optional<PairVerdict> checkMiddle(const EdgeInterval& interval, int slot) {
    for (const int p : impl_.queue.pairs(interval)) {
      const EdgePair& pair = impl_.frames.pair(p);
      PairState state = impl_.queries.coarseState(slot, pair);
      // If a sweep has just failed, the pair is near enough for an exact query. A contact is found
      // within few nodes; the absence of one must be proven by the halves anyway.
      if (state == PairState::kOpen &&
          impl_.memory.of(p).sweep_failed == impl_.queries.interval() && !impl_.work.isSpent())
        state = impl_.queries.exactState(slot, pair, kContactNodes);
      if (state == PairState::kNotFree) return PairVerdict{Verdict::kNotFree, p, interval.middle()};
    }
    return std::nullopt;
  }

  Impl& impl_;
  PairVerdict undecided_{
      Verdict::kUndecided};  ///< if nothing more is known of the current interval
};

PairVerdict EdgeCertifier::Impl::sweepAll() {
  VerdictRule rule(*this);
  queue.subdivide(EdgeQueue::Order::kByLevel, rule);
  return rule.verdict;
}

/// Starts at the edge's start; ends at the first interval that stays open.
class EdgeCertifier::Impl::LastValidRule {
 public:
  explicit LastValidRule(Impl& impl) : impl_(impl) {}
  double last_valid = 0;

  bool sweep(EdgeInterval& interval) {
    impl_.sweepTasks(interval);  // an interval in contact at its end may be certified in part
    if (interval.isSettled()) {
      last_valid = interval.t0 + interval.h;
      return true;
    }
    return interval.level < kLastValidLevel && !impl_.work.isSpent() &&
           interval.h > impl_.queries.least_interval;
  }
  bool look(EdgeInterval& interval, int slot) { return slot >= 0 && impl_.queue.hasRoom(interval); }

 private:
  Impl& impl_;
};

double EdgeCertifier::Impl::lastValid() {
  frames.release(0);
  startWork(work.limit);
  int offender = -1;
  const int start = frames.place(0), end = frames.place(1);
  if (start < 0 || checkState(start, 0, offender) != Verdict::kFree || end < 0) return 0;
  if (!takeWholeEdge(start, end, beyondMargins())) return 0;
  LastValidRule rule(*this);
  queue.subdivide(EdgeQueue::Order::kFromLeft, rule);
  return rule.last_valid;
}

}  // namespace leeway::planner
