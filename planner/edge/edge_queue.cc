#include "planner/edge/edge_queue.h"

#include <algorithm>

namespace leeway::planner {
namespace {

constexpr std::size_t kIntervals = 2048;  ///< per level
constexpr std::size_t kSpans = 4096;      ///< with more, none are joined

}  // namespace

EdgeQueue::EdgeQueue(EdgeFrames& frames, std::size_t pairs) : frames_(frames) {
  for (Tasks* tasks : {&now_, &next_}) {
    tasks->intervals.reserve(kIntervals);
    tasks->pairs.reserve(pairs);
  }
  spans_.reserve(kSpans);
}

bool EdgeQueue::add(int pair, double from, double width, int level) {
  auto& [intervals, pairs] = now_;
  if (pairs.size() == pairs.capacity()) return false;
  if (intervals.empty() || intervals.back().t0 != from || intervals.back().h != width) {
    const int first = frames_.slotAt(from), last = frames_.slotAt(from + width);
    if (first < 0 || last < 0 || intervals.size() == intervals.capacity()) return false;
    const auto begin = static_cast<int>(pairs.size());
    intervals.push_back({first, last, from, width, begin, begin, level});
  }
  pairs.push_back(pair);
  ++intervals.back().end;
  return true;
}

double EdgeQueue::widthOf(int pair) const {
  double width = 0;  // exact
  for (const EdgeInterval& interval : now_.intervals)
    for (int i = interval.begin; i < interval.end; ++i)
      if (now_.pairs[at(i)] == pair) width += interval.h;
  return width;
}

bool EdgeQueue::take(EdgeInterval& interval) {
  auto& [intervals, pairs] = now_;
  if (order_ == Order::kFromLeft) {
    if (intervals.empty()) return false;
    interval = intervals.back();
    intervals.pop_back();
    pairs.resize(at(interval.end));
    // Slots of intervals further left are not used again.
    const int used = std::max(interval.slot0, interval.slot1) + 1;
    if (frames_.used() > used) frames_.release(used);
    return true;
  }
  if (taken_ == intervals.size()) {
    std::swap(now_, next_);
    next_.clear();
    taken_ = 0;
    if (intervals.empty()) return false;
  }
  interval = intervals[taken_++];
  return true;
}

bool EdgeQueue::hasRoom(const EdgeInterval& interval) const {
  if (order_ == Order::kFromLeft)
    return hasRoomToHalve(interval) && now_.intervals.size() + 2 <= now_.intervals.capacity();
  return next_.pairs.size() + 2 * at(interval.end - interval.begin) <= next_.pairs.capacity() &&
         next_.intervals.size() + 2 <= next_.intervals.capacity();
}

std::array<EdgeInterval, 2> EdgeQueue::halve(const EdgeInterval& interval, int slot) {
  const double h = interval.h / 2;
  const auto top = static_cast<int>(now_.pairs.size());
  for (int i = interval.begin; i < interval.end; ++i) now_.pairs.push_back(now_.pairs[at(i)]);
  const auto end = static_cast<int>(now_.pairs.size());
  return {EdgeInterval{interval.slot0, slot, interval.t0, h, top, end, interval.level + 1},
          EdgeInterval{slot, interval.slot1, interval.t0 + h, h, interval.begin, interval.end,
                       interval.level + 1}};
}

void EdgeQueue::split(const EdgeInterval& interval, int slot) {
  if (order_ == Order::kFromLeft) {
    now_.pairs.resize(at(interval.end));
    const auto [left, right] = halve(interval, slot);
    now_.intervals.push_back(right);
    now_.intervals.push_back(left);
    return;
  }
  const double h = interval.h / 2;
  for (int half = 0; half < 2; ++half) {
    const auto begin = static_cast<int>(next_.pairs.size());
    next_.pairs.insert(next_.pairs.end(), now_.pairs.begin() + interval.begin,
                       now_.pairs.begin() + interval.end);
    next_.intervals.push_back({half == 0 ? interval.slot0 : slot, half == 0 ? slot : interval.slot1,
                               interval.t0 + half * h, h, begin,
                               static_cast<int>(next_.pairs.size()), interval.level + 1});
  }
}

void EdgeQueue::listSpans() {
  spans_.clear();
  if (now_.intervals.size() < 2 || now_.pairs.size() > spans_.capacity()) return;
  for (const EdgeInterval& interval : now_.intervals)
    for (const int pair : pairs(interval)) spans_.push_back({pair, interval.t0, interval.h});
  std::sort(spans_.begin(), spans_.end(), [](const Span& x, const Span& y) {
    return x.pair != y.pair ? x.pair < y.pair : x.from < y.from;
  });
}

bool EdgeQueue::addSpans(std::size_t count) {
  spans_.resize(count);
  std::sort(spans_.begin(), spans_.end(), [](const Span& x, const Span& y) {
    return x.from != y.from     ? x.from < y.from
           : x.width != y.width ? x.width > y.width
                                : x.pair < y.pair;
  });
  now_.clear();
  for (const Span& span : spans_)
    if (!add(span.pair, span.from, span.width)) return false;
  return true;
}

}  // namespace leeway::planner
