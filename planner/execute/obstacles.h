#pragma once

// Private to planner/: the deforming obstacles of a problem, followed through time.

#include <span>
#include <string>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/replanner.h"

namespace leeway::planner {

/// Where the obstacles were last seen, and where they can be after that. For one thread at a time;
/// any thread may read the snapshots that it returns.
class Obstacles {
 public:
  using Replacements = std::vector<CompiledScene::Replacement>;

  Obstacles(const Problem& problem, const CompiledScene& scene);

  /// Scene bodies, one per obstacle.
  const std::vector<int>& bodies() const { return bodies_; }
  bool has(int body) const;
  /// Variants of a scene: without the pairs of obstacles, and with only these pairs.
  std::shared_ptr<const CompiledScene> pairsOfOthers(const CompiledScene& scene) const;
  std::shared_ptr<const CompiledScene> pairsOfThese(const CompiledScene& scene) const;
  /// Whether the motions of all obstacles are known beyond the last look.
  bool arePredicted() const;

  /// Moves all obstacles that have a motion to `time` [s].
  void look(double time);
  /// See Replanner::setVertices().
  void set(const std::string& object, std::span<const Eigen::Vector3d> vertices, double time,
           double speed_bound);
  /// Returns how much farther these vertices, seen at `time`, are from those of the last look than
  /// the obstacle's speed bound allows [m]: at most 0 if the bound holds, NaN if a vertex is not
  /// finite. Throws std::invalid_argument for an unknown obstacle.
  double jump(const std::string& object, std::span<const Eigen::Vector3d> vertices,
              double time) const;
  /// Whether vertices with this speed bound may move farther than the bound so far allows. True if
  /// a motion has placed the obstacle so far. Throws as jump() does.
  bool widens(const std::string& object, double speed_bound) const;
  /// The number of an obstacle's vertices, and the time when it was last seen [s]. Both throw
  /// std::invalid_argument for an unknown obstacle.
  std::size_t vertexCount(const std::string& object) const {
    return static_cast<std::size_t>(obstacles_[indexOf(object)].source->mesh->vertexCount());
  }
  double seenAt(const std::string& object) const { return obstacles_[indexOf(object)].seen; }

  /// The shapes at the last look, each grown by `growth` [m].
  Replacements seen(double growth = 0) const;
  /// Grown shapes that contain every obstacle at every time from t0 to t1 [s].
  Replacements during(double t0, double t1);
  /// The shapes of during(t0, t1), grown to contain every obstacle only at the middle of that time.
  Replacements atMiddle(Replacements during, double t0, double t1) const;

  const std::vector<ObstacleUpdate>& updates() const { return updates_; }

 private:
  struct Followed {
    std::string object;
    const DeformingObstacle* source;
    bool predicted;  ///< `motion` gives its place after the last look
    collision::Deformable present, future;
    double seen = 0;     ///< time of `present` [s]
    double speed_bound;  ///< from the program with set vertices, else from the problem [m/s]
    bool own = false;    ///< the program has set its vertices
    // If `own`: the time of the look before `seen`, and the speed bound between the two.
    double seen_before = 0, bound_before = 0;
  };
  std::size_t indexOf(const std::string& object) const;
  double speedBetween(const Followed& obstacle, double t0, double t1) const;
  double agedGrowth(const Followed& obstacle, double time) const;

  std::vector<int> bodies_;
  std::vector<Followed> obstacles_;
  std::vector<ObstacleUpdate> updates_;
};

}  // namespace leeway::planner
