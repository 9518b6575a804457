#include "collision/deform/bounds/skinned_bounds.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/base/prefetch.h"
#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/deform/motion/motion_input.h"

// clang-format off
// A vertex with rest position r, in the box c +- e of its node, goes to
//
//     x = sum_b w_b T_b r,   sum_b w_b = 1,   T_b affine (bone b's matrix).
//
// (1) Around the mean. With m_b near the weights of all vertices of the node, |w_b - m_b| <= h_b
// and sum_b m_b = 1, and with the mean map M = sum_b m_b T_b,
//
//     x = M r + sum_b (w_b - m_b) T_b r = M r + sum_b (w_b - m_b) (T_b - M) r,
//
// because the differences of the weights add up to 0. A skin bends where weights change along it:
// with any gradients g_b, w_b - m_b = g_b . (r - c) + f_b. T_b - M is affine, too, with the linear
// part L_b = R_b - R_M, so that with d = r - c and D_b = T_b c - M c
//
//     x = M c + (R_M + sum_b D_b g_b^T) d + sum_b f_b D_b + sum_b (w_b - m_b) L_b d,
//     x in  M c +- ( |R_M + sum_b D_b g_b^T| e + sum_b |f_b| |D_b| + sum_b h_b |L_b| e ).
//
// The first term is exact where weights are linear in the rest position; the others are of second
// order in the size of the node, however far apart the bones are. Kavan and Zara's sphere is this
// with a ball for the box and without gradients; their convex combination of the bones' images of
// the centre is M c.
//
// (2) Around the bones. x is a convex combination of the images T_b r, each within T_b c +- |R_b| e:
// it is in the box around these boxes, over the bones that carry vertices of the node. Better for
// large nodes, where weights range from 0 to 1.
//
// Both hold, so their intersection does.
// clang-format on

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

// A bound on |coordinates| of T r for rest positions with |coordinates| up to `reach`. T: rotation
// row by row, then the translation.
double sizeOf(const double* T, double reach) {
  double size = 0;
  for (int k = 0; k < 3; ++k) {
    const double turned = std::abs(T[3 * k]) + std::abs(T[3 * k + 1]) + std::abs(T[3 * k + 2]);
    size = std::max(size, std::abs(T[9 + k]) + reach * turned);
  }
  return size;
}

}  // namespace

SkinnedBounds::SkinnedBounds(const SkinnedVertices& motion, const DeformTree& tree,
                             std::int32_t nodes) {
  rest_size_ = largestCoordinate(motion.rest());
  first_part_.push_back(0);
  for (std::int32_t node = 0; node < nodes; ++node) {
    std::uint8_t children = 0;
    SkinRest rest{};
    for (; children < kWidth; ++children) {
      const std::span<const std::int32_t> vertices = tree.vertices(node, children);
      if (vertices.empty()) break;
      Vector3d low = motion.rest()[static_cast<std::size_t>(vertices[0])], high = low;
      for (const std::int32_t v : vertices) {
        low = low.cwiseMin(motion.rest()[static_cast<std::size_t>(v)]);
        high = high.cwiseMax(motion.rest()[static_cast<std::size_t>(v)]);
      }
      for (int k = 0; k < 3; ++k) {
        const double center = 0.5 * (low[k] + high[k]);
        rest.center[k][children] = center;
        // Four units cover the rounding of the difference.
        rest.half[k][children] =
            std::max(high[k] - center, center - low[k]) * (1 + 4 * kUnitRoundoff);
      }
    }
    rest_.push_back(rest);
    children_.push_back(children);
    addParts(motion, tree, node);
    first_part_.push_back(static_cast<std::int32_t>(parts_.size()));
    terms_ = std::max(
        terms_, static_cast<double>(first_part_.back() - first_part_[first_part_.size() - 2]));
  }
  for (int v = 0; v < motion.vertexCount(); ++v)
    terms_ = std::max(terms_, static_cast<double>(motion.influences(v).size()));
}

