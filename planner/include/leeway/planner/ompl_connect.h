#pragma once

#include <ompl/base/Planner.h>

#include <cstdint>
#include <optional>

namespace leeway::planner {

/// Connect, our RRT-Connect, for OMPL programs: two balanced trees with dynamic domains. The state
/// space must be an OmplStateSpace; the motion validator checks edges. The first path ends the
/// search, and each call of solve() starts a new one. The goal must be sampleable; the second tree
/// grows from up to 16 samples of it. plan() runs the same search without OMPL.
class OmplConnect : public ompl::base::Planner {
 public:
  explicit OmplConnect(const ompl::base::SpaceInformationPtr& space_information);

  /// Throws ompl::Exception in another space.
  void setup() override;
  void clear() override;
  ompl::base::PlannerStatus solve(const ompl::base::PlannerTerminationCondition& stop) override;

  /// The longest edge, in the space's distance; 0, the default: derived from the space.
  void setRange(double range) { range_ = range; }
  double getRange() const { return range_; }
  /// If true (default), both trees grow to about the same size; otherwise they take turns.
  void setBalance(bool balance) { balance_ = balance; }
  bool getBalance() const { return balance_; }
  /// If true (default), nodes whose edges have failed are extended only to near samples.
  void setDynamicDomain(bool dynamic) { dynamic_domain_ = dynamic; }
  bool getDynamicDomain() const { return dynamic_domain_; }
  /// If true, samples come from a low-discrepancy sequence instead of random numbers (default,
  /// except for one free body).
  void setLowDiscrepancy(bool low) { low_discrepancy_ = low; }
  bool getLowDiscrepancy() const { return low_discrepancy_.value_or(true); }

 private:
  double range_ = 0;
  bool balance_ = true, dynamic_domain_ = true;
  std::optional<bool> low_discrepancy_;
  std::uint64_t runs_ = 0;  ///< calls of solve(), each with another seed
  std::uint64_t seed_;
};

}  // namespace leeway::planner
