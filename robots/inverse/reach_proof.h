#pragma once

#include <cstdint>
#include <span>

#include "robots/inverse/chain.h"

namespace leeway::robots {

struct ReachProof {
  /// No configuration within the ranges has the frame in its region, tolerances included.
  bool proven = false;
  std::int64_t boxes = 0;  ///< of configurations that were examined
};

/// Tries to prove that the chain's frame cannot be in the region while its solved variables stay
/// within lower..upper (one a column) and all others at `configuration`. Branch and bound over
/// boxes of configurations; gives up after `limit` boxes, or at a small one that it cannot exclude.
/// Rounding included: reach_proof.cc. O(boxes * joints).
ReachProof proveUnreachable(const Chain& chain, const PoseRegion& region,
                            std::span<const double> configuration, std::span<const double> lower,
                            std::span<const double> upper, std::int64_t limit);

}  // namespace leeway::robots
