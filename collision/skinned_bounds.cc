#include "collision/skinned_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/motion_input.h"
#include "collision/round_box.h"
#include "leeway/collision/tolerances.h"

// A vertex with rest position r, in the box c +- e of its node, goes to
//
//     x = sum_b w_b T_b r,   sum_b w_b = 1,   T_b affine (bone b's matrix).
//
// (1) Around the mean. With m_b near the weights of all vertices of the node, |w_b - m_b| <= h_b
// and sum_b m_b = 1, and with the mean map M = sum_b m_b T_b,
//
//     x = M r + sum_b (w_b - m_b) T_b r = M r + sum_b (w_b - m_b) (T_b - M) r,
//
// because the differences of the weights add up to 0. T_b - M is affine, too: over the rest box it
// stays, coordinate by coordinate, within |(T_b - M) c| + |R_b - R_M| e of 0. So
//
//     x in  M c +- ( |R_M| e + sum_b h_b ( |T_b c - M c| + |R_b - R_M| e ) ).
//
// One bone alone (h = 0) leaves the turned rest box; small nodes, whose weights hardly differ, come
// close to it however far their bones are apart. Kavan and Zara's sphere is this with a ball for
// the box, their convex combination of the bones' images of its centre being M c.
//
// (2) Around the bones. x is a convex combination of the images T_b r, each within T_b c +- |R_b|
// e: it is in the box around these boxes, of the bones that have a part in the node. This is the
// better one for large nodes, where weights range from 0 to 1.
//
// Both hold, so their intersection does.

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Matrix {
  const double* numbers;  // rotation row by row, then the translation
  double linear(int row, int column) const { return numbers[3 * row + column]; }
  double translation(int row) const { return numbers[9 + row]; }
};

}  // namespace

SkinnedBounds::SkinnedBounds(const SkinnedVertices& motion, const DeformTree& tree) {
  rest_size_ = largestCoordinate(motion.rest());
  first_part_.push_back(0);
  for (std::int32_t node = 0; node < tree.nodeCount(); ++node) {
    std::uint8_t lanes = 0;
    Lanes rest{};
    for (; lanes < kWidth; ++lanes) {
      const std::span<const std::int32_t> vertices = tree.vertices(node, lanes);
      if (vertices.empty()) break;
      Vector3d low = motion.rest()[static_cast<std::size_t>(vertices[0])], high = low;
      for (const std::int32_t v : vertices) {
        low = low.cwiseMin(motion.rest()[static_cast<std::size_t>(v)]);
        high = high.cwiseMax(motion.rest()[static_cast<std::size_t>(v)]);
      }
      for (int k = 0; k < 3; ++k) {
        const double center = 0.5 * (low[k] + high[k]);
        rest.center[k][lanes] = center;
        // Two units cover the rounding of the difference.
        rest.half[k][lanes] = std::max(high[k] - center, center - low[k]) * (1 + 4 * kUnitRoundoff);
      }
    }
    rest_.push_back(rest);
    lanes_.push_back(lanes);
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
  // Least and largest weight of every bone in every lane; a vertex that a bone does not carry
  // counts with 0.
  struct Seen {
    std::int32_t bone;
    double least[kWidth], largest[kWidth];
    std::size_t count[kWidth];
  };
  std::vector<Seen> seen;
  std::vector<int> place(static_cast<std::size_t>(motion.boneCount()), -1);
  for (int lane = 0; lane < kWidth; ++lane) {
    for (const std::int32_t v : tree.vertices(node, lane)) {
      for (const SkinnedVertices::Influence& influence : motion.influences(v)) {
        if (!(influence.weight > 0)) continue;
        int& at = place[static_cast<std::size_t>(influence.bone)];
        if (at < 0) {
          at = static_cast<int>(seen.size());
          seen.push_back({influence.bone, {}, {}, {}});
          std::fill_n(seen.back().least, kWidth, kInfinity);
        }
        Seen& s = seen[static_cast<std::size_t>(at)];
        s.least[lane] = std::min(s.least[lane], influence.weight);
        s.largest[lane] = std::max(s.largest[lane], influence.weight);
        ++s.count[lane];
      }
    }
  }
  std::sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) { return a.bone < b.bone; });
  const std::size_t begin = parts_.size();
  for (const Seen& s : seen) {
    Part part{s.bone, {}, {}};
    for (int lane = 0; lane < kWidth; ++lane) {
      const double least = s.count[lane] == tree.vertices(node, lane).size() ? s.least[lane] : 0;
      part.mean[lane] = 0.5 * (least + s.largest[lane]);
      part.range[lane] = 0.5 * (s.largest[lane] - least);
    }
    parts_.push_back(part);
  }
  // The means must add up to 1: what is missing goes to the bones of the lane in equal shares.
  for (int lane = 0; lane < kWidth; ++lane) {
    double sum = 0, bones = 0;
    for (std::size_t i = begin; i < parts_.size(); ++i) {
      sum += parts_[i].mean[lane];
      bones += parts_[i].mean[lane] > 0 ? 1 : 0;
    }
    if (bones == 0) continue;
    const double missing = (1 - sum) / bones;
    for (std::size_t i = begin; i < parts_.size(); ++i) {
      if (!(parts_[i].mean[lane] > 0)) continue;
      const double moved = parts_[i].mean[lane] + missing;
      parts_[i].range[lane] =
          (parts_[i].range[lane] + std::abs(missing)) * (1 + 8 * kUnitRoundoff) + 4 * kUnitRoundoff;
      parts_[i].mean[lane] = moved;
    }
  }
}

