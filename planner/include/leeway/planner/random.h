#pragma once

#include <cstdint>

namespace leeway::planner {

/// Random numbers that are the same on every machine: xoshiro256++ (Blackman and Vigna, "Scrambled
/// linear pseudorandom number generators", 2021), its state filled by splitmix64 from a seed and a
/// stream number. No distribution of the standard library (they differ between libraries) and no
/// transcendental function of the C library (they differ between instruction sets) takes part.
class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0);

  std::uint64_t next();
  /// Uniform in [0, 1), a multiple of 2^-53.
  double uniform();
  /// Uniform in [lower, upper]; never outside, whatever the rounding.
  double uniform(double lower, double upper);
  /// Uniform in {0, ..., count - 1}; count > 0.
  int index(int count);
  /// Mean 0, variance 1: the sum of twelve uniform numbers less six. Its tails end at 6; samplers
  /// need no more.
  double gaussian();
  /// A uniformly distributed unit quaternion (Marsaglia 1972: two points of the disc, no
  /// trigonometry).
  void quaternion(double* xyzw);
  /// Uniform in the ball of that radius.
  void inBall(double radius, double* xyz);

 private:
  std::uint64_t state_[4];
};

}  // namespace leeway::planner
