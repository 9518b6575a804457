// The farthest vertex of a hull: a scan of columns of coordinates, or of the vertices listed in a
// table of directions. Included once for each target (see Highway's foreach_target.h).

#if defined(LEEWAY_COLLISION_SCAN_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_SCAN_INL_H
#undef LEEWAY_COLLISION_SCAN_INL_H
#else
#define LEEWAY_COLLISION_SCAN_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "collision/base/lanes-inl.h"
#include "collision/base/tolerances.h"
#include "collision/base/triple.h"
#include "collision/shapes/hull_support.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Places one register of a hull's vertices, from number `from` on: sign (R v + t), with a sign of
/// 1 or -1.
HWY_INLINE void placeColumns(const HullSupport& support, int from, const Eigen::Matrix3d& R,
                             const Triple& t, double sign, double* to_x, double* to_y,
                             double* to_z) {
  const Widest d;
  const Same x = hn::Load(d, support.x() + from), y = hn::Load(d, support.y() + from),
             z = hn::Load(d, support.z() + from);
  const auto flip = hn::And(hn::Set(d, sign), hn::SignBit(d));
  const auto row = [&](int r, double shift) HWY_ATTR {
    return hn::Xor(
        hn::Add(hn::Add(hn::Add(hn::Mul(hn::Set(d, R(r, 0)), x), hn::Mul(hn::Set(d, R(r, 1)), y)),
                        hn::Mul(hn::Set(d, R(r, 2)), z)),
                hn::Set(d, shift)),
        flip);
  };
  hn::Store(row(0, t.x), d, to_x);
  hn::Store(row(1, t.y), d, to_y);
  hn::Store(row(2, t.z), d, to_z);
}

// Loops over registers are written as packs of indices, because compilers do not unroll loops of
// this length, which leaves the values in memory and needs a branch for each.

/// The maximum, lane by lane, of the registers from kBegin to kEnd.
template <std::size_t kBegin, std::size_t kEnd>
HWY_INLINE hn::Vec<Widest> largest(const hn::Vec<Widest>* values) {
  if constexpr (kEnd - kBegin == 1) {
    return values[kBegin];
  } else {
    constexpr std::size_t kMiddle = (kBegin + kEnd) / 2;
    return hn::Max(largest<kBegin, kMiddle>(values), largest<kMiddle, kEnd>(values));
  }
}

/// Index of the first of the largest of at most 64 values, and that value.
template <std::size_t... kRegister>
HWY_INLINE int firstLargest(const hn::Vec<Widest>* values, double& value,
                            std::index_sequence<kRegister...> /*registers*/) {
  const Widest d;
  constexpr std::size_t kLanes = hn::MaxLanes(Widest());
  const auto most = hn::MaxOfLanes(d, largest<0, sizeof...(kRegister)>(values));
  const auto bitsOfRegister = [&](std::size_t i) {
    std::uint8_t bits[8] = {0};
    hn::StoreMaskBits(d, hn::Eq(values[i], most), bits);
    return static_cast<std::uint64_t>(bits[0]) << (i * kLanes);
  };
  const std::uint64_t bits = (bitsOfRegister(kRegister) | ...);
  value = hn::GetLane(most);
  // (None if there is a NaN.)
  return bits != 0 ? std::countr_zero(bits) : 0;
}

/// Index of the first of the largest values x dx + y dy + z dz in a set of registers.
template <std::size_t... kRegister>
HWY_INLINE int firstFarthest(const double* x, const double* y, const double* z, double dx,
                             double dy, double dz, std::index_sequence<kRegister...> registers) {
  const Widest d;
  constexpr std::size_t kLanes = hn::MaxLanes(Widest());
  const auto dx_all = hn::Set(d, dx), dy_all = hn::Set(d, dy), dz_all = hn::Set(d, dz);
  const hn::Vec<Widest> values[] = {
      hn::Add(hn::Add(hn::Mul(hn::Load(d, x + kRegister * kLanes), dx_all),
                      hn::Mul(hn::Load(d, y + kRegister * kLanes), dy_all)),
              hn::Mul(hn::Load(d, z + kRegister * kLanes), dz_all))...};
  double value = 0;
  return firstLargest(values, value, registers);
}

