#include "collision/base/exact_predicates.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "collision/base/tolerances.h"

namespace leeway::collision {
namespace {

// A nonoverlapping expansion, smallest term first. The exact value is the sum of the terms; its
// sign is that of the last term. Shewchuk 1997, section 2. The capacities below suffice for a
// product of three differences.
template <std::size_t capacity>
struct Expansion {
  std::array<double, capacity> term;
  std::size_t size = 0;

  // Coordinates outside the range of the predicates (for example from a damaged file) end in NaN,
  // and in more terms than fit. The sign is then arbitrary.
  void push(double value) {
    if (value != 0 && size < capacity) term[size++] = value;
  }
  int sign() const { return size == 0 ? 0 : (term[size - 1] > 0 ? 1 : -1); }
};

struct Pair {
  double high, low;  // high + low is the exact result, high the rounded one
};

Pair twoSum(double a, double b) {
  const double sum = a + b;
  const double b_virtual = sum - a;
  const double a_virtual = sum - b_virtual;
  return {sum, (a - a_virtual) + (b - b_virtual)};
}

Pair split(double a) {
  constexpr double kSplitter = 134217729.0;  // 2^27 + 1
  const double c = kSplitter * a;
  const double high = c - (c - a);
  return {high, a - high};
}

Pair twoProduct(double a, double b) {
  const double product = a * b;
  const Pair x = split(a), y = split(b);
  const double error = ((product - x.high * y.high) - x.low * y.high) - x.high * y.low;
  return {product, x.low * y.low - error};
}

Expansion<2> difference(double a, double b) {
  const Pair d = twoSum(a, -b);
  Expansion<2> e;
  e.push(d.low);
  e.push(d.high);
  return e;
}

// Adds f to e, term by term (Shewchuk's grow-expansion). It works in place because writes never
// overtake reads.
template <std::size_t n, std::size_t m>
void add(Expansion<n>& e, const Expansion<m>& f) {
  for (std::size_t j = 0; j < f.size; ++j) {
    double carry = f.term[j];
    std::size_t kept = 0;
    for (std::size_t i = 0; i < e.size; ++i) {
      const Pair s = twoSum(carry, e.term[i]);
      if (s.low != 0) e.term[kept++] = s.low;
      carry = s.high;
    }
    e.size = kept;
    e.push(carry);
  }
}

template <std::size_t n, std::size_t m>
Expansion<2 * n * m> multiply(const Expansion<n>& e, const Expansion<m>& f) {
  Expansion<2 * n * m> result;
  for (std::size_t j = 0; j < f.size; ++j) {
    Expansion<2 * n> scaled;
    double carry = 0;
    for (std::size_t i = 0; i < e.size; ++i) {
      const Pair product = twoProduct(e.term[i], f.term[j]);
      const Pair low = twoSum(carry, product.low);
      scaled.push(low.low);
      const Pair high = twoSum(product.high, low.high);
      scaled.push(high.low);
      carry = high.high;
    }
    scaled.push(carry);
    add(result, scaled);
  }
  return result;
}

template <std::size_t n>
void negate(Expansion<n>& e) {
  for (std::size_t i = 0; i < e.size; ++i) e.term[i] = -e.term[i];
}

// a d - b c
Expansion<16> determinant2(const Expansion<2>& a, const Expansion<2>& b, const Expansion<2>& c,
                           const Expansion<2>& d) {
  const Expansion<8> plus = multiply(a, d);
  Expansion<8> minus = multiply(b, c);
  negate(minus);
  Expansion<16> result;
  add(result, plus);
  add(result, minus);
  return result;
}

int exactOrientation(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                     const Eigen::Vector3d& d) {
  std::array<std::array<Expansion<2>, 3>, 3> row;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    row[0][k] = difference(b[i], a[i]);
    row[1][k] = difference(c[i], a[i]);
    row[2][k] = difference(d[i], a[i]);
  }
  Expansion<192> sum;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
    const Expansion<16> minor = determinant2(row[0][l], row[0][m], row[1][l], row[1][m]);
    const Expansion<64> product = multiply(minor, row[2][k]);
    add(sum, product);
  }
  return sum.sign();
}

}  // namespace

int orientation(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                const Eigen::Vector3d& d) {
  const double bx = b.x() - a.x(), by = b.y() - a.y(), bz = b.z() - a.z();
  const double cx = c.x() - a.x(), cy = c.y() - a.y(), cz = c.z() - a.z();
  const double dx = d.x() - a.x(), dy = d.y() - a.y(), dz = d.z() - a.z();
  const double x1 = by * cz, x2 = bz * cy, y1 = bz * cx, y2 = bx * cz, z1 = bx * cy, z2 = by * cx;
  const double determinant = dx * (x1 - x2) + dy * (y1 - y2) + dz * (z1 - z2);
  const double permanent = std::abs(dx) * (std::abs(x1) + std::abs(x2)) +
                           std::abs(dy) * (std::abs(y1) + std::abs(y2)) +
                           std::abs(dz) * (std::abs(z1) + std::abs(z2));
  if (permanent == 0) return 0;  // every product has a factor 0: common in axis-aligned parts
  const double error = kOrientationRounding * permanent;
  if (determinant > error) return 1;
  if (-determinant > error) return -1;
  return exactOrientation(a, b, c, d);
}

int turn(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, int i,
         int j) {
  const double left = (b[i] - a[i]) * (c[j] - a[j]);
  const double right = (b[j] - a[j]) * (c[i] - a[i]);
  const double error = kTurnRounding * (std::abs(left) + std::abs(right));
  if (left - right > error) return 1;
  if (right - left > error) return -1;
  return determinant2(difference(b[i], a[i]), difference(b[j], a[j]), difference(c[i], a[i]),
                      difference(c[j], a[j]))
      .sign();
}

bool collinear(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return turn(a, b, c, 0, 1) == 0 && turn(a, b, c, 1, 2) == 0 && turn(a, b, c, 2, 0) == 0;
}

}  // namespace leeway::collision
