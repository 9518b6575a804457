#pragma once

// Private to planner/: the pairs that are checked along an edge, and its configurations, each
// placed once.

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
#include "leeway/robots/motion_bound.h"

namespace leeway::planner {

using collision::Pose;

/// One geometry of the scene, ready to be placed.
struct Piece {
  int body = -1;
  int link = -1;    ///< that carries it; -1: the world
  int moving = -1;  ///< its number among those that move
  const collision::Geometry* geometry = nullptr;
  const collision::GeometryBounds* bounds = nullptr;  ///< in the link's frame, or the world's
  bool at_origin = false;                             ///< X_BG is the identity
  bool is_free_mesh = false;  ///< a mesh that a planned floating or planar joint carries
  /// For pieces of the world: the absolute coordinates of the inverse of their pose and of
  /// their ball's centre, added up [m].
  double scale = 0;
};

/// The geometries of a scene. The piece of a geometry in a place is made by each call, because
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

/// One pair of the scene. Piece a is swept, seen from piece b.
struct EdgePair {
  int scene_pair;
  int a, b;          ///< pieces
  int motion;        ///< of a seen from b's link, index into EdgeModel::motions
  double threshold;  ///< that separation must exceed: margin + rounding [m]
  double rounding;   ///< of the poses that a separation is computed from [m]
  bool is_self;      ///< of two parts of the robot
  bool is_reversed;  ///< a is the scene's second body
  bool by_surfaces;  ///< swept by collision::sweepMesh(); its margin is not negative
  int gap = -1;      ///< index of the table of its links' gap by joint angles; -1: none
};

/// The pairs of a scene: those that the scene lists, by their first piece, then as in the scene,
/// and those of its table (see collision::ScenePairs), which have the numbers that they have there.
class EdgePairs {
 public:
  /// How many there are.
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  /// All numbers are below this.
  std::size_t numbers() const { return numbers_; }
  /// O(1).
  EdgePair operator[](std::size_t number) const {
    return number < listed_.size() ? listed_[number] : inTable(number, pieceOf(number));
  }
  /// A pair of the table, from its piece that stands still.
  EdgePair inTable(std::size_t number, const Piece& still) const;

  /// EdgePair::scene_pair.
  int numberInScene(int number) const {
    return at(number) < listed_.size() ? listed_[at(number)].scene_pair : number;
  }

  /// A piece that moves, with its pairs in the table; one for each of the scene's rows.
  struct Row {
    int piece, motion;
    double most_threshold;  ///< of its pairs, at least 0; NaN where one is [m]
  };
  std::span<const Row> rows() const { return rows_; }
  /// The piece in a place; that of the first place is the first.
  int pieceIn(std::size_t place) const { return first_still_ + static_cast<int>(place); }
  /// That of a pair of the table.
  int stillOf(std::size_t number) const;

  /// The first pairs.
  std::span<const EdgePair> listed() const { return listed_; }

  /// Of all pairs, at most [m]; NaN where one is.
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

/// What all edges of a compiled scene ask of it. Constant; shared by its certifiers.
struct EdgeScene {
  /// Borrows from the scene. O(geometries outside places + listed pairs + rows).
  explicit EdgeScene(const CompiledScene& scene);
  EdgeScene(const EdgeScene&) = delete;
  EdgeScene& operator=(const EdgeScene&) = delete;

  Pieces pieces;            ///< one a geometry
  std::vector<int> moving;  ///< the pieces that move
  EdgePairs pairs;
  std::vector<const robots::LinkGap*> gaps;
  bool has_surface_pairs = false;  ///< some pair is by_surfaces
};

/// Places configurations a + t dq of one edge in numbered slots. Allocates in the constructor only.
class EdgeFrames {
 public:
  EdgeFrames(std::shared_ptr<const CompiledScene> scene, int capacity);

  /// Takes a variant of the same scene with as many pairs; no slot is in use afterwards.
  void rebind(std::shared_ptr<const CompiledScene> scene);

  /// Starts an edge: no slot is in use afterwards. False when it cannot be certified at all:
  /// numbers that are not finite, angles too large to be exact, a quaternion of no length, a joint
  /// that has no room and is not in its place, or a mimic joint that would jump.
  bool begin(std::span<const double> a, std::span<const double> b);
  /// A slot with the configuration at t; -1 when none is left or a body is beyond EdgeModel::reach.
  int place(double t);
  /// place(), once for each multiple of 1 / kSharedPlaces while its slot is in use.
  int slotAt(double t);
  int used() const { return used_; }
  /// Frees all slots from `used` on.
  void release(int used) {
    used_ = used;
    ++generation_;
  }
  /// Changes whenever a slot may come to hold another configuration.
  std::uint64_t generation() const { return generation_; }

