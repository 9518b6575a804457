#pragma once

// Private to collision/: all pairs of boxes that are near each other, without a hierarchy.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "collision/base/tolerances.h"
#include "collision/deform/tree/deform_tree.h"

namespace leeway::collision {

/// Distance of two boxes in one frame, rounded downwards: three differences of outward-rounded
/// numbers, three squares and a root are each off by 2^-24 of themselves. 0 if the boxes overlap,
/// or are so close that squares lose digits. A square that overflows counts as the largest float.
inline float boxDistance(const FloatBox& a, const FloatBox& b) {
  float squared = 0;
  for (int k = 0; k < 3; ++k) {
    const float gap = std::max(std::max(b.low[k] - a.high[k], a.low[k] - b.high[k]), 0.0F);
    squared += gap * gap;
  }
  if (!(squared > kLeastWaySquared)) return 0;
  return std::sqrt(std::min(squared, std::numeric_limits<float>::max())) * kBoxDistanceInwards;
}

/// Finds all pairs of boxes, one from each of two sets, that are within `reach` of each other.
/// Boxes in the overlap of the two sets' boxes are sorted into the cells of an implicit octree; a
/// cell with boxes of only one set is finished (A. Smith et al., "A simple and efficient method for
/// accurate collision detection among deformable polyhedral objects in arbitrary motion", 1995).
/// Boxes of the first set are grown by `reach`, which turns distance into overlap. A box may be in
/// several cells; a pair belongs to the cell that has the lowest corner of the two boxes' overlap.
class OctreePairs {
 public:
  /// `room` stores the lists of the cells from the root to the current one, and needs at least
  /// a.size() + b.size() entries. A cell for which it is too small is not split.
  OctreePairs(std::span<const FloatBox> a, std::span<const FloatBox> b, float reach,
              std::span<std::int32_t> room)
      : a_(a), b_(b), reach_(reach), room_(room) {}

  /// Calls visit(i, j, distance of the boxes) once for every such pair, until it returns false.
  /// Returns whether all pairs were visited.
  template <class Visit>
  bool run(const Visit& visit) {
    FloatBox all_a = around(a_), all_b = around(b_);
    for (int k = 0; k < 3; ++k) {
      region_.low[k] = std::max(all_a.low[k] - reach_, all_b.low[k]);
      region_.high[k] = std::min(all_a.high[k] + reach_, all_b.high[k]);
      if (!(region_.low[k] <= region_.high[k])) return true;
    }
    Lists lists{0, 0, 0};
    for (std::size_t i = 0; i < a_.size(); ++i) {
      if (inA(a_[i], region_)) room_[lists.count_a++] = static_cast<std::int32_t>(i);
    }
    for (std::size_t j = 0; j < b_.size(); ++j) {
      if (inB(b_[j], region_))
        room_[lists.count_a + lists.count_b++] = static_cast<std::int32_t>(j);
    }
    return cell(region_, lists, 0, visit);
  }

  /// Cells visited by run() [count].
  std::size_t cells() const { return cells_; }
  /// Pairs of boxes compared by run() [count].
  std::size_t compared() const { return compared_; }

 private:
  // At room_[begin]: indices of the first set, then those of the second.
  struct Lists {
    std::size_t begin, count_a, count_b;
  };

  static constexpr int kMaxDepth = 16;
  // The octants below the middle along x, y, z, one bit each.
  static constexpr unsigned kLower[] = {0x55, 0x33, 0x0f};
  // Up to this many pairs are compared without splitting.
  static constexpr std::size_t kFew = 32;

  static FloatBox around(std::span<const FloatBox> boxes) {
    FloatBox all = boxes[0];
    for (const FloatBox& box : boxes) {
      for (int k = 0; k < 3; ++k) {
        all.low[k] = std::min(all.low[k], box.low[k]);
        all.high[k] = std::max(all.high[k], box.high[k]);
      }
    }
    return all;
  }

  bool inA(const FloatBox& box, const FloatBox& cell) const {
    for (int k = 0; k < 3; ++k) {
      if (!(box.low[k] - reach_ <= cell.high[k] && cell.low[k] <= box.high[k] + reach_))
        return false;
    }
    return true;
  }
  static bool inB(const FloatBox& box, const FloatBox& cell) {
    for (int k = 0; k < 3; ++k) {
      if (!(box.low[k] <= cell.high[k] && cell.low[k] <= box.high[k])) return false;
    }
    return true;
  }

