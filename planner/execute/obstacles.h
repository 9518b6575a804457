#pragma once

// Private to planner/: the obstacles of a problem that move, followed through time.

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/replanner.h"

namespace leeway::planner {

/// Where the obstacles that deform, and the objects that have a motion, were last seen, and where
/// they can be after that. One thread at a time; any thread may read what it hands out.
///
/// Obstacles are in groups, each with a scene of its own that has no other pairs. Group 0 has all
/// obstacles without a cloud. Each cloud is a group: so its growth is one margin of a whole scene,
/// which costs the same for any number of balls, and a new cloud is a new scene.
class Obstacles {
 public:
  using Replacements = std::vector<CompiledScene::Replacement>;
  /// A cloud that was seen in the frame X_WO; without it, in the frame in which the object stood
  /// before.
  struct CloudSight {
    std::shared_ptr<const PointCloud> cloud;
    std::optional<robots::Pose> X_WO = {};
  };
  /// An observation: the vertices of a deforming obstacle in its frame, the pose X_WO of a rigid
  /// one, or all balls of a cloud.
  using Sight = std::variant<std::span<const Eigen::Vector3d>, robots::Pose, CloudSight>;
  /// A bound from an observation on: on the speed of vertices, or of a rigid obstacle's origin
  /// [m/s], and on its turning [rad/s].
  struct Bound {
    double speed = 0, turning = 0;
  };

  /// `scene` is that of the problem. O(objects), and the compilation of a scene for each cloud.
  Obstacles(const Problem& problem, std::shared_ptr<const CompiledScene> scene);
  ~Obstacles();

  bool empty() const { return obstacles_.empty(); }
  /// The scene without the pairs of obstacles.
  const std::shared_ptr<const CompiledScene>& still() const { return still_; }
  std::size_t groups() const { return 1 + clouds_.size(); }
  /// The scene of a group, with its pairs only: for a new certifier. It has other pairs than before
  /// (CompiledScene::hasPairsOf()) where a cloud was replaced.
  std::shared_ptr<const CompiledScene> sceneOf(std::size_t group) const;
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
  /// its bounds allow [m], or how much farther a rigid one has turned [rad]; at most 0 where they
  /// hold, each for itself, NaN for a sight that makes no sense:
  /// another number of vertices, numbers that are not finite, a matrix that is not a rotation, a
  /// carved cloud elsewhere. The balls of two clouds do not correspond, so that no cloud jumps: 0
  /// or less.
  double jump(const std::string& object, const Sight& seen, double time) const;
  /// Whether points with this bound may move farther than was bounded before; so they may where a
  /// motion was known until now. A new cloud always widens: it may have balls anywhere.
  bool widens(const std::string& object, const Sight& seen, const Bound& bound) const;
  /// Where a rigid obstacle was last seen: X_WO.
  robots::Pose poseOf(const std::string& object) const;
  /// When an obstacle was last seen [s].
  double seenAt(const std::string& object, const Sight& seen) const;
  /// Throws std::invalid_argument for a cloud that was seen before the present one, because
  /// it would hide newer balls. A motion that the problem gives does not count as seen.
  void requireNewer(const std::string& object, const Sight& seen, double time) const;
  /// Throws std::invalid_argument for a bound that is not 0 or more.
  static void requireBound(const std::string& object, const Bound& bound);

  /// The problem's scene with all obstacles as at the last look, each grown by `growth` [m].
  std::shared_ptr<const CompiledScene> world(double growth = 0);
  /// The scene of a group as at the last look.
  std::shared_ptr<const CompiledScene> seenIn(std::size_t group) const;
  /// Where the obstacles of a group can be from one time to another.
  struct Placement {
    std::shared_ptr<const CompiledScene> grown;   ///< at any of these times
    std::shared_ptr<const CompiledScene> middle;  ///< at the middle time; null if not asked for
    double growth = 0;                            ///< the largest growth in `grown` [m]
    double growth_at_middle = 0;                  ///< and in `middle` [m]
  };
  Placement place(std::size_t group, double t0, double t1, bool with_middle);

  /// How far points of an obstacle can be, at any time from t0 to t1 [s], from where place() has
  /// them; and at the middle of that time [m]. `number`: in the order of updates().
  struct Growth {
    double most, at_middle;
  };
  Growth growthOf(std::size_t number, double t0, double t1);

  const std::vector<ObstacleUpdate>& updates() const { return updates_; }

 private:
  struct Followed;
  struct Deforming;
  struct Rigid;
  struct Cloud;
  void add(std::unique_ptr<Followed> obstacle);
  Followed& find(const std::string& object, const Sight& seen) const;
  bool has(int body) const;
  bool isCloud(const Followed& obstacle) const;
  struct Bounded {
    std::variant<collision::Shape, robots::Pose> now;
    Growth growth;
  };
  /// Where an obstacle is from t0 to t1 [s]: at that place, grown.
  static Bounded bounded(Followed& obstacle, double t0, double t1);
  /// Group 0 at the last look, each obstacle grown by `growth` [m].
  Replacements seen(double growth) const;

  std::vector<std::unique_ptr<Followed>> obstacles_;  ///< in the problem's order
  std::vector<ObstacleUpdate> updates_;
  // Group 0: its obstacles, their bodies in base_, and the scene with their pairs only.
  std::vector<Followed*> solids_;
  std::vector<int> bodies_;
  std::shared_ptr<const CompiledScene> solid_scene_;
  std::vector<Cloud*> clouds_;  ///< the other groups
  /// The problem's scene without clouds that move; without any pairs of obstacles; with all clouds
  /// as at the last look, null: one of them is another since.
  std::shared_ptr<const CompiledScene> base_, still_, with_clouds_;
};

}  // namespace leeway::planner
