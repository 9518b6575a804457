#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "collision/vector.h"

namespace leeway::collision {

class ConvexHull;

/// Hulls of up to this many vertices are scanned, coordinates side by side in vector registers;
/// beyond, a climb from a good start looks at fewer. The best of 32, 64, 128 and 256 on hulls of
/// 128 and 512 vertices [count].
inline constexpr int kScanUpTo = 64;

/// What a hull's support function is quick with, made once with the hull.
class HullSupport {
 public:
  /// From the vertices and, where there are many, the neighbour lists of `hull`. O(vertices).
  explicit HullSupport(const ConvexHull& hull);

  /// Coordinates of all vertices side by side, padded to a multiple of eight by copies of vertex 0;
  /// 64-byte aligned. Empty (length 0) where climbing is quicker.
  const double* x() const { return columns_.empty() ? nullptr : columns_[0].value; }
  const double* y() const { return x() + length_; }
  const double* z() const { return x() + 2 * length_; }
  std::int32_t length() const { return length_; }

  /// A vertex that is about the farthest along a direction of any length: where to start a climb.
  /// 0 where there is no table (length() > 0).
  std::int32_t start(double dx, double dy, double dz) const {
    if (start_.empty()) return 0;
    const double direction[3] = {dx, dy, dz};
    const double size[3] = {std::abs(dx), std::abs(dy), std::abs(dz)};
    const std::size_t first = size[0] >= size[1] ? 0 : 1;
    const std::size_t axis = size[2] > size[first] ? 2 : first;
    const std::size_t face = 2 * axis + (direction[axis] < 0 ? 1 : 0);
    if (!(size[axis] > 0)) return 0;
    const double scale = 0.5 * kCells / size[axis];
    const auto cell = [scale](double across) {
      const int i = static_cast<int>(across * scale + 0.5 * kCells);
      return static_cast<std::size_t>(i < kCells ? i : kCells - 1);
    };
    const std::size_t u = cell(direction[axis == 2 ? 0 : axis + 1]);
    const std::size_t v = cell(direction[axis == 0 ? 2 : axis - 1]);
    return start_[(face * kCells + u) * kCells + v];
  }

 private:
  static constexpr int kCells = 8;  // a side of a face of the cube of directions
  struct alignas(64) Eight {
    double value[8];
  };
  std::vector<Eight> columns_;
  std::int32_t length_ = 0;
  std::vector<std::int32_t> start_;
};

}  // namespace leeway::collision
