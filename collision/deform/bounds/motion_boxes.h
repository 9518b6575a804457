#pragma once

// Private to collision/: the inner loops of bounds from a motion.

#include <cstddef>
#include <cstdint>
#include <span>

#include "collision/deform/tree/deform_tree.h"

namespace leeway::collision {

/// The boxes of the eight children of a node along one axis.
struct alignas(64) AxisRow {
  float low[kWidth], high[kWidth];
};

/// Sums of boxes of the eight children of a node: x of all columns, then y, z.
struct BoxSum {
  static constexpr int kNumbers = 3 * kWidth;
  double low[kNumbers], high[kNumbers];
};

/// Boxes of the rest positions below each child of a node.
struct SkinRest {
  double center[3][kWidth], half[3][kWidth];
};

/// A bone's weights in the vertices of each column. All are within `range` of `mean`, and within
/// `residue` of mean + gradient . (rest position - center). The means of a column's bones sum to 1,
/// as the weights do. If range and mean are 0, the bone carries no vertex of the column.
struct SkinPart {
  std::int32_t bone;
  double mean[kWidth], range[kWidth], residue[kWidth], gradient[3][kWidth];
};

/// Function pointers for one instruction set. Every set yields the same bytes. `to` and `from` are
/// parameters of a motion; if `from` is not null, to - from replaces `to`.
struct MotionKernels {
  /// Adds `count` boxes, each times its parameter (interval arithmetic: a negative factor swaps low
  /// and high). A box has a row for each of the axes x, y, z whose bit is set in its `axes`.
  void (*blend)(const AxisRow* rows, const std::uint8_t* axes, const double* to, const double* from,
                std::size_t count, BoxSum& sum);
  /// Rounds a sum outwards.
  void (*put)(const BoxSum& sum, WideBox& box);
  /// Displaces the boxes in `before` by the displacements in `way`. `way` is first clamped to low
  /// .. high, which also replaces NaN; `side` receives the longest side of each column's way.
  void (*move)(const WideBox& before, float low, float high, WideBox& way, WideBox& box,
               float* side);
  /// The boxes of skinned_bounds.cc, grown by `rounding`; columns without a part are undefined.
  void (*skin)(const SkinRest& rest, std::span<const SkinPart> parts, const double* to,
               const double* from, double rounding, WideBox& box);
};

/// The kernels for the best instruction set of this machine. Takes about 3 ns.
const MotionKernels& motionKernels();

}  // namespace leeway::collision
