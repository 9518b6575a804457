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

struct Sum {
  double low[kNumbers], high[kNumbers];

  /// += p [box.low, box.high].
  void add(double p, const WideBox& box) {
    const float* lower = p >= 0 ? box.low[0] : box.high[0];
    const float* upper = p >= 0 ? box.high[0] : box.low[0];
    for (int i = 0; i < kNumbers; ++i) low[i] += p * static_cast<double>(lower[i]);
    for (int i = 0; i < kNumbers; ++i) high[i] += p * static_cast<double>(upper[i]);
  }
};

// [-slack, slack] and what is added with `first` times the first box.
Sum sumOf(double slack, const WideBox* boxes, double first, std::span<const double> rest) {
  Sum sum;
  for (int i = 0; i < kNumbers; ++i) sum.low[i] = -slack;
  for (int i = 0; i < kNumbers; ++i) sum.high[i] = slack;
  sum.add(first, *boxes);
  for (const double p : rest) sum.add(p, *++boxes);
  return sum;
}

BlendedMotion::Field meanOf(const std::vector<BlendedMotion::Field>& fields) {
  BlendedMotion::Field mean = fields[0];
  for (std::size_t k = 1; k < fields.size(); ++k) {
    for (std::size_t v = 0; v < mean.size(); ++v) mean[v] += fields[k][v];
  }
  for (Eigen::Vector3d& v : mean) v /= static_cast<double>(fields.size());
  return mean;
}

}  // namespace

BlendedBounds::BlendedBounds(const BlendedMotion& motion, const DeformTree& tree)
    : fields_(motion.fields().size()), has_base_(!motion.base().empty()) {
  base_size_ = largestCoordinate(motion.base());
  for (const BlendedMotion::Field& field : motion.fields())
    field_sizes_.push_back(largestCoordinate(field));
  boxes_.reserve(static_cast<std::size_t>(tree.nodeCount()) * (fields_ + (has_base_ ? 1 : 0)));
  BlendedMotion::Field mean;
  std::vector<BlendedMotion::Field> differences;
  if (!has_base_) {
    mean = meanOf(motion.fields());
    differences = motion.fields();
    for (BlendedMotion::Field& field : differences) {
      for (std::size_t v = 0; v < mean.size(); ++v) field[v] -= mean[v];
    }
  }
  for (std::int32_t node = 0; node < tree.nodeCount(); ++node) {
    if (!has_base_) differences_.push_back(boxOf(mean, tree, node));
    for (const BlendedMotion::Field& field : differences)
      differences_.push_back(boxOf(field, tree, node));
    if (has_base_) boxes_.push_back(boxOf(motion.base(), tree, node));
    for (const BlendedMotion::Field& field : motion.fields())
      boxes_.push_back(boxOf(field, tree, node));
    lanes_.push_back(lanesOf(tree, node));
  }
}

// In exact arithmetic the sums below hold the exact vertices. A vertex as evaluated and each bound
// are off by at most one rounding a product and a sum, of numbers that are at most the sum of
// magnitudes: (fields + 1) units each, so that 4 (fields + 2) cover both and the sum's own. A
// difference from the mean is at most twice as large and one rounding more: 8 (fields + 4) there.
void BlendedBounds::bound(std::int32_t node, std::span<const double> parameters,
                          WideBox& box) const {
  double size = base_size_, total = 0;
  bool turned = false;
  for (std::size_t k = 0; k < fields_; ++k) {
    size += std::abs(parameters[k]) * field_sizes_[k];
    total += parameters[k];
    turned = turned || parameters[k] < 0;
  }
  const double rounding = 8 * (static_cast<double>(fields_) + 4) * kUnitRoundoff * size;
  const auto n = static_cast<std::size_t>(node);
  Sum sum = has_base_ ? sumOf(rounding, &boxes_[n * (fields_ + 1)], 1, parameters)
                      : sumOf(rounding, &boxes_[n * fields_], parameters[0], parameters.subspan(1));
  if (turned && !has_base_) {
    const Sum other = sumOf(rounding, &differences_[n * (fields_ + 1)], total, parameters);
    for (int i = 0; i < kNumbers; ++i) {
      sum.low[i] = std::max(sum.low[i], other.low[i]);
      sum.high[i] = std::min(sum.high[i], other.high[i]);
    }
  }
  const int lanes = lanes_[n];
  for (int axis = 0; axis < 3; ++axis) {
    for (int lane = 0; lane < kWidth; ++lane) {
      const int i = axis * kWidth + lane;
      const bool empty = lane >= lanes;
      box.low[axis][lane] =
          empty ? std::numeric_limits<float>::infinity() : roundedDown(sum.low[i]);
      box.high[axis][lane] =
          empty ? -std::numeric_limits<float>::infinity() : roundedUpToFloat(sum.high[i]);
    }
  }
}

}  // namespace leeway::collision
