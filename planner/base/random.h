#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace leeway::planner {

/// Random numbers that are the same on every machine: xoshiro256++ (Blackman and Vigna, "Scrambled
/// linear pseudorandom number generators", 2021), with a state that splitmix64 fills from a seed
/// and a stream number. Uses no distribution of the standard library, because they differ between
/// libraries, and no transcendental function of the C library, because they differ between
/// instruction sets.
class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0);

  std::uint64_t next() {
    const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
    const std::uint64_t shifted = state_[1] << 17U;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= shifted;
    state_[3] = std::rotl(state_[3], 45);
    return result;
  }
  /// Uniform in [0, 1), a multiple of 2^-53.
  double uniform() { return static_cast<double>(next() >> 11U) * 0x1p-53; }
  /// Uniform in [lower, upper]; rounding never leaves that range.
  double uniform(double lower, double upper) {
    return std::clamp(lower + uniform() * (upper - lower), lower, upper);
  }
  /// Uniform in {0, ..., count - 1}; count > 0.
  int index(int count);
  /// Mean 0, variance 1: the sum of twelve uniform numbers minus six. Its tails end at 6, which is
  /// enough for samplers.
  double gaussian();
  /// A uniformly distributed unit quaternion, without trigonometry (Marsaglia, "Choosing a point
  /// from the surface of a sphere", 1972: two points of the disc).
  void quaternion(double* xyzw);
  /// Uniform in the ball of the given radius about the origin.
  void inBall(double radius, double* xyz);

 private:
  std::uint64_t state_[4];
};

}  // namespace leeway::planner
