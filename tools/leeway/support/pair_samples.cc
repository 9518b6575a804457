#include "tools/leeway/support/pair_samples.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "leeway/collision/distance.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/motion_bound.h"
#include "leeway/robots/stopped.h"
#include "tools/leeway/support/terminal.h"

namespace leeway::tools {
namespace {

/// SplitMix64 (Steele, Lea, Flood 2014): gives the same numbers with every library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform() {  // [0, 1)
    state_ += 0x9e3779b97f4a7c15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    return static_cast<double>((z ^ (z >> 31U)) >> 11U) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

/// A uniform rotation (Shoemake 1992).
void sampleRotation(Random& random, double* quaternion) {
  const double u = random.uniform();
  const double a = 2 * std::numbers::pi * random.uniform();
  const double b = 2 * std::numbers::pi * random.uniform();
  quaternion[0] = std::sqrt(1 - u) * std::sin(a);
  quaternion[1] = std::sqrt(1 - u) * std::cos(a);
  quaternion[2] = std::sqrt(u) * std::sin(b);
  quaternion[3] = std::sqrt(u) * std::cos(b);
}

void samplePoint(const planner::ConfigurationSpace& space, Random& random,
                 std::vector<double>& point) {
  for (const auto& part : space.parts()) {
    const auto first = static_cast<std::size_t>(part.first);
    if (part.kind == planner::ConfigurationSpace::Kind::kRotation) {
      sampleRotation(random, &point[first]);
      continue;
    }
    // With a problem's narrower limits, other pairs would seem to touch nearly always.
    const int v = space.variables()[first];
    auto [lower, upper] = space.model().variables[static_cast<std::size_t>(v)].touchRange();
    if (!std::isfinite(lower)) lower = -std::numbers::pi;
    if (!std::isfinite(upper)) upper = std::numbers::pi;
    point[first] = lower + random.uniform() * (upper - lower);
  }
}

/// The variables that are not planned and have limits.
std::vector<int> limitedPassive(const planner::CompiledScene& scene) {
  const std::span<const int> planned = scene.space().variables();
  std::vector<int> passive;
  for (int v = 0; v < static_cast<int>(scene.model().variables.size()); ++v) {
    const robots::Variable& variable = scene.model().variables[static_cast<std::size_t>(v)];
    const auto type = scene.model().joints[static_cast<std::size_t>(variable.joint)].type;
    if ((type == robots::JointType::kRevolute || type == robots::JointType::kPrismatic) &&
        std::find(planned.begin(), planned.end(), v) == planned.end())
      passive.push_back(v);
  }
  return passive;
}

/// Whether a pair is not proven apart with the links at X_WL.
bool touches(const planner::CompiledScene& scene, const collision::ScenePair& pair,
             std::span<const robots::Pose> X_WL, collision::Scratch& scratch) {
  collision::DistanceRequest request;
  request.depth = false;
  request.threshold = 0;
  return !(distanceOf(scene, pair, X_WL, request, scratch).lower > 0);
}

}  // namespace

std::vector<PairSamples> samplePairs(const planner::CompiledScene& scene, int samples,
                                     std::uint64_t seed) {
  const auto& pairs = scene.scene().pairs();
  std::map<std::pair<int, int>, std::vector<std::size_t>> of_bodies;  // numbers of their pairs
  for (auto at = pairs.begin(); at != pairs.end() && at.number() < pairs.listedCount(); ++at) {
    const collision::ScenePair pair = *at;
    if (scene.isOfRobot(pair))
      of_bodies[std::minmax(pair.body_a, pair.body_b)].push_back(at.number());
  }
  std::vector<PairSamples> result;
  for (const auto& [bodies, numbers] : of_bodies)
    result.push_back({static_cast<int>(numbers.front()), 0});
  // A pair that only joints outside the plan move would otherwise touch in all samples or in none.
  const std::vector<int> passive = limitedPassive(scene);
  Random random(seed);
  collision::Scratch scratch;
  std::vector<double> point(static_cast<std::size_t>(scene.space().size()));
  std::vector<double> q(scene.model().variables.size());
  std::vector<robots::Pose> X_WL(scene.model().links.size());
  for (int i = 0; i < samples; ++i) {
    robots::throwIfStopped(interrupted, "links that meet were looked for");
    samplePoint(scene.space(), random, point);
    scene.expand(point, q);
    for (const int v : passive) {
      const robots::Variable& variable = scene.model().variables[static_cast<std::size_t>(v)];
      const auto [lower, upper] = variable.touchRange();
      q[static_cast<std::size_t>(v)] = std::isfinite(upper - lower)
                                           ? lower + random.uniform() * (upper - lower)
                                           : q[static_cast<std::size_t>(v)];
    }
    robots::forwardKinematics(scene.model(), q, X_WL);
    auto entry = result.begin();
    for (const auto& [bodies, numbers] : of_bodies)
      (entry++)->hits += std::any_of(numbers.begin(), numbers.end(), [&](std::size_t number) {
        return touches(scene, pairs[number], X_WL, scratch);
      });
  }
  return result;
}

std::string allowHint(const planner::Problem& problem, const std::vector<PairNames>& pairs) {
  constexpr int kSamples = 200;
  std::vector<PairNames> nearly_always;
  const planner::CompiledScene scene(problem);
  for (const PairSamples& entry : samplePairs(scene, kSamples, problem.seed)) {
    if (entry.hits < kNearlyAlways * kSamples) continue;
    const PairNames names = pairNames(scene, entry.pair);
    if (std::any_of(pairs.begin(), pairs.end(),
                    [&](const PairNames& pair) { return pair.a == names.a && pair.b == names.b; }))
      nearly_always.push_back(names);
  }
  std::string hint;
  if (!nearly_always.empty())
    hint = "Too near in nearly all random configurations: " + pairsText(nearly_always) +
           ".\nIf they may touch, add them to `allowed` or an SRDF; `leeway srdf` proposes one.\n";
  const std::vector<robots::Link>& links = scene.model().links;
  std::vector<PairNames> at_rest;
  for (const auto& [first, second] : robots::touchingAtRest(scene.model(), interrupted)) {
    const std::string& a = links[static_cast<std::size_t>(first)].name;
    const std::string& b = links[static_cast<std::size_t>(second)].name;
    for (const PairNames& pair : pairs)
      if ((pair.a == a && pair.b == b) || (pair.a == b && pair.b == a)) at_rest.push_back(pair);
  }
  if (at_rest.empty()) return hint;
  return hint + "They touch at rest (zero, or MJCF's qpos0) as well: " + pairsText(at_rest) +
         ".\nIf they may touch, wherever the joints are: --allowed auto, or `allowed: auto` in a "
         "file; `leeway srdf` proposes which pairs need no check.\n";
}

PairNames overlappingPair(const planner::CompiledScene& scene, std::span<const double> point) {
  const std::vector<robots::Pose> X_WL = linksAt(scene, point);
  collision::Scratch scratch;
  collision::DistanceRequest request;
  request.depth = false;
  request.threshold = 0;
  const auto& pairs = scene.scene().pairs();
  for (auto at = pairs.begin(); at != pairs.end(); ++at)
    // A negative margin allows an overlap, so such a pair is not in collision.
    if ((*at).margin >= 0 && distanceOf(scene, *at, X_WL, request, scratch).upper <= 0)
      return pairNames(scene, static_cast<int>(at.number()));
  return {};
}

std::vector<PairNames> pairsTooNear(const planner::Problem& problem,
                                    const planner::PlanResult& result) {
  const PairNames known{result.offending_a, result.offending_b};
  if (known.a.empty()) return {};
  if (result.status != planner::PlanStatus::kInvalidStart || !problem.steps.empty()) return {known};
  return pairsTooNear(planner::CompiledScene(problem), startPoint(problem), known);
}

double offendingMargin(const planner::Problem& problem, const planner::PlanResult& result) {
  const planner::CompiledScene scene(problem);
  const auto& bodies = scene.scene().bodies();
  const auto isOf = [&](int body, const std::string& name) {
    return bodies[static_cast<std::size_t>(body)].name == name;
  };
  for (const auto& pair : scene.scene().pairs()) {
    const auto [a, b] = std::pair(pair.body_a, pair.body_b);
    if ((isOf(a, result.offending_a) && isOf(b, result.offending_b)) ||
        (isOf(b, result.offending_a) && isOf(a, result.offending_b)))
      return pair.margin;
  }
  return problem.margins.common;  // of an object that a step attaches
}

}  // namespace leeway::tools
