#pragma once

// Private to planner/: motions in time among obstacles that move.

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/planner/edge_certifier.h"
#include "planner/base/tolerances.h"
#include "planner/execute/obstacles.h"
#include "planner/execute/rows_proof.h"

namespace leeway::planner {

/// Certifies paths in the world as last seen, and motions over a time. Each group of obstacles has
/// its own certifier, so that the pairs without obstacles stay certified along a path.
class StepCertifier {
 public:
  StepCertifier(std::shared_ptr<const CompiledScene> scene, Obstacles& obstacles,
                const Execution& execution);

  /// A time of the execution, counted in parts of its steps. Proofs begin and end at ticks, so that
  /// candidates and steps share the places of obstacles.
  using Tick = std::int64_t;
  static constexpr Tick kStepTicks = Tick{1} << kMustHalvings;
  /// Stops and what follows them are proven up to multiples of this.
  static constexpr Tick kCoarse = kStepTicks / 8;
  double timeOf(Tick tick) const {
    const Tick whole_step = tick / kStepTicks;
    return start_ + static_cast<double>(whole_step) * step_ +
           static_cast<double>(tick % kStepTicks) * (step_ / kStepTicks);
  }

  /// Begins a step at a tick. Drops all placements of obstacles unless their motions are known:
  /// then they hold in all steps. Makes new certifiers for clouds that were replaced.
  void begin(Tick now);

  /// The names of two bodies; empty if unknown.
  struct Bodies {
    std::string a, b;
  };
  /// True when every edge of the path is certified in the world as last seen; `broken` names the
  /// bodies of the first that is not. `first_edge_known`: the first edge, as all others, is
  /// certified against the bodies that stand still.
  bool holds(const std::vector<std::vector<double>>& path, bool first_edge_known, Bodies& broken);

  /// True when the motion is certified in the world as last seen.
  bool isFree(std::span<const TimedPoint> motion);

  /// Sets what proofs from now on may cost together, in units of collision::Work. What is not
  /// decided within it is not proven.
  void setWork(std::int64_t work) { rows_.setWork(work); }

  /// Returns the time of the last of `marks` up to which the motion, which begins with the step, is
  /// proven to keep all margins, or the step's beginning; -infinity if it is not proven against
  /// what stands still. `marks` increase; the motion does not end before the last one. Halves
  /// intervals kMustHalvings times before the first `must` marks and kAheadHalvings times after
  /// them. `known`: a step before has proven it against what moves up to there [s].
  double certify(std::span<const TimedPoint> motion, std::span<const Tick> marks, std::size_t must,
                 Bodies& broken, double known = -kInfinity);

  /// Returns the least separation over the motion from its beginning to `end` [m]. The last call of
  /// certify() must have proven this part.
  Interval clearance(std::span<const TimedPoint> motion, double end, double tolerance,
                     Bodies& closest);
  /// Clearance of the robot at `point` from the obstacles that move at `time` [m]. Used to rank
  /// points.
  double roomAt(std::span<const double> point, Tick time);

  const CompiledScene& all() const { return *scene_; }
  EdgeCertifier::Statistics statistics() const;
  std::uint64_t looks = 0;

 private:
  /// A group of obstacles.
  struct Mover {
    std::unique_ptr<EdgeCertifier> certifier;
    std::map<std::pair<Tick, Tick>, Obstacles::Placement> placements;
    std::vector<std::pair<Tick, Tick>> proven;  ///< intervals that the last certify() proved
  };
  const Obstacles::Placement& placement(std::size_t group, Tick t0, Tick t1);
  bool certifyPart(std::size_t group, std::span<const TimedPoint> motion, Tick t0, Tick t1,
                   int depth, Bodies& broken);
  /// Whether the motion from row 0 to row `last` is free.
  template <class Row>
  bool allFree(EdgeCertifier& certifier, const Row& row, int last, Bodies& broken);
  bool rowsFree(EdgeCertifier& certifier, std::span<const TimedPoint> rows, Bodies& broken);
  double departure(std::span<const TimedPoint> rows);
  static Bodies names(const CompiledScene& scene, int pair);

  std::shared_ptr<const CompiledScene> scene_;
  Obstacles& obstacles_;
  double start_, step_;  ///< of the execution [s]
  Tick longest_;         ///< part, a power of two
  Tick now_ = 0;
  EdgeCertifier still_;
  RowsProof rows_;
  std::vector<Mover> movers_;         ///< by group
  EdgeCertifier::Statistics before_;  ///< of certifiers that were replaced
};

}  // namespace leeway::planner
