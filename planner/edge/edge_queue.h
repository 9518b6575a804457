#pragma once

// Private to planner/: what is still open along an edge, and the loop that halves it.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/base/spare_memory.h"
#include "planner/edge/edge_frames.h"

namespace leeway::planner {

/// Part [t0, t0 + h] of the edge; both are dyadic, and so exact. The pairs that are still open
/// there are [begin, end) of a list: EdgeQueue::pairs().
struct EdgeInterval {
  int slot0, slot1;  ///< the configurations at its ends
  double t0, h;
  int begin, end;
  int level;  ///< bisections so far

  double middle() const { return t0 + h / 2; }
  bool isSettled() const { return begin == end; }
};

/// The tasks of an edge: pairs that are still open, each over an interval, grouped by interval.
/// Allocates in the constructor only.
class EdgeQueue {
 public:
  /// Has room for `pairs` tasks of one level.
  EdgeQueue(EdgeFrames& frames, std::size_t pairs);

  void clear() { now_.clear(); }
  bool empty() const { return now_.intervals.empty(); }
  std::span<const EdgeInterval> intervals() const { return now_.intervals; }
  std::span<int> pairs(const EdgeInterval& interval) {
    return {now_.pairs.data() + interval.begin, at(interval.end - interval.begin)};
  }
  /// All pairs that tasks name.
  std::span<const int> pairs() const { return now_.pairs; }

  /// Appends a task. One over the interval of the task before joins its group. False when full.
  bool add(int pair, double from, double width, int level = 0);
  /// Replaces all tasks by one interval, the whole edge, whose ends are placed. fill(interval,
  /// pairs) gives a SpareVector<int> its pairs, and does not grow it.
  template <class Fill>
  void takeWholeEdge(int start, int end, const Fill& fill) {
    clear();
    EdgeInterval whole{start, end, 0, 1, 0, 0, 0};
    fill(whole, now_.pairs);
    whole.end = static_cast<int>(now_.pairs.size());
    now_.intervals.push_back(whole);
  }
  /// Makes one task of a pair's tasks over neighbouring intervals, as long as mayJoin(pair, width)
  /// allows one of that width: one long sweep costs less than two short ones. False when full.
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

  /// Keeps those of an interval's tasks for which isOpen(pair) is true.
  template <class IsOpen>
  void keep(EdgeInterval& interval, const IsOpen& isOpen) {
    int kept = interval.begin;
    for (int i = interval.begin; i < interval.end; ++i) {
      const int pair = now_.pairs[at(i)];
      if (isOpen(pair)) now_.pairs[at(kept++)] = pair;
    }
    interval.end = kept;
  }

  /// In which order subdivide() takes intervals.
  enum class Order : unsigned char {
    kByLevel,   ///< as they were added, then their halves: the widest first
    kFromLeft,  ///< from one end of the edge to the other; begins with the last interval
  };
  /// Takes each interval to a rule, and the halves of those that stay open, until none is left.
  /// A rule says what is asked of an edge, and when that is answered:
  ///   bool sweep(EdgeInterval& interval)            settles what it can of the interval's tasks
  ///   bool look(EdgeInterval& interval, int slot)   of one that stays open, at its middle, placed
  ///                                                 in `slot`; -1: it could not be placed
  /// Both end the loop by returning false. look() returns true only where hasRoom() does, or where
  /// no task is left.
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
  /// Whether there is room for what halve() adds.
  bool hasRoomToHalve(const EdgeInterval& interval) const {
    return now_.pairs.size() + at(interval.end - interval.begin) <= now_.pairs.capacity();
  }
  /// The halves of an interval, which meet in `slot`. The right one keeps its tasks, the left one
  /// gets copies behind all others.
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
  /// A task of its own, for join().
  struct Span {
    int pair;
    double from, width;
  };

  bool take(EdgeInterval& interval);
  void split(const EdgeInterval& interval, int slot);
  /// The tasks, one by one, by pair and place; none where nothing can be joined.
  void listSpans();
  /// Replaces all tasks by the first `count` spans.
  bool addSpans(std::size_t count);

  EdgeFrames& frames_;
  Order order_ = Order::kByLevel;
  std::size_t taken_ = 0;  // intervals of now_
  Tasks now_, next_;       // of this level and the next
  std::vector<Span> spans_;
};

}  // namespace leeway::planner
