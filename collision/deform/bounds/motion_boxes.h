#pragma once

// Private to collision/: the inner loops of bounds from a motion, for every instruction set.

#include <cstddef>
#include <cstdint>
#include <span>

#include "collision/deform/tree/deform_tree.h"

namespace leeway::collision {

/// What boxes of the eight children of a node have along one axis.
struct alignas(64) AxisRow {
  float low[kWidth], high[kWidth];
};

/// Boxes of the eight children of a node that are still being summed up: as WideBox has them, in a
/// row.
struct BoxSum {
  static constexpr int kNumbers = 3 * kWidth;
  double low[kNumbers], high[kNumbers];
};

/// The boxes of what is below each child of a node in the rest position.
struct SkinRest {
  double center[3][kWidth], half[3][kWidth];
};

/// A bone's part in the vertices of each lane: every weight is within `range` of `mean`, and
/// within `residue` of mean + gradient . (rest position - center); the means of a lane add up to
/// what the weights do. No range and no mean: no part.
struct SkinPart {
  std::int32_t bone;
  double mean[kWidth], range[kWidth], residue[kWidth], gradient[3][kWidth];
};

/// Function pointers of one instruction set. Every set yields the same bytes. Parameters are a
/// motion's: where there are `from`, the differences to - from take the place of `to`.
struct MotionKernels {
  /// Adds each of `count` boxes times its parameter, which turns a box round when it is below 0. Of
  /// each box there is a row for each of the axes x, y, z whose bit is set in `axes`.
  void (*blend)(const AxisRow* rows, const std::uint8_t* axes, const double* to, const double* from,
                std::size_t count, BoxSum& sum);
  /// Rounded outwards.
  void (*put)(const BoxSum& sum, WideBox& box);
  /// Boxes of what was in `before` and has come as far as `way` says, which is cut to low .. high
  /// first (what is no number there says nothing); `side` is the longest of each way's box.
  void (*move)(const WideBox& before, float low, float high, WideBox& way, WideBox& box,
               float* side);
  /// The boxes of skinned_bounds.cc, grown by `rounding`; lanes without a part hold anything.
  void (*skin)(const SkinRest& rest, std::span<const SkinPart> parts, const double* to,
               const double* from, double rounding, WideBox& box);
};

/// Those of the best instruction set that this machine has: about 3 ns.
const MotionKernels& motionKernels();

}  // namespace leeway::collision
