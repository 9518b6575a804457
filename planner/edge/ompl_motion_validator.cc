#include "leeway/planner/ompl_motion_validator.h"

#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <utility>

#include "planner/base/tolerances.h"
#include "planner/edge/ompl_point.h"
#include "planner/space/ompl_lock.h"

namespace leeway::planner {

namespace ob = ompl::base;

OmplMotionValidator::OmplMotionValidator(const ob::SpaceInformationPtr& space_information,
                                         std::shared_ptr<CertifierPool> pool)
    : MotionValidator(space_information), pool_(std::move(pool)) {
  if (!pool_) throw std::invalid_argument("OmplMotionValidator: certifiers are expected");
  pool_->requireSpace(space_information, "OmplMotionValidator");
}

bool OmplMotionValidator::count(const EdgeCheck& check, CertifierPool::Slot& slot) const {
  const bool valid = check.verdict == Verdict::kFree;
  if (!valid && check.pair >= 0) ++slot.blocked[check.pair];
  std::atomic_ref<unsigned int>(valid ? valid_ : invalid_).fetch_add(1, std::memory_order_relaxed);
  return valid;
}

bool OmplMotionValidator::checkMotion(const ob::State* s1, const ob::State* s2) const {
  const CompiledScene& scene = pool_->scene();
  CertifierPool::Slot& slot = pool_->local();
  const EdgeCheck check =
      slot.certifier.certify(pointOf(s1, scene), pointOf(s2, scene), slot.certifier.searching());
  return count(check, slot);
}

bool OmplMotionValidator::checkMotion(const ob::State* s1, const ob::State* s2,
                                      std::pair<ob::State*, double>& last_valid) const {
  const CompiledScene& scene = pool_->scene();
  CertifierPool::Slot& slot = pool_->local();
  const std::span<const double> a = pointOf(s1, scene), b = pointOf(s2, scene);
  EdgeRequest request = slot.certifier.searching();
  request.last_valid = true;
  const EdgeCheck check = slot.certifier.certify(a, b, request);
  if (check.verdict == Verdict::kFree) return count(check, slot);
  double t = std::clamp(check.last_valid, 0.0, 1.0);
  // The end of the certified part is a rounded point next to the edge, so the edge to it is
  // certified again. `last_valid.first` may be s1 or s2 itself, so it is written last.
  for (int i = 0; i < kLastValidTries && t > 0; ++i, t /= 2) {
    scene.space().interpolate(a, b, t, slot.point);
    if (scene.space().withinLimits(slot.point) &&
        slot.certifier.certify(a, slot.point).verdict == Verdict::kFree)
      break;
    if (i + 1 == kLastValidTries) t = 0;
  }
  if (t <= 0) {
    t = 0;
    std::copy(a.begin(), a.end(), slot.point.begin());
  }
  last_valid.second = t;
  if (last_valid.first != nullptr)
    std::copy(slot.point.begin(), slot.point.end(), pointOf(last_valid.first, scene).begin());
  return count(check, slot);
}

ob::SpaceInformationPtr makeSpaceInformation(std::shared_ptr<const CompiledScene> scene,
                                             std::uint64_t seed,
                                             std::shared_ptr<CertifierPool> pool) {
  if (!pool) pool = std::make_shared<CertifierPool>(scene);
  if (&pool->scene() != scene.get())
    throw std::invalid_argument(
        "makeSpaceInformation(): the certifiers are of another scene; a pool of this scene is "
        "expected");
  const std::lock_guard<std::recursive_mutex> lock(omplSeedLock());
  const ConfigurationSpace* space_of_scene = &scene->space();
  auto space = std::make_shared<OmplStateSpace>(
      std::shared_ptr<const ConfigurationSpace>(std::move(scene), space_of_scene), seed);
  auto information = std::make_shared<ob::SpaceInformation>(space);
  information->setStateValidityChecker(std::make_shared<OmplValidityChecker>(information, pool));
  information->setMotionValidator(std::make_shared<OmplMotionValidator>(information, pool));
  information->setup();
  return information;
}

}  // namespace leeway::planner
