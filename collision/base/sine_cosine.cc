// Sine and cosine from basic operations alone, so that a configuration has the same bytes on every
// machine. Reduction: Cody and Waite, Software Manual for the Elementary Functions (1980), with
// pi/2 in three parts. Where cancellation leaves too few digits of the remainder, and for large
// arguments: Payne and Hanek, Radian Reduction for Trigonometric Functions (1983), in integers. The
// polynomials are minimax (Remez exchange, 300 bits) on |r| <= pi/4 + 2^-20;
// tools/lab/long_run/derive_sine_cosine.py prints them.

#include "collision/base/sine_cosine.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace leeway::collision {

namespace {

/// A number as the unevaluated sum of two doubles, |low| <= ulp(high) / 2.
struct Reduced {
  double high, low;
  unsigned quadrant;  ///< multiples of pi/2 taken off, modulo 4
};

// 2/pi = 0.a2f9836e...: 1280 bits, enough for the largest double (1024 + 256).
constexpr std::array<std::uint64_t, 20> kTwoOverPi = {
    0xa2f9836e4e441529u, 0xfc2757d1f534ddc0u, 0xdb6295993c439041u, 0xfe5163abdebbc561u,
    0xb7246e3a424dd2e0u, 0x06492eea09d1921cu, 0xfe1deb1cb129a73eu, 0xe88235f52ebb4484u,
    0xe99c7026b45f7e41u, 0x3991d639835339f4u, 0x9c845f8bbdf9283bu, 0x1ff897ffde05980fu,
    0xef2f118b5a0a6d1fu, 0x6d367ecf27cb09b7u, 0x4f463f669e5fea2du, 0x7527bac7ebe5f17bu,
    0x3d0739f78a5292eau, 0x6bfb5fb11f8d5d08u, 0x56033046fc7b6babu, 0xf0cfbc209af4361du};

/// The 64 bits of 2/pi from bit `first` on (0: the bit of weight 1/2); zeros past the table.
std::uint64_t bitsOfTwoOverPi(int first) {
  const auto word = static_cast<std::size_t>(first / 64);
  const int shift = first % 64;
  const std::uint64_t high = word < kTwoOverPi.size() ? kTwoOverPi[word] : 0;
  const std::uint64_t low = word + 1 < kTwoOverPi.size() ? kTwoOverPi[word + 1] : 0;
  return shift == 0 ? high : (high << shift) | (low >> (64 - shift));
}

/// The 128-bit product of two words, in halves.
void multiply(std::uint64_t a, std::uint64_t b, std::uint64_t& high, std::uint64_t& low) {
  const std::uint64_t mask = 0xffffffffu;
  const std::uint64_t a1 = a >> 32, a0 = a & mask, b1 = b >> 32, b0 = b & mask;
  const std::uint64_t p00 = a0 * b0, p01 = a0 * b1, p10 = a1 * b0;
  const std::uint64_t middle = (p00 >> 32) + (p01 & mask) + (p10 & mask);
  low = (middle << 32) | (p00 & mask);
  high = a1 * b1 + (p01 >> 32) + (p10 >> 32) + (middle >> 32);
}

double powerOfTwo(int exponent) {  // for normal results only
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
}

/// a * b = product + error exactly (Dekker 1971), for moderate sizes.
double productError(double a, double b, double product) {
  constexpr double kSplit = 134217729.0;  // 2^27 + 1
  const double ta = kSplit * a, a1 = ta - (ta - a), a0 = a - a1;
  const double tb = kSplit * b, b1 = tb - (tb - b), b0 = b - b1;
  return ((a1 * b1 - product) + a1 * b0 + a0 * b1) + a0 * b0;
}

/// For finite x >= 2^-1: x * 2/pi modulo 4 in 320 bits of fixed point, two of them before the
/// point.
Reduced reduceExactly(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const std::uint64_t mantissa = (bits & ((std::uint64_t{1} << 52) - 1)) | (std::uint64_t{1} << 52);
  const int exponent = static_cast<int>(bits >> 52) - 1075;  // x = mantissa * 2^exponent
  // Omits bits of 2/pi whose product with x is a multiple of 4; 256 bits are kept.
  const int first = exponent >= 2 ? exponent - 2 : 0;
  std::array<std::uint64_t, 5> fixed{};  // most significant word first
  std::uint64_t carry = 0;
  for (int i = 3; i >= 0; --i) {
    std::uint64_t high, low;
    multiply(mantissa, bitsOfTwoOverPi(first + 64 * i), high, low);
    low += carry;
    high += low < carry ? 1 : 0;
    fixed[static_cast<std::size_t>(i) + 1] = low;
    carry = high;
  }
  fixed[0] = carry;
  // The product is x * 2/pi * 2^(256 - (exponent - first)); the shift puts the point behind the
  // second bit of word 0.
  const int shift = 62 + exponent - first;
  for (std::size_t i = 0; i < 5; ++i) {
    const std::uint64_t next = i < 4 ? fixed[i + 1] : 0;
    fixed[i] = shift == 64 ? next : (fixed[i] << shift) | (next >> (64 - shift));
  }
  unsigned quadrant = static_cast<unsigned>(fixed[0] >> 62);
  fixed[0] <<= 2;  // drops the quadrant; the loop moves the lower words' bits up, too
  for (std::size_t i = 0; i < 4; ++i) {
    fixed[i] |= fixed[i + 1] >> 62;
    fixed[i + 1] <<= 2;
  }
  const bool negative = (fixed[0] >> 63) != 0;
  if (negative) {  // nearer to the next quadrant: 1 - fraction, except for the last bit
    ++quadrant;
    for (std::uint64_t& word : fixed) word = ~word;
  }
  int zeros = 0;
  std::size_t word = 0;
  while (word < 3 && fixed[word] == 0) {
    zeros += 64;
    ++word;
  }
  const int left = std::countl_zero(fixed[word]);
  if (left == 64) return {0, 0, quadrant & 3u};
  zeros += left;
  const std::uint64_t top =
      left == 0 ? fixed[word] : (fixed[word] << left) | (fixed[word + 1] >> (64 - left));
  const std::uint64_t following = word + 2 < 5 ? fixed[word + 2] : 0;
  const std::uint64_t bottom =
      left == 0 ? fixed[word + 1] : (fixed[word + 1] << left) | (following >> (64 - left));
  const double sign = negative ? -1.0 : 1.0;
  const double f1 = sign * static_cast<double>(top >> 11) * powerOfTwo(-53 - zeros);
  const double f0 =
      sign * static_cast<double>(((top & 0x7ff) << 42) | (bottom >> 22)) * powerOfTwo(-106 - zeros);
  constexpr double kHalfPiHigh = 0x1.921fb54442d18p+0, kHalfPiLow = 0x1.1a62633145c07p-54;
  const double product = f1 * kHalfPiHigh;
  const double rest = productError(f1, kHalfPiHigh, product) + (f1 * kHalfPiLow + f0 * kHalfPiHigh);
  const double high = product + rest;
  return {high, rest - (high - product), quadrant & 3u};
}

/// x in (pi/4, 1e5]: pi/2 in parts of 33, 33 and 53 bits; n has at most 16 bits, so the first two
/// products are exact.
Reduced reduce(double x) {
  constexpr double kPart1 = 0x1.921fb544p+0, kPart2 = 0x1.0b4611a6p-34,
                   kPart3 = 0x1.3198a2e037073p-69;
  constexpr double kTwoOverPiRounded = 0x1.45f306dc9c883p-1;
  constexpr double kRound = 0x1.8p+52;  // adding and subtracting it rounds to the nearest integer
  const double n = (x * kTwoOverPiRounded + kRound) - kRound;
  // Exact: both are multiples of the same unit, and the result is small.
  const double first = x - n * kPart1;
  const double second = n * kPart2;
  const double third = n * kPart3;
  const double sum = first - second;  // sum + error = first - second exactly (Knuth's two-sum)
  const double back = sum - first;
  const double error = (first - (sum - back)) - (second + back);
  const double low = error - third;
  const double high = sum + low;
  // The remainder errs by at most 2^-101: below 2^-40 that would show in the last place.
  if (std::fabs(high) < 0x1p-40) return reduceExactly(x);
  return {high, low - (high - sum), static_cast<unsigned>(static_cast<int>(n)) & 3u};
}

/// sin(r + low), |r| <= pi/4. The polynomial is within 2^-57 of the value, relative.
double sinePolynomial(double r, double low) {
  const double z = r * r;
  const double p = -0x1.5555555555549p-3 +
                   z * (0x1.111111110f881p-7 +
                        z * (-0x1.a01a019c126a1p-13 +
                             z * (0x1.71de357873517p-19 +
                                  z * (-0x1.ae5e66d3f129bp-26 + z * 0x1.5d932efa481fap-33))));
  return r + (r * z * p + low * (1 - 0.5 * z));
}

/// cos(r + low), |r| <= pi/4. The polynomial is within 2^-59 of the value.
double cosinePolynomial(double r, double low) {
  const double z = r * r;
  const double q = 0x1.555555555554cp-5 +
                   z * (-0x1.6c16c16c15184p-10 +
                        z * (0x1.a01a019cb26e4p-16 +
                             z * (-0x1.27e4f80a75becp-22 +
                                  z * (0x1.1ee9ec473cf96p-29 + z * -0x1.8faeceec5f803p-37))));
  const double half = 0.5 * z;
  const double leading = 1 - half;
  return leading + (((1 - leading) - half) + (z * z * q - r * low));
}

}  // namespace

void sineCosine(double x, double& sine, double& cosine) {
  const double magnitude = std::fabs(x);
  Reduced reduced{magnitude, 0, 0};
  if (!(magnitude <= 0.785398163397448)) {  // NaN, too
    if (!(magnitude < std::numeric_limits<double>::infinity())) {
      sine = cosine = std::numeric_limits<double>::quiet_NaN();
      return;
    }
    reduced = magnitude <= 1e5 ? reduce(magnitude) : reduceExactly(magnitude);
  }
  const double s = sinePolynomial(reduced.high, reduced.low);
  const double c = cosinePolynomial(reduced.high, reduced.low);
  const double turned_sine = (reduced.quadrant & 1u) != 0 ? c : s;
  const double turned_cosine = (reduced.quadrant & 1u) != 0 ? s : c;
  const double positive = (reduced.quadrant & 2u) != 0 ? -turned_sine : turned_sine;
  sine = std::signbit(x) ? -positive : positive;
  cosine = reduced.quadrant == 1 || reduced.quadrant == 2 ? -turned_cosine : turned_cosine;
}

}  // namespace leeway::collision
