#include "planner/search/goal_supply.h"

#include <algorithm>
#include <utility>

#include "planner/base/tolerances.h"

namespace leeway::planner {

GoalSupply::GoalSupply(std::shared_ptr<const CompiledScene> scene, GoalSampler& sampler,
                       GoalPoints& points)
    : scene_(std::move(scene)), sampler_(sampler), points_(points) {
  drawn_.points = points.points;
}

void GoalSupply::open(bool apart) {
  if (!apart) return;
  own_ = std::make_unique<EdgeCertifier>(scene_);
  sampler_.use(*own_);
}

bool GoalSupply::add(std::size_t k, std::vector<std::vector<double>>& points) {
  const std::lock_guard<std::mutex> lock(mutex_);
  while (batches_.size() <= k) {
    const std::size_t before = drawn_.points.size();
    if (before >= static_cast<std::size_t>(kGoalSamples) || !sampler_.more(drawn_)) return false;
    batches_.push_back({before, {}});
    if (own_) batches_.back().work = own_->statistics;
  }
  const auto begin = static_cast<std::ptrdiff_t>(batches_[k].first);
  const auto end = static_cast<std::ptrdiff_t>(k + 1 < batches_.size() ? batches_[k + 1].first
                                                                       : drawn_.points.size());
  points.insert(points.end(), drawn_.points.begin() + begin, drawn_.points.begin() + end);
  return true;
}

void GoalSupply::close(std::size_t batches) {
  const std::size_t known = std::min(batches, batches_.size());
  if (known == 0) return;
  work_ = batches_[known - 1].work;
  const std::size_t end = known < batches_.size() ? batches_[known].first : drawn_.points.size();
  points_.points.assign(drawn_.points.begin(),
                        drawn_.points.begin() + static_cast<std::ptrdiff_t>(end));
}

}  // namespace leeway::planner
