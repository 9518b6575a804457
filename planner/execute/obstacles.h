#pragma once

// Private to planner/: the deforming obstacles of a problem, followed through time.

#include <span>
#include <string>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/replanner.h"

namespace leeway::planner {

/// Where the obstacles are seen and what they can do from there on. Not for several threads at
/// once; the snapshots that it hands out are.
class Obstacles {
 public:
  using Replacements = std::vector<CompiledScene::Replacement>;

  Obstacles(const Problem& problem, const CompiledScene& scene);

  /// Scene bodies, one an obstacle.
  const std::vector<int>& bodies() const { return bodies_; }
  bool has(int body) const;
  /// True when the motions of all are known beyond the last look.
  bool arePredicted() const;

  /// Brings all that have a motion to `time`.
  void look(double time);
  /// See Replanner::setVertices().
  void set(const std::string& object, std::span<const Eigen::Vector3d> vertices, double time,
           double speed_bound);

  /// As they were seen, each grown by `growth` [m].
  Replacements seen(double growth = 0) const;
  /// Placements that, grown as they are, hold every obstacle at every moment from t0 to t1.
  Replacements during(double t0, double t1);
  /// The same placements, grown only by what is not known of the middle of that time.
  Replacements atMiddle(Replacements during, double t0, double t1) const;

  const std::vector<ObstacleUpdate>& updates() const { return updates_; }

 private:
  struct Followed {
    std::string object;
    const DeformingObstacle* source;
    bool predicted;  ///< its motion is known, and asked beyond the last look
    collision::Deformable present, future;
    double seen = 0;     ///< time of `present` [s]
    double speed_bound;  ///< of set vertices, or the file's [m/s]
    bool own = false;    ///< set by the program
  };
  double speedBetween(const Followed& obstacle, double t0, double t1) const;
  double agedGrowth(const Followed& obstacle, double time) const;

  std::vector<int> bodies_;
  std::vector<Followed> obstacles_;
  std::vector<ObstacleUpdate> updates_;
};

}  // namespace leeway::planner
