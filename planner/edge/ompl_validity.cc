#include "leeway/planner/ompl_validity.h"

#include <algorithm>
#include <stdexcept>
#include <string>

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

void CertifierPool::requireSpace(const ompl::base::SpaceInformationPtr& space_information,
                                 const char* call) const {
  const auto* states =
      dynamic_cast<const OmplStateSpace*>(space_information->getStateSpace().get());
  if (states == nullptr) return;
  const ConfigurationSpace &theirs = states->space(), &ours = scene_->space();
  bool is_same = &theirs.model() == &ours.model() &&
                 std::equal(theirs.variables().begin(), theirs.variables().end(),
                            ours.variables().begin(), ours.variables().end());
  for (int i = 0; is_same && i < ours.size(); ++i)
    is_same = theirs.lower(i) == ours.lower(i) && theirs.upper(i) == ours.upper(i);
  if (!is_same)
    throw std::invalid_argument(
        std::string(call) +
        ": the certifiers are of a scene with another space; those of a scene with this model, "
        "variables and limits are expected");
}

namespace {

std::shared_ptr<CertifierPool> requiredPool(std::shared_ptr<CertifierPool> pool,
                                            const ompl::base::SpaceInformationPtr& information) {
  if (!pool) throw std::invalid_argument("OmplValidityChecker: certifiers are expected");
  pool->requireSpace(information, "OmplValidityChecker");
  return pool;
}

}  // namespace

OmplValidityChecker::OmplValidityChecker(const ompl::base::SpaceInformationPtr& space_information,
                                         std::shared_ptr<CertifierPool> pool, double tolerance)
    : StateValidityChecker(space_information),
      pool_(requiredPool(std::move(pool), space_information)),
      tolerance_(tolerance) {
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
