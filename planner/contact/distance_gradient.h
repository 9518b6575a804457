#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "leeway/planner/edge_certifier.h"

namespace leeway::planner {

/// The derivative of a pair's distance along each direction of the space, by differences of the
/// kinematics. Keeps its buffers; use it in one thread at a time.
class DistanceGradient {
 public:
  explicit DistanceGradient(const CompiledScene& scene);

  /// The gradient at a place with the result `found`, whose pair is one of `pairs`: a withPairs()
  /// of the scene, or the scene itself. Returns one number per direction of the space, as in
  /// ConfigurationSpace::difference() [m]; empty if the witness points give no direction.
  std::span<const double> find(std::span<const double> place, const EdgeClearance& found,
                               const CompiledScene& pairs);
  /// The cost of one call [units of collision::Work].
  std::int64_t work() const;

 private:
  std::size_t firstMoved() const;

  const CompiledScene& scene_;
  std::vector<double> gradient_, direction_, near_;
  std::vector<double> q_, near_q_;       ///< the place as a configuration, and a neighbour of it
  std::vector<std::size_t> directions_;  ///< an orientation has three
  std::vector<int> chain_;               ///< of the pair's links
  std::vector<robots::Pose> X_WL_, moved_;
};

}  // namespace leeway::planner
