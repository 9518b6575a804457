#pragma once

#include <Eigen/Core>
#include <cmath>

namespace leeway::oracle {

/// Quadruple precision (113 bits). Compiler builtin, not a language extension switch.
__extension__ typedef __float128 Quad;  // NOLINT(modernize-use-using): no __extension__ there

/// Widens a double explicitly, because some compilers warn about the implicit conversion.
inline constexpr Quad wide(double x) { return static_cast<Quad>(x); }
inline constexpr Quad infinity() { return wide(HUGE_VAL); }

/// Unit roundoff of Quad, 2^-113.
inline Quad quadRoundoff() { return wide(0x1p-113); }

inline Quad absolute(Quad x) { return x < 0 ? -x : x; }
inline double toDouble(Quad x) { return static_cast<double>(x); }

/// Largest double <= x.
inline double roundDown(Quad x) {
  const double d = static_cast<double>(x);
  return wide(d) <= x ? d : std::nextafter(d, -HUGE_VAL);
}

/// Smallest double >= x.
inline double roundUp(Quad x) {
  const double d = static_cast<double>(x);
  return wide(d) >= x ? d : std::nextafter(d, HUGE_VAL);
}

/// Square root by Newton's method from the double root, within 2 ulp; 0 for x <= 0.
inline Quad squareRoot(Quad x) {
  if (!(x > 0)) return 0;
  if (x == infinity()) return x;
  // Scaled into the range of double first: squares of tiny lengths leave it.
  Quad scale = 1;
  while (x < wide(1e-200)) {
    x *= wide(0x1p400);
    scale *= wide(0x1p-200);
    if (scale == 0) return 0;
  }
  while (x > wide(1e200)) {
    x *= wide(0x1p-400);
    scale *= wide(0x1p200);
  }
  Quad r = wide(std::sqrt(static_cast<double>(x)));
  // 53 digits become 106, then all.
  for (int i = 0; i < 2; ++i) r = wide(0.5) * (r + x / r);
  return r * scale;
}

struct Vector {
  Quad x = 0, y = 0, z = 0;
};

inline Vector toVector(const Eigen::Vector3d& v) { return {wide(v.x()), wide(v.y()), wide(v.z())}; }
inline Vector operator+(const Vector& a, const Vector& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vector operator-(const Vector& a, const Vector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vector operator-(const Vector& a) { return {-a.x, -a.y, -a.z}; }
inline Vector operator*(Quad s, const Vector& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Quad dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Quad squaredNorm(const Vector& a) { return dot(a, a); }
/// Exponents have 15 bits: no square of a double's leaves the range.
inline Quad norm(const Vector& a) { return squareRoot(squaredNorm(a)); }

}  // namespace leeway::oracle
