#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace leeway::collision {

inline constexpr float kFar = 1e30F;  ///< beyond all coordinates [m]

/// Axis-aligned boxes of obstacles in the world, in single precision: a tree whose nodes have
/// kWidth adjacent children, for comparison in vectors. A small number of boxes is one list.
class ObstacleBoxes {
 public:
  static constexpr std::size_t kWidth = 16;
  /// Up to this many boxes are compared one after the other [count].
  static constexpr std::size_t kMostInList = 4 * kWidth;

  struct Box {
    float low[3], high[3];
    bool is_ball = false;  ///< around a ball, whose centre is the box's up to rounding
  };
  /// The boxes of one level, padded to a multiple of kWidth with boxes that intersect nothing. The
  /// children of node i are [kWidth i, kWidth (i + 1)) in the level below.
  struct Level {
    std::vector<float> low[3], high[3];
    std::size_t size() const { return low[0].size(); }
  };

  ObstacleBoxes() = default;
  /// O(n log n).
  explicit ObstacleBoxes(std::span<const Box> boxes) : ObstacleBoxes(boxes, nullptr, 0) {}
  /// Adds more boxes to those of `first`, which are shared and must not have a first() themselves;
  /// the number of the first added box is `number`. O(n log n) in the number of added boxes.
  ObstacleBoxes(std::span<const Box> more, std::shared_ptr<const ObstacleBoxes> first,
                std::int32_t number);

  /// The levels, without those of first(). Level 0 has the boxes themselves, ordered so that
  /// neighbours are near each other.
  std::span<const Level> levels() const { return levels_; }
  /// The boxes in the preceding slots; null if there are none.
  const std::shared_ptr<const ObstacleBoxes>& first() const { return first_; }
  std::size_t slots() const { return slots_of_first_ + obstacle_.size(); }
  /// The number of the box in a slot of level 0; -1: padding.
  std::int32_t obstacle(std::size_t slot) const {
    return slot < slots_of_first_ ? first_->obstacle_[slot] : obstacle_[slot - slots_of_first_];
  }
  /// Whether all boxes of a node of level 1 are around balls; without those of first().
  bool hasBallsAlone(std::size_t node) const { return balls_alone_[node] != 0; }
  std::size_t bytes() const;

  /// Calls visit(slot) for the boxes that `box` intersects, in the order of their slots, until it
  /// returns false. NaN intersects everything. O(boxes) at worst. The ball pass of LaneSweep has
  /// its own version.
  template <class Visit>
  void forEachNear(const Box& box, const Visit& visit) const {
    visitNear(
        box,
        [](const void* of, std::size_t slot) { return (*static_cast<const Visit*>(of))(slot); },
        &visit);
  }

 private:
  /// Calls visit(of, slot) until it returns false, and then returns false.
  bool visitNear(const Box& box, bool (*visit)(const void* of, std::size_t slot),
                 const void* of) const;

  std::shared_ptr<const ObstacleBoxes> first_;
  std::size_t slots_of_first_ = 0;
  std::vector<Level> levels_;
  std::vector<std::int32_t> obstacle_;
  std::vector<char> balls_alone_;  // one for each kWidth slots
};

}  // namespace leeway::collision
