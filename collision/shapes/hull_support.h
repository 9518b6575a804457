#pragma once

#include <cstdint>
#include <vector>

#include "collision/base/vector.h"

namespace leeway::collision {

class ConvexHull;

/// Hulls of up to this many vertices are scanned, coordinates side by side in vector registers;
/// beyond, a table of directions says which few to look at. At 64 a scan takes four fifths of the
/// time with registers of eight doubles, nine tenths with four (hulls of 64 and of 66) [count].
inline constexpr int kScanUpTo = 64;

/// A cell of the table of directions: whatever the direction in it, the farthest vertex is one of
/// these. Where there are more than eight, the first is kMany.
struct alignas(16) HullCell {
  static constexpr std::uint16_t kMany = 0xffff;
  std::uint16_t vertex[8];
};

/// A vertex, and a 0 that makes it half a cache line: it is read in one piece.
struct alignas(32) HullCorner {
  double x, y, z, zero;
};

/// What a hull's support function is quick with, made once with the hull.
class HullSupport {
 public:
  /// From the vertices and, where there are many, the neighbour lists of `hull`, which has to stay
  /// where it is. O(vertices), with some hundred nanoseconds for each cell of a table, of which
  /// there are about three a vertex.
  explicit HullSupport(const ConvexHull& hull);
  HullSupport(const HullSupport&) = delete;  // it points into itself
  HullSupport& operator=(const HullSupport&) = delete;

  /// Coordinates of all vertices side by side, padded to a multiple of eight by copies of vertex 0;
  /// 64-byte aligned. Empty (length 0) where the table is quicker.
  const double* x() const { return x_; }
  const double* y() const { return x() + length_; }
  const double* z() const { return x() + 2 * length_; }
  std::int32_t length() const { return length_; }

  const Vector* points() const { return points_; }
  /// The same, as vector registers take them.
  const HullCorner* corners() const { return corners_.data(); }

  /// The table of directions: cells of the six faces of the cube |d| = 1, sides() along either edge
  /// (scan-inl.h finds a direction's). Empty where there is none.
  std::int32_t sides() const { return sides_; }
  const HullCell* cells() const { return cells_.data(); }

  /// An ellipsoid that is about as the hull is, where there is a table: its middle, and the matrix
  /// S for which it reaches sqrt(n . S n) from there along a unit vector n [m^2].
  const Vector& middle() const { return middle_; }
  const Eigen::Matrix3d& spread() const { return spread_; }

  /// The segment that a needle is about: halfLength() [m] either way from middle() along the unit
  /// vector axis(). Half a length of 0 where the hull is none or has a table; without a table its
  /// middle is about the vertices' mean.
  const Vector& axis() const { return axis_; }
  double halfLength() const { return half_length_; }

  /// The vertices of a cell of many, a multiple of eight; `count` is 0 where they are too many to
  /// look at.
  const HullCell* many(const HullCell& cell, int& count) const {
    count = cell.vertex[1];
    return more_.data() + (cell.vertex[2] + (static_cast<std::size_t>(cell.vertex[3]) << 16U));
  }

  /// A vertex that is about the farthest along the directions of a cell: where to start a climb.
  static int start(const HullCell& cell) {
    return cell.vertex[0] == HullCell::kMany ? cell.vertex[4] : cell.vertex[0];
  }

 private:
  struct alignas(64) Eight {
    double value[8];
  };
  void fillColumns(std::int32_t count);
  void fillCells(const ConvexHull& hull);
  void store(std::vector<std::uint16_t>& candidates);
  void fillEllipsoid(const ConvexHull& hull);
  void fillAxis(const ConvexHull& hull);

  const Vector* points_;
  std::vector<HullCorner> corners_;
  std::vector<Eight> columns_;
  const double* x_ = nullptr;
  std::int32_t length_ = 0;
  std::int32_t sides_ = 0;
  std::vector<HullCell> cells_;
  std::vector<HullCell> more_;
  Vector middle_ = Vector::Zero();
  Eigen::Matrix3d spread_ = Eigen::Matrix3d::Zero();
  Vector axis_ = Vector::UnitX();
  double half_length_ = 0;
};

}  // namespace leeway::collision
