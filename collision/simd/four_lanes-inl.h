// Four doubles side by side, the same operation on each: one, two or four registers, as the target
// has them. Every operation is rounded like that of single doubles (there is no fused one), so that
// results are the same on every target. Included once a target (see Highway's foreach_target.h).

#if defined(LEEWAY_COLLISION_FOUR_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_FOUR_LANES_INL_H
#undef LEEWAY_COLLISION_FOUR_LANES_INL_H
#else
#define LEEWAY_COLLISION_FOUR_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "collision/vector.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 4>;
constexpr int kRegisters = 4 / static_cast<int>(hn::MaxLanes(Doubles()));

struct Lanes {
  hn::Vec<Doubles> v[kRegisters];
};
struct Mask {
  hn::Mask<Doubles> v[kRegisters];
};

template <class Operation>
HWY_INLINE Lanes eachLane(Operation operation) {
  Lanes result;
  for (int i = 0; i < kRegisters; ++i) result.v[i] = operation(i);
  return result;
}

HWY_INLINE Lanes allLanes(double x) {
  return eachLane([x](int) { return hn::Set(Doubles(), x); });
}
HWY_INLINE Lanes operator+(const Lanes& a, const Lanes& b) {
  return eachLane([&](int i) { return hn::Add(a.v[i], b.v[i]); });
}
HWY_INLINE Lanes operator-(const Lanes& a, const Lanes& b) {
  return eachLane([&](int i) { return hn::Sub(a.v[i], b.v[i]); });
}
HWY_INLINE Lanes operator*(const Lanes& a, const Lanes& b) {
  return eachLane([&](int i) { return hn::Mul(a.v[i], b.v[i]); });
}
HWY_INLINE Lanes operator/(const Lanes& a, const Lanes& b) {
  return eachLane([&](int i) { return hn::Div(a.v[i], b.v[i]); });
}
HWY_INLINE Mask operator>(const Lanes& a, const Lanes& b) {
  Mask result;
  for (int i = 0; i < kRegisters; ++i) result.v[i] = hn::Gt(a.v[i], b.v[i]);
  return result;
}
HWY_INLINE Mask operator&(const Mask& a, const Mask& b) {
  Mask result;
  for (int i = 0; i < kRegisters; ++i) result.v[i] = hn::And(a.v[i], b.v[i]);
  return result;
}

/// Lane by lane x where the mask is set, else y.
HWY_INLINE Lanes choose(const Mask& mask, const Lanes& x, const Lanes& y) {
  return eachLane([&](int i) { return hn::IfThenElse(mask.v[i], x.v[i], y.v[i]); });
}

/// Bit i is set where lane i of the mask is.
HWY_INLINE unsigned bitsOf(const Mask& mask) {
  unsigned bits = 0;
  for (int i = 0; i < kRegisters; ++i) {
    std::uint8_t some[8] = {0};
    hn::StoreMaskBits(Doubles(), mask.v[i], some);
    bits |= static_cast<unsigned>(some[0]) << static_cast<unsigned>(4 / kRegisters * i);
  }
  return bits;
}

/// From and to four doubles at a multiple of 32 bytes.
HWY_INLINE Lanes load(const double* from) {
  return eachLane([from](int i) { return hn::Load(Doubles(), from + 4 / kRegisters * i); });
}
HWY_INLINE void store(const Lanes& a, double* to) {
  for (int i = 0; i < kRegisters; ++i) hn::Store(a.v[i], Doubles(), to + 4 / kRegisters * i);
}

/// Lanes 1, 2, 0, 1: the next one of the first three.
HWY_INLINE Lanes nextOfThree(const Lanes& a) {
#if HWY_TARGET == HWY_SCALAR
  return {{a.v[1], a.v[2], a.v[0], a.v[1]}};
#elif HWY_CAP_GE256
  alignas(32) static constexpr std::int64_t kNext[4] = {1, 2, 0, 1};
  return {{hn::TableLookupLanes(a.v[0], hn::SetTableIndices(Doubles(), kNext))}};
#else
  return {{hn::CombineShiftRightBytes<8>(Doubles(), a.v[1], a.v[0]), a.v[0]}};
#endif
}

/// Four points.
struct FourPoints {
  Lanes x, y, z;
};

HWY_INLINE FourPoints fourTimes(const Vector& p) {
  return {allLanes(p.x()), allLanes(p.y()), allLanes(p.z())};
}
HWY_INLINE FourPoints operator-(const FourPoints& a, const FourPoints& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
HWY_INLINE Lanes dot(const FourPoints& a, const FourPoints& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
HWY_INLINE FourPoints cross(const FourPoints& a, const FourPoints& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
HWY_INLINE FourPoints nextOfThree(const FourPoints& a) {
  return {nextOfThree(a.x), nextOfThree(a.y), nextOfThree(a.z)};
}
/// p, turned round in the lanes where x is negative.
HWY_INLINE FourPoints withSignOf(const FourPoints& p, const Lanes& x) {
  const auto turned = [&x](const Lanes& a) {
    return eachLane(
        [&](int i) { return hn::Xor(a.v[i], hn::And(x.v[i], hn::SignBit(Doubles()))); });
  };
  return {turned(p.x), turned(p.y), turned(p.z)};
}
HWY_INLINE FourPoints choose(const Mask& mask, const FourPoints& a, const FourPoints& b) {
  return {choose(mask, a.x, b.x), choose(mask, a.y, b.y), choose(mask, a.z, b.z)};
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
