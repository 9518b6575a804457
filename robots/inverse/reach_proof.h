#pragma once

#include <cstdint>
#include <span>

#include "robots/inverse/chain.h"

namespace leeway::robots {

struct ReachProof {
  /// Proven: no configuration within the ranges has the frame in its region, tolerances included.
  bool proven = false;
  std::int64_t boxes = 0;  ///< number of examined boxes of configurations
};

/// Tries to prove that the chain's frame cannot be in the region while its solved variables stay
/// within lower..upper (one for each column) and all others at `configuration`. Branch and bound
/// over boxes of configurations; gives up after `limit` boxes, or at a small box that it cannot
/// exclude. Rounding is included, see reach_proof.cc. O(boxes * joints).
ReachProof proveUnreachable(const Chain& chain, const PoseRegion& region,
                            std::span<const double> configuration, std::span<const double> lower,
                            std::span<const double> upper, std::int64_t limit);

}  // namespace leeway::robots
