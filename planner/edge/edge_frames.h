#pragma once

// Private to planner/: the pairs that are checked along an edge, and the edge's configurations,
// each placed once.

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/base/pair_table.h"
#include "collision/base/spare_memory.h"
#include "collision/base/work.h"
#include "collision/scene/scene_access.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/motion_bound.h"
#include "planner/compiled/edge_model.h"

namespace leeway::planner {

using collision::Pose;

/// One geometry of the scene, ready to be placed.
struct Piece {
  int body = -1;
  int link = -1;    ///< that carries it; -1: the world
  int moving = -1;  ///< its number among the moving pieces
  collision::SceneGeometry stored;
  bool at_origin = false;     ///< X_BG is the identity
  bool is_free_mesh = false;  ///< a mesh that a planned floating or planar joint carries
  /// For pieces of the world: the sum of the absolute coordinates of their inverse pose and of
  /// their ball's centre [m].
  double scale = 0;

  const collision::Geometry& geometry() const { return stored.geometry(); }
  const collision::Shape& shape() const { return geometry().shape; }
  /// In the link's frame, or the world's.
  const collision::GeometryBounds& bounds() const { return stored.bounds(); }
};

/// The geometries of a scene. Each call constructs the piece of a geometry in a place, because
/// there may be a million of them.
class Pieces {
 public:
  /// O(1).
  Piece operator[](std::size_t i) const { return i < listed_.size() ? listed_[i] : inPlace(i); }
  /// The first pieces: all whose geometry is in no place.
  std::span<const Piece> listed() const { return listed_; }

 private:
  friend class EdgeSceneBuilder;
  Piece inPlace(std::size_t i) const;
  std::vector<Piece> listed_;
  const CompiledScene* scene_ = nullptr;
};

/// One pair of the scene. Piece a is swept, relative to piece b.
struct EdgePair {
  int scene_pair;
  int a, b;          ///< pieces
  int motion;        ///< of a relative to b's link, index into EdgeModel::motions
  double threshold;  ///< that the separation must exceed: margin + rounding [m]
  double rounding;   ///< of the poses from which a separation is computed [m]
  bool is_self;      ///< between two parts of the robot
  bool is_reversed;  ///< a is the scene's second body
  bool by_surfaces;  ///< swept by collision::sweepMesh(); its margin is not negative
  int gap = -1;      ///< index into EdgeModel::gaps; -1: no proof by joint angles
};

/// The question about an edge's pairs.
struct Asked {
  Pairs pairs = Pairs::kAll;       ///< all others are ignored
  double separation = -kInfinity;  ///< required of pairs with a smaller margin [m]
  double beyond = 0;               ///< required in addition to either [m]

  bool has(const EdgePair& pair) const {
    return pairs == Pairs::kAll || pair.is_self == (pairs == Pairs::kSelf);
  }
  /// The value that a pair's separation must exceed [m].
  double thresholdOf(const EdgePair& pair) const {
    return std::max(pair.threshold, separation + pair.rounding) + beyond;
  }
};

/// The pairs of a scene. First come the pairs that the scene lists, ordered by their first piece
/// and then as in the scene. Then come those of its table (see collision::ScenePairs), with the
/// table's numbers.
class EdgePairs {
 public:
  /// The number of pairs.
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  /// All numbers are below this.
  std::size_t numbers() const { return numbers_; }
  /// O(1).
  EdgePair operator[](std::size_t number) const {
    return number < listed_.size() ? listed_[number] : inTable(number, pieceOf(number));
  }
  /// A pair of the table, from its static piece.
  EdgePair inTable(std::size_t number, const Piece& still) const;

  /// EdgePair::scene_pair.
  int numberInScene(int number) const {
    return at(number) < listed_.size() ? listed_[at(number)].scene_pair : number;
  }

  /// A moving piece with its pairs in the table; one for each row of the scene.
  struct Row {
    int piece, motion;
    double most_threshold;  ///< the greatest of its pairs, at least 0; NaN if one is NaN [m]
  };
  std::span<const Row> rows() const { return rows_; }
  /// The piece in a place. The first place has the lowest number.
  int pieceIn(std::size_t place) const { return first_still_ + static_cast<int>(place); }
  /// The static piece of a pair of the table.
  int stillOf(std::size_t number) const;

