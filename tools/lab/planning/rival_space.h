#pragma once

#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/geometric/PathGeometric.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/ompl_state_space.h"
#include "tools/lab/base/state_engine.h"

namespace leeway::tools::report {

using Rows = std::vector<std::vector<double>>;

/// Our space for OMPL: another engine checks its states, and motions are checked in steps.
class RivalSpace {
 public:
  /// `resolution`: of a step, as a share of the space's extent. `distances`: the checker that
  /// measures clearances; null if there is none.
  RivalSpace(std::shared_ptr<const planner::CompiledScene> scene, StateChecker& checker,
             StateChecker* distances, double resolution, std::uint64_t seed);

  const ompl::base::SpaceInformationPtr& information() const { return information_; }
  ompl::base::ProblemDefinitionPtr definition(const std::vector<double>& start,
                                              const Rows& goals) const;
  Rows rowsOf(ompl::geometric::PathGeometric& path) const;

 private:
  std::shared_ptr<const planner::CompiledScene> scene_;
  std::shared_ptr<planner::OmplStateSpace> space_;
  ompl::base::SpaceInformationPtr information_;
};

/// Goals that are single configurations.
Rows pointsOf(const planner::Problem& problem);
/// Whether some edge is proven to be in contact.
bool collides(planner::EdgeCertifier& certifier, const Rows& path);

}  // namespace leeway::tools::report