void SkinnedBounds::addParts(const SkinnedVertices& motion, const DeformTree& tree,
                             std::int32_t node) {
  // Least and largest weight of every bone in every column. A bone has weight 0 at vertices that it
  // does not carry.
  struct Seen {
    std::int32_t bone;
    double least[kWidth], largest[kWidth];
    std::size_t count[kWidth];
  };
  std::vector<Seen> seen;
  std::vector<int> place(static_cast<std::size_t>(motion.boneCount()), -1);
  for (int column = 0; column < kWidth; ++column) {
    for (const std::int32_t v : tree.vertices(node, column)) {
      for (const SkinnedVertices::Influence& influence : motion.influences(v)) {
        if (!(influence.weight > 0)) continue;
        int& at = place[static_cast<std::size_t>(influence.bone)];
        if (at < 0) {
          at = static_cast<int>(seen.size());
          seen.push_back({influence.bone, {}, {}, {}});
          std::fill_n(seen.back().least, kWidth, kInfinity);
        }
        Seen& s = seen[static_cast<std::size_t>(at)];
        s.least[column] = std::min(s.least[column], influence.weight);
        s.largest[column] = std::max(s.largest[column], influence.weight);
        ++s.count[column];
      }
    }
  }
  std::sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) { return a.bone < b.bone; });
  const std::size_t begin = parts_.size();
  for (const Seen& s : seen) {
    SkinPart part{s.bone, {}, {}, {}, {}};
    for (int column = 0; column < kWidth; ++column) {
      const double least =
          s.count[column] == tree.vertices(node, column).size() ? s.least[column] : 0;
      part.mean[column] = 0.5 * (least + s.largest[column]);
      part.range[column] = 0.5 * (s.largest[column] - least);
    }
    parts_.push_back(part);
  }
  // Makes the means sum to 1: the bones of the column share the missing part equally.
  for (int column = 0; column < kWidth; ++column) {
    double sum = 0, bones = 0;
    for (std::size_t i = begin; i < parts_.size(); ++i) {
      sum += parts_[i].mean[column];
      bones += parts_[i].mean[column] > 0 ? 1 : 0;
    }
    if (bones == 0) continue;
    const double missing = (1 - sum) / bones;
    for (std::size_t i = begin; i < parts_.size(); ++i) {
      if (!(parts_[i].mean[column] > 0)) continue;
      const double moved = parts_[i].mean[column] + missing;
      parts_[i].range[column] =
          (parts_[i].range[column] + std::abs(missing)) * (1 + 8 * kUnitRoundoff) +
          4 * kUnitRoundoff;
      parts_[i].mean[column] = moved;
    }
    fitGradients(motion, tree.vertices(node, column), column,
                 std::span<SkinPart>(parts_).subspan(begin));
  }
}

