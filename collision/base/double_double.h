#pragma once

// Numbers of about 106 bits as sums of two doubles (Dekker 1971; the operations as in Hida, Li and
// Bailey 2001), without fused multiply-add, so that they are the same everywhere. Sums, products,
// quotients and roots err by less than 2^-100 of their size, sums by 2^-100 of their terms'. For
// numbers of 1e-140 to 1e140, or 0.

#include <cmath>

#include "collision/base/vector.h"

namespace leeway::collision {

struct DoubleDouble {
  double high = 0, low = 0;

  DoubleDouble() = default;
  DoubleDouble(double value) : high(value) {}  // NOLINT(google-explicit-constructor): a widening
  DoubleDouble(double h, double l) : high(h), low(l) {}
};

inline DoubleDouble exactSum(double a, double b) {
  const double sum = a + b, part = sum - a;
  return {sum, (a - (sum - part)) + (b - part)};
}

inline DoubleDouble exactProduct(double a, double b) {
  constexpr double kSplitter = 134217729.0;  // 2^27 + 1
  const double ca = kSplitter * a, cb = kSplitter * b;
  const double a_high = ca - (ca - a), a_low = a - a_high;
  const double b_high = cb - (cb - b), b_low = b - b_high;
  const double product = a * b;
  return {product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

inline DoubleDouble operator-(const DoubleDouble& a) { return {-a.high, -a.low}; }
inline DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble s = exactSum(a.high, b.high), t = exactSum(a.low, b.low);
  const DoubleDouble u = exactSum(s.high, s.low + t.high);
  return exactSum(u.high, u.low + t.low);
}
inline DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b) { return a + (-b); }
inline DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble p = exactProduct(a.high, b.high);
  return exactSum(p.high, p.low + (a.high * b.low + a.low * b.high));
}
inline DoubleDouble operator/(const DoubleDouble& a, const DoubleDouble& b) {
  const double first = a.high / b.high;
  const DoubleDouble rest = a - b * first;
  const double second = rest.high / b.high;
  const DoubleDouble last = rest - b * second;
  return exactSum(first, second) + last.high / b.high;
}
inline bool operator<(const DoubleDouble& a, const DoubleDouble& b) {
  return a.high < b.high || (a.high == b.high && a.low < b.low);
}
inline bool operator<=(const DoubleDouble& a, const DoubleDouble& b) {
  return a.high < b.high || (a.high == b.high && a.low <= b.low);
}
inline DoubleDouble absolute(const DoubleDouble& a) { return a.high < 0 ? -a : a; }

/// 0 for what is not positive.
inline DoubleDouble squareRoot(const DoubleDouble& a) {
  if (!(a.high > 0)) return 0;
  const double root = std::sqrt(a.high);
  const DoubleDouble rest = a - exactProduct(root, root);
  const DoubleDouble better = exactSum(root, rest.high / (2 * root));
  const DoubleDouble last = a - better * better;
  return better + last.high / (2 * root);
}

struct DoubleDoubleVector {
  DoubleDouble x, y, z;

  DoubleDoubleVector() = default;
  DoubleDoubleVector(const DoubleDouble& x_, const DoubleDouble& y_, const DoubleDouble& z_)
      : x(x_), y(y_), z(z_) {}
  explicit DoubleDoubleVector(const Vector& v) : x(v.x()), y(v.y()), z(v.z()) {}
  Vector rounded() const { return {x.high, y.high, z.high}; }
};

inline DoubleDoubleVector operator+(const DoubleDoubleVector& a, const DoubleDoubleVector& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline DoubleDoubleVector operator-(const DoubleDoubleVector& a, const DoubleDoubleVector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline DoubleDoubleVector operator-(const DoubleDoubleVector& a) { return {-a.x, -a.y, -a.z}; }
inline DoubleDoubleVector operator*(const DoubleDouble& s, const DoubleDoubleVector& a) {
  return {s * a.x, s * a.y, s * a.z};
}
inline DoubleDouble dot(const DoubleDoubleVector& a, const DoubleDoubleVector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline DoubleDoubleVector cross(const DoubleDoubleVector& a, const DoubleDoubleVector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline DoubleDouble norm(const DoubleDoubleVector& a) { return squareRoot(dot(a, a)); }

}  // namespace leeway::collision
