#include "collision/lanes/obstacle_boxes.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace leeway::collision {
namespace {

using Box = ObstacleBoxes::Box;
using Level = ObstacleBoxes::Level;

constexpr std::size_t kWidth = ObstacleBoxes::kWidth;
// Boxes that are longer than this share of the world would stretch the nodes of all others, so they
// are grouped together.
constexpr float kLargeShare = 0.25F;

float middle(const Box& box, int k) { return 0.5F * box.low[k] + 0.5F * box.high[k]; }

// The range of the middles on each axis.
struct Spread {
  float low[3], high[3];
  float length(int k) const { return high[k] - low[k]; }
  int longest() const {
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (length(k) > length(axis)) axis = k;
    return axis;
  }
};

// A box while it is sorted.
struct Middle {
  float at[3];
  std::int32_t box;
};

Spread spreadOf(std::span<const Middle> middles) {
  Spread spread;
  std::fill_n(spread.low, 3, kFar);
  std::fill_n(spread.high, 3, -kFar);
  for (const Middle& m : middles)
    for (int k = 0; k < 3; ++k) {
      spread.low[k] = std::min(spread.low[k], m.at[k]);
      spread.high[k] = std::max(spread.high[k], m.at[k]);
    }
  return spread;
}

// The largest power of kWidth below n: the number of boxes of a full node.
std::size_t fullNode(std::size_t n) {
  std::size_t full = kWidth;
  while (full * kWidth < n) full *= kWidth;
  return full;
}

// Halves along the longest axis, at a multiple of a full node, until kWidth are left.
void sortMiddles(std::span<Middle> middles) {
  while (middles.size() > kWidth) {
    const std::size_t full = fullNode(middles.size());
    const std::size_t half = (middles.size() / 2 + full - 1) / full * full;
    const int axis = spreadOf(middles).longest();
    std::nth_element(middles.begin(), middles.begin() + static_cast<std::ptrdiff_t>(half),
                     middles.end(), [axis](const Middle& x, const Middle& y) {
                       return x.at[axis] < y.at[axis] ||
                              (x.at[axis] == y.at[axis] && x.box < y.box);
                     });
    sortMiddles(middles.first(half));
    middles = middles.subspan(half);
  }
  std::sort(middles.begin(), middles.end(),
            [](const Middle& x, const Middle& y) { return x.box < y.box; });
}

// Stored contiguously, because sorting through indices waits for memory.
std::vector<Middle> middlesOf(std::span<const Box> boxes, std::span<const std::int32_t> order) {
  std::vector<Middle> middles;
  middles.reserve(order.size());
  for (const std::int32_t i : order) {
    const Box& box = boxes[static_cast<std::size_t>(i)];
    middles.push_back({{middle(box, 0), middle(box, 1), middle(box, 2)}, i});
  }
  return middles;
}

void sortBoxes(std::span<const Box> boxes, std::span<std::int32_t> order) {
  std::vector<Middle> middles = middlesOf(boxes, order);
  sortMiddles(middles);
  for (std::size_t i = 0; i < middles.size(); ++i) order[i] = middles[i].box;
}

// At least this many boxes are sorted along a Morton curve, which is faster; for fewer boxes,
// halving gives tighter nodes.
constexpr std::size_t kManyBoxes = 1U << 16U;

// Spreads bits to every third position.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32U) & 0x001f00000000ffffU;
  x = (x | x << 16U) & 0x001f0000ff0000ffU;
  x = (x | x << 8U) & 0x100f00f00f00f00fU;
  x = (x | x << 4U) & 0x10c30c30c30c30c3U;
  return (x | x << 2U) & 0x1249249249249249U;
}

void sortAlongCurve(std::span<const Box> boxes, std::span<std::int32_t> order) {
  constexpr float kCells = 0x1p20F;
  const Spread world = spreadOf(middlesOf(boxes, order));
  const float length = world.length(world.longest());
  const float cells = length > 0 ? kCells / length : 0;
  std::vector<std::pair<std::uint64_t, std::int32_t>> keys;
  keys.reserve(order.size());
  for (const std::int32_t i : order) {
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k) {
      const float cell = (middle(boxes[static_cast<std::size_t>(i)], k) - world.low[k]) * cells;
      key = key << 1U | spread(static_cast<std::uint64_t>(std::clamp(cell, 0.0F, kCells)));
    }
    keys.emplace_back(key, i);
  }
  std::sort(keys.begin(), keys.end());
  for (std::size_t i = 0; i < keys.size(); ++i) order[i] = keys[i].second;
}

Level emptyLevel(std::size_t count) {
  const std::size_t padded = (count + kWidth - 1) / kWidth * kWidth;
  Level level;
  for (int k = 0; k < 3; ++k) {
    level.low[k].assign(padded, kFar);
    level.high[k].assign(padded, -kFar);
  }
  return level;
}

Level levelAbove(const Level& below) {
  Level level = emptyLevel(below.size() / kWidth);
  for (int k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < below.size(); ++i) {
      level.low[k][i / kWidth] = std::min(level.low[k][i / kWidth], below.low[k][i]);
      level.high[k][i / kWidth] = std::max(level.high[k][i / kWidth], below.high[k][i]);
    }
  return level;
}

}  // namespace

ObstacleBoxes::ObstacleBoxes(std::span<const Box> boxes, std::shared_ptr<const ObstacleBoxes> first,
                             std::int32_t number)
    : first_(std::move(first)), slots_of_first_(first_ ? first_->slots() : 0) {
  if (boxes.empty()) return;
  std::vector<std::int32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0);
  if (boxes.size() > kMostInList) {
    const Spread world = spreadOf(middlesOf(boxes, order));
    const float longest = kLargeShare * world.length(world.longest());
    const auto isLarge = [&](std::int32_t i) {
      const Box& box = boxes[static_cast<std::size_t>(i)];
      for (int k = 0; k < 3; ++k)
        if (box.high[k] - box.low[k] > longest) return true;
      return false;
    };
    // Large boxes are last, so that the nodes of the others stay full.
    const auto large = std::stable_partition(order.begin(), order.end(),
                                             [&](std::int32_t i) { return !isLarge(i); });
    if (large - order.begin() > static_cast<std::ptrdiff_t>(kManyBoxes))
      sortAlongCurve(boxes, {order.begin(), large});
    else
      sortBoxes(boxes, {order.begin(), large});
    sortBoxes(boxes, {large, order.end()});
  }
  levels_.push_back(emptyLevel(boxes.size()));
  Level& slots = levels_.front();
  obstacle_.assign(slots.size(), -1);
  balls_alone_.assign(slots.size() / kWidth, 1);
  for (std::size_t slot = 0; slot < order.size(); ++slot) {
    obstacle_[slot] = number + order[slot];
    const Box& box = boxes[static_cast<std::size_t>(order[slot])];
    if (!box.is_ball) balls_alone_[slot / kWidth] = 0;
    for (int k = 0; k < 3; ++k) {
      slots.low[k][slot] = box.low[k];
      slots.high[k][slot] = box.high[k];
    }
  }
  while (levels_.back().size() > kMostInList) levels_.push_back(levelAbove(levels_.back()));
}

std::size_t ObstacleBoxes::bytes() const {
  std::size_t boxes = 0;
  for (const Level& level : levels_) boxes += level.size();
  return boxes * 6 * sizeof(float) + obstacle_.size() * sizeof(std::int32_t) + balls_alone_.size() +
         (first_ ? first_->bytes() : 0);
}

}  // namespace leeway::collision