  /// The listed pairs, which come first.
  std::span<const EdgePair> listed() const { return listed_; }

  /// The greatest rounding of any pair [m]; NaN if one is NaN.
  double mostRounding() const { return most_rounding_; }

 private:
  friend class EdgeSceneBuilder;
  Piece pieceOf(std::size_t number) const;
  std::vector<EdgePair> listed_;
  std::vector<Row> rows_;
  int first_still_ = 0;
  std::size_t size_ = 0, numbers_ = 0;
  double most_rounding_ = 0;
  const CompiledScene* compiled_ = nullptr;
  const EdgeScene* edges_ = nullptr;
};

/// Data of a compiled scene for all edges. Constant; shared by its certifiers.
struct EdgeScene {
  /// Refers to the scene. O(geometries outside places + listed pairs + rows).
  explicit EdgeScene(const CompiledScene& scene);
  EdgeScene(const EdgeScene&) = delete;
  EdgeScene& operator=(const EdgeScene&) = delete;

  Pieces pieces;            ///< one per geometry
  std::vector<int> moving;  ///< the moving pieces
  EdgePairs pairs;
  bool has_surface_pairs = false;  ///< at least one pair is by_surfaces
  /// The pairs that may be near anywhere, ascending: all, if they are few, or the listed pairs.
  std::vector<int> near_anywhere;
  bool areAllNear() const { return near_anywhere.size() == pairs.size(); }
  /// The smallest margin of the pairs in question [m]; infinity without such pairs.
  double leastMargin(Pairs of) const { return least_margin_[static_cast<std::size_t>(of)]; }

 private:
  friend class EdgeSceneBuilder;
  std::array<double, 3> least_margin_{};
};

/// Places configurations a + t dq of one edge in numbered slots. Allocates only in the constructor.
class EdgeFrames {
 public:
  EdgeFrames(std::shared_ptr<const CompiledScene> scene, int capacity);

  /// Takes a variant of the same scene with the same number of pairs; afterwards no slot is in use.
  void rebind(std::shared_ptr<const CompiledScene> scene);

  /// Starts an edge; afterwards no slot is in use. False if the edge cannot be certified at all:
  /// numbers that are not finite or too large to be exact, a quaternion of zero length, a
  /// joint without range that is not in its position, or a mimic joint that would jump.
  bool begin(std::span<const double> a, std::span<const double> b);
  /// A slot with the configuration at t; -1 if no slot is left or a body is beyond
  /// EdgeModel::reach.
  int place(double t);
  /// As place(), but once for each multiple of 1 / kSharedPlaces while its slot is in use.
  int slotAt(double t);
  int used() const { return used_; }
  /// Frees all slots from `used` on.
  void release(int used) {
    used_ = used;
    ++generation_;
  }
  /// Changes whenever a slot may get another configuration.
  std::uint64_t generation() const { return generation_; }

  const CompiledScene& scene() const { return *scene_; }
  const std::shared_ptr<const CompiledScene>& sharedScene() const { return scene_; }
  // The current edge: its start and difference in the space, the difference in the model's
  // variables, and how far each joint moves.
  std::span<const double> start() const { return a_; }
  std::span<const double> difference() const { return difference_; }
  std::span<const double> configurationDifference() const { return dq_; }
  std::span<const robots::JointMotion> jointMotion() const { return joint_motion_; }
  /// The joints that edges can move.
  std::span<const int> movedJoints() const { return moved_joints_; }
  /// True if the angles of two joints between a pair's links prove that the pair keeps more than
  /// `threshold` [m] from t0 to t1 (robots::LinkGap). O(cells of the table that the angles cross).
  bool keepsGap(const EdgePair& pair, double threshold, double t0, double t1) const;
  /// From now on, adds the cost of placing and of tables to `work`.
  void countInto(collision::Work& work) { work_ = &work; }
  bool isWithinLimits() const { return within_limits_; }
  const EdgeScene& edges() const { return *edges_; }
  const EdgePairs& pairs() const { return edges_->pairs; }
  /// A pair by its number. A pair of the table is constructed once and kept. O(1).
  EdgePair pair(int number) const {
    const std::span<const EdgePair> listed = edges_->pairs.listed();
    if (at(number) < listed.size()) return listed[at(number)];
    const EdgePair* const known = known_pairs_.find(number - static_cast<int>(listed.size()));
    return known != nullptr ? *known : findPair(number);
  }
  /// A piece by its number. The reference to a piece in a place is valid until the next call for
  /// such a piece; a pair has at most one. O(1).
  const Piece& piece(int number) const {
    const std::span<const Piece> listed = edges_->pieces.listed();
    if (at(number) < listed.size()) return listed[at(number)];
    const Piece* const known = known_pieces_.find(number - static_cast<int>(listed.size()));
    return known != nullptr ? *known : findPiece(number);
  }

