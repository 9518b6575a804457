#pragma once

// Private to planner/: motions in time among obstacles that deform.

#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "planner/execute/obstacles.h"

namespace leeway::planner {

/// Certifies paths in the world as it is seen, and motions over a time. Pairs with obstacles that
/// deform are asked apart from the others, which stay certified along a path.
class StepCertifier {
 public:
  StepCertifier(std::shared_ptr<const CompiledScene> scene, Obstacles& obstacles);

  /// Forgets what was known of times: the obstacles have been seen anew.
  void begin();

  /// Names of two bodies; empty where unknown.
  struct Bodies {
    std::string a, b;
  };
  /// True when every edge of the path is certified in the world as seen; the first that is not ends
  /// the look. `known_edges`: false when the first edge was never certified against what stands
  /// still (the others were).
  bool holds(const std::vector<std::vector<double>>& path, bool first_edge_known, Bodies& broken);

  /// Up to which of `marks` (increasing times, the last that of the motion's end) it is proven to
  /// keep all margins; its beginning when not to the first. Beyond the first only coarse work is
  /// spent.
  double certify(std::span<const TimedPoint> motion, std::span<const double> marks, Bodies& broken);

  /// The least separation over the motion from its beginning to `end`, which certify() has proven.
  Interval clearance(std::span<const TimedPoint> motion, double end, double tolerance,
                     Bodies& closest);
  /// Of a standing robot from all that deforms, where it is then [m]: to compare places.
  double roomAt(std::span<const double> point, double time);

  const CompiledScene& all() const { return *scene_; }
  EdgeCertifier::Statistics statistics() const;
  std::uint64_t looks = 0;

 private:
  /// What is known of the obstacles from one time to another.
  struct Moment {
    std::shared_ptr<const CompiledScene> grown;   ///< holds them all the time
    std::shared_ptr<const CompiledScene> middle;  ///< in the middle of it
    double growth = 0;                            ///< the largest [m]
  };
  const Moment& moment(double t0, double t1);
  bool certifyPart(std::span<const TimedPoint> motion, double t0, double t1, int depth,
                   Bodies& broken);
  bool edgesFree(std::span<const TimedPoint> part, Bodies& broken);
  Bodies names(const CompiledScene& scene, int pair) const;

  std::shared_ptr<const CompiledScene> scene_, still_scene_, moving_scene_;
  Obstacles& obstacles_;
  EdgeCertifier still_, moving_;
  std::map<std::pair<double, double>, Moment> moments_;
  std::vector<std::pair<double, double>> proven_;  ///< parts of the last certify(), as they were
};

}  // namespace leeway::planner
