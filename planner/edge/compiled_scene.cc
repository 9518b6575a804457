#include "leeway/planner/compiled_scene.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "collision/scene/scene_access.h"
#include "leeway/robots/input_error.h"
#include "planner/edge/edge_model.h"
#include "planner/edge/scene_pairs.h"

namespace leeway::planner {
namespace {

using robots::VariableRange;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Limits for what is planned, the start's value for what is not.
std::vector<VariableRange> plannedRanges(const Problem& problem) {
  std::vector<VariableRange> ranges = robots::limitRanges(*problem.robot.model);
  std::vector<char> planned(ranges.size(), 0);
  for (const int v : problem.robot.variables) planned[at(v)] = 1;
  for (std::size_t v = 0; v < ranges.size(); ++v)
    if (!planned[v]) ranges[v] = {problem.start[v], problem.start[v]};
  return ranges;
}

}  // namespace

CompiledScene::CompiledScene(const Problem& problem)
    : model_(problem.robot.model),
      space_(std::make_shared<ConfigurationSpace>(problem.robot.model, problem.robot.variables)),
      base_configuration_(problem.start) {
  const std::vector<VariableRange> ranges = plannedRanges(problem);
  ScenePairs pairs(problem, ranges);
  try {
    scene_ = pairs.builder().build();
  } catch (const std::invalid_argument& error) {
    throw robots::InputError(problem.name, 0, error.what());
  }
  dropped_ = pairs.takeDropped();
  body_link_ = pairs.bodyLinks();
  std::vector<const robots::LinkGap*> gaps;
  for (const collision::ScenePair& pair : scene_.pairs())
    gaps.push_back(pairs.linkGap(pair.body_a, pair.body_b));
  edge_model_ = makeEdgeModel(*this, ranges, gaps, pairs.hasProven());
}

std::shared_ptr<const CompiledScene> CompiledScene::withShapes(
    std::span<const Replacement> shapes) const {
  auto changed = std::make_shared<CompiledScene>(*this);
  for (const Replacement& r : shapes) {
    changed->scene_.setShape(r.body, r.geometry, r.shape);
    changed->scene_.growMargins(r.body, r.geometry, r.growth);
  }
  return changed;
}

std::shared_ptr<const CompiledScene> CompiledScene::withMarginAtLeast(double margin) const {
  auto raised = std::make_shared<CompiledScene>(*this);
  raised->scene_.raiseMargins(margin);
  return raised;
}

std::shared_ptr<const CompiledScene> CompiledScene::withMarginsGrown(double growth) const {
  auto grown = std::make_shared<CompiledScene>(*this);
  for (std::size_t body = 0; body < scene_.bodies().size(); ++body)
    if (scene_.bodies()[body].moving)  // one of every pair is
      for (std::size_t g = 0; g < scene_.bodies()[body].geometries.size(); ++g)
        grown->scene_.growMargins(static_cast<int>(body), static_cast<int>(g), growth);
  return grown;
}

std::shared_ptr<const CompiledScene> CompiledScene::withPairs(
    const std::function<bool(const collision::ScenePair&)>& keep) const {
  auto reduced = std::make_shared<CompiledScene>(*this);
  auto model = std::make_shared<EdgeModel>(*edge_model_);
  model->pairs.clear();
  // keep() is called once a pair: were a second answer another, pairs would get the motions of
  // others, and proofs would not hold.
  std::vector<char> kept;
  kept.reserve(scene_.pairs().size());
  for (std::size_t p = 0; p < scene_.pairs().size(); ++p) {
    kept.push_back(keep(scene_.pairs()[p]) ? 1 : 0);
    if (kept.back() != 0) model->pairs.push_back(edge_model_->pairs[p]);
  }
  std::size_t next = 0;
  collision::SceneAccess::keepPairs(reduced->scene_,
                                    [&](const collision::ScenePair&) { return kept[next++] != 0; });
  reduced->edge_model_ = std::move(model);
  return reduced;
}

void CompiledScene::expand(std::span<const double> point, std::span<double> q) const {
  std::copy(base_configuration_.begin(), base_configuration_.end(), q.begin());
  const std::span<const int> variables = space_->variables();
  for (std::size_t i = 0; i < variables.size(); ++i) q[at(variables[i])] = point[i];
}

}  // namespace leeway::planner
