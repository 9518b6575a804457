#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include "leeway/collision/pose.h"

namespace leeway::fuzz {

/// Turns raw bytes into numbers that are hard for geometry. Zeros once the bytes are used up.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  bool empty() const { return at_ >= bytes_.size(); }

  std::uint8_t byte() { return empty() ? std::uint8_t{0} : bytes_[at_++]; }

  int below(int n) { return byte() % n; }

  /// Mostly of ordinary size; sometimes zero, about the smallest and largest sizes of shapes,
  /// subnormal, NaN, infinite, or any bit pattern.
  double number() {
    const int kind = byte();
    if (kind < 200)
      return (static_cast<double>(byte()) - 128 + static_cast<double>(byte()) / 256) / 64;
    switch (kind % 16) {
      case 0:
        return 0;
      case 1:
        return -0.0;
      case 2:
        return std::numeric_limits<double>::quiet_NaN();
      case 3:
        return std::numeric_limits<double>::infinity();
      case 4:
        return -std::numeric_limits<double>::infinity();
      case 5:
        return std::numeric_limits<double>::denorm_min();
      case 6:
        return std::numeric_limits<double>::max();
      case 7:
        return 1e-300;
      case 8:
        return 1e154;
      case 9:
        return 1 + 0x1p-52;
      case 10:
        return std::ldexp(1.0, below(64) - 32);
      case 11:
        return -std::ldexp(1.0, below(64) - 32);
      case 12:
        return byte();
      case 13:
        return -static_cast<double>(byte());
      default:
        break;
    }
    std::uint64_t bits = 0;
    for (int i = 0; i < 8; ++i) bits = bits << 8 | byte();
    double value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }

  /// A size, mostly non-negative.
  double size() { return below(16) == 0 ? number() : std::abs(number()); }

  Eigen::Vector3d vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }

  /// Mostly a rotation up to rounding (identity, quarter turns, from a quaternion); sometimes nine
  /// arbitrary numbers.
  Eigen::Matrix3d rotation() {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    switch (below(8)) {
      case 0:
        return R;
      case 1:
        R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
        return R;
      case 2:
        for (int i = 0; i < 9; ++i) R(i / 3, i % 3) = number();
        return R;
      default:
        break;
    }
    Eigen::Vector4d q;
    for (int i = 0; i < 4; ++i) q[i] = static_cast<double>(byte()) - 127.5;
    q /= q.norm();
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    R << 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),  //
        2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),   //
        2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y);
    return R;
  }

  collision::Pose pose() {
    collision::Pose X;
    X.rotation = rotation();
    X.translation = vector();
    return X;
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

}  // namespace leeway::fuzz
