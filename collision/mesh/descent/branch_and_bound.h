#pragma once

// Private to collision/: the order in which all branch and bounds over hierarchies visit.

#include <array>
#include <cstddef>
#include <span>

namespace leeway::collision {

/// Depth-first branch and bound, nearer parts first, with a stack of fixed size for kRoom open
/// parts: pairs of parts of two bodies, or parts of one body that are compared with a point or a
/// whole body. `Open::lower` bounds everything below such a part from below.
///
/// `Bounds` is what has been proven so far, and decides how far the search goes:
///   isPruned(open)   the part cannot change the answer
///   settle(open)     records the lower bound of a part that gets no closer look
///   isDone()         the answer is known
///   isSpent()        a limit has been reached
/// The caller opens what next() returns: it pushes the parts below it, or compares leaves.
template <class Open, std::size_t kRoom>
class BranchAndBound {
 public:
  bool isEmpty() const { return size_ == 0; }
  std::size_t size() const { return size_; }

  void push(const Open& open) { open_[size_++] = open; }
  /// Pushes a part next to its siblings, which are above `first`, the stack's size before them: the
  /// nearest on top, and of equal ones the last.
  void pushSibling(std::size_t first, const Open& open) {
    std::size_t at = size_++;
    for (; at > first && open_[at - 1].lower < open.lower; --at) open_[at] = open_[at - 1];
    open_[at] = open;
  }
  /// The same, unless the part is pruned. It is settled in that case.
  template <class Bounds>
  void pushSibling(Bounds& bounds, std::size_t first, const Open& open) {
    if (bounds.isPruned(open)) {
      bounds.settle(open);
    } else {
      pushSibling(first, open);
    }
  }

  /// Takes the next part that needs a closer look, and settles the pruned parts before it. False if
  /// the search is over: nothing is open (isEmpty()), the answer is known, or a limit was reached.
  template <class Bounds>
  bool next(Bounds& bounds, Open& open) {
    while (size_ > 0 && !bounds.isDone()) {
      open = open_[size_ - 1];
      if (!bounds.isPruned(open)) {
        if (bounds.isSpent()) return false;
        --size_;
        return true;
      }
      bounds.settle(open);
      --size_;
    }
    return false;
  }

  /// Takes several parts, so that their cache misses overlap: one leaf (`Open::isLeaf()`), or as
  /// many of the next nodes as `room` holds. Until `Bounds::hasUpper()` it takes one node at a
  /// time, because the nearest leads to an upper bound. Counts them by `Bounds::visit()`.
  template <class Bounds, std::size_t kTogether>
  bool next(Bounds& bounds, std::array<Open, kTogether>& room, std::span<const Open>& taken) {
    std::size_t count = 0;
    if (!bounds.isDone()) {
      const std::size_t most = bounds.hasUpper() ? kTogether : 1;
      while (size_ > 0 && count < most) {
        const Open open = open_[size_ - 1];
        if (bounds.isPruned(open)) {
          bounds.settle(open);
          --size_;
          continue;
        }
        const bool is_leaf = open.isLeaf();
        if ((is_leaf && count > 0) || bounds.isSpent()) break;
        bounds.visit();
        --size_;
        room[count++] = open;
        if (is_leaf) break;
      }
    }
    taken = std::span<const Open>(room).first(count);
    return count > 0;
  }

  /// Settles all parts that are still open.
  template <class Bounds>
  void settleRest(Bounds& bounds) {
    while (size_ > 0) bounds.settle(open_[--size_]);
  }

 private:
  std::array<Open, kRoom> open_;
  std::size_t size_ = 0;
};

}  // namespace leeway::collision
