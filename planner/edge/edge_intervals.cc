// Lists of intervals with their open pairs: which pairs are swept over which part of the edge.

#include <algorithm>
#include <iterator>

#include "planner/base/tolerances.h"
#include "planner/edge/edge_certifier_impl.h"

namespace leeway::planner {

bool EdgeCertifier::Impl::listWholeEdge(int start, int end, double reach) {
  open_pairs.assign(looked_at.begin(), looked_at.end());
  const EdgeInterval whole{start, end, 0, 1, 0, 0, 0};
  startInterval();
  bool has_room = true;
  for (std::size_t row = 0; !looks_at_all && row < frames.pairs().rows().size(); ++row) {
    // No point is farther than that from where the nearer end has it.
    const double way = motionOf(whole, frames.pairs().rows()[row].motion).speed / 2;
    for (const int slot : {start, end})
      has_room = has_room && frames.nearInRow(row, slot, reach + way, open_pairs);
  }
  if (!looks_at_all) {
    std::sort(open_pairs.begin(), open_pairs.end());
    open_pairs.erase(std::unique(open_pairs.begin(), open_pairs.end()), open_pairs.end());
  }
  std::erase_if(open_pairs, [&](int p) { return !isAsked(frames.pair(p)); });
  intervals.clear();
  intervals.push_back(whole);
  intervals.back().end = static_cast<int>(open_pairs.size());
  return has_room;
}

bool EdgeCertifier::Impl::addInterval(double from, double width) {
  const int first = slotAt(from), last = slotAt(from + width);
  if (first < 0 || last < 0 || intervals.size() == intervals.capacity()) return false;
  const auto size = static_cast<int>(open_pairs.size());
  intervals.push_back({first, last, from, width, size, size, 0});
  return true;
}

int EdgeCertifier::Impl::lanesPerSweep(const collision::LaneSweep::Open& pair) const {
  double growth = lanes.growth(frames.pair(pair.id).motion);
  int width = 1;
  while (width < collision::kLanes && 4 * growth <= kMergedGrowth) {
    growth *= 4;
    width *= 2;
  }
  return width;
}

bool EdgeCertifier::Impl::isSweptOver(const collision::LaneSweep::Open& pair, int lane,
                                      int width) const {
  const auto block = [](int first, int count) { return ((1U << count) - 1) << first; };
  const std::uint32_t wanted = block(lane, width);
  if (!frames.pair(pair.id).by_surfaces)
    return (pair.lanes & wanted) != 0 && lanesPerSweep(pair) == width;
  // The sweep of surfaces halves long parts itself where that pays, so it gets the widest blocks
  // that are open.
  if ((pair.lanes & wanted) != wanted) return false;
  if (width == collision::kLanes) return true;
  const std::uint32_t wider = block(lane & ~(2 * width - 1), 2 * width);
  return (pair.lanes & wider) != wider;
}

bool EdgeCertifier::Impl::listOpenLanes() {
  if (lanes.isFull()) return false;
  int slots[collision::kLanes + 1];
  std::fill(std::begin(slots), std::end(slots), -1);
  for (int width = collision::kLanes, level = 0; width >= 1; width /= 2, ++level) {
    for (int lane = 0; lane < collision::kLanes; lane += width) {
      const auto begin = static_cast<int>(open_pairs.size());
      if (open_pairs.size() + lanes.open().size() > open_pairs.capacity()) return false;
      for (const collision::LaneSweep::Open& pair : lanes.open())
        if (!isForParts(pair) && isSweptOver(pair, lane, width)) open_pairs.push_back(pair.id);
      const auto end = static_cast<int>(open_pairs.size());
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

std::size_t EdgeCertifier::Impl::mergeSpans() {
  std::sort(spans.begin(), spans.end(), [](const Span& x, const Span& y) {
    return x.pair != y.pair ? x.pair < y.pair : x.from < y.from;
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < spans.size();) {
    Span merged = spans[i++];
    const EdgePair& pair = frames.pair(merged.pair);
    // Growth of the whole edge; that of a span falls with the square of its width.
    const double growth = lanes.growth(pair.motion) * collision::kLanes * collision::kLanes;
    const auto fits = [&](const Span& next) {
      const double width = merged.width + next.width;
      return next.pair == merged.pair && next.from == merged.from + merged.width &&
             width * width * growth <= kMergedAgainGrowth;
    };
    while (!pair.by_surfaces && i < spans.size() && fits(spans[i]))
      merged.width += spans[i++].width;
    spans[kept++] = merged;
  }
  return kept;
}

bool EdgeCertifier::Impl::mergeIntervals() {
  if (intervals.size() < 2 || open_pairs.size() > spans.capacity()) return true;
  spans.clear();
  for (const EdgeInterval& interval : intervals)
    for (int i = interval.begin; i < interval.end; ++i)
      spans.push_back({open_pairs[at(i)], interval.t0, interval.h});
  const std::size_t kept = mergeSpans();
  if (kept == spans.size()) return true;
  spans.resize(kept);
  std::sort(spans.begin(), spans.end(), [](const Span& x, const Span& y) {
    return x.from != y.from     ? x.from < y.from
           : x.width != y.width ? x.width > y.width
                                : x.pair < y.pair;
  });
  intervals.clear();
  open_pairs.clear();
  for (std::size_t i = 0; i < spans.size(); ++i) {
    const Span& span = spans[i];
    const bool is_new =
        i == 0 || span.from != spans[i - 1].from || span.width != spans[i - 1].width;
    if (is_new && !addInterval(span.from, span.width)) return false;
    open_pairs.push_back(span.pair);
    intervals.back().end = static_cast<int>(open_pairs.size());
  }
  return true;
}

void EdgeCertifier::Impl::split(const EdgeInterval& interval, int slot) {
  const int count = interval.end - interval.begin;
  if (count == 0) return;
  const double h = interval.h / 2;
  for (int half = 0; half < 2; ++half) {
    const auto begin = static_cast<int>(next_open_pairs.size());
    next_open_pairs.insert(next_open_pairs.end(), open_pairs.begin() + interval.begin,
                           open_pairs.begin() + interval.end);
    next_intervals.push_back({half == 0 ? interval.slot0 : slot, half == 0 ? slot : interval.slot1,
                              interval.t0 + half * h, h, begin, begin + count, interval.level + 1});
  }
}

}  // namespace leeway::planner
