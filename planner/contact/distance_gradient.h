#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "leeway/planner/edge_certifier.h"

namespace leeway::planner {

/// How the distance of a pair changes along each direction of the space, by differences of the
/// kinematics. Keeps its buffers; not for two threads at once.
class DistanceGradient {
 public:
  explicit DistanceGradient(const CompiledScene& scene);

  /// At a place where `found` has been found, whose pair is one of `pairs`, a withPairs() of the
  /// scene or the scene itself. One number a direction of the space, as of
  /// ConfigurationSpace::difference() [m]; empty where the witness points give no direction.
  std::span<const double> find(std::span<const double> place, const EdgeClearance& found,
                               const CompiledScene& pairs);
  /// What one call costs [units of collision::Work].
  std::int64_t work() const;

 private:
  std::size_t firstMoved() const;

  const CompiledScene& scene_;
  std::vector<double> gradient_, direction_, near_;
  std::vector<double> q_, near_q_;       ///< the place as a configuration, and what is next to it
  std::vector<std::size_t> directions_;  ///< an orientation has three
  std::vector<int> chain_;               ///< of the pair's links
  std::vector<robots::Pose> X_WL_, moved_;
};

}  // namespace leeway::planner
