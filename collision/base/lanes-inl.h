// Vectors of four or eight doubles, in as many registers as the target needs. Every operation
// rounds like one on single doubles, without fused multiply-add, so that results are the same on
// every target. Included once for each target (see Highway's foreach_target.h).

#if defined(LEEWAY_COLLISION_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_LANES_INL_H
#undef LEEWAY_COLLISION_LANES_INL_H
#else
#define LEEWAY_COLLISION_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstddef>
#include <cstdint>

#include "collision/base/triple.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <int n>
using Doubles = hn::CappedTag<double, static_cast<std::size_t>(n)>;
template <int n>
constexpr int kRegisters = n / static_cast<int>(hn::MaxLanes(Doubles<n>()));

template <int n>
struct Lanes {
  hn::Vec<Doubles<n>> v[kRegisters<n>];
};
template <int n>
struct Mask {
  hn::Mask<Doubles<n>> v[kRegisters<n>];
};

template <int n, class Operation>
HWY_INLINE Lanes<n> eachLane(Operation operation) {
  Lanes<n> result;
  for (int i = 0; i < kRegisters<n>; ++i) result.v[i] = operation(i);
  return result;
}

template <int n>
HWY_INLINE Lanes<n> allLanes(double x) {
  return eachLane<n>([x](int) { return hn::Set(Doubles<n>(), x); });
}
template <int n>
HWY_INLINE Lanes<n> operator+(const Lanes<n>& a, const Lanes<n>& b) {
  return eachLane<n>([&](int i) { return hn::Add(a.v[i], b.v[i]); });
}
template <int n>
HWY_INLINE Lanes<n> operator-(const Lanes<n>& a, const Lanes<n>& b) {
  return eachLane<n>([&](int i) { return hn::Sub(a.v[i], b.v[i]); });
}
template <int n>
HWY_INLINE Lanes<n> operator*(const Lanes<n>& a, const Lanes<n>& b) {
  return eachLane<n>([&](int i) { return hn::Mul(a.v[i], b.v[i]); });
}
template <int n>
HWY_INLINE Lanes<n> operator/(const Lanes<n>& a, const Lanes<n>& b) {
  return eachLane<n>([&](int i) { return hn::Div(a.v[i], b.v[i]); });
}
template <int n>
HWY_INLINE Mask<n> operator>(const Lanes<n>& a, const Lanes<n>& b) {
  Mask<n> result;
  for (int i = 0; i < kRegisters<n>; ++i) result.v[i] = hn::Gt(a.v[i], b.v[i]);
  return result;
}
template <int n>
HWY_INLINE Mask<n> operator&(const Mask<n>& a, const Mask<n>& b) {
  Mask<n> result;
  for (int i = 0; i < kRegisters<n>; ++i) result.v[i] = hn::And(a.v[i], b.v[i]);
  return result;
}

/// b, cleared where a is set.
template <int n>
HWY_INLINE Mask<n> andNot(const Mask<n>& a, const Mask<n>& b) {
  Mask<n> result;
  for (int i = 0; i < kRegisters<n>; ++i) result.v[i] = hn::AndNot(a.v[i], b.v[i]);
  return result;
}

/// Lane by lane: x where the mask is set, otherwise y.
template <int n>
HWY_INLINE Lanes<n> choose(const Mask<n>& mask, const Lanes<n>& x, const Lanes<n>& y) {
  return eachLane<n>([&](int i) { return hn::IfThenElse(mask.v[i], x.v[i], y.v[i]); });
}
/// x, negated in the lanes where the sign bit of s is set.
template <int n>
HWY_INLINE Lanes<n> withSignOf(const Lanes<n>& x, const Lanes<n>& s) {
  return eachLane<n>(
      [&](int i) { return hn::Xor(x.v[i], hn::And(s.v[i], hn::SignBit(Doubles<n>()))); });
}

/// Bit i is set if lane i of the mask is set.
template <int n>
HWY_INLINE unsigned bitsOf(const Mask<n>& mask) {
  unsigned bits = 0;
  for (int i = 0; i < kRegisters<n>; ++i) {
    std::uint8_t some[8] = {0};
    hn::StoreMaskBits(Doubles<n>(), mask.v[i], some);
    bits |= static_cast<unsigned>(some[0]) << static_cast<unsigned>(n / kRegisters<n> * i);
  }
  return bits;
}

