#pragma once

// Private to planner/: motions in time among obstacles that move.

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "planner/execute/obstacles.h"
#include "planner/execute/rows_proof.h"

namespace leeway::planner {

/// Certifies paths in the world as last seen, and motions over a time. Each group of obstacles has
/// its own certifier, so that the pairs without obstacles stay certified along a path.
class StepCertifier {
 public:
  StepCertifier(std::shared_ptr<const CompiledScene> scene, Obstacles& obstacles);

  /// Drops all placements of obstacles, because the obstacles have been observed again. Makes new
  /// certifiers for clouds that were replaced.
  void begin();

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

  /// Sets what the calls below may cost together, in units of collision::Work. What is not decided
  /// within it is not proven.
  void setWork(std::int64_t work) { rows_.setWork(work); }

  /// Returns the last of `marks` up to which the motion is proven to keep all margins, or the
  /// motion's beginning; -infinity if it is not proven against what stands still. `marks` are
  /// increasing times [s]; the last one is the motion's end. Halves intervals kMustHalvings times
  /// before the first `must` marks and kAheadHalvings times after them.
  double certify(std::span<const TimedPoint> motion, std::span<const double> marks,
                 std::size_t must, Bodies& broken);

  /// Returns the least separation over the motion from its beginning to `end` [m]. The last call of
  /// certify() must have proven this part.
  Interval clearance(std::span<const TimedPoint> motion, double end, double tolerance,
                     Bodies& closest);
  /// Clearance of the robot at `point` from the obstacles that move at `time` [m]. Used to rank
  /// points.
  double roomAt(std::span<const double> point, double time);

  const CompiledScene& all() const { return *scene_; }
  EdgeCertifier::Statistics statistics() const;
  std::uint64_t looks = 0;

 private:
  /// A group of obstacles.
  struct Mover {
    std::unique_ptr<EdgeCertifier> certifier;
    std::map<std::pair<double, double>, Obstacles::Placement> placements;
    std::vector<std::pair<double, double>>
        proven;  ///< intervals that the last certify() proved [s]
  };
  const Obstacles::Placement& placement(std::size_t group, double t0, double t1);
  bool certifyPart(std::size_t group, std::span<const TimedPoint> motion, double t0, double t1,
                   int depth, Bodies& broken);
  bool rowsFree(EdgeCertifier& certifier, std::span<const TimedPoint> rows, Bodies& broken);
  double departure(std::span<const TimedPoint> rows);
  static Bodies names(const CompiledScene& scene, int pair);

  std::shared_ptr<const CompiledScene> scene_;
  Obstacles& obstacles_;
  EdgeCertifier still_;
  RowsProof rows_;
  std::vector<Mover> movers_;         ///< by group
  EdgeCertifier::Statistics before_;  ///< of certifiers that were replaced
};

}  // namespace leeway::planner
