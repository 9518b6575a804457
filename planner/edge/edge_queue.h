#pragma once

// Private to planner/: the open tasks along an edge, and the loop that halves them.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/base/spare_memory.h"
#include "planner/edge/edge_frames.h"

namespace leeway::planner {

/// Part [t0, t0 + h] of the edge; both are dyadic and therefore exact. The pairs that are still
/// open there are [begin, end) of the list EdgeQueue::pairs().
struct EdgeInterval {
  int slot0, slot1;  ///< the configurations at its ends
  double t0, h;
  int begin, end;
  int level;  ///< bisections so far

  double middle() const { return t0 + h / 2; }
  bool isSettled() const { return begin == end; }
};

/// The tasks of an edge: pairs that are still open, each over an interval, grouped by interval.
/// Allocates only in the constructor.
class EdgeQueue {
 public:
  /// Has room for `pairs` tasks per level.
  EdgeQueue(EdgeFrames& frames, std::size_t pairs);

  void clear() { now_.clear(); }
  bool empty() const { return now_.intervals.empty(); }
  std::span<const EdgeInterval> intervals() const { return now_.intervals; }
  std::span<int> pairs(const EdgeInterval& interval) {
    return {now_.pairs.data() + interval.begin, at(interval.end - interval.begin)};
  }
  /// The pairs of all tasks.
  std::span<const int> pairs() const { return now_.pairs; }

  /// The sum of the widths of a pair's tasks: below 1 if they leave out a part of the edge.
  /// O(tasks).
  double widthOf(int pair) const;

  /// Appends a task. A task over the interval of the previous task joins its group. False if full.
  bool add(int pair, double from, double width, int level = 0);
  /// Replaces all tasks by one interval, the whole edge, whose ends are placed. fill(interval,
  /// pairs) adds the pairs to a SpareVector<int> and does not grow it.
  template <class Fill>
  void takeWholeEdge(int start, int end, const Fill& fill) {
    clear();
    EdgeInterval whole{start, end, 0, 1, 0, 0, 0};
    fill(whole, now_.pairs);
    whole.end = static_cast<int>(now_.pairs.size());
    now_.intervals.push_back(whole);
  }
  /// Merges a pair's tasks over neighbouring intervals into one, as long as mayJoin(pair, width)
  /// allows its width, because one long sweep costs less than two short ones. False if full.
  /// O(tasks log tasks).
  template <class MayJoin>
  bool join(const MayJoin& mayJoin) {
    listSpans();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < spans_.size();) {
      Span whole = spans_[i++];
      for (; i < spans_.size() && spans_[i].pair == whole.pair &&
             spans_[i].from == whole.from + whole.width &&
             mayJoin(whole.pair, whole.width + spans_[i].width);
           ++i)
        whole.width += spans_[i].width;
      spans_[kept++] = whole;
    }
    return kept == spans_.size() || addSpans(kept);
  }

  /// Keeps the tasks of an interval for which isOpen(pair) is true.
  template <class IsOpen>
  void keep(EdgeInterval& interval, const IsOpen& isOpen) {
    int kept = interval.begin;
    for (int i = interval.begin; i < interval.end; ++i) {
      const int pair = now_.pairs[at(i)];
      if (isOpen(pair)) now_.pairs[at(kept++)] = pair;
    }
    interval.end = kept;
  }

  /// The order in which subdivide() takes intervals.
  enum class Order : unsigned char {
    kByLevel,   ///< as they were added, then their halves: the widest first
    kFromLeft,  ///< from one end of the edge to the other; starts with the last interval
  };
  /// Calls a rule for each interval, and for the halves of those that stay open, until none is
  /// left. The rule defines the question about the edge, and when it is answered:
  ///   bool sweep(EdgeInterval& interval)            settles tasks of the interval
  ///   bool look(EdgeInterval& interval, int slot)   checks an open interval at its middle, placed
  ///                                                 in `slot`; -1: it could not be placed
  /// Both end the loop by returning false. look() returns true only if hasRoom() does, or if no
  /// task is left.
  template <class Rule>
  void subdivide(Order order, Rule& rule) {
    order_ = order;
    taken_ = 0;
    next_.clear();
    EdgeInterval interval{};
    while (take(interval)) {
      if (!rule.sweep(interval)) return;
      if (interval.isSettled()) continue;
      const int slot = frames_.place(interval.middle());
      if (!rule.look(interval, slot)) return;
      if (!interval.isSettled()) split(interval, slot);
    }
  }
  /// Within subdivide(): true for the first interval of a level.
  bool startsLevel() const { return taken_ == 1; }
  /// Within subdivide(): whether there is room for the halves of an interval.
  bool hasRoom(const EdgeInterval& interval) const;
  /// Whether there is room for the tasks that halve() adds.
  bool hasRoomToHalve(const EdgeInterval& interval) const {
    return now_.pairs.size() + at(interval.end - interval.begin) <= now_.pairs.capacity();
  }
  /// The halves of an interval, which meet in `slot`. The right half keeps its tasks, the left half
  /// gets copies after all others.
  std::array<EdgeInterval, 2> halve(const EdgeInterval& interval, int slot);

 private:
  struct Tasks {
    collision::SpareVector<EdgeInterval> intervals;
    collision::SpareVector<int> pairs;
    void clear() {
      intervals.clear();
      pairs.clear();
    }
  };
  /// A single task, for join().
  struct Span {
    int pair;
    double from, width;
  };

  bool take(EdgeInterval& interval);
  void split(const EdgeInterval& interval, int slot);
  /// Lists the tasks one by one, by pair and place; leaves the list empty if no tasks can be
  /// joined.
  void listSpans();
  /// Replaces all tasks by the first `count` spans.
  bool addSpans(std::size_t count);

  EdgeFrames& frames_;
  Order order_ = Order::kByLevel;
  std::size_t taken_ = 0;  // into now_
  Tasks now_, next_;       // of the current level and the next
  std::vector<Span> spans_;
};

}  // namespace leeway::planner
