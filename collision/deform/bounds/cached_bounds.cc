#include "collision/deform/bounds/cached_bounds.h"

#include <algorithm>
#include <limits>

#include "collision/base/rounding.h"

namespace leeway::collision {

CachedBounds::CachedBounds(const CachedVertices& motion, const DeformTree& tree, std::int32_t nodes)
    : frames_(motion.frameCount()),
      rows_(3 * frames_ * static_cast<std::size_t>(nodes)),
      children_(static_cast<std::size_t>(nodes)) {
  // Backwards, because children have higher numbers than their parents.
  for (std::int32_t node = nodes - 1; node >= 0; --node) {
    const auto n = static_cast<std::size_t>(node);
    for (int column = 0; column < kWidth; ++column) {
      const std::int32_t child = tree.node(node).child[column];
      if (child == DeformTree::kNone) break;  // empty children are last
      ++children_[n];
      const std::span<const std::int32_t> below = tree.vertices(node, column);
      for (std::size_t f = 0; f < frames_; ++f) {
        AxisRow* const rows = &rows_[3 * (n * frames_ + f)];
        const bool known = child >= 0 && child < nodes;
        const AxisRow* const of_child =
            known ? &rows_[3 * (static_cast<std::size_t>(child) * frames_ + f)] : nullptr;
        const int children = known ? children_[static_cast<std::size_t>(child)] : 0;
        const Eigen::Vector3d* const frame = motion.frame(f);
        for (int k = 0; k < 3; ++k) {
          float low = std::numeric_limits<float>::infinity(), high = -low;
          for (int i = 0; i < children; ++i) {
            low = std::min(low, of_child[k].low[i]);
            high = std::max(high, of_child[k].high[i]);
          }
          if (!known) {
            for (const std::int32_t v : below) {
              low = std::min(low, floatBelow(frame[v][k]));
              high = std::max(high, floatAbove(frame[v][k]));
            }
          }
          rows[k].low[column] = low;
          rows[k].high[column] = high;
        }
      }
    }
  }
}

// The ends of boxes are rounded outwards. Products and sums are rounded like those of
// CachedVertices::vertices(), and rounding is monotonic, so no evaluated vertex is outside its box.
void CachedBounds::bound(std::int32_t node, std::span<const double> parameters,
                         WideBox& box) const {
  constexpr std::uint8_t kAllAxes[] = {7, 7};
  const double share = parameters[1];
  const double weights[] = {share > 0 ? 1 - share : 1, share};
  BoxSum sum{};
  const MotionKernels& kernels = motionKernels();
  // There is no frame after the last one.
  kernels.blend(rowsOf(node, parameters), kAllAxes, weights, nullptr, share > 0 ? 2 : 1, sum);
  kernels.put(sum, box);
  box.clear(children_[static_cast<std::size_t>(node)]);
}

void CachedBounds::fetch(std::int32_t node, std::span<const double> parameters) const {
  if (static_cast<std::size_t>(node) >= children_.size()) return;
  const AxisRow* const rows = rowsOf(node, parameters);
  for (int i = 0; i < (parameters[1] > 0 ? 6 : 3); ++i) __builtin_prefetch(rows + i);
}

}  // namespace leeway::collision
