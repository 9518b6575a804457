#pragma once

// Private to planner/: bounds on the motion of a robot's points.

#include <span>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/robots/motion_bound.h"

namespace leeway::planner {

/// How far any point of the robot moves, seen from any body that it is checked against, while
/// planned variables change by up to some numbers.
class Displacement {
 public:
  explicit Displacement(const CompiledScene& scene);
  /// Returns that bound [m], for configurations within the limits before and after the change.
  /// O(motions of the scene x joints).
  double of(std::span<const double> changes);
  /// Returns it for changes from within the limits to anywhere; infinity where all joints together
  /// turn by 1 rad or more.
  double beyondLimits(std::span<const double> changes);
  /// How far points of the robot are from where they are on the edge from row `from` to row `to`,
  /// its chord, while it passes the rows between them [m]. `row(k)` is a configuration within the
  /// limits. Infinity where no bound is found, as for long turns, and with floating joints.
  template <class Row>
  double fromChord(const Row& row, int from, int to) {
    const std::span<const double> a = row(from);
    const double squared = setChord(a, row(to));
    if (!(squared < kInfinity)) return kInfinity;
    for (int k = from + 1; k < to; ++k) depart(a, row(k), squared);
    return of(departure_);
  }

 private:
  /// Sets the chord. Returns its squared length; infinity for one that is too long.
  double setChord(std::span<const double> a, std::span<const double> b);
  void depart(std::span<const double> a, std::span<const double> row, double squared);

  const CompiledScene& scene_;
  std::vector<double> departure_, chord_;
  std::vector<double> dq_;
  std::vector<robots::JointMotion> motion_;
};

}  // namespace leeway::planner