/// Reads or writes n doubles, aligned to 8 n bytes.
template <int n>
HWY_INLINE Lanes<n> load(const double* from) {
  return eachLane<n>(
      [from](int i) { return hn::Load(Doubles<n>(), from + n / kRegisters<n> * i); });
}
template <int n>
HWY_INLINE void store(const Lanes<n>& a, double* to) {
  for (int i = 0; i < kRegisters<n>; ++i)
    hn::Store(a.v[i], Doubles<n>(), to + n / kRegisters<n> * i);
}

/// One number in every lane of the widest register.
using Widest = Doubles<8>;
using Same = hn::Vec<Widest>;

template <int n>
HWY_INLINE Lanes<n> allLanes(Same x) {
#if HWY_CAP_GE512
  if constexpr (n == 4) {
    return {{hn::LowerHalf(x)}};
  } else {
    return {{x}};
  }
#else
  return eachLane<n>([x](int) { return x; });
#endif
}

/// Selects one lane.
template <int n>
class Pick {
 public:
  using Place = hn::Vec<hn::RebindToSigned<Widest>>;
  HWY_INLINE explicit Pick(std::int64_t lane) : Pick(hn::Set(hn::RebindToSigned<Widest>(), lane)) {}
  /// From a register that holds the lane's number in every lane.
  HWY_INLINE explicit Pick(Place lane) : lane_(lane) {}
  HWY_INLINE int lane() const { return static_cast<int>(hn::GetLane(lane_)); }
  HWY_INLINE double operator()(const Lanes<n>& a) const {
#if HWY_CAP_GE512
    return hn::GetLane(hn::TableLookupLanes(a.v[0], places<n>()));
#else
    alignas(64) double some[std::size_t{n}];
    store(a, some);
    return some[hn::GetLane(lane_)];
#endif
  }
  /// The selected number in every lane.
  HWY_INLINE Same same(const Lanes<n>& a) const {
#if HWY_CAP_GE512
    if constexpr (n == 4) {
      // (Highway's conversion zeroes the upper half, which is never read.)
      return hn::TableLookupLanes(Same{_mm512_castpd256_pd512(a.v[0].raw)}, places<8>());
    } else {
      return hn::TableLookupLanes(a.v[0], places<8>());
    }
#else
    return hn::Set(Widest(), (*this)(a));
#endif
  }

 private:
#if HWY_CAP_GE512
  template <int m>
  HWY_INLINE auto places() const {
    if constexpr (m == 4) {
      return hn::IndicesFromVec(Doubles<4>(), hn::LowerHalf(lane_));
    } else {
      return hn::IndicesFromVec(Doubles<8>(), lane_);
    }
  }
#endif
  Place lane_;
};

/// Gathers from[places], lane by lane; places >= 0.
HWY_INLINE Same gathered(const double* from, hn::Vec<hn::RebindToSigned<Widest>> places) {
#if HWY_CAP_GE512
  // Highway's gather merges into an uninitialized register, which makes the result of one hull wait
  // for that of the other. (With a constant mask, compilers could also drop the zeroed source.)
  const __mmask8 all = _mm512_cmpge_epi64_mask(places.raw, _mm512_setzero_si512());
  return Same{_mm512_mask_i64gather_pd(_mm512_setzero_pd(), all, places.raw, from, 8)};
#else
  return hn::GatherIndex(Widest(), from, places);
#endif
}

/// The minimum of a register's lanes, in every lane.
HWY_INLINE Same leastLane(Same x) {
#if HWY_TARGET == HWY_SCALAR
  return x;
#else
#if HWY_CAP_GE256
  x = hn::Min(x, hn::ReverseBlocks(Widest(), x));
#endif
#if HWY_CAP_GE512
  x = hn::Min(x, hn::SwapAdjacentBlocks(x));
#endif
  return hn::Min(x, hn::Shuffle01(x));
#endif
}

