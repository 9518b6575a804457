#pragma once

// The pairs that bench_pairs times: families of convex shapes, and one mesh, in our form and in
// FCL's.

#include <fcl/narrowphase/distance.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "leeway/collision/distance.h"

namespace leeway::bench {

using collision::Pose;
using collision::Shape;

/// One body, in our form and in FCL's.
struct Body {
  Shape ours;
  std::shared_ptr<fcl::CollisionGeometryd> theirs;  ///< null: FCL is not timed
};
struct Pair {
  Body a, b;
  Pose X_WA, X_WB;
  fcl::Transform3d F_WA, F_WB;
  double gap = 0;        // [m], by construction
  double threshold = 0;  // [m], of the tolerance test
  int track = 0;
};
enum class Query {
  kCold,
  kWarm,    ///< with the cache of the previous frame
  kDepth,   ///< signed distance in overlap
  kVerify,  ///< d > threshold?
};

struct PairFamily {
  const char* name;
  double target;  // target ratio; for kVerify, relative to our own distance query
  Query query;
  std::vector<Pair> pairs;
};

/// Families whose names contain `only` (all if empty). Each family has its own seed, so that a
/// single family can be reproduced alone.
std::vector<PairFamily> pairFamilies(std::uint64_t seed, const std::string& only);

}  // namespace leeway::bench