// Rounding: every number here and in a vertex's evaluation is at most the size below, made of sums
// of up to terms_ + 12 products; the means and the weights add up to 1 within terms_ + 2 units
// each, which moves x by that share of the size. 64 (terms_ + 12) units cover the sum of all.
void SkinnedBounds::bound(std::int32_t node, std::span<const double> parameters,
                          WideBox& box) const {
  const auto n = static_cast<std::size_t>(node);
  const Lanes& rest = rest_[n];
  const std::span<const Part> parts(parts_.data() + first_part_[n],
                                    parts_.data() + first_part_[n + 1]);
  const auto matrixOf = [&](const Part& part) {
    return Matrix{parameters.data() + 12 * static_cast<std::size_t>(part.bone)};
  };
  double size = 0;
  for (const Part& part : parts) {
    const Matrix T = matrixOf(part);
    for (int k = 0; k < 3; ++k) {
      size = std::max(size, std::abs(T.translation(k)) +
                                rest_size_ * (std::abs(T.linear(k, 0)) + std::abs(T.linear(k, 1)) +
                                              std::abs(T.linear(k, 2))));
    }
  }
  const double rounding = 64 * (terms_ + 12) * kUnitRoundoff * size;

  const int lanes = lanes_[n];
  for (int row = 0; row < 3; ++row) {
    double center[kWidth] = {}, linear[3][kWidth] = {};  // of the mean map
    double low[kWidth], high[kWidth];                    // around the bones
    std::fill_n(low, kWidth, kInfinity);
    std::fill_n(high, kWidth, -kInfinity);
    for (const Part& part : parts) {
      const Matrix T = matrixOf(part);
      const double x = T.linear(row, 0), y = T.linear(row, 1), z = T.linear(row, 2);
      const double t = T.translation(row);
      for (int i = 0; i < kWidth; ++i) {
        const double image =
            x * rest.center[0][i] + y * rest.center[1][i] + z * rest.center[2][i] + t;
        const double reach = std::abs(x) * rest.half[0][i] + std::abs(y) * rest.half[1][i] +
                             std::abs(z) * rest.half[2][i];
        const double mean = part.mean[i];
        center[i] += mean * image;
        linear[0][i] += mean * x;
        linear[1][i] += mean * y;
        linear[2][i] += mean * z;
        // A bone without a part says nothing.
        const bool has_part = part.range[i] > 0 || mean > 0;
        low[i] = std::min(low[i], has_part ? image - reach : kInfinity);
        high[i] = std::max(high[i], has_part ? image + reach : -kInfinity);
      }
    }
    double spread[kWidth];  // around the mean
    for (int i = 0; i < kWidth; ++i) {
      spread[i] = std::abs(linear[0][i]) * rest.half[0][i] +
                  std::abs(linear[1][i]) * rest.half[1][i] +
                  std::abs(linear[2][i]) * rest.half[2][i];
    }
    for (const Part& part : parts) {
      const Matrix T = matrixOf(part);
      const double x = T.linear(row, 0), y = T.linear(row, 1), z = T.linear(row, 2);
      const double t = T.translation(row);
      for (int i = 0; i < kWidth; ++i) {
        const double image =
            x * rest.center[0][i] + y * rest.center[1][i] + z * rest.center[2][i] + t;
        const double reach = std::abs(x - linear[0][i]) * rest.half[0][i] +
                             std::abs(y - linear[1][i]) * rest.half[1][i] +
                             std::abs(z - linear[2][i]) * rest.half[2][i];
        spread[i] += part.range[i] * (std::abs(image - center[i]) + reach);
      }
    }
    for (int i = 0; i < kWidth; ++i) {
      const bool empty = i >= lanes;
      const double lower = std::max(low[i], center[i] - spread[i]) - rounding;
      const double upper = std::min(high[i], center[i] + spread[i]) + rounding;
      box.low[row][i] = empty ? std::numeric_limits<float>::infinity() : roundedDown(lower);
      box.high[row][i] = empty ? -std::numeric_limits<float>::infinity() : roundedUpToFloat(upper);
    }
  }
}

}  // namespace leeway::collision
