#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace leeway::robots {

/// A bijection that separates similar seeds: the step of splitmix64 (Steele, Lea, Flood, "Fast
/// splittable pseudorandom number generators", 2014).
constexpr std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

/// A low-discrepancy sequence in several dimensions: the additive recurrence with the powers of the
/// root of x^(d + 1) = x + 1 (M. Roberts, "The unreasonable effectiveness of quasirandom
/// sequences", 2018), shifted by the seed. It uses integers, so it is exact and the same on every
/// machine, for any index.
class LowDiscrepancy {
 public:
  LowDiscrepancy(std::size_t dimensions, std::uint64_t seed);

  /// The number with this index in one dimension, in [0, 1), a multiple of 2^-53. O(1).
  double at(std::uint64_t index, std::size_t dimension) const {
    return static_cast<double>((shifts_[dimension] + index * steps_[dimension]) >> 11U) * 0x1p-53;
  }

 private:
  std::vector<std::uint64_t> steps_, shifts_;
};

}  // namespace leeway::robots
