#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace leeway::collision {

/// Weights of cycles are integers modulo this prime, 2^61 - 1.
inline constexpr std::uint64_t kCyclePrime = (std::uint64_t{1} << 61) - 1;

/// One patch's contribution to the border along an edge.
struct BorderTerm {
  std::int32_t patch;
  std::int32_t times;  ///< uses of the edge in its direction, minus those against it; not 0
};

/// Along an edge, the borders of all patches must cancel: sum of times * weight = 0. Sorted by
/// patch; each patch occurs once.
using BorderEquation = std::vector<BorderTerm>;

/// A cycle of patches: weights with which the borders of all patches cancel along every edge.
struct PatchCycle {
  /// For each patch, below kCyclePrime; 0: the patch is in no cycle.
  std::vector<std::uint64_t> weight;
  /// For each patch: the lowest patch that its borders connect it to; itself if there is none.
  std::vector<std::int32_t> cluster;
};

/// Returns a cycle that no other one exceeds: a patch has weight 0 only if every cycle omits it,
/// and this cycle winds around every point that any cycle winds around. A cluster with one degree
/// of freedom has weights of small numbers (1 for its lowest free patch). With several degrees of
/// freedom the weights are pseudo-random; the winding numbers of two cycles then cancel at a point
/// with a probability of 2^-60. Uses Gaussian elimination; if that takes more than a second,
/// patches with borders have weight 0.
PatchCycle largestCycle(std::size_t patches, std::span<const BorderEquation> equations);

}  // namespace leeway::collision