  const CompiledScene& scene() const { return *scene_; }
  const std::shared_ptr<const CompiledScene>& sharedScene() const { return scene_; }
  // Of the edge begun: its start and difference in the space, the difference in the model's
  // variables, and how far each joint moves.
  std::span<const double> start() const { return a_; }
  std::span<const double> difference() const { return difference_; }
  std::span<const double> configurationDifference() const { return dq_; }
  std::span<const robots::JointMotion> jointMotion() const { return joint_motion_; }
  /// The joints that edges can move.
  std::span<const int> movedJoints() const { return moved_joints_; }
  /// True when the angles of two joints between a pair's links prove that it keeps more than
  /// `threshold` [m] from t0 to t1 (robots::LinkGap). O(cells of the table that the angles cross).
  bool keepsGap(const EdgePair& pair, double threshold, double t0, double t1) const;
  /// Counts what placing and tables cost into `work` from now on.
  void countInto(collision::Work& work) { work_ = &work; }
  /// Whether some pair is by_surfaces.
  bool hasSurfacePairs() const { return edges_->has_surface_pairs; }
  bool isWithinLimits() const { return within_limits_; }
  const EdgePairs& pairs() const { return edges_->pairs; }
  /// A pair by its number; one of the table is made once and kept. O(1).
  EdgePair pair(int number) const {
    const std::span<const EdgePair> listed = edges_->pairs.listed();
    if (at(number) < listed.size()) return listed[at(number)];
    const EdgePair* const known = known_pairs_.find(number - static_cast<int>(listed.size()));
    return known != nullptr ? *known : findPair(number);
  }
  /// A piece by its number. The reference to one in a place holds until the next call for one in a
  /// place; a pair has at most one. O(1).
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
    return p.link < 0 ? p.bounds->outer.center : centers_[at(slot) * moving_.size() + at(p.moving)];
  }
  /// Both shapes are convex: then a sweep sees containment, too.
  bool isConvex(const EdgePair& pair) const {
    return piece(pair.a).geometry->shape.isConvex() && piece(pair.b).geometry->shape.isConvex();
  }
  /// Appends the pairs of a row that may not keep their thresholds plus `reach` >= 0 [m] at a
  /// slot's configuration, in no order. False where `pairs` has no room for all. A descent of the
  /// boxes of what stands still.
  bool nearInRow(std::size_t row, int slot, double reach, collision::SpareVector<int>& pairs) const;
  Pose piecePose(int slot, int number) const;
  /// X_BA of a pair's pieces.
  Pose relative(int slot, const EdgePair& pair) const;
  /// A point of the world in the frame of a piece's coarse shape: its link's, or the world's.
  Eigen::Vector3d inFrameOf(int slot, int number, const Eigen::Vector3d& p_W) const;

  /// Bounds on a motion within `half` (in t) of a slot's configuration, see
  /// robots::localMotionBound().
  robots::MotionBound motionNear(int motion, int slot, double half) const;

 private:
  EdgePair findPair(int number) const;
  const Piece& findPiece(int number) const;
  void take(const EdgeScene& edges);
  void findMovedJoints();
  /// Takes an edge's ends; false as begin().
  bool takeLines(std::span<const double> a, std::span<const double> b);
  bool takeAny(std::span<const double> a, std::span<const double> b);
  bool hasExactAngles(std::span<const double> point) const;
  bool isWellFormed(std::span<const double> point) const;

  std::shared_ptr<const CompiledScene> scene_;
  const EdgeScene* edges_ = nullptr;  // the scene's
  mutable collision::PairTable<EdgePair> known_pairs_;
  mutable collision::PairTable<Piece> known_pieces_;
  std::span<const int> moving_;
  /// A joint's angle is multiplier * a planned number + offset [rad]; place < 0: the offset alone.
  struct Angle {
    int place;
    double multiplier, offset;
  };
  /// The gap between a pair's links by two joints' angles.
  struct Gap {
    const robots::LinkGap* table;
    Angle joint, other;
  };
  /// Needs q_ for joints that are not planned.
  Angle angleOf(int joint) const;
  /// From t0 to t1.
  robots::LinkGap::Range range(const Angle& angle, double t0, double t1) const;
  std::vector<Gap> gaps_;
  std::size_t links_;
  collision::Work* work_ = nullptr;
  int capacity_;
  int used_ = 0;
  std::uint64_t generation_ = 0;
  static constexpr int kSharedPlaces = 1 << 9;
  struct SharedSlot {
    std::uint64_t generation = 0;
    int slot = -1;
  };
  std::vector<SharedSlot> shared_slots_;  // of slotAt()
  bool only_lines_ = false;               // in the space
  bool within_limits_ = true, watch_reach_ = false;
  std::vector<double> a_, b_, difference_, point_, q_, dq_;
  std::vector<robots::JointMotion> joint_motion_;
  std::vector<int> moved_joints_;
  // Slot by slot. Room is reserved for all, and begun slot by slot: few edges use many.
  collision::SpareVector<Pose> poses_;               // one a link
  collision::SpareVector<Eigen::Vector3d> centers_;  // one a moving piece
};

}  // namespace leeway::planner
