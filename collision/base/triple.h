#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>

#include "collision/base/vector.h"
#include "leeway/collision/interval.h"

namespace leeway::collision {

/// Three plain numbers, uninitialized, that stay in registers. A Vector goes through memory: two
/// coordinates that are written one by one and read back together stall store forwarding for longer
/// than a closed form takes.
struct Triple {
  double x, y, z;
};

inline Triple tripleOf(const Vector& v) { return {v.x(), v.y(), v.z()}; }
/// Stores in units of the size that compilers copy by, so that reads do not stall.
inline void write(double first, double second, double* to) {
  using Pair = double __attribute__((vector_size(16)));
  const Pair pair = {first, second};
  std::memcpy(to, &pair, sizeof(pair));
}
inline void write(const Triple& t, Vector& v) {
  write(t.x, t.y, v.data());
  v.z() = t.z;
}
inline void write(const Interval& from, Interval& to) {
  static_assert(sizeof(Interval) == 2 * sizeof(double));
  write(from.lower, from.upper, &to.lower);
}
inline Triple column(const Eigen::Matrix3d& R, int k) { return {R(0, k), R(1, k), R(2, k)}; }
inline Triple operator+(const Triple& a, const Triple& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Triple operator-(const Triple& a, const Triple& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Triple operator-(const Triple& a) { return {-a.x, -a.y, -a.z}; }
inline Triple operator*(double s, const Triple& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Triple& a, const Triple& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double squared(const Triple& a) { return dot(a, a); }
inline Triple cross(const Triple& a, const Triple& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// Sum of |a_i| b_i: how far a box with half extents b reaches along a.
inline double reach(const Triple& a, const Triple& b) {
  return std::abs(a.x) * b.x + std::abs(a.y) * b.y + std::abs(a.z) * b.z;
}
/// R v and R^T v.
inline Triple rotated(const Eigen::Matrix3d& R, const Triple& v) {
  return {R(0, 0) * v.x + R(0, 1) * v.y + R(0, 2) * v.z,
          R(1, 0) * v.x + R(1, 1) * v.y + R(1, 2) * v.z,
          R(2, 0) * v.x + R(2, 1) * v.y + R(2, 2) * v.z};
}
inline Triple rotatedBack(const Eigen::Matrix3d& R, const Triple& v) {
  return {R(0, 0) * v.x + R(1, 0) * v.y + R(2, 0) * v.z,
          R(0, 1) * v.x + R(1, 1) * v.y + R(2, 1) * v.z,
          R(0, 2) * v.x + R(1, 2) * v.y + R(2, 2) * v.z};
}

/// x clamped to [low, high], branch-free; NaN becomes one of the limits.
inline double within(double x, double low, double high) {
  const double y = x < high ? x : high;
  return y > low ? y : low;
}
inline Triple within(const Triple& p, const Triple& half) {
  return {within(p.x, -half.x, half.x), within(p.y, -half.y, half.y), within(p.z, -half.z, half.z)};
}

}  // namespace leeway::collision
