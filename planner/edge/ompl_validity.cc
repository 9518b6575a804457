#include "leeway/planner/ompl_validity.h"

#include "leeway/planner/ompl_state_space.h"
#include "planner/edge/ompl_point.h"

namespace leeway::planner {

CertifierPool::Slot::Slot(const std::shared_ptr<const CompiledScene>& scene)
    : certifier(scene), point(static_cast<std::size_t>(scene->space().size())) {}

CertifierPool::CertifierPool(std::shared_ptr<const CompiledScene> scene)
    : scene_(std::move(scene)), owner_(std::this_thread::get_id()), own_(scene_) {}

CertifierPool::Slot& CertifierPool::local() {
  const std::thread::id me = std::this_thread::get_id();
  if (me == owner_) return own_;
  const std::lock_guard<std::mutex> lock(mutex_);
  std::unique_ptr<Slot>& slot = others_[me];
  if (!slot) slot = std::make_unique<Slot>(scene_);
  return *slot;
}

EdgeCertifier::Statistics CertifierPool::statistics() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  EdgeCertifier::Statistics sum = own_.certifier.statistics;
  for (const auto& [thread, slot] : others_) sum += slot->certifier.statistics;
  return sum;
}

std::unordered_map<int, std::uint64_t> CertifierPool::blocked() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::unordered_map<int, std::uint64_t> sum = own_.blocked;
  for (const auto& [thread, slot] : others_)
    for (const auto& [pair, edges] : slot->blocked) sum[pair] += edges;
  return sum;
}

OmplValidityChecker::OmplValidityChecker(const ompl::base::SpaceInformationPtr& space_information,
                                         std::shared_ptr<CertifierPool> pool, double tolerance)
    : StateValidityChecker(space_information), pool_(std::move(pool)), tolerance_(tolerance) {
  specs_.clearanceComputationType = ompl::base::StateValidityCheckerSpecs::BOUNDED_APPROXIMATE;
}

bool OmplValidityChecker::isValid(const ompl::base::State* state) const {
  const std::span<const double> q = pointOf(state, pool_->scene());
  return pool_->scene().space().withinLimits(q) &&
         pool_->local().certifier.decide(q) == Verdict::kFree;
}

double OmplValidityChecker::clearance(const ompl::base::State* state) const {
  return pool_->local()
      .certifier.clearance(pointOf(state, pool_->scene()), tolerance_)
      .clearance.lower;
}

}  // namespace leeway::planner
