// The farthest vertex of a hull: of many points whose coordinates stand side by side, or by a
// climb. Included once a target (see Highway's foreach_target.h).

#if defined(LEEWAY_COLLISION_SCAN_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_SCAN_INL_H
#undef LEEWAY_COLLISION_SCAN_INL_H
#else
#define LEEWAY_COLLISION_SCAN_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using EightDoubles = hn::CappedTag<double, 8>;

/// Index of the first of the largest among kRegisters registers full of x dx + y dy + z dz.
template <std::size_t kRegisters>
HWY_INLINE int firstFarthest(const double* x, const double* y, const double* z, double dx,
                             double dy, double dz, double& value) {
  const EightDoubles d;
  constexpr std::size_t kLanes = hn::MaxLanes(EightDoubles());
  const auto dx_all = hn::Set(d, dx), dy_all = hn::Set(d, dy), dz_all = hn::Set(d, dz);
  hn::Vec<EightDoubles> values[kRegisters];
  for (std::size_t i = 0; i < kRegisters; ++i) {
    values[i] = hn::Add(hn::Add(hn::Mul(hn::Load(d, x + i * kLanes), dx_all),
                                hn::Mul(hn::Load(d, y + i * kLanes), dy_all)),
                        hn::Mul(hn::Load(d, z + i * kLanes), dz_all));
  }
  hn::Vec<EightDoubles> best[kRegisters];
  for (std::size_t i = 0; i < kRegisters; ++i) best[i] = values[i];
  for (std::size_t step = 1; step < kRegisters; step *= 2) {
    for (std::size_t i = 0; i + step < kRegisters; i += 2 * step) {
      best[i] = hn::Max(best[i], best[i + step]);
    }
  }
  const auto most = hn::MaxOfLanes(d, best[0]);
  int first = 0;
  for (std::size_t i = kRegisters; i-- > 0;) {
    const auto here = static_cast<int>(hn::FindFirstTrue(d, hn::Eq(values[i], most)));
    first = here >= 0 ? static_cast<int>(i * kLanes) + here : first;
  }
  value = hn::GetLane(most);
  return first;
}

/// Index of the first of the largest of `length` values x dx + y dy + z dz, a multiple of eight;
/// columns are 64-byte aligned.
HWY_INLINE int scanColumns(const double* x, const double* y, const double* z, int length, double dx,
                           double dy, double dz) {
  constexpr std::size_t kEight = 8 / hn::MaxLanes(EightDoubles());
  double value = 0;
  if (length == 8) return firstFarthest<kEight>(x, y, z, dx, dy, dz, value);
  if (length == 32) return firstFarthest<4 * kEight>(x, y, z, dx, dy, dz, value);
  int best = 0;
  double best_value = 0;
  int begin = 0;
  for (const int block : {32, 8}) {
    for (; begin + block <= length; begin += block) {
      const int found =
          block == 32
              ? firstFarthest<4 * kEight>(x + begin, y + begin, z + begin, dx, dy, dz, value)
              : firstFarthest<kEight>(x + begin, y + begin, z + begin, dx, dy, dz, value);
      if (begin > 0 && !(value > best_value)) continue;
      best = begin + found;
      best_value = value;
    }
  }
  return best;
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
