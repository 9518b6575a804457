#include "collision/hull_support.h"

#include "collision/support.h"

namespace leeway::collision {

HullSupport::HullSupport(const ConvexHull& hull) {
  const std::span<const Vector> vertices = hull.vertices();
  const auto count = static_cast<std::int32_t>(vertices.size());
  if (count <= kScanUpTo || !hull.hasNeighbours()) {
    length_ = (count + 7) / 8 * 8;
    columns_.resize(static_cast<std::size_t>(3 * length_ / 8));
    for (std::int32_t i = 0; i < length_; ++i) {
      const Vector& p = vertices[static_cast<std::size_t>(i < count ? i : 0)];
      for (std::int32_t axis = 0; axis < 3; ++axis) {
        const std::int32_t place = axis * length_ + i;
        columns_[static_cast<std::size_t>(place / 8)].value[place % 8] = p[axis];
      }
    }
    return;
  }
  // Each cell's middle, from the answer of the cell before.
  int best = 0;
  for (int face = 0; face < 6; ++face) {
    for (int u = 0; u < kCells; ++u) {
      for (int v = 0; v < kCells; ++v) {
        const int axis = face / 2;
        Vector d;
        d[axis] = face % 2 == 0 ? 1 : -1;
        d[axis == 2 ? 0 : axis + 1] = (u + 0.5) * 2 / kCells - 1;
        d[axis == 0 ? 2 : axis - 1] = (v + 0.5) * 2 / kCells - 1;
        best = climbFarthest(hull, vertices.data(), count, d, best, 0);
        start_.push_back(best);
      }
    }
  }
}

}  // namespace leeway::collision
