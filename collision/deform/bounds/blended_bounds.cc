#include "collision/deform/bounds/blended_bounds.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "collision/base/numbers.h"
#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/deform/bounds/motion_boxes.h"
#include "collision/deform/motion/motion_input.h"

namespace leeway::collision {
namespace {

// The boxes of a field below a node. Empty columns are 0, because infinity times a weight of 0 is
// NaN.
WideBox boxOf(const BlendedMotion::Field& field, const DeformTree& tree, std::int32_t node) {
  WideBox box{};
  for (int column = 0; column < kWidth; ++column) {
    const std::span<const std::int32_t> vertices = tree.vertices(node, column);
    if (vertices.empty()) break;
    Eigen::Vector3d low = field[static_cast<std::size_t>(vertices[0])], high = low;
    for (const std::int32_t v : vertices) {
      low = low.cwiseMin(field[static_cast<std::size_t>(v)]);
      high = high.cwiseMax(field[static_cast<std::size_t>(v)]);
    }
    for (int k = 0; k < 3; ++k) {
      box.low[k][column] = roundedDown(low[k]);
      box.high[k][column] = roundedUpToFloat(high[k]);
    }
  }
  return box;
}

// The number of a node's children.
std::uint8_t childrenOf(const DeformTree& tree, std::int32_t node) {
  std::uint8_t children = 0;
  while (children < kWidth && tree.node(node).child[children] != DeformTree::kNone) ++children;
  return children;
}

// Starts a sum with [-slack, slack] in every column.
BoxSum sumOf(double slack) {
  BoxSum sum;
  std::fill_n(sum.low, BoxSum::kNumbers, -slack);
  std::fill_n(sum.high, BoxSum::kNumbers, slack);
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

// Diagonal i is axis a plus or minus axis b.
struct Pair {
  int a, b;
  double sign;
};
Pair pairOf(int i) {
  const int a = i / 2;
  return {a, (a + 1) % 3, i % 2 == 0 ? 1.0 : -1.0};
}
// The reciprocal of a diagonal's length.
constexpr double kPerDiagonal = std::numbers::sqrt2 / 2;

double alongDiagonal(const double* p, int i) {
  const Pair d = pairOf(i);
  return p[d.a] + d.sign * p[d.b];
}

// The interval that a body covers along diagonal i, by its box along B's axes and by its box along
// its own axes, grown by `slack`.
Interval reachAlongDiagonal(const Probe& probe, int i, double slack) {
  const Pair d = pairOf(i);
  const auto number = [](float x) { return static_cast<double>(x); };
  const bool plus = d.sign > 0;
  Interval reach{
      number(probe.low[d.a]) + (plus ? number(probe.low[d.b]) : -number(probe.high[d.b])),
      number(probe.high[d.a]) + (plus ? number(probe.high[d.b]) : -number(probe.low[d.b]))};
  Interval own{-slack, slack};
  for (int j = 0; j < 3; ++j) {
    const double n = number(probe.axis[j][d.a]) + d.sign * number(probe.axis[j][d.b]);
    const double low = number(probe.axis_low[j]), high = number(probe.axis_high[j]);
    own.lower += n > 0 ? n * low : n * high;
    own.upper += n > 0 ? n * high : n * low;
  }
  // A NaN (0 times infinity) has no effect here.
  if (own.lower > reach.lower) reach.lower = own.lower;
  if (own.upper < reach.upper) reach.upper = own.upper;
  return reach;
}

// Raises a bound to `lower`, unless that is NaN.
void raise(double lower, float& bound) {
  if (lower > static_cast<double>(bound)) bound = roundedDown(lower);
}

}  // namespace

BlendedBounds::BlendedBounds(const BlendedMotion& motion, const DeformTree& tree,
                             DeformVolume volume, std::int32_t nodes)
    : volume_(volume), fields_(motion.fields().size()), has_base_(!motion.base().empty()) {
  base_size_ = largestCoordinate(motion.base());
  for (const BlendedMotion::Field& field : motion.fields())
    field_sizes_.push_back(largestCoordinate(field));
  // The mean of the fields may be as large as the largest of them.
  if (!has_base_) {
    const double largest = *std::max_element(field_sizes_.begin(), field_sizes_.end());
    std::fill(field_sizes_.begin(), field_sizes_.end(), largest);
  }
  std::vector<const BlendedMotion::Field*> all;
  if (has_base_) all.push_back(&motion.base());
  for (const BlendedMotion::Field& field : motion.fields()) all.push_back(&field);
  std::vector<BlendedMotion::Field> differences;  // the mean, then each field minus the mean
  if (!has_base_ && volume != DeformVolume::kBall) {
    differences.push_back(meanOf(motion.fields()));
    for (const BlendedMotion::Field& field : motion.fields()) {
      differences.push_back(field);
      for (std::size_t v = 0; v < field.size(); ++v) differences.back()[v] -= differences[0][v];
    }
  }
  for (const BlendedMotion::Field& field : differences) differences_.addField(field);
  if (volume != DeformVolume::kBall) {
    for (const BlendedMotion::Field* field : all) boxes_.addField(*field);
  }
  for (std::int32_t node = 0; node < nodes; ++node) {
    children_.push_back(childrenOf(tree, node));
    if (volume == DeformVolume::kBall) {
      for (const BlendedMotion::Field* field : all) balls_.push_back(ballsOf(*field, tree, node));
      continue;
    }
    for (std::size_t i = 0; i < differences.size(); ++i)
      differences_.addNode(differences[i], i, tree, node);
    for (std::size_t i = 0; i < all.size(); ++i) {
      boxes_.addNode(*all[i], i, tree, node);
      if (volume == DeformVolume::kDop) diagonals_.push_back(diagonalsOf(*all[i], tree, node));
    }
  }
}

void BlendedBounds::Boxes::addField(const BlendedMotion::Field& field) {
  unsigned there = 0;
  for (const Eigen::Vector3d& v : field) {
    for (int k = 0; k < 3; ++k) there |= v[k] != 0 ? 1U << k : 0U;
  }
  axes.push_back(static_cast<std::uint8_t>(there));
  rows_a_node += static_cast<std::size_t>(std::popcount(there));
}

void BlendedBounds::Boxes::addNode(const BlendedMotion::Field& field, std::size_t number,
                                   const DeformTree& tree, std::int32_t node) {
  const WideBox box = boxOf(field, tree, node);
  for (int k = 0; k < 3; ++k) {
    if ((axes[number] >> k & 1) == 0) continue;
    AxisRow& row = rows.emplace_back();
    std::copy_n(box.low[k], kWidth, row.low);
    std::copy_n(box.high[k], kWidth, row.high);
  }
}

void BlendedBounds::Boxes::fetch(std::int32_t node) const {
  const std::size_t first = static_cast<std::size_t>(node) * rows_a_node;
  if (first >= rows.size()) return;
  for (std::size_t i = 0; i < rows_a_node; ++i) __builtin_prefetch(&rows[first + i]);
}

void BlendedBounds::Boxes::blend(std::int32_t node, const double* first, std::span<const double> to,
                                 std::span<const double> from, BoxSum& sum) const {
  const MotionKernels& kernels = motionKernels();
  const AxisRow* row = rows.data() + static_cast<std::size_t>(node) * rows_a_node;
  const std::size_t others = axes.size() - to.size();  // 1 or none
  if (first != nullptr) kernels.blend(row, axes.data(), first, nullptr, others, sum);
  if (others > 0) row += std::popcount(axes[0]);
  kernels.blend(row, axes.data() + others, to.data(), from.empty() ? nullptr : from.data(),
                to.size(), sum);
}

// Outward rounding to float covers the rounding of the sum of two doubles.
BlendedBounds::Diagonals BlendedBounds::diagonalsOf(const BlendedMotion::Field& field,
                                                    const DeformTree& tree, std::int32_t node) {
  Diagonals result{};
  for (int column = 0; column < kWidth; ++column) {
    const std::span<const std::int32_t> vertices = tree.vertices(node, column);
    if (vertices.empty()) break;
    for (int i = 0; i < kDiagonals; ++i) {
      double low = kInfinity, high = -kInfinity;
      for (const std::int32_t v : vertices) {
        const double along = alongDiagonal(field[static_cast<std::size_t>(v)].data(), i);
        low = std::min(low, along);
        high = std::max(high, along);
      }
      result.low[i][column] = roundedDown(low);
      result.high[i][column] = roundedUpToFloat(high);
    }
  }
  return result;
}

// Balls are centred in the boxes. Radii are measured from the stored centres, so their rounding is
// covered.
BlendedBounds::Balls BlendedBounds::ballsOf(const BlendedMotion::Field& field,
                                            const DeformTree& tree, std::int32_t node) {
  Balls result{};
  const WideBox box = boxOf(field, tree, node);
  for (int column = 0; column < kWidth; ++column) {
    const std::span<const std::int32_t> vertices = tree.vertices(node, column);
    if (vertices.empty()) break;
    Eigen::Vector3d center;
    for (int k = 0; k < 3; ++k) {
      result.center[k][column] = 0.5F * box.low[k][column] + 0.5F * box.high[k][column];
      center[k] = static_cast<double>(result.center[k][column]);
    }
    double squared = 0;
    for (const std::int32_t v : vertices)
      squared = std::max(squared, (field[static_cast<std::size_t>(v)] - center).squaredNorm());
    result.radius[column] = roundedUpToFloat(std::sqrt(squared));
  }
  return result;
}

void BlendedBounds::bound(std::int32_t node, std::span<const double> parameters,
                          WideBox& box) const {
  if (volume_ != DeformVolume::kBall) {
    boundBoxes(node, parameters, box);
    return;
  }
  box.clear();
  const BlendedBalls balls = blendBalls(node, parameters);
  for (int column = 0; column < children_[static_cast<std::size_t>(node)]; ++column) {
    for (int k = 0; k < 3; ++k) {
      box.low[k][column] = roundedDown(balls.center[k][column] - balls.radius[column]);
      box.high[k][column] = roundedUpToFloat(balls.center[k][column] + balls.radius[column]);
    }
  }
}

// In exact arithmetic the sums below contain the exact vertices. With n fields, in units of
// kUnitRoundoff times the sum of magnitudes (`size`):
//   - an evaluated vertex and each bound are off by one rounding for each product and sum, n + 1
//     each; 4 (n + 2) cover both and the addition of the slack;
//   - a difference from the mean is at most twice as large, with one more rounding, and a diagonal
//     adds two coordinates: 8 (n + 4);
//   - the errors of a vertex and of a ball's centre are sqrt(3) times as long, and a radius is at
//     most 2 sqrt(3) times the largest coordinate: 7 (n + 2) in all.
double BlendedBounds::rounding(std::span<const double> parameters) const {
  double size = base_size_;
  for (std::size_t k = 0; k < fields_; ++k) size += std::abs(parameters[k]) * field_sizes_[k];
  return 8 * (static_cast<double>(fields_) + 4) * kUnitRoundoff * size;
}

void BlendedBounds::boundBoxes(std::int32_t node, std::span<const double> parameters,
                               WideBox& box) const {
  double total = 0;
  bool turned = false;
  for (std::size_t k = 0; k < fields_; ++k) {
    total += parameters[k];
    turned = turned || parameters[k] < 0;
  }
  const double slack = rounding(parameters);
  BoxSum sum = sumOf(slack);
  const double one = 1;
  boxes_.blend(node, &one, parameters, {}, sum);
  if (turned && !has_base_) {
    BoxSum other = sumOf(slack);
    differences_.blend(node, &total, parameters, {}, other);
    for (int i = 0; i < BoxSum::kNumbers; ++i) {
      sum.low[i] = std::max(sum.low[i], other.low[i]);
      sum.high[i] = std::min(sum.high[i], other.high[i]);
    }
  }
  motionKernels().put(sum, box);
  box.clear(children_[static_cast<std::size_t>(node)]);
}

// The difference of two sums is the sum with the differences of the parameters. Each of the two
// sums is off by its rounding(). The differences are at most as large as both together, so they are
// off by the sum of these.
void BlendedBounds::displacement(std::int32_t node, std::span<const double> from,
                                 std::span<const double> to, double rounding, WideBox& box) const {
  (has_base_ ? boxes_ : differences_).fetch(node + kNodesAhead);
  BoxSum sum = sumOf(rounding);
  if (has_base_) {
    boxes_.blend(node, nullptr, to, from, sum);
  } else {
    double total = 0;
    for (std::size_t k = 0; k < fields_; ++k) total += to[k] - from[k];
    differences_.blend(node, &total, to, from, sum);
  }
  motionKernels().put(sum, box);
}

double BlendedBounds::displacementRounding(std::span<const double> from,
                                           std::span<const double> to) const {
  return rounding(from) + rounding(to);
}

std::size_t BlendedBounds::bytes() const {
  std::size_t bytes = sizeof(*this) + diagonals_.capacity() * sizeof(Diagonals) +
                      balls_.capacity() * sizeof(Balls) + children_.capacity() +
                      field_sizes_.capacity() * sizeof(double);
  for (const Boxes* boxes : {&boxes_, &differences_})
    bytes += boxes->axes.capacity() + boxes->rows.capacity() * sizeof(AxisRow);
  return bytes;
}

BlendedBounds::BlendedBalls BlendedBounds::blendBalls(std::int32_t node,
                                                      std::span<const double> parameters) const {
  BlendedBalls sum{};
  const double slack = rounding(parameters);
  for (double& radius : sum.radius) radius = slack;
  const Balls* balls = &balls_[static_cast<std::size_t>(node) * volumesOfNode()];
  for (std::size_t i = 0; i < volumesOfNode(); ++i) {
    const double p = weight(parameters, i);
    for (int column = 0; column < kWidth; ++column) {
      for (int k = 0; k < 3; ++k)
        sum.center[k][column] += p * static_cast<double>(balls[i].center[k][column]);
      sum.radius[column] += std::abs(p) * static_cast<double>(balls[i].radius[column]);
    }
  }
  return sum;
}

void BlendedBounds::tighten(std::int32_t node, std::span<const double> parameters,
                            const Probe& probe, WideBounds& bounds) const {
  if (volume_ == DeformVolume::kDop) tightenByDiagonals(node, parameters, probe, bounds);
  if (volume_ == DeformVolume::kBall) tightenByBalls(node, parameters, probe, bounds);
}

// The body's own axes in single precision are off by less than 2^-22 in all. The body's coordinates
// along them are off by that times a size, where probe.slack is 2^-19 of that size. If the axes
// depart from a rotation as far as allowed, the error doubles. Four times the slack covers both.
void BlendedBounds::tightenByDiagonals(std::int32_t node, std::span<const double> parameters,
                                       const Probe& probe, WideBounds& bounds) const {
  double low[kDiagonals][kWidth], high[kDiagonals][kWidth];
  const double slack = rounding(parameters);
  for (int i = 0; i < kDiagonals; ++i) {
    for (int column = 0; column < kWidth; ++column) {
      low[i][column] = -slack;
      high[i][column] = slack;
    }
  }
  const Diagonals* diagonals = &diagonals_[static_cast<std::size_t>(node) * volumesOfNode()];
  for (std::size_t f = 0; f < volumesOfNode(); ++f) {
    const double p = weight(parameters, f);
    const auto& lower = p >= 0 ? diagonals[f].low : diagonals[f].high;
    const auto& upper = p >= 0 ? diagonals[f].high : diagonals[f].low;
    for (int i = 0; i < kDiagonals; ++i) {
      for (int column = 0; column < kWidth; ++column) {
        low[i][column] += p * static_cast<double>(lower[i][column]);
        high[i][column] += p * static_cast<double>(upper[i][column]);
      }
    }
  }
  const double body_slack = static_cast<double>(probe.slack);
  const double grown = static_cast<double>(probe.radius) + body_slack;
  for (int i = 0; i < kDiagonals; ++i) {
    const Interval across = reachAlongDiagonal(probe, i, 4 * body_slack);
    for (int column = 0; column < children_[static_cast<std::size_t>(node)]; ++column) {
      double gap = std::max(low[i][column] - across.upper, across.lower - high[i][column]);
      if (!(gap >= -kInfinity)) continue;  // NaN: both are infinite
      gap *= kPerDiagonal;
      raise(gap - std::abs(gap) * kRotationTolerance - grown, bounds.lower[column]);
    }
  }
}

// A centre within the body's box proves nothing about depth.
void BlendedBounds::tightenByBalls(std::int32_t node, std::span<const double> parameters,
                                   const Probe& probe, WideBounds& bounds) const {
  const BlendedBalls balls = blendBalls(node, parameters);
  const double grown = static_cast<double>(probe.radius) + static_cast<double>(probe.slack);
  for (int column = 0; column < children_[static_cast<std::size_t>(node)]; ++column) {
    double squared = 0;
    for (int j = 0; j < 3; ++j) {
      double along = 0;
      for (int k = 0; k < 3; ++k)
        along += static_cast<double>(probe.axis[j][k]) * balls.center[k][column];
      const double outside = std::max({along - static_cast<double>(probe.axis_high[j]),
                                       static_cast<double>(probe.axis_low[j]) - along, 0.0});
      squared += outside * outside;
    }
    if (!(squared > 0)) continue;
    // Axes that depart from a rotation overstate distances.
    raise(std::sqrt(squared) * (1 - kRotationTolerance) - balls.radius[column] - grown,
          bounds.lower[column]);
  }
}

}  // namespace leeway::collision
