#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/plan.h"
#include "tools/view/base/pairs_too_near.h"

namespace leeway::tools {

/// The number of random configurations in which two bodies of the robot touch; margins do not
/// count.
struct PairSamples {
  int pair = -1;  ///< one of their pairs of geometries
  int hits = 0;
};

/// Checks all pairs of two bodies of the robot at `samples` configurations. Planned variables and
/// other joints with limits are uniform within the limits of the robot's file; unlimited planned
/// ones are within +-pi, and all others are as in the problem. The result is a hint for a user:
/// every pair stays checked. The same seed gives the same counts. Throws robots::Stopped for an
/// interrupt. O(samples * pairs).
std::vector<PairSamples> samplePairs(const planner::CompiledScene& scene, int samples,
                                     std::uint64_t seed);

/// Bodies that touch in this share of the samples touch nearly always. MoveIt's assistant uses the
/// same share.
inline constexpr double kNearlyAlways = 0.95;

/// Returns advice about those of `pairs` that touch nearly always; empty without such pairs.
std::string allowHint(const planner::Problem& problem, const std::vector<PairNames>& pairs);

/// A pair of bodies that is proven to overlap at a point of the space, regardless of its margin;
/// empty names if none is. The cost is that of pairsTooNear() without depths.
PairNames overlappingPair(const planner::CompiledScene& scene, std::span<const double> point);

/// As pairsTooNear() at the start that a plan has refused. For another state, returns the pair that
/// the plan names; empty if it names none.
std::vector<PairNames> pairsTooNear(const planner::Problem& problem,
                                    const planner::PlanResult& result);

/// The margin that is required of the pair that a plan names as too near at its start or goal [m].
double offendingMargin(const planner::Problem& problem, const planner::PlanResult& result);

}  // namespace leeway::tools
