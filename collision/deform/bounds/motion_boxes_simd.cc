#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "collision/base/rounding.h"
#include "collision/deform/bounds/motion_boxes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/deform/bounds/motion_boxes_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

// Products and sums are separate (no fused multiply-add), so that all instruction sets agree. Plain
// loops over lanes are left to the compiler's vectoriser.

HWY_BEFORE_NAMESPACE();
namespace leeway::collision {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

const hn::CappedTag<double, kWidth> kDoubles;
const hn::Rebind<float, decltype(kDoubles)> kSingles;
const hn::CappedTag<float, kWidth> kLanes;

void blend(const AxisRow* rows, const std::uint8_t* axes, const double* to, const double* from,
           std::size_t count, BoxSum& sum) {
  unsigned any = 0;
  for (std::size_t f = 0; f < count; ++f) any |= axes[f];
  for (std::size_t k = 0; k < 3; ++k) {
    if ((any >> k & 1) == 0) continue;  // waves, for example, move along one axis
    for (std::size_t i = 0; i < kWidth; i += hn::Lanes(kDoubles)) {
      double *const at_low = sum.low + k * kWidth + i, *const at_high = sum.high + k * kWidth + i;
      auto low = hn::LoadU(kDoubles, at_low), high = hn::LoadU(kDoubles, at_high);
      const AxisRow* row = rows;
      for (std::size_t f = 0; f < count; ++f) {
        const unsigned there = axes[f];
        if ((there >> k & 1) != 0) {
          const double p = from != nullptr ? to[f] - from[f] : to[f];
          const AxisRow& own = row[std::popcount(there & ((1U << k) - 1))];
          const auto factor = hn::Set(kDoubles, p);
          const auto l = hn::PromoteTo(kDoubles,
                                       hn::Load(kSingles, (p >= 0 ? own.low : own.high) + i)),
                     h = hn::PromoteTo(kDoubles,
                                       hn::Load(kSingles, (p >= 0 ? own.high : own.low) + i));
          low = hn::Add(low, hn::Mul(factor, l));
          high = hn::Add(high, hn::Mul(factor, h));
        }
        row += std::popcount(there);
      }
      hn::StoreU(low, kDoubles, at_low);
      hn::StoreU(high, kDoubles, at_high);
    }
  }
}

// A sum is off by half a unit in the last place, and 2^-23 of it is at least one unit. Subnormal
// sums are exact.
void move(const WideBox& before, float least, float most, WideBox& way, WideBox& box, float* side) {
  for (std::size_t i = 0; i < kWidth; i += hn::Lanes(kLanes)) {
    const auto lowest = hn::Set(kLanes, least), highest = hn::Set(kLanes, most),
               unit = hn::Set(kLanes, 0x1p-23F);
    auto longest = hn::Zero(kLanes);
    for (int k = 0; k < 3; ++k) {
      auto low = hn::Load(kLanes, way.low[k] + i), high = hn::Load(kLanes, way.high[k] + i);
      // These comparisons replace a NaN.
      low = hn::IfThenElse(hn::Gt(low, lowest), low, lowest);
      high = hn::IfThenElse(hn::Lt(high, highest), high, highest);
      hn::Store(low, kLanes, way.low[k] + i);
      hn::Store(high, kLanes, way.high[k] + i);
      longest = hn::Max(longest, hn::Sub(high, low));
      low = hn::Add(hn::Load(kLanes, before.low[k] + i), low);
      high = hn::Add(hn::Load(kLanes, before.high[k] + i), high);
      hn::Store(hn::Sub(low, hn::Mul(hn::Abs(low), unit)), kLanes, box.low[k] + i);
      hn::Store(hn::Add(high, hn::Mul(hn::Abs(high), unit)), kLanes, box.high[k] + i);
    }
    hn::StoreU(longest, kLanes, side + i);
  }
}

// roundedDown() and roundedUpToFloat() in vectors, because plain code takes eight times as long.
void put(const BoxSum& sum, WideBox& box) {
  const auto most = hn::Set(kSingles, std::numeric_limits<float>::max()),
             least = hn::Set(kSingles, std::numeric_limits<float>::min()),
             unit = hn::Set(kSingles, 0x1p-22F);
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < kWidth; i += hn::Lanes(kDoubles)) {
      auto low = hn::DemoteTo(kSingles, hn::LoadU(kDoubles, sum.low + k * kWidth + i)),
           high = hn::DemoteTo(kSingles, hn::LoadU(kDoubles, sum.high + k * kWidth + i));
      // A NaN stays NaN here.
      low = hn::IfThenElse(hn::Gt(low, most), most, low);
      high = hn::IfThenElse(hn::Lt(high, hn::Neg(most)), hn::Neg(most), high);
      low = hn::Sub(low, hn::Add(hn::Mul(hn::Abs(low), unit), least));
      high = hn::Add(high, hn::Add(hn::Mul(hn::Abs(high), unit), least));
      hn::StoreU(low, kSingles, box.low[k] + i);
      hn::StoreU(high, kSingles, box.high[k] + i);
    }
  }
}