/// Picks a lane whose value is the least to within some units in the last place. Values must be
/// finite and not negative. (Infinity tagged with its lane would become NaN, and lanes disagree on
/// a minimum with NaN.)
HWY_INLINE Pick<8> leastLaneOf(const Lanes<8>& a) {
  // The lane's number replaces the last bits of each value. This avoids converting a mask to an
  // index.
  const hn::RebindToSigned<Widest> di;
  const auto named = [&](int i) HWY_ATTR {
    const auto lane = hn::Iota(di, 8 / kRegisters<8> * i);
    return hn::BitCast(Widest(), hn::OrAnd(lane, hn::BitCast(di, a.v[i]), hn::Set(di, -8)));
  };
  Same least = named(0);
  for (int i = 1; i < kRegisters<8>; ++i) least = hn::Min(least, named(i));
  return Pick<8>(hn::And(hn::BitCast(di, leastLane(least)), hn::Set(di, 7)));
}

/// The lanes named by the first four of `lanes`.
HWY_INLINE Lanes<4> fourOf(const Lanes<8>& a, const std::int64_t (&lanes)[8]) {
#if HWY_CAP_GE512
  return {{hn::LowerHalf(hn::TableLookupLanes(a.v[0], hn::SetTableIndices(Doubles<8>(), lanes)))}};
#else
  alignas(64) double some[8];
  store(a, some);
  alignas(32)
      const double four[4] = {some[lanes[0]], some[lanes[1]], some[lanes[2]], some[lanes[3]]};
  return load<4>(four);
#endif
}

/// Rotates all lanes except the last by one: each gets its successor, and the last of them gets the
/// first. The last lane gets an arbitrary value.
HWY_INLINE Lanes<4> nextInRing(const Lanes<4>& a) {
#if HWY_TARGET == HWY_SCALAR
  return {{a.v[1], a.v[2], a.v[0], a.v[1]}};
#elif HWY_CAP_GE256
  alignas(32) static constexpr std::int64_t kNext[4] = {1, 2, 0, 1};
  return {{hn::TableLookupLanes(a.v[0], hn::SetTableIndices(Doubles<4>(), kNext))}};
#else
  return {{hn::CombineShiftRightBytes<8>(Doubles<4>(), a.v[1], a.v[0]), a.v[0]}};
#endif
}
HWY_INLINE Lanes<8> nextInRing(const Lanes<8>& a) {
#if HWY_CAP_GE512
  alignas(64) static constexpr std::int64_t kNext[8] = {1, 2, 3, 4, 5, 6, 0, 7};
  return {{hn::TableLookupLanes(a.v[0], hn::SetTableIndices(Doubles<8>(), kNext))}};
#else
  alignas(64) double some[16];
  store(a, some);
  some[8] = some[7];
  some[7] = some[0];
  return eachLane<8>(
      [&](int i) { return hn::LoadU(Doubles<8>(), some + 1 + 8 / kRegisters<8> * i); });
#endif
}

/// The lane with the least of a[k] / part[k] for k = 0, 1, 2; no part is below 0. (The fourth lane
/// may hold anything.)
HWY_INLINE Pick<4> leastOfThree(const Lanes<4>& a, const Lanes<4>& part) {
  // Cross-multiplied instead of divided: tests whether the lane's quotient is greater than the next
  // one's.
  const Mask<4> greater = a * nextInRing(part) > nextInRing(a) * part;
  static constexpr std::int64_t kLeastLane[8] = {0, 1, 2, 2, 0, 1, 0, 0};
  return Pick<4>(kLeastLane[bitsOf(greater) & 7U]);
}

/// (x, y, z, any), where each argument holds its number in all lanes.
HWY_INLINE Lanes<4> sideBySide(const Lanes<4>& x, const Lanes<4>& y, const Lanes<4>& z) {
#if HWY_TARGET == HWY_SCALAR
  return {{x.v[0], y.v[0], z.v[0], z.v[0]}};
#elif HWY_CAP_GE256
  return {{hn::ConcatUpperLower(Doubles<4>(), z.v[0], hn::OddEven(y.v[0], x.v[0]))}};
#else
  return {{hn::OddEven(y.v[0], x.v[0]), z.v[0]}};
#endif
}

