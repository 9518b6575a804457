#pragma once

#include <ompl/base/MotionValidator.h>
#include <ompl/base/SpaceInformation.h>

#include <memory>
#include <utility>

#include "leeway/planner/ompl_state_space.h"
#include "leeway/planner/ompl_validity.h"

namespace leeway::planner {

/// A motion is valid if the whole edge between its states is certified; it has no resolution.
/// States are those of OmplStateSpace. Thread-safe; allocates at a thread's first call, and when a
/// pair is in the way for the first time.
class OmplMotionValidator : public ompl::base::MotionValidator {
 public:
  OmplMotionValidator(const ompl::base::SpaceInformationPtr& space_information,
                      std::shared_ptr<CertifierPool> pool);

  bool checkMotion(const ompl::base::State* s1, const ompl::base::State* s2) const override;
  /// For a motion that is not valid, `last_valid.second` is a fraction up to which the edge is
  /// certified. `last_valid.first`, unless null, is the state there: valid, and the end of a
  /// certified edge from s1. If nothing can be certified, they are 0 and s1.
  bool checkMotion(const ompl::base::State* s1, const ompl::base::State* s2,
                   std::pair<ompl::base::State*, double>& last_valid) const override;

 private:
  bool count(const EdgeCheck& check, CertifierPool::Slot& slot) const;
  std::shared_ptr<CertifierPool> pool_;
};

/// Returns a SpaceInformation for a scene, set up for any geometric planner of OMPL: an
/// OmplStateSpace with `seed`, and OmplValidityChecker and OmplMotionValidator over one pool (null:
/// a new one). Throws std::invalid_argument without a scene, for a pool of another scene, and for a
/// planned variable without limits.
ompl::base::SpaceInformationPtr makeSpaceInformation(std::shared_ptr<const CompiledScene> scene,
                                                     std::uint64_t seed = 1,
                                                     std::shared_ptr<CertifierPool> pool = nullptr);

}  // namespace leeway::planner
