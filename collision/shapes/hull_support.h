#pragma once

#include <cstdint>
#include <vector>

#include "collision/base/vector.h"

namespace leeway::collision {

class ConvexHull;

/// Hulls of up to this many vertices are scanned in vector registers; for larger ones, a table of
/// directions lists the few candidates. At 64 vertices, a scan takes 0.8 of the table's time with
/// registers of eight doubles and 0.9 with four (hulls of 64 and of 66) [count].
inline constexpr int kScanUpTo = 64;

/// A cell of the table of directions: for every direction in it, the farthest vertex is one of
/// these. If there are more than eight, the first entry is kMany.
struct alignas(16) HullCell {
  static constexpr std::uint16_t kMany = 0xffff;
  std::uint16_t vertex[8];
};

/// The cells of a table of directions, and the vertices of its kMany cells.
struct HullTable {
  std::vector<HullCell> cells, more;
};

/// A vertex, padded with a 0 to half a cache line: one load reads it.
struct alignas(32) HullCorner {
  double x, y, z, zero;
};

/// Precomputed data of a hull's support function.
class HullSupport {
 public:
  /// Uses the vertices and, if there are many, the neighbour lists of `hull`, which must not move.
  /// O(vertices): a few hundred nanoseconds for each of the table's cells, with about three cells
  /// for each vertex.
  explicit HullSupport(const ConvexHull& hull);
  /// The same with a table from a file, for which isTable() is true. O(vertices).
  HullSupport(const ConvexHull& hull, HullTable table);
  /// Whether a table from a file has the size of this hull's table and lists only its vertices.
  static bool isTable(const HullTable& table, const ConvexHull& hull);
  HullSupport(const HullSupport&) = delete;  // it points into itself
  HullSupport& operator=(const HullSupport&) = delete;

  /// Columns of the vertices' coordinates, padded to a multiple of eight with copies of vertex 0;
  /// 64-byte aligned. Empty (length 0) if the table is faster.
  const double* x() const { return x_; }
  const double* y() const { return x() + length_; }
  const double* z() const { return x() + 2 * length_; }
  std::int32_t length() const { return length_; }

  const Vector* points() const { return points_; }
  /// The vertices, padded for vector loads.
  const HullCorner* corners() const { return corners_.data(); }

  /// The table of directions: each of the six faces of the cube max |d_i| = 1 has sides() x sides()
  /// cells (hull_scan-inl.h finds the cell of a direction). Empty if there is no table.
  std::int32_t sides() const { return sides_; }
  const HullCell* cells() const { return cells_.data(); }

  /// If there is a table: an ellipsoid that approximates the hull, given by its centre [m] and the
  /// matrix S [m^2] with which it reaches sqrt(n . S n) from the centre along a unit vector n.
  const Vector& middle() const { return middle_; }
  const Eigen::Matrix3d& spread() const { return spread_; }

  /// The segment that approximates a needle: halfLength() [m] to either side of middle() along the
  /// unit vector axis(). The half length is 0 if the hull is not a needle or has a table; without a
  /// table, middle() is near the vertices' mean.
  const Vector& axis() const { return axis_; }
  double halfLength() const { return half_length_; }

  /// The vertices of a kMany cell, padded to a multiple of eight; `count` is 0 if there are too
  /// many to scan.
  const HullCell* many(const HullCell& cell, int& count) const {
    count = cell.vertex[1];
    return more_.data() + (cell.vertex[2] + (static_cast<std::size_t>(cell.vertex[3]) << 16U));
  }

  /// A vertex that is nearly the farthest along a cell's directions, as the start of a climb.
  static int start(const HullCell& cell) {
    return cell.vertex[0] == HullCell::kMany ? cell.vertex[4] : cell.vertex[0];
  }

 private:
  struct alignas(64) Eight {
    double value[8];
  };
  friend struct HullFile;
  static bool hasTable(const ConvexHull& hull);
  static std::int32_t sidesFor(std::size_t vertices);
  void fill(const ConvexHull& hull);
  void fillColumns(std::int32_t count);
  void fillCells(const ConvexHull& hull);
  void store(std::vector<std::uint16_t>& candidates);
  void fillEllipsoid(const ConvexHull& hull);
  void fillAxis(const ConvexHull& hull);

  const Vector* points_ = nullptr;
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
