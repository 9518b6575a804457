// ObstacleBoxes::forEachNear(), one box in each lane.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "collision/lanes/obstacle_boxes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/lanes/near_boxes_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "collision/base/dispatch.h"
#include "collision/lanes/lane_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

class NearBoxes {
 public:
  using Visit = bool (*)(const void* of, std::size_t slot);

  NearBoxes(const ObstacleBoxes::Level* levels, std::size_t first_slot,
            const ObstacleBoxes::Box& box, Visit visit, const void* of)
      : levels_(levels), first_slot_(first_slot), box_(box), visit_(visit), of_(of) {}

  /// False if a visit returns false.
  HWY_ATTR bool search(std::size_t level, std::size_t begin, std::size_t end) const {
    const ObstacleBoxes::Level& boxes = levels_[level];
    end = std::min(end, boxes.size());  // NaN also meets nodes that are padding
    for (std::size_t i = begin; i < end; i += hn::Lanes(D())) {
      for (std::uint32_t near = nearBoxes(box_.low, box_.high, boxes, i); near != 0;
           near &= near - 1) {
        const std::size_t box = i + static_cast<std::size_t>(std::countr_zero(near));
        if (level == 0 ? !visit_(of_, first_slot_ + box)
                       : !search(level - 1, ObstacleBoxes::kWidth * box,
                                 ObstacleBoxes::kWidth * (box + 1)))
          return false;
      }
    }
    return true;
  }

 private:
  const ObstacleBoxes::Level* levels_;
  std::size_t first_slot_;
  const ObstacleBoxes::Box& box_;
  Visit visit_;
  const void* of_;
};

HWY_ATTR bool searchBoxes(std::span<const ObstacleBoxes::Level> levels, std::size_t first_slot,
                          const ObstacleBoxes::Box& box, NearBoxes::Visit visit, const void* of) {
  return NearBoxes(levels.data(), first_slot, box, visit, of)
      .search(levels.size() - 1, 0, levels.back().size());
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(searchBoxes);

bool ObstacleBoxes::visitNear(const Box& box, bool (*visit)(const void* of, std::size_t slot),
                              const void* of) const {
  if (first_ != nullptr && !first_->visitNear(box, visit, of)) return false;
  return levels_.empty() || LEEWAY_DISPATCH(searchBoxes)(levels_, slots_of_first_, box, visit, of);
}

}  // namespace leeway::collision
#endif
