#pragma once

// Private to planner/: the obstacles of a problem that move, followed through time.

#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/replanner.h"

namespace leeway::planner {

/// Where the obstacles that deform, and the objects that have a motion, were last seen, and where
/// they can be after that. One thread at a time; any thread may read what it hands out.
class Obstacles {
 public:
  using Replacements = std::vector<CompiledScene::Replacement>;
  /// An observation: the vertices of a deforming obstacle in its frame, or the pose X_WO of a rigid
  /// one.
  using Sight = std::variant<std::span<const Eigen::Vector3d>, robots::Pose>;
  /// A bound from an observation on: on the speed of vertices, or of a rigid obstacle's origin
  /// [m/s], and on its turning [rad/s].
  struct Bound {
    double speed = 0, turning = 0;
  };

  Obstacles(const Problem& problem, const CompiledScene& scene);
  ~Obstacles();

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

  // The functions below throw std::invalid_argument for an obstacle that does not exist, or not of
  // the sight's kind.

  /// Takes an observation; see Replanner::setVertices() and setPose(). Throws
  /// std::invalid_argument, and changes nothing, where it makes no sense.
  void set(const std::string& object, const Sight& seen, double time, const Bound& bound);
  /// How much farther points of the obstacle, seen at `time`, are from those of the last look than
  /// its speed bound allows [m]; at most 0 where it holds, NaN for a sight that makes no sense:
  /// another number of vertices, numbers that are not finite, a matrix that is not a rotation.
  double jump(const std::string& object, const Sight& seen, double time) const;
  /// Whether points with this bound may move farther than was bounded before; so they may where a
  /// motion was known until now.
  bool widens(const std::string& object, const Sight& seen, const Bound& bound) const;
  /// When an obstacle was last seen [s].
  double seenAt(const std::string& object, const Sight& seen) const;
  /// Throws std::invalid_argument for a bound that is not 0 or more.
  static void requireBound(const std::string& object, const Bound& bound);

  /// The obstacles at the last look, each grown by `growth` [m].
  Replacements seen(double growth = 0) const;
  /// Grown obstacles that contain every obstacle at every time from t0 to t1 [s].
  Replacements during(double t0, double t1);
  /// The result of during(t0, t1), grown to contain every obstacle only at the middle of that time.
  Replacements atMiddle(Replacements during, double t0, double t1) const;

  const std::vector<ObstacleUpdate>& updates() const { return updates_; }

 private:
  struct Followed;
  struct Deforming;
  struct Rigid;
  void add(std::unique_ptr<Followed> obstacle, const CompiledScene& scene);
  Followed& find(const std::string& object, const Sight& seen) const;

  std::vector<int> bodies_;
  std::vector<std::unique_ptr<Followed>> obstacles_;
  std::vector<ObstacleUpdate> updates_;
};

}  // namespace leeway::planner