HWY_INLINE Lanes<2> twoOf(double first, double second) {
#if HWY_TARGET == HWY_SCALAR
  return {{hn::Set(Doubles<2>(), first), hn::Set(Doubles<2>(), second)}};
#else
  return {{hn::OddEven(hn::Set(Doubles<2>(), second), hn::Set(Doubles<2>(), first))}};
#endif
}
HWY_INLINE double firstOf(const Lanes<2>& a) { return hn::GetLane(a.v[0]); }
HWY_INLINE double secondOf(const Lanes<2>& a) {
#if HWY_TARGET == HWY_SCALAR
  return hn::GetLane(a.v[1]);
#else
  return hn::GetLane(hn::Shuffle01(a.v[0]));
#endif
}

/// A group of n points.
template <int n>
struct Points {
  Lanes<n> x, y, z;
};
/// A point in every lane of the widest registers.
struct SamePoint {
  Same x, y, z;
};

HWY_INLINE void set(SamePoint& p, const Triple& q) {
  const Widest d;
  p = {hn::Set(d, q.x), hn::Set(d, q.y), hn::Set(d, q.z)};
}
HWY_INLINE void set(Triple& p, const Triple& q) { p = q; }
using leeway::collision::tripleOf;
HWY_INLINE Triple tripleOf(const SamePoint& p) {
  return {hn::GetLane(p.x), hn::GetLane(p.y), hn::GetLane(p.z)};
}
HWY_INLINE Triple tripleOf(const Triple& p) { return p; }
template <int n, class Point>
HWY_INLINE Points<n> allLanes(const Point& p) {
  return {allLanes<n>(p.x), allLanes<n>(p.y), allLanes<n>(p.z)};
}
/// (a, b, c, any).
HWY_INLINE Points<4> sideBySide(const Triple& a, const Triple& b, const Triple& c) {
  return {sideBySide(allLanes<4>(a.x), allLanes<4>(b.x), allLanes<4>(c.x)),
          sideBySide(allLanes<4>(a.y), allLanes<4>(b.y), allLanes<4>(c.y)),
          sideBySide(allLanes<4>(a.z), allLanes<4>(b.z), allLanes<4>(c.z))};
}
/// R p, rounded like rotated() of a Triple.
HWY_INLINE Points<4> rotated(const Eigen::Matrix3d& R, const Points<4>& p) {
  const auto row = [&](int i) HWY_ATTR {
    return allLanes<4>(R(i, 0)) * p.x + allLanes<4>(R(i, 1)) * p.y + allLanes<4>(R(i, 2)) * p.z;
  };
  return {row(0), row(1), row(2)};
}
template <int n>
HWY_INLINE Points<n> operator+(const Points<n>& a, const Points<n>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <int n>
HWY_INLINE Points<n> operator-(const Points<n>& a, const Points<n>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <int n>
HWY_INLINE Points<n> operator*(const Lanes<n>& s, const Points<n>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <int n>
HWY_INLINE Lanes<n> dot(const Points<n>& a, const Points<n>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <int n>
HWY_INLINE Points<n> cross(const Points<n>& a, const Points<n>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <int n>
HWY_INLINE Points<n> nextInRing(const Points<n>& a) {
  return {nextInRing(a.x), nextInRing(a.y), nextInRing(a.z)};
}
template <int n>
HWY_INLINE Points<n> withSignOf(const Points<n>& p, const Lanes<n>& s) {
  return {withSignOf(p.x, s), withSignOf(p.y, s), withSignOf(p.z, s)};
}
template <int n>
HWY_INLINE Points<n> choose(const Mask<n>& mask, const Points<n>& a, const Points<n>& b) {
  return {choose(mask, a.x, b.x), choose(mask, a.y, b.y), choose(mask, a.z, b.z)};
}
template <int n>
HWY_INLINE void pick(const Points<n>& a, const Pick<n>& lane, SamePoint& p) {
  p = {lane.same(a.x), lane.same(a.y), lane.same(a.z)};
}
template <int n>
HWY_INLINE void pick(const Points<n>& a, const Pick<n>& lane, Triple& p) {
  p = {lane(a.x), lane(a.y), lane(a.z)};
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
