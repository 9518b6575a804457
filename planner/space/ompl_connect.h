#pragma once

#include <ompl/base/Planner.h>

#include "planner/space/connect_trees.h"

namespace leeway::planner {

/// ConnectTrees for OMPL. Its space must be an OmplStateSpace; edges are asked of the motion
/// validator. The first path ends the search.
class OmplConnect : public ompl::base::Planner {
 public:
  explicit OmplConnect(const ompl::base::SpaceInformationPtr& space_information);

  /// Throws ompl::Exception in another space.
  void setup() override;
  void clear() override;
  ompl::base::PlannerStatus solve(const ompl::base::PlannerTerminationCondition& stop) override;

  /// The longest edge; 0: defaultRange().
  void setRange(double range) { range_ = range; }
  double getRange() const { return range_; }
  void setBalance(bool balance) { settings_.balance = balance; }
  bool getBalance() const { return settings_.balance; }
  void setDynamicDomain(bool dynamic) { settings_.dynamic_domain = dynamic; }
  bool getDynamicDomain() const { return settings_.dynamic_domain; }

 private:
  double range_ = 0;
  ConnectSettings settings_;
  std::uint64_t runs_ = 0;  ///< of solve(), each with another seed
  std::uint64_t seed_;
};

}  // namespace leeway::planner
