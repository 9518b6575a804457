#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/plan.h"
#include "tools/leeway/support/scene_names.h"

namespace leeway::tools {

/// In how many random configurations two bodies of the robot touched, whatever their margin.
struct PairSamples {
  int pair = -1;  ///< one of their pairs of geometries
  int hits = 0;
};

/// Asks all pairs of two bodies of the robot at `samples` configurations, uniform within the limits
/// of the robot's file, of the planned variables and of other joints with limits (unlimited planned
/// ones within +-pi, all else as in the problem). What this suggests is a hint to a user: every
/// pair stays checked. Same seed, same counts. Throws robots::Stopped for an interrupt. O(samples *
/// pairs).
std::vector<PairSamples> samplePairs(const planner::CompiledScene& scene, int samples,
                                     std::uint64_t seed);

/// Bodies that touch in this share of the samples touch nearly always, as MoveIt's assistant has
/// it.
inline constexpr double kNearlyAlways = 0.95;

/// What to do about those of `pairs` that touch nearly always, in words; empty: there are none.
std::string allowHint(const planner::Problem& problem, const std::vector<PairNames>& pairs);

/// All pairs of bodies that are not proven to keep their margin at a point of the space, each once,
/// `known` first, which a query has found. One distance query a pair of geometries.
std::vector<PairNames> pairsTooNear(const planner::CompiledScene& scene,
                                    std::span<const double> point, const PairNames& known);

/// A pair of bodies that is proven to overlap at a point of the space, whatever its margin; empty
/// names: there is none. Cost as pairsTooNear(), without depths.
PairNames overlappingPair(const planner::CompiledScene& scene, std::span<const double> point);

/// The same at the start that a plan has refused; of another state the pair that it names. Empty
/// where a plan names no pair.
std::vector<PairNames> pairsTooNear(const planner::Problem& problem,
                                    const planner::PlanResult& result);

/// "a and b; c and d", all of them.
std::string pairsText(const std::vector<PairNames>& pairs);

}  // namespace leeway::tools