// Least squares, regularised where the vertices do not span all directions. Any gradient is
// correct, because the bound uses its residue, which includes the rounding of these sums.
void SkinnedBounds::fitGradients(const SkinnedVertices& motion,
                                 std::span<const std::int32_t> vertices, int column,
                                 std::span<SkinPart> parts) const {
  const SkinRest& rest = rest_.back();
  const Vector3d center(rest.center[0][column], rest.center[1][column], rest.center[2][column]);
  const auto offset = [&](std::int32_t v) -> Vector3d {
    return motion.rest()[static_cast<std::size_t>(v)] - center;
  };
  const auto weight = [&](std::int32_t v, std::int32_t bone) {
    for (const SkinnedVertices::Influence& influence : motion.influences(v)) {
      if (influence.bone == bone) return influence.weight;
    }
    return 0.0;
  };
  double reach = 0;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const std::int32_t v : vertices) {
    const Vector3d d = offset(v);
    spread += d * d.transpose();
    reach = std::max(reach, d.lpNorm<1>());
  }
  spread += (1e-6 * spread.trace() + 1e-200) * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d inverse = spread.inverse();
  for (SkinPart& part : parts) {
    part.residue[column] = part.range[column];
    if (!(part.range[column] > 0)) continue;
    Vector3d sum = Vector3d::Zero();
    for (const std::int32_t v : vertices)
      sum += (weight(v, part.bone) - part.mean[column]) * offset(v);
    const Vector3d gradient = inverse * sum;
    double residue = 0;
    for (const std::int32_t v : vertices) {
      const Vector3d d = offset(v);
      const double linear = gradient.x() * d.x() + gradient.y() * d.y() + gradient.z() * d.z();
      residue = std::max(residue, std::abs(weight(v, part.bone) - part.mean[column] - linear));
    }
    residue += 16 * kUnitRoundoff * (1 + gradient.lpNorm<1>() * (reach + 2 * center.lpNorm<1>()));
    // With a NaN the gradient stays 0, and also if it is steep, because a steep gradient would cost
    // digits.
    const double across = std::abs(gradient.x()) * rest.half[0][column] +
                          std::abs(gradient.y()) * rest.half[1][column] +
                          std::abs(gradient.z()) * rest.half[2][column];
    if (!(residue < part.range[column] && across <= kSteepestWeight)) continue;
    part.residue[column] = residue;
    for (int k = 0; k < 3; ++k) part.gradient[k][column] = gradient[k];
  }
}

// Rounding: every number here and in the evaluation of a vertex is at most `size` (boundBy()) and a
// sum of up to terms_ + 12 products. Means and weights sum to 1 within terms_ + 2 units each, which
// moves x by that share of the size. A gradient changes a weight by at most kSteepestWeight over a
// node. 64 (terms_ + 12) units for each part, and four more parts, cover all of this.
void SkinnedBounds::bound(std::int32_t node, std::span<const double> parameters,
                          WideBox& box) const {
  boundBy(node, parameters, {}, box);
  box.clear(children_[static_cast<std::size_t>(node)]);
}

// A vertex moves from sum w_b S_b r to sum w_b T_b r, that is by sum w_b (T_b - S_b) r; the
// derivation above does not need rigid bones. Both ends are off by their own rounding, and a
// difference is at most as large as both numbers together.
void SkinnedBounds::displacement(std::int32_t node, std::span<const double> from,
                                 std::span<const double> to, double /*rounding*/,
                                 WideBox& box) const {
  fetch(node + kNodesAhead);
  boundBy(node, to, from, box);
}

// boundBy() computes the rounding of each node, which is far less than that of all bones.
double SkinnedBounds::displacementRounding(std::span<const double> /*from*/,
                                           std::span<const double> /*to*/) const {
  return 0;
}

void SkinnedBounds::fetch(std::int32_t node) const {
  const auto n = static_cast<std::size_t>(node);
  if (n >= rest_.size()) return;
  prefetch(&rest_[n], sizeof(SkinRest));
  const std::int32_t begin = first_part_[n], end = first_part_[n + 1];
  prefetch(parts_.data() + begin, static_cast<std::size_t>(end - begin) * sizeof(SkinPart));
}

void SkinnedBounds::boundBy(std::int32_t node, std::span<const double> to,
                            std::span<const double> from, WideBox& box) const {
  const auto n = static_cast<std::size_t>(node);
  const std::span<const SkinPart> parts(parts_.data() + first_part_[n],
                                        parts_.data() + first_part_[n + 1]);
  double size = 0;
  for (const SkinPart& part : parts) {
    const std::size_t first = 12 * static_cast<std::size_t>(part.bone);
    size = std::max(size, sizeOf(&to[first], rest_size_) +
                              (from.empty() ? 0 : sizeOf(&from[first], rest_size_)));
  }
  const double rounding =
      64 * (terms_ + 12) * (static_cast<double>(parts.size()) + 4) * kUnitRoundoff * size;
  motionKernels().skin(rest_[n], parts, to.data(), from.empty() ? nullptr : from.data(), rounding,
                       box);
}

}  // namespace leeway::collision
