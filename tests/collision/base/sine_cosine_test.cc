#include "collision/base/sine_cosine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace leeway::collision {
namespace {

/// Error of `value` in units in the last place of `exact`.
double ulps(double value, long double exact) {
  int exponent;
  std::frexp(exact, &exponent);
  return static_cast<double>(std::fabs(static_cast<long double>(value) - exact) /
                             std::ldexp(1.0L, std::max(exponent - 53, -1074)));
}

struct Worst {
  double sine = 0, cosine = 0, at = 0;
  void look(double x) {
    double s, c;
    sineCosine(x, s, c);
    const double es = ulps(s, std::sin(static_cast<long double>(x))),
                 ec = ulps(c, std::cos(static_cast<long double>(x)));
    if (std::max(es, ec) > std::max(sine, cosine)) at = x;
    sine = std::max(sine, es);
    cosine = std::max(cosine, ec);
  }
};

void expectSmall(const Worst& worst) {
  EXPECT_LE(worst.sine, 1.5) << "x = " << std::hexfloat << worst.at;
  EXPECT_LE(worst.cosine, 1.5) << "x = " << std::hexfloat << worst.at;
}

TEST(SineCosine, RandomArgumentsWithinOneAndAHalfUlp) {
  std::mt19937_64 random(1);
  for (double range : {0.7853981633974483, 3.2, 100.0, 1e5, 1e9, 1e15}) {
    Worst worst;
    std::uniform_real_distribution<double> uniform(-range, range);
    for (int i = 0; i < 200000; ++i) worst.look(uniform(random));
    expectSmall(worst);
    EXPECT_GT(worst.sine, 0.45) << "the comparison does not bite";
    RecordProperty("worst_ulp_" + std::to_string(static_cast<long long>(range)),
                   std::to_string(std::max(worst.sine, worst.cosine)));
  }
}

TEST(SineCosine, NearMultiplesOfAQuarterTurn) {
  Worst worst;
  for (int n = 1; n < 63000; n = n < 3000 ? n + 1 : n + 37) {
    double x = static_cast<double>(static_cast<long double>(n) *
                                   1.57079632679489661923132169163975144L / 2);
    for (int step = -3; step <= 3; ++step) {
      double y = x;
      for (int k = 0; k < std::abs(step); ++k) y = std::nextafter(y, step < 0 ? 0.0 : 1e300);
      worst.look(y);
      worst.look(-y);
    }
  }
  expectSmall(worst);
}

TEST(SineCosine, EveryMagnitude) {
  Worst worst;
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> mantissa(0.5, 1.0);
  for (int exponent = -1073; exponent <= 1024; ++exponent)
    for (int i = 0; i < 20; ++i) worst.look(std::ldexp(mantissa(random), exponent));
  expectSmall(worst);
  worst.look(0x1.6ac5b262ca1ffp+849);  // the double nearest to a multiple of pi/2 (Muller et al.,
                                       // Handbook of Floating-Point Arithmetic)
  worst.look(std::numeric_limits<double>::max());
  expectSmall(worst);
}

TEST(SineCosine, SpecialValues) {
  double s, c;
  sineCosine(0.0, s, c);
  EXPECT_EQ(s, 0);
  EXPECT_FALSE(std::signbit(s));
  EXPECT_EQ(c, 1);
  sineCosine(-0.0, s, c);
  EXPECT_TRUE(std::signbit(s));
  for (double x :
       {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
        std::numeric_limits<double>::quiet_NaN()}) {
    sineCosine(x, s, c);
    EXPECT_TRUE(std::isnan(s) && std::isnan(c));
  }
}

TEST(SineCosine, OddAndEvenToTheBit) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(0, 1000);
  for (int i = 0; i < 100000; ++i) {
    const double x = uniform(random);
    double s0, c0, s1, c1;
    sineCosine(x, s0, c0);
    sineCosine(-x, s1, c1);
    ASSERT_EQ(s0, -s1) << std::hexfloat << x;
    ASSERT_EQ(c0, c1) << std::hexfloat << x;
  }
}

}  // namespace
}  // namespace leeway::collision