/// The indices of the registers that hold 8 kEights doubles.
template <std::size_t kEights>
using Registers = std::make_index_sequence<kEights * 8 / hn::MaxLanes(Widest())>;

/// Index of the first of the largest of `length` values x dx + y dy + z dz; `length` is a multiple
/// of eight up to kMost. Columns are 64-byte aligned.
template <int kMost>
HWY_INLINE int scanColumns(const double* x, const double* y, const double* z, int length, double dx,
                           double dy, double dz) {
  static_assert(kMost == 32 || kMost == 64);
  switch (length / 8) {
    case 1:
      return firstFarthest(x, y, z, dx, dy, dz, Registers<1>());
    case 2:
      return firstFarthest(x, y, z, dx, dy, dz, Registers<2>());
    case 3:
      return firstFarthest(x, y, z, dx, dy, dz, Registers<3>());
    default:
      break;
  }
  if constexpr (kMost == 64) {
    switch (length / 8) {
      case 5:
        return firstFarthest(x, y, z, dx, dy, dz, Registers<5>());
      case 6:
        return firstFarthest(x, y, z, dx, dy, dz, Registers<6>());
      case 7:
        return firstFarthest(x, y, z, dx, dy, dz, Registers<7>());
      case 8:
        return firstFarthest(x, y, z, dx, dy, dz, Registers<8>());
      default:
        break;
    }
  }
  return firstFarthest(x, y, z, dx, dy, dz, Registers<4>());
}

HWY_INLINE Triple tripleOf(const HullCorner& corner) { return {corner.x, corner.y, corner.z}; }

/// x dx + y dy + z dz of one register of a cell's vertices, from number `from` on. (Each vertex is
/// loaded whole and transposed in registers, because on some processors a gather takes as long for
/// every coordinate.)
HWY_INLINE Same valuesOfCell(const HullCell& cell, int from, const HullCorner* corners, double dx,
                             double dy, double dz) {
  const std::uint16_t* const names = cell.vertex + from;
#if HWY_CAP_GE512
  const __m512d direction = _mm512_broadcast_f64x4(_mm256_set_pd(0, dz, dy, dx));
  const auto products = [&](int i, int j) HWY_ATTR {
    const __m512d two =
        _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd(&corners[names[i]].x)),
                           _mm256_load_pd(&corners[names[j]].x), 1);
    return _mm512_mul_pd(two, direction);
  };
  // Four vertices: x dx + y dy of two in each even 128-bit block, their z dz in the next one.
  const auto sums = [&](int i) HWY_ATTR {
    const __m512d even = products(i, i + 2), odd = products(i + 1, i + 3);
    return _mm512_add_pd(_mm512_unpacklo_pd(even, odd), _mm512_unpackhi_pd(even, odd));
  };
  const __m512d first = sums(0), second = sums(4);
  return Same{_mm512_add_pd(_mm512_shuffle_f64x2(first, second, 0x88),
                            _mm512_shuffle_f64x2(first, second, 0xdd))};
#elif HWY_CAP_GE256
  const Widest d;
  const Same direction = Same{_mm256_set_pd(0, dz, dy, dx)};
  const auto products = [&](int i) HWY_ATTR {
    return hn::Mul(hn::Load(d, &corners[names[i]].x), direction);
  };
  const auto sums = [&](int i) HWY_ATTR {
    const Same even = products(i), odd = products(i + 1);
    return hn::Add(hn::InterleaveLower(d, even, odd), hn::InterleaveUpper(d, even, odd));
  };
  const Same first = sums(0), second = sums(2);
  return hn::Add(hn::ConcatLowerLower(d, second, first), hn::ConcatUpperUpper(d, second, first));
#else
  const Widest d;
  alignas(16) double values[hn::MaxLanes(Widest())];
  for (std::size_t i = 0; i < hn::MaxLanes(Widest()); ++i) {
    const HullCorner& corner = corners[names[i]];
    values[i] = corner.x * dx + corner.y * dy + corner.z * dz;
  }
  return hn::Load(d, values);
#endif
}

