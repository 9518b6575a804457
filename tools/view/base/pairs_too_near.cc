#include "tools/view/base/pairs_too_near.h"

#include <algorithm>
#include <set>
#include <utility>

#include "leeway/robots/kinematics.h"

namespace leeway::tools {
namespace {

/// Whether a pair is proven to keep its margin with the links at X_WL.
bool keepsMargin(const planner::CompiledScene& scene, const collision::ScenePair& pair,
                 std::span<const robots::Pose> X_WL, collision::Scratch& scratch) {
  collision::DistanceRequest request;
  request.depth = pair.margin < 0;
  request.threshold = pair.margin;
  return distanceOf(scene, pair, X_WL, request, scratch).lower > pair.margin;
}

}  // namespace

std::vector<robots::Pose> linksAt(const planner::CompiledScene& scene,
                                  std::span<const double> point) {
  std::vector<double> q(scene.model().variables.size());
  scene.expand(point, q);
  std::vector<robots::Pose> X_WL(scene.model().links.size());
  robots::forwardKinematics(scene.model(), q, X_WL);
  return X_WL;
}

collision::Interval distanceOf(const planner::CompiledScene& scene,
                               const collision::ScenePair& pair, std::span<const robots::Pose> X_WL,
                               const collision::DistanceRequest& request,
                               collision::Scratch& scratch) {
  const auto bodies = scene.scene().bodies();
  const auto geometry = [&](int body, int index) {
    return bodies[static_cast<std::size_t>(body)].geometry(static_cast<std::size_t>(index));
  };
  const auto place = [&](int body, const robots::Geometry& of) {
    const int link = scene.bodyLink(body);
    return (link >= 0 ? X_WL[static_cast<std::size_t>(link)]
                      : bodies[static_cast<std::size_t>(body)].X_WB) *
           of.X_BG;
  };
  const robots::Geometry a = geometry(pair.body_a, pair.geometry_a),
                         b = geometry(pair.body_b, pair.geometry_b);
  return collision::distance(a.shape, place(pair.body_a, a), b.shape, place(pair.body_b, b),
                             request, scratch)
      .distance;
}

std::vector<PairNames> pairsTooNear(const planner::CompiledScene& scene,
                                    std::span<const double> point, const PairNames& known) {
  const std::vector<robots::Pose> X_WL = linksAt(scene, point);
  collision::Scratch scratch;
  std::vector<PairNames> near = {known};
  std::set<std::pair<int, int>> found;
  const auto& pairs = scene.scene().pairs();
  for (auto at = pairs.begin(); at != pairs.end(); ++at) {
    const collision::ScenePair pair = *at;
    if (found.count({pair.body_a, pair.body_b}) != 0 || keepsMargin(scene, pair, X_WL, scratch))
      continue;
    found.emplace(pair.body_a, pair.body_b);
    const PairNames names = pairNames(scene, static_cast<int>(at.number()));
    if (std::minmax(names.a, names.b) != std::minmax(known.a, known.b)) near.push_back(names);
  }
  return near;
}

std::string pairsText(const std::vector<PairNames>& pairs) {
  std::string text;
  for (const PairNames& pair : pairs)
    text += (text.empty() ? "" : "; ") + pair.a + " and " + pair.b;
  return text;
}

}  // namespace leeway::tools