  std::span<const Pose> links(int slot) const { return {&poses_[at(slot) * links_], links_}; }
  /// Centre of a piece's ball, in the world.
  const Eigen::Vector3d& center(int slot, int number) const {
    const Piece& p = piece(number);
    return p.link < 0 ? p.bounds().outer.center
                      : centers_[at(slot) * moving_.size() + at(p.moving)];
  }
  /// Whether both shapes are convex. A sweep of such a pair also detects containment.
  bool isConvex(const EdgePair& pair) const {
    return piece(pair.a).shape().isConvex() && piece(pair.b).shape().isConvex();
  }
  /// Appends the pairs of a row that may not keep their thresholds plus `reach` >= 0 [m] at a
  /// slot's configuration, in any order. False if `pairs` has no room for all. Descends the boxes
  /// of static bodies.
  bool nearInRow(std::size_t row, int slot, double reach, collision::SpareVector<int>& pairs) const;
  Pose piecePose(int slot, int number) const;
  /// X_BA of a pair's pieces.
  Pose relative(int slot, const EdgePair& pair) const;
  /// A point of the world in the frame of a piece's coarse shape: the frame of its link, or the
  /// world.
  Eigen::Vector3d inFrameOf(int slot, int number, const Eigen::Vector3d& p_W) const;

  /// Bounds on a motion within `half` (in t) of a slot's configuration; see
  /// robots::localMotionBound().
  robots::MotionBound motionNear(int motion, int slot, double half) const;

 private:
  EdgePair findPair(int number) const;
  const Piece& findPiece(int number) const;
  void take();
  /// Takes an edge's ends; false as for begin().
  bool takeLines(std::span<const double> a, std::span<const double> b);
  bool takeAny(std::span<const double> a, std::span<const double> b);
  bool isExact(std::span<const double> point) const;
  bool isWellFormed(std::span<const double> point) const;

  std::shared_ptr<const CompiledScene> scene_;
  const EdgeScene* edges_ = nullptr;  // the scene's
  mutable collision::PairTable<EdgePair> known_pairs_;
  mutable collision::PairTable<Piece> known_pieces_;
  std::span<const int> moving_;
  /// The range from t0 to t1.
  robots::LinkGap::Range range(const EdgeModel::Angle& angle, double t0, double t1) const;
  std::size_t links_;
  collision::Work* work_ = nullptr;
  int capacity_;
  int used_ = 0;
  std::uint64_t generation_ = 0;
  static constexpr int kSharedPlaces = 1 << 9;
  collision::SpareArray<int> shared_slots_;  // of slotAt(); -1: none
  std::uint64_t shared_generation_ = 0;      // in which they were set
  bool only_lines_ = false;                  // in the space
  bool within_limits_ = true, watch_reach_ = false;
  std::vector<double> numbers_;  // all of the following
  std::span<double> a_, b_, difference_, point_, q_, dq_;
  std::span<const double> largest_;  // RobotMotions::largest_exact
  std::vector<robots::JointMotion> joint_motion_;
  std::span<const int> moved_joints_;
  // Data by slot. Memory is reserved for all slots and constructed slot by slot, because few edges
  // use many.
  collision::SpareVector<Pose> poses_;               // one per link
  collision::SpareVector<Eigen::Vector3d> centers_;  // one per moving piece
};

}  // namespace leeway::planner