  template <class Visit>
  bool cell(const FloatBox& cell_box, const Lists& lists, int depth, const Visit& visit) {
    ++cells_;
    if (lists.count_a == 0 || lists.count_b == 0) return true;
    const std::size_t next = lists.begin + lists.count_a + lists.count_b;
    const std::size_t longest = std::max(lists.count_a, lists.count_b);
    if (longest <= 2 || lists.count_a * lists.count_b <= kFew || depth == kMaxDepth ||
        next + lists.count_a + lists.count_b > room_.size()) {
      return pairs(cell_box, lists, visit);
    }
    float middle[3];
    unsigned parts = 0xff;  // a bit for each octant
    for (int k = 0; k < 3; ++k) {
      middle[k] = 0.5F * cell_box.low[k] + 0.5F * cell_box.high[k];
      if (isHalved(cell_box, lists, k, middle[k])) continue;
      middle[k] = cell_box.high[k];
      parts &= kLower[k];
    }
    // Boxes longer than a cell are in several of its parts, so splitting gains nothing if most
    // pairs remain.
    std::array<std::size_t, 8> count_a{}, count_b{};
    for (std::size_t i = lists.begin; i < lists.begin + lists.count_a; ++i)
      countIn(parts & octantsOf(boxA(i), reach_, middle), count_a);
    for (std::size_t i = lists.begin + lists.count_a; i < next; ++i)
      countIn(parts & octantsOf(boxB(i), 0, middle), count_b);
    std::size_t left = 0;
    for (std::size_t octant = 0; octant < 8; ++octant) left += count_a[octant] * count_b[octant];
    if (4 * left > 3 * lists.count_a * lists.count_b) return pairs(cell_box, lists, visit);
    for (std::size_t octant = 0; octant < 8; ++octant) {
      if (count_a[octant] == 0 || count_b[octant] == 0) continue;
      FloatBox part;
      for (int k = 0; k < 3; ++k) {
        const bool upper = ((octant >> k) & 1) != 0;
        part.low[k] = upper ? middle[k] : cell_box.low[k];
        part.high[k] = upper ? cell_box.high[k] : middle[k];
      }
      Lists below{next, 0, 0};
      for (std::size_t i = 0; i < lists.count_a; ++i) {
        const std::int32_t id = room_[lists.begin + i];
        if (inA(a_[static_cast<std::size_t>(id)], part)) room_[next + below.count_a++] = id;
      }
      for (std::size_t i = 0; i < lists.count_b; ++i) {
        const std::int32_t id = room_[lists.begin + lists.count_a + i];
        if (inB(b_[static_cast<std::size_t>(id)], part))
          room_[next + below.count_a + below.count_b++] = id;
      }
      if (!cell(part, below, depth + 1, visit)) return false;
    }
    return true;
  }

  const FloatBox& boxA(std::size_t i) const { return a_[static_cast<std::size_t>(room_[i])]; }
  const FloatBox& boxB(std::size_t i) const { return b_[static_cast<std::size_t>(room_[i])]; }

  // Whether splitting along axis k leaves fewer pairs. Across flat boxes that share a plane, or
  // along parallel ropes, it leaves twice as many. A cell without thickness is not split, because
  // both halves would own all its pairs.
  bool isHalved(const FloatBox& cell_box, const Lists& lists, int k, float middle) const {
    if (!(cell_box.low[k] < middle && middle < cell_box.high[k])) return false;
    std::size_t lower_a = 0, upper_a = 0, lower_b = 0, upper_b = 0;
    const std::size_t begin_b = lists.begin + lists.count_a;
    for (std::size_t i = lists.begin; i < begin_b; ++i) {
      lower_a += static_cast<std::size_t>(boxA(i).low[k] - reach_ <= middle);
      upper_a += static_cast<std::size_t>(middle <= boxA(i).high[k] + reach_);
    }
    for (std::size_t i = begin_b; i < begin_b + lists.count_b; ++i) {
      lower_b += static_cast<std::size_t>(boxB(i).low[k] <= middle);
      upper_b += static_cast<std::size_t>(middle <= boxB(i).high[k]);
    }
    return lower_a * lower_b + upper_a * upper_b < lists.count_a * lists.count_b;
  }

  // The octants around `middle` that a box of the cell overlaps, one bit each.
  static unsigned octantsOf(const FloatBox& box, float grown, const float* middle) {
    unsigned octants = 0xff;
    for (int k = 0; k < 3; ++k) {
      octants &= (box.low[k] - grown <= middle[k] ? kLower[k] : 0U) |
                 (middle[k] <= box.high[k] + grown ? 0xffU & ~kLower[k] : 0U);
    }
    return octants;
  }
  static void countIn(unsigned octants, std::array<std::size_t, 8>& counts) {
    for (; octants != 0; octants &= octants - 1)
      ++counts[static_cast<std::size_t>(std::countr_zero(octants))];
  }

  template <class Visit>
  bool pairs(const FloatBox& cell_box, const Lists& lists, const Visit& visit) {
    compared_ += lists.count_a * lists.count_b;
    for (std::size_t i = 0; i < lists.count_a; ++i) {
      const std::int32_t id_a = room_[lists.begin + i];
      const FloatBox& a = a_[static_cast<std::size_t>(id_a)];
      for (std::size_t j = 0; j < lists.count_b; ++j) {
        const std::int32_t id_b = room_[lists.begin + lists.count_a + j];
        const FloatBox& b = b_[static_cast<std::size_t>(id_b)];
        if (!inA(a, b) || !owns(cell_box, a, b)) continue;
        if (!visit(id_a, id_b, boxDistance(a, b))) return false;
      }
    }
    return true;
  }

  // Whether the lowest corner of the overlap of two boxes is in the cell.
  bool owns(const FloatBox& cell_box, const FloatBox& a, const FloatBox& b) const {
    for (int k = 0; k < 3; ++k) {
      const float x = std::max(a.low[k] - reach_, b.low[k]);
      // Cells are half open, except at the upper end of the region.
      if (!(cell_box.low[k] <= x && (x < cell_box.high[k] || cell_box.high[k] == region_.high[k])))
        return false;
    }
    return true;
  }

  std::span<const FloatBox> a_, b_;
  float reach_;
  std::span<std::int32_t> room_;
  FloatBox region_{};
  std::size_t cells_ = 0, compared_ = 0;
};

}  // namespace leeway::collision
