#include "collision/blended_bounds.h"

#include <algorithm>
#include <cmath>

#include "collision/motion_input.h"
#include "collision/round_box.h"
#include "leeway/collision/tolerances.h"

namespace leeway::collision {
namespace {

// Zeros where a lane is empty, so that no infinity meets a weight of 0.
WideBox boxOf(const BlendedMotion::Field& field, const DeformTree& tree, std::int32_t node) {
  WideBox box{};
  for (int lane = 0; lane < kWidth; ++lane) {
    const std::span<const std::int32_t> vertices = tree.vertices(node, lane);
    if (vertices.empty()) break;
    Eigen::Vector3d low = field[static_cast<std::size_t>(vertices[0])], high = low;
    for (const std::int32_t v : vertices) {
      low = low.cwiseMin(field[static_cast<std::size_t>(v)]);
      high = high.cwiseMax(field[static_cast<std::size_t>(v)]);
    }
    for (int k = 0; k < 3; ++k) {
      box.low[k][lane] = roundedDown(low[k]);
      box.high[k][lane] = roundedUpToFloat(high[k]);
    }
  }
  return box;
}

/// Children of a node stand before its empty lanes.
std::uint8_t lanesOf(const DeformTree& tree, std::int32_t node) {
  std::uint8_t lanes = 0;
  while (lanes < kWidth && tree.node(node).child[lanes] != DeformTree::kNone) ++lanes;
  return lanes;
}

constexpr int kNumbers = 3 * kWidth;

// a += p [low, high], a number p that is not negative.
void addScaled(double p, const float* low, const float* high, double* sum_low, double* sum_high) {
  for (int i = 0; i < kNumbers; ++i) sum_low[i] += p * static_cast<double>(low[i]);
  for (int i = 0; i < kNumbers; ++i) sum_high[i] += p * static_cast<double>(high[i]);
}

}  // namespace

BlendedBounds::BlendedBounds(const BlendedMotion& motion, const DeformTree& tree)
    : fields_(motion.fields().size()), has_base_(!motion.base().empty()) {
  base_size_ = largestCoordinate(motion.base());
  for (const BlendedMotion::Field& field : motion.fields())
    field_sizes_.push_back(largestCoordinate(field));
  boxes_.reserve(static_cast<std::size_t>(tree.nodeCount()) * (fields_ + (has_base_ ? 1 : 0)));
  for (std::int32_t node = 0; node < tree.nodeCount(); ++node) {
    if (has_base_) boxes_.push_back(boxOf(motion.base(), tree, node));
    for (const BlendedMotion::Field& field : motion.fields())
      boxes_.push_back(boxOf(field, tree, node));
    lanes_.push_back(lanesOf(tree, node));
  }
}

// In exact arithmetic the sum below holds the exact vertices. A vertex as evaluated and each bound
// are off by at most one rounding a product and a sum, of numbers that are at most the sum of
// magnitudes: (fields + 1) units each, so that 4 (fields + 2) cover both and the sum's own.
void BlendedBounds::bound(std::int32_t node, std::span<const double> parameters,
                          WideBox& box) const {
  double size = base_size_;
  for (std::size_t k = 0; k < fields_; ++k) size += std::abs(parameters[k]) * field_sizes_[k];
  const double rounding = 4 * (static_cast<double>(fields_) + 2) * kUnitRoundoff * size;

  const std::size_t stride = fields_ + (has_base_ ? 1 : 0);
  const WideBox* from = boxes_.data() + static_cast<std::size_t>(node) * stride;
  double low[kNumbers], high[kNumbers];
  for (int i = 0; i < kNumbers; ++i) low[i] = -rounding;
  for (int i = 0; i < kNumbers; ++i) high[i] = rounding;
  if (has_base_) {
    addScaled(1, from->low[0], from->high[0], low, high);
    ++from;
  }
  for (std::size_t k = 0; k < fields_; ++k, ++from) {
    if (parameters[k] >= 0) {
      addScaled(parameters[k], from->low[0], from->high[0], low, high);
    } else {
      addScaled(parameters[k], from->high[0], from->low[0], low, high);
    }
  }
  const int lanes = lanes_[static_cast<std::size_t>(node)];
  for (int axis = 0; axis < 3; ++axis) {
    for (int lane = 0; lane < kWidth; ++lane) {
      const int i = axis * kWidth + lane;
      const bool empty = lane >= lanes;
      box.low[axis][lane] = empty ? std::numeric_limits<float>::infinity() : roundedDown(low[i]);
      box.high[axis][lane] =
          empty ? -std::numeric_limits<float>::infinity() : roundedUpToFloat(high[i]);
    }
  }
}

}  // namespace leeway::collision