// One row of an affine map: linear part and translation.
struct Row {
  double x, y, z, t;
};

// A row of the bone's matrix `to`, or of to - from.
HWY_INLINE Row rowOf(const SkinPart& part, const double* to, const double* from, int row) {
  const double* T = to + 12 * static_cast<std::ptrdiff_t>(part.bone);
  Row r{T[3 * row], T[3 * row + 1], T[3 * row + 2], T[9 + row]};
  if (from == nullptr) return r;
  const double* S = from + 12 * static_cast<std::ptrdiff_t>(part.bone);
  return {r.x - S[3 * row], r.y - S[3 * row + 1], r.z - S[3 * row + 2], r.t - S[9 + row]};
}

// Numbers in brackets and symbols refer to the derivation in skinned_bounds.cc.
void skin(const SkinRest& rest, std::span<const SkinPart> parts, const double* to,
          const double* from, double rounding, WideBox& box) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  BoxSum sum;
  for (int row = 0; row < 3; ++row) {
    double center[kWidth], x[kWidth], y[kWidth], z[kWidth];  // M c and R_M, (1)
    double low[kWidth], high[kWidth];                        // around the bones' images, (2)
    for (int i = 0; i < kWidth; ++i) {
      center[i] = x[i] = y[i] = z[i] = 0;
      low[i] = kInfinity;
      high[i] = -kInfinity;
    }
    for (const SkinPart& part : parts) {
      const Row r = rowOf(part, to, from, row);
      for (int i = 0; i < kWidth; ++i) {
        const double image =
            r.x * rest.center[0][i] + r.y * rest.center[1][i] + r.z * rest.center[2][i] + r.t;
        const double reach = std::abs(r.x) * rest.half[0][i] + std::abs(r.y) * rest.half[1][i] +
                             std::abs(r.z) * rest.half[2][i];
        const double mean = part.mean[i];
        center[i] += mean * image;
        x[i] += mean * r.x;
        y[i] += mean * r.y;
        z[i] += mean * r.z;
        // A bone that carries no vertex of the column is ignored.
        const bool has_part = static_cast<int>(part.range[i] > 0) | static_cast<int>(mean > 0);
        const double lower = has_part ? image - reach : kInfinity,
                     upper = has_part ? image + reach : -kInfinity;
        low[i] = std::min(low[i], lower);
        high[i] = std::max(high[i], upper);
      }
    }
    double spread[kWidth], bent_x[kWidth], bent_y[kWidth], bent_z[kWidth];  // (1)
    for (int i = 0; i < kWidth; ++i) {
      spread[i] = 0;
      bent_x[i] = x[i];
      bent_y[i] = y[i];
      bent_z[i] = z[i];
    }
    for (const SkinPart& part : parts) {
      const Row r = rowOf(part, to, from, row);
      for (int i = 0; i < kWidth; ++i) {
        const double image =
            r.x * rest.center[0][i] + r.y * rest.center[1][i] + r.z * rest.center[2][i] + r.t;
        const double away = image - center[i];
        bent_x[i] += away * part.gradient[0][i];
        bent_y[i] += away * part.gradient[1][i];
        bent_z[i] += away * part.gradient[2][i];
        const double turned = std::abs(r.x - x[i]) * rest.half[0][i] +
                              std::abs(r.y - y[i]) * rest.half[1][i] +
                              std::abs(r.z - z[i]) * rest.half[2][i];
        spread[i] += part.residue[i] * std::abs(away) + part.range[i] * turned;
      }
    }
    for (int i = 0; i < kWidth; ++i) {
      const double across = spread[i] + (std::abs(bent_x[i]) * rest.half[0][i] +
                                         std::abs(bent_y[i]) * rest.half[1][i] +
                                         std::abs(bent_z[i]) * rest.half[2][i]);
      sum.low[row * kWidth + i] = std::max(low[i], center[i] - across) - rounding;
      sum.high[row * kWidth + i] = std::min(high[i], center[i] + across) + rounding;
    }
  }
  put(sum, box);
}

}  // namespace

const MotionKernels* motionKernelsOfTarget() {
  static constexpr MotionKernels kKernels = {blend, put, move, skin};
  return &kKernels;
}

}  // namespace HWY_NAMESPACE
}  // namespace leeway::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(motionKernelsOfTarget);

const MotionKernels& motionKernels() { return *HWY_DYNAMIC_DISPATCH(motionKernelsOfTarget)(); }

}  // namespace leeway::collision
#endif
