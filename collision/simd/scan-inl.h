// The farthest vertex of a hull: of many points whose coordinates stand side by side, or of those
// that a table names. Included once a target (see Highway's foreach_target.h).

#if defined(LEEWAY_COLLISION_SCAN_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_SCAN_INL_H
#undef LEEWAY_COLLISION_SCAN_INL_H
#else
#define LEEWAY_COLLISION_SCAN_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "collision/hull_support.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using EightDoubles = hn::CappedTag<double, 8>;

/// Index of the first of the largest among kRegisters registers full of values.
template <std::size_t kRegisters>
HWY_INLINE int firstLargest(const hn::Vec<EightDoubles>* values, double& value) {
  const EightDoubles d;
  constexpr std::size_t kLanes = hn::MaxLanes(EightDoubles());
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

/// The same of x dx + y dy + z dz.
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
  return firstLargest<kRegisters>(values, value);
}

/// Place in a cell of the first of its farthest vertices.
HWY_INLINE int firstOfCell(const HullCell& cell, const Vector* points, double dx, double dy,
                           double dz, double& value) {
  const EightDoubles d;
  constexpr std::size_t kLanes = hn::MaxLanes(EightDoubles());
  constexpr std::size_t kParts = 8 / kLanes;
  const hn::Rebind<std::uint16_t, EightDoubles> narrow;
  const hn::Rebind<std::uint32_t, EightDoubles> wider;
  const hn::Rebind<std::int64_t, EightDoubles> index;
  const auto dx_all = hn::Set(d, dx), dy_all = hn::Set(d, dy), dz_all = hn::Set(d, dz);
  const double* base = points->data();
  hn::Vec<EightDoubles> values[kParts];
  for (std::size_t i = 0; i < kParts; ++i) {
    const auto names = hn::BitCast(
        index, hn::PromoteTo(hn::Rebind<std::uint64_t, EightDoubles>(),
                             hn::PromoteTo(wider, hn::Load(narrow, cell.vertex + i * kLanes))));
    const auto at = hn::Add(names, hn::Add(names, names));
    values[i] = hn::Add(hn::Add(hn::Mul(hn::GatherIndex(d, base, at), dx_all),
                                hn::Mul(hn::GatherIndex(d, base + 1, at), dy_all)),
                        hn::Mul(hn::GatherIndex(d, base + 2, at), dz_all));
  }
  return firstLargest<kParts>(values, value);
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

/// The cell that holds a direction; null where there is no table, or the length is beyond what can
/// be divided by.
HWY_INLINE const HullCell* cellOf(const HullSupport& support, double dx, double dy, double dz) {
  const double sides = support.sides();
  // Choices among places in memory, which need no branches: those among directions are not
  // foreseen.
  const double direction[3] = {dx, dy, dz};
  const double ax = std::abs(dx), ay = std::abs(dy), az = std::abs(dz);
  int axis = static_cast<int>(ay > ax);
  axis += static_cast<int>(az > std::max(ax, ay)) * (2 - axis);
  const double along = direction[axis], size = std::abs(along);
  if (HWY_UNLIKELY(!(size > 1e-290 && size < 1e290 && sides > 0))) return nullptr;
  const double half = 0.5 * sides, scale = half / size;
  const auto place = [=](double across) {
    // In this order a NaN is 0.
    return static_cast<std::int32_t>(std::min(std::max(0.0, across * scale + half), sides - 1));
  };
  static constexpr int kNext[3] = {1, 2, 0}, kPrevious[3] = {2, 0, 1};
  const int face = 2 * axis + static_cast<int>(along < 0);
  const std::int32_t u = place(direction[kNext[axis]]), v = place(direction[kPrevious[axis]]);
  return support.cells() + (face * support.sides() + u) * support.sides() + v;
}

/// Index of the farthest vertex of a hull; -1 where only a climb finds it, which starts well from
/// `hint`.
HWY_INLINE int scanSupport(const HullSupport& support, double dx, double dy, double dz, int& hint) {
  if (support.length() > 0) {
    return scanColumns(support.x(), support.y(), support.z(), support.length(), dx, dy, dz);
  }
  const HullCell* cell = cellOf(support, dx, dy, dz);
  if (HWY_UNLIKELY(cell == nullptr)) return -1;
  double value = 0;
  if (HWY_LIKELY(cell->vertex[0] != HullCell::kMany)) {
    return cell->vertex[firstOfCell(*cell, support.points(), dx, dy, dz, value)];
  }
  hint = HullSupport::start(*cell);
  int count = 0, best = -1;
  const HullCell* part = support.many(*cell, count);
  double best_value = 0;
  for (int i = 0; i < count; i += 8, ++part) {
    const int found = firstOfCell(*part, support.points(), dx, dy, dz, value);
    if (best >= 0 && !(value > best_value)) continue;
    best = part->vertex[found];
    best_value = value;
  }
  return best;
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
