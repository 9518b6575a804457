#pragma once

#include <ompl/base/Planner.h>

#include <cstdint>
#include <optional>

namespace leeway::planner {

/// Connect, our RRT-Connect, for OMPL programs: two balanced trees with dynamic domains. The state
/// space must be an OmplStateSpace; edges are asked of the motion validator. The first path ends
/// the search, which begins anew at each call of solve(). The goal must be sampleable; its second
/// tree grows from up to 16 samples. plan() runs the same search without OMPL.
class OmplConnect : public ompl::base::Planner {
 public:
  explicit OmplConnect(const ompl::base::SpaceInformationPtr& space_information);

  /// Throws ompl::Exception in another space.
  void setup() override;
  void clear() override;
  ompl::base::PlannerStatus solve(const ompl::base::PlannerTerminationCondition& stop) override;

  /// The longest edge, in the space's distance; 0, the default: chosen by the space.
  void setRange(double range) { range_ = range; }
  double getRange() const { return range_; }
  /// Both trees grow to about the same size (default); otherwise they take turns.
  void setBalance(bool balance) { balance_ = balance; }
  bool getBalance() const { return balance_; }
  /// Nodes whose edges have failed are extended to near samples only (default).
  void setDynamicDomain(bool dynamic) { dynamic_domain_ = dynamic; }
  bool getDynamicDomain() const { return dynamic_domain_; }
  /// Samples of a low-discrepancy sequence in place of random ones (default but for one free body).
  void setLowDiscrepancy(bool low) { low_discrepancy_ = low; }
  bool getLowDiscrepancy() const { return low_discrepancy_.value_or(true); }

 private:
  double range_ = 0;
  bool balance_ = true, dynamic_domain_ = true;
  std::optional<bool> low_discrepancy_;
  std::uint64_t runs_ = 0;  ///< of solve(), each with another seed
  std::uint64_t seed_;
};

}  // namespace leeway::planner
