// Exact sweeps of intervals, halved until every pair is decided: adaptive bisection as in
// Schwarzer, Saha and Latombe 2005, see EdgeCertifier.

#include <utility>

#include "planner/base/tolerances.h"
#include "planner/edge/edge_certifier_impl.h"

namespace leeway::planner {

EdgeCheck EdgeCertifier::Impl::certifyByBisection() {
  const int end = frames.place(1);
  int offender = -1;
  // The end first: it decides most edges. It also settles containment, which cannot change along a
  // certified edge.
  const Verdict at_end = end < 0 ? Verdict::kUndecided : checkState(end, 1, offender);
  if (at_end != Verdict::kFree) return makeCheck(at_end, offender, 1);
  const int start = frames.place(0);
  if (start < 0) return makeCheck(Verdict::kUndecided);
  if (!listWholeEdge(start, end, beyondMargins())) return makeCheck(Verdict::kUndecided);
  return bisectIntervals();
}

EdgeCheck EdgeCertifier::Impl::bisectIntervals() {
  while (!intervals.empty()) {
    next_intervals.clear();
    next_open_pairs.clear();
    for (EdgeInterval& interval : intervals)
      if (const auto check = bisect(interval)) return *check;
    intervals.swap(next_intervals);
    open_pairs.swap(next_open_pairs);
  }
  return makeCheck(Verdict::kFree);
}

std::optional<EdgeCheck> EdgeCertifier::Impl::bisect(EdgeInterval& interval) {
  if (const auto contact = sweepOpenPairs(interval))
    return makeCheck(Verdict::kNotFree, contact->pair, contact->t);
  if (interval.begin == interval.end) return std::nullopt;
  const int first = open_pairs[at(interval.begin)];
  const double middle = interval.t0 + interval.h / 2;
  const auto undecided = [&] { return makeCheck(Verdict::kUndecided, first, middle); };
  if (work.isSpent()) return undecided();
  // A planner's edges come from where it is free and often end in contact.
  if (const auto check = checkEnd(interval)) return check;
  if (interval.level >= kDeepestLevel || interval.h <= smallest) return undecided();
  const double speed = motionOf(interval, frames.pair(first).motion).speed;
  if (interval.h * speed < kSmallestMotion) return undecided();
  const int slot = frames.place(middle);
  if (slot < 0) return undecided();
  if (const auto check = checkMiddle(interval, slot)) return check;
  if (!hasRoomToSplit(at(interval.end - interval.begin))) return undecided();
  split(interval, slot);
  return std::nullopt;
}

void EdgeCertifier::Impl::findLastValid(EdgeCheck& check) {
  frames.release(0);
  startWork(work_limit);
  check.last_valid = 0;
  int offender = -1;
  const int start = frames.place(0), end = frames.place(1);
  if (start < 0 || checkState(start, 0, offender) != Verdict::kFree || end < 0) return;
  if (!listWholeEdge(start, end, beyondMargins())) return;
  certifyPrefix(intervals.front(), check);
}

bool EdgeCertifier::Impl::certifyPrefix(EdgeInterval interval, EdgeCheck& check) {
  sweepOpenPairs(interval);  // of an interval in contact at its end a part may be certified
  if (interval.begin == interval.end) {
    check.last_valid = interval.t0 + interval.h;
    return true;
  }
  if (interval.level >= kLastValidLevel || work.isSpent() || interval.h <= smallest) return false;
  const auto count = at(interval.end - interval.begin);
  const int mark = frames.used();
  const std::size_t top = open_pairs.size();
  const int slot = frames.place(interval.t0 + interval.h / 2);
  if (slot < 0 || top + count > open_pairs.capacity()) return false;
  bool certified = true;
  for (int half = 0; half < 2 && certified; ++half) {
    open_pairs.resize(top);
    open_pairs.insert(open_pairs.end(), open_pairs.begin() + interval.begin,
                      open_pairs.begin() + interval.end);
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
  open_pairs.resize(top);
  frames.release(mark);
  return certified;
}

}  // namespace leeway::planner
