#include "planner/base/random.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace leeway::planner {
namespace {

/// Steele, Lea, Flood, "Fast splittable pseudorandom number generators", 2014. A bijection of a
/// counter with full period: no seed gives four zeros, a state that xoshiro never leaves.
std::uint64_t splitmix64(std::uint64_t& counter) {
  counter += 0x9e3779b97f4a7c15u;
  std::uint64_t z = counter;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

}  // namespace

Random::Random(std::uint64_t seed, std::uint64_t stream) {
  std::uint64_t counter = seed;
  // Both are mixed before the xor: with a plain xor, (1, 0) and (0, 1) would be the same stream.
  std::uint64_t stream_counter = stream;
  counter = splitmix64(counter) ^ std::rotl(splitmix64(stream_counter), 32);
  for (std::uint64_t& word : state_) word = splitmix64(counter);
}

int Random::index(int count) { return std::min(static_cast<int>(uniform() * count), count - 1); }

double Random::gaussian() {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += uniform();
  return sum;
}

void Random::quaternion(double* xyzw) {
  double x[2], y[2], s[2];
  for (int i = 0; i < 2; ++i) {
    do {
      x[i] = uniform(-1, 1);
      y[i] = uniform(-1, 1);
      s[i] = x[i] * x[i] + y[i] * y[i];
    } while (s[i] >= 1 || s[i] == 0);
  }
  const double scale = std::sqrt((1 - s[0]) / s[1]);
  xyzw[0] = x[0];
  xyzw[1] = y[0];
  xyzw[2] = x[1] * scale;
  xyzw[3] = y[1] * scale;
}

void Random::inBall(double radius, double* xyz) {
  double squared;
  do {
    squared = 0;
    for (int i = 0; i < 3; ++i) {
      xyz[i] = uniform(-1, 1);
      squared += xyz[i] * xyz[i];
    }
  } while (squared > 1);
  for (int i = 0; i < 3; ++i) xyz[i] *= radius;
}

}  // namespace leeway::planner
