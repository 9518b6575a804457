#include "collision/mesh/box_ranges.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/mesh/box_ranges_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "collision/base/dispatch.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

HWY_ATTR void ranges(const std::array<std::span<const double>, 3>& points,
                     std::span<const Eigen::Matrix3d> frames, BoxRange* out) {
  const hn::CappedTag<double, kRangeBlock> d;
  using V = hn::Vec<decltype(d)>;
  const double *x = points[0].data(), *y = points[1].data(), *z = points[2].data();
  const std::size_t count = points[0].size();
  for (std::size_t f = 0; f < frames.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const V ax = hn::Set(d, frames[f](0, k)), ay = hn::Set(d, frames[f](1, k)),
              az = hn::Set(d, frames[f](2, k));
      const auto along = [&](std::size_t i) HWY_ATTR {
        return hn::Add(hn::Add(hn::Mul(ax, hn::LoadU(d, x + i)), hn::Mul(ay, hn::LoadU(d, y + i))),
                       hn::Mul(az, hn::LoadU(d, z + i)));
      };
      V low = along(0), high = low;
      for (std::size_t i = hn::Lanes(d); i < count; i += hn::Lanes(d)) {
        const V v = along(i);
        low = hn::Min(low, v);
        high = hn::Max(high, v);
      }
      // (+ 0, because the minimum of 0 and -0 may be either.)
      out[f].low[k] = hn::GetLane(hn::MinOfLanes(d, low)) + 0.0;
      out[f].high[k] = hn::GetLane(hn::MaxOfLanes(d, high)) + 0.0;
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace leeway::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(ranges);

void boxRanges(const std::array<std::span<const double>, 3>& points,
               std::span<const Eigen::Matrix3d> frames, BoxRange* ranges) {
  LEEWAY_DISPATCH(ranges)(points, frames, ranges);
}

}  // namespace leeway::collision
#endif