/// Index within a cell of the first of its farthest vertices.
template <std::size_t... kRegister>
HWY_INLINE int firstOfCell(const HullCell& cell, const HullCorner* corners, double dx, double dy,
                           double dz, double& value, std::index_sequence<kRegister...> registers) {
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(Widest()));
  const hn::Vec<Widest> values[] = {
      valuesOfCell(cell, static_cast<int>(kRegister) * kLanes, corners, dx, dy, dz)...};
  return firstLargest(values, value, registers);
}

/// The cell that holds a direction; null if there is no table, or if quotients would leave the
/// range of double.
HWY_INLINE const HullCell* cellOf(const HullSupport& support, double dx, double dy, double dz) {
  // Selected in lanes, without branches, because which coordinate is largest is unpredictable.
  // (Also without memory, which the two hulls' directions would share.)
  const double ax = std::abs(dx), ay = std::abs(dy), az = std::abs(dz);
  const Lanes<2> x_x = allLanes<2>(ax), y_y = allLanes<2>(ay), z_z = allLanes<2>(az);
  const Mask<2> y_most = y_y > x_x;
  const Lanes<2> xy_most = choose(y_most, y_y, x_x);
  const Mask<2> z_most = z_z > xy_most;
  const Lanes<2> size = choose(z_most, z_z, xy_most);
  const double largest_size = firstOf(size), sides = support.sides();
  if (HWY_UNLIKELY(!(largest_size > kSmallestDirection && sides > 0))) return nullptr;
  const Lanes<2> along =
      choose(z_most, allLanes<2>(dz), choose(y_most, allLanes<2>(dy), allLanes<2>(dx)));
  // The coordinates after and before it, cyclically.
  const Lanes<2> across =
      choose(z_most, twoOf(dx, dy), choose(y_most, twoOf(dz, dx), twoOf(dy, dz)));
  const Lanes<2> zero = allLanes<2>(0.0), half = allLanes<2>(0.5 * sides),
                 last = allLanes<2>(sides - 1);
  const Lanes<2> place = across * (half / size) + half;
  // In this order NaN becomes 0.
  const Lanes<2> above = choose(place > zero, place, zero),
                 within = choose(above > last, last, above);
  const auto u = static_cast<std::int32_t>(firstOf(within)),
             v = static_cast<std::int32_t>(secondOf(within));
  int axis = static_cast<int>(ay > ax);
  axis += static_cast<int>(az > std::max(ax, ay)) * (2 - axis);
  const int face = 2 * axis + static_cast<int>(firstOf(along) < 0);
  return support.cells() + (face * support.sides() + u) * support.sides() + v;
}

/// Index of the farthest vertex of a hull with a table, given the direction's cell; -1 if only a
/// climb finds it, for which `hint` is then a good start.
HWY_INLINE int scanCell(const HullSupport& support, const HullCell* cell, double dx, double dy,
                        double dz, int& hint) {
  if (HWY_UNLIKELY(cell == nullptr)) return -1;
  double value = 0;
  if (HWY_LIKELY(cell->vertex[0] != HullCell::kMany)) {
    return cell->vertex[firstOfCell(*cell, support.corners(), dx, dy, dz, value, Registers<1>())];
  }
  hint = HullSupport::start(*cell);
  int count = 0, best = -1;
  const HullCell* part = support.many(*cell, count);
  double best_value = 0;
  for (int i = 0; i < count; i += 8, ++part) {
    const int found = firstOfCell(*part, support.corners(), dx, dy, dz, value, Registers<1>());
    if (best >= 0 && !(value > best_value)) continue;
    best = part->vertex[found];
    best_value = value;
  }
  return best;
}
HWY_INLINE int scanTable(const HullSupport& support, double dx, double dy, double dz, int& hint) {
  return scanCell(support, cellOf(support, dx, dy, dz), dx, dy, dz, hint);
}

/// Index of the farthest vertex of any hull, or -1 and a hint, as in scanCell().
HWY_INLINE int scanSupport(const HullSupport& support, double dx, double dy, double dz, int& hint) {
  if (support.length() == 0) return scanTable(support, dx, dy, dz, hint);
  return scanColumns<kScanUpTo>(support.x(), support.y(), support.z(), support.length(), dx, dy,
                                dz);
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
