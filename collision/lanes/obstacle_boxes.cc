#include "collision/lanes/obstacle_boxes.h"

#include <algorithm>
#include <bit>
#include <cmath>
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

template <class Things, class MiddleOf>
Spread spreadOfEach(const Things& things, const MiddleOf& middle) {
  Spread spread;
  std::fill_n(spread.low, 3, kFar);
  std::fill_n(spread.high, 3, -kFar);
  for (const auto& thing : things)
    for (int k = 0; k < 3; ++k) {
      const float at = middle(thing, k);
      spread.low[k] = std::min(spread.low[k], at);
      spread.high[k] = std::max(spread.high[k], at);
    }
  return spread;
}
Spread spreadOf(std::span<const Middle> middles) {
  return spreadOfEach(middles, [](const Middle& m, int k) { return m.at[k]; });
}
Spread spreadOf(std::span<const Box> boxes, std::span<const std::int32_t> order) {
  return spreadOfEach(order, [boxes](std::int32_t i, int k) {
    return middle(boxes[static_cast<std::size_t>(i)], k);
  });
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

// More boxes, or more balls, than this are sorted along a Hilbert curve, which is faster; for
// fewer, halving gives tighter nodes. Balls of a cloud are nearly of one size and evenly spread, so
// that their nodes are as tight either way.
constexpr std::size_t kManyBoxes = 1U << 16U, kManyBalls = 1U << 8U;

// Spreads bits to every third position.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32U) & 0x001f00000000ffffU;
  x = (x | x << 16U) & 0x001f0000ff0000ffU;
  x = (x | x << 8U) & 0x100f00f00f00f00fU;
  x = (x | x << 4U) & 0x10c30c30c30c30c3U;
  return (x | x << 2U) & 0x1249249249249249U;
}

// Cells whose places along the curve are computed together, in vector registers.
constexpr std::size_t kCells = 16;
struct Cells {
  std::uint32_t at[3][kCells];
};

// Turns cells such that the interleaved bits of one are its place along a Hilbert curve, on which
// neighbours are next to each other (J. Skilling, "Programming the Hilbert curve", 2004). `bits`:
// of each coordinate.
void turnAlongCurve(Cells& cells, unsigned bits) {
  const auto maskOf = [](std::uint32_t c, unsigned bit) { return 0U - (c >> bit & 1U); };
  std::uint32_t* const first = cells.at[0];
  for (unsigned bit = bits - 1; bit > 0; --bit) {
    const std::uint32_t below = (1U << bit) - 1;
    for (std::size_t i = 0; i < kCells; ++i) first[i] ^= below & maskOf(first[i], bit);
    // Either inverts the lower bits of the first coordinate or exchanges them with the other's.
    const auto turn = [&](std::uint32_t* other) {
      for (std::size_t i = 0; i < kCells; ++i) {
        const std::uint32_t inverts = below & maskOf(other[i], bit);
        const std::uint32_t exchanged = (first[i] ^ other[i]) & below & ~inverts;
        first[i] ^= inverts | exchanged;
        other[i] ^= exchanged;
      }
    };
    turn(cells.at[1]);
    turn(cells.at[2]);
  }
  std::uint32_t* const last = cells.at[2];
  std::uint32_t turned[kCells] = {};
  for (std::size_t i = 0; i < kCells; ++i) {
    cells.at[1][i] ^= first[i];
    last[i] ^= cells.at[1][i];
  }
  for (unsigned bit = bits - 1; bit > 0; --bit)
    for (std::size_t i = 0; i < kCells; ++i) turned[i] ^= ((1U << bit) - 1) & maskOf(last[i], bit);
  for (auto& of_axis : cells.at)
    for (std::size_t i = 0; i < kCells; ++i) of_axis[i] ^= turned[i];
}

// Sorts by the bits from `low` to `high`, which are not above 64; equal ones keep their order.
// Least significant digits come first.
void sortByBits(std::vector<std::uint64_t>& keys, unsigned low, unsigned high) {
  constexpr unsigned kDigit = 11;
  std::vector<std::uint64_t> sorted(keys.size());
  for (unsigned shift = low; shift < high; shift += kDigit) {
    const std::uint64_t mask = (std::uint64_t{1} << std::min(kDigit, high - shift)) - 1;
    std::size_t next[1U << kDigit] = {};
    for (const std::uint64_t key : keys) ++next[key >> shift & mask];
    std::size_t sum = 0;
    for (std::size_t digit = 0; digit <= mask; ++digit) {
      const std::size_t count = std::exchange(next[digit], sum);
      sum += count;
    }
    for (const std::uint64_t key : keys) sorted[next[key >> shift & mask]++] = key;
    keys.swap(sorted);
  }
}

// Boxes in one cell of the curve keep their order. Points of a surface are in about sqrt(n) cells
// along each axis; the curve has sixteen times as many.
void sortAlongCurve(std::span<const Box> boxes, std::span<std::int32_t> order) {
  if (order.empty()) return;
  const auto of_number = static_cast<unsigned>(std::bit_width(boxes.size() - 1));
  const unsigned of_axis = std::min(static_cast<unsigned>(std::bit_width(order.size())) / 2 + 4,
                                    std::min((64 - of_number) / 3, 21U));
  const auto most = static_cast<float>((1U << of_axis) - 1);
  const Spread world = spreadOf(boxes, order);
  const float length = world.length(world.longest());
  const float cells = length > 0 ? most / length : 0;
  std::vector<std::uint64_t> keys(order.size());
  for (std::size_t begin = 0; begin < order.size(); begin += kCells) {
    const std::size_t count = std::min(kCells, order.size() - begin);
    Cells block{};
    for (std::size_t i = 0; i < count; ++i)
      for (int k = 0; k < 3; ++k) {
        const Box& box = boxes[static_cast<std::size_t>(order[begin + i])];
        const float at = (middle(box, k) - world.low[k]) * cells;
        // Infinity and NaN get a cell, too; they only make nodes larger.
        block.at[k][i] = static_cast<std::uint32_t>(at >= 0 ? std::min(at, most) : 0);
      }
    turnAlongCurve(block, of_axis);
    for (std::size_t i = 0; i < count; ++i) {
      std::uint64_t key = 0;
      for (const auto& along : block.at) key = key << 1U | spread(along[i]);
      keys[begin + i] = key << of_number | static_cast<std::uint64_t>(order[begin + i]);
    }
  }
  sortByBits(keys, of_number, of_number + 3 * of_axis);
  const std::uint64_t number = (std::uint64_t{1} << of_number) - 1;
  for (std::size_t i = 0; i < keys.size(); ++i)
    order[i] = static_cast<std::int32_t>(keys[i] & number);
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
    const Spread world = spreadOf(boxes, order);
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
    const auto isBall = [&](std::int32_t i) { return boxes[static_cast<std::size_t>(i)].is_ball; };
    const auto many = [](std::size_t count) { return static_cast<std::ptrdiff_t>(count); };
    auto balls = large;
    // Many balls come after the other boxes, so that nodes have balls alone.
    if (std::count_if(order.begin(), large, isBall) > many(kManyBalls)) {
      balls =
          std::stable_partition(order.begin(), large, [&](std::int32_t i) { return !isBall(i); });
      sortAlongCurve(boxes, {balls, large});
    }
    if (balls - order.begin() > many(kManyBoxes))
      sortAlongCurve(boxes, {order.begin(), balls});
    else
      sortBoxes(boxes, {order.begin(), balls});
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
