#include "collision/base/exact_predicates.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>

#include "tests/support/mesh_cases.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

// Exact signs against integer arithmetic without rounding.
TEST(Exact, OrientationOfSmallIntegers) {
  Random random(5);
  int zeros = 0;
  for (int i = 0; i < 20000; ++i) {
    std::array<std::array<std::int64_t, 3>, 4> p;
    std::array<Vector3d, 4> v;
    const double scale = std::ldexp(1.0, random.below(40) - 20);
    for (std::size_t k = 0; k < 4; ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        p[k][c] = random.below(5) + (random.below(2) != 0 ? 0 : (std::int64_t{1} << 20));
        v[k][static_cast<int>(c)] = scale * static_cast<double>(p[k][c]);
      }
    }
    const auto d = [&](std::size_t k, std::size_t c) { return p[k][c] - p[0][c]; };
    const std::int64_t det = d(3, 0) * (d(1, 1) * d(2, 2) - d(1, 2) * d(2, 1)) +
                             d(3, 1) * (d(1, 2) * d(2, 0) - d(1, 0) * d(2, 2)) +
                             d(3, 2) * (d(1, 0) * d(2, 1) - d(1, 1) * d(2, 0));
    EXPECT_EQ(orientation(v[0], v[1], v[2], v[3]), (det > 0) - (det < 0));
    zeros += det == 0 ? 1 : 0;
  }
  EXPECT_GT(zeros, 200);
}

// A point one ulp off a plane: the filter is inconclusive, the expansion must decide.
TEST(Exact, OrientationOfOneUlp) {
  const Vector3d a(0.1, 0.1, 0.1), b(12.3, 12.3, 12.3), c(0.7, 0.7, 24.5);
  for (const double x : {0.3, 1.7, 9.1}) {
    const Vector3d on(x, x, 0.2);
    EXPECT_EQ(orientation(a, b, c, on), 0);
    const Vector3d up(std::nextafter(x, 100), x, 0.2), down(std::nextafter(x, -100), x, 0.2);
    EXPECT_EQ(orientation(a, b, c, up), -orientation(a, b, c, down));
    EXPECT_NE(orientation(a, b, c, up), 0);
  }
}

}  // namespace
}  // namespace leeway::collision
