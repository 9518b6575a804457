#pragma once

// The data of LaneSweep, in the form that its kernels read.

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "collision/base/pair_table.h"
#include "collision/base/spare_memory.h"
#include "collision/base/work.h"
#include "collision/convex/gjk/convex_view.h"
#include "collision/lanes/lane_sweep.h"
#include "collision/lanes/obstacle_boxes.h"
#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

inline void setSingle(const Eigen::Vector3d& p, float* single) {
  for (int k = 0; k < 3; ++k) single[k] = static_cast<float>(p[k]);
}

struct LaneSweep::Impl {
  enum class Kind : unsigned char { kBox, kCylinder, kHalfSpace };
  /// The shape of an obstacle, in double precision.
  struct Exact {
    std::shared_ptr<const Shape> kept;  // null: another owner keeps it
    const Shape* shape = nullptr;
    Pose X_WG;
    ConvexView view;  // of the shape or its hull; borrows from it
  };
  static Exact exactOf(const Shape& shape, const Pose& X_WG);
  static Exact keptExactOf(const Shape& shape, const Pose& X_WG);
  /// A box, a cylinder, or the half-space z <= 0. Points and segments are boxes with size 0 in some
  /// axes.
  struct Core {
    Kind kind = Kind::kBox;
    bool aligned = false;  // its axes are parallel to the world's
    float rotation[9];     // from the world to its own axes, row by row
    float center[3], half[3];
  };
  /// A core, grown by a radius.
  struct Obstacle : Core {
    bool exact = false;  // identical to the shape, not a box or cylinder around it
    float radius = 0;
    double scale = 0;  // magnitudes that its rounding is relative to [m]
    bool has_view = false, deforms = false;
    int parts_begin = 0, parts_end = 0;  // indices into obstacles
    std::int32_t place = -1;             // in the world; -1: none
    int balls = -1;                      // Pair::balls of its pairs with the world
    Exact exact_shape;
  };
  struct LaneBall {
    float center[3], radius;
  };
  struct LanePiece {
    int frame, motion;
    LaneBall outer;
    int cover, inner, end;  // balls [cover, inner) and [inner, end)
    double reach;
    std::int32_t row = -1;    // -1: it has no pairs with the world
    std::int32_t group = -1;  // index into groups; -1: none
    float row_above = 0;      // the greatest free_above of its row's pairs
    float inner_reach = 0;    // inner balls are within this of outer's centre [m]
    // Points whose hull, grown by a radius, contains the piece: `points` are a few, `fine` are
    // more, with a smaller radius. Both may be the same.
    struct Points {
      int begin = 0, end = 0;
      float radius = 0;
      int clusters_begin = 0, clusters_end = 0;  // clusters with all points; or no clusters
    };
    Points points, fine;
    float own = -1;   // points belong to the piece within this [m]; below 0: not all do
    ConvexView view;  // of `points`; borrows from Impl::points; without points: not made yet
    ConvexView fine_view;
    int parts_begin = 0, parts_end = 0;  // indices into pieces
  };
  struct Pair {
    int id, a;  // its number; a piece
    int b;      // for a place without an obstacle: -1 - the place
    int balls;  // the piece whose balls contain b, if b is an obstacle; otherwise b; -1: none
    int motion;
    bool pieces;  // b is also a piece
    // The threshold plus and minus the rounding of this pass.
    float free_above, contact_below;
    // free_above for single balls of a cover, at least 0. Depths of single balls do not bound the
    // depth of all, because each ball may have a different shortest way out.
    float cover_above;
    // free_above for planes from queries and for planes computed in each lane, without the points'
    // radius; below 0: no such planes.
    float plane_above, own_plane_above;
    bool by_parts = false, has_proof = false;  // see addPair()
    std::uint8_t kind = 1;                     // 0: there is no such pair
    // The number of pairs that its convex parts make (or one side's parts with the other side as a
    // whole), which are tried if the hulls of the wholes are not apart; those of b's parts are
    // adjacent. These pairs are not listed. 0: the pair is not tried by parts.
    int parts = 0;
    const Obstacle* made = nullptr;  // used if b has no obstacle, see LaneSweepKernel::pair()
    bool hasObstacle() const { return b >= 0; }
    std::int32_t place() const { return -1 - b; }
  };
  /// A pair with more pairs of parts than this is not tried by parts [count].
  static constexpr int kMostPartPairs = kCoverParts * kCoverParts;
  struct Range {
    int begin, end;
    int size() const { return end - begin; }
  };
  /// The parts of a piece or an obstacle, or the thing itself if it has none.
  template <class Thing>
  static Range partsOf(const std::vector<Thing>& things, int i) {
    const Thing& thing = things[static_cast<std::size_t>(i)];
    return thing.parts_begin < thing.parts_end ? Range{thing.parts_begin, thing.parts_end}
                                               : Range{i, i + 1};
  }
  Range partsOfA(const Pair& pair) const { return partsOf(pieces, pair.a); }
  Range partsOfB(const Pair& pair) const {
    if (!pair.hasObstacle()) return {pair.b, pair.b + 1};
    return pair.pieces ? partsOf(pieces, pair.b) : partsOf(obstacles, pair.b);
  }

  /// Neighbouring points and a ball around them, grown by the rounding of both, so that the points
  /// of most clusters can be skipped.
  struct Cluster {
    float center[3], radius;
    int begin, end;
  };
  /// Balls and points of all pieces. Copies of a sweep share them until one of them adds more.
  struct Stock {
    std::vector<LaneBall> balls;
    std::vector<Eigen::Vector3d> points;
    std::vector<float> point[3];  // `points`, coordinate by coordinate
    // For each point: itself, or the fine point of its piece that is nearest to it. A search by
    // fine points starts there.
    std::vector<std::int32_t> nearest_fine;
    std::vector<Cluster> clusters;
  };
  std::shared_ptr<Stock> stock = std::make_shared<Stock>();
  bool owns_stock = true;  // false for copies, which other threads may use
  /// Returns the stock for additions; from then on it is not shared.
  Stock& ownStock();
  // Pointers into the stock, set by finish().
  const LaneBall* balls = nullptr;
  const Eigen::Vector3d* points = nullptr;
  const float* point[3] = {nullptr, nullptr, nullptr};
  const std::int32_t* nearest_fine = nullptr;
  const Cluster* clusters = nullptr;

  std::vector<LanePiece> pieces;  // wholes, then parts
  std::size_t wholes = 0;
  std::vector<LanePiece> parts;     // until finish()
  std::vector<Obstacle> obstacles;  // wholes, then parts
  std::size_t whole_obstacles = 0;
  std::vector<Obstacle> obstacle_parts;
  std::vector<Pair> pairs;  // of wholes
  // Numbers of pairs with parts are below the first; the second is the largest Pair::parts.
  std::size_t pairs_with_parts = 0, most_parts = 0;
  std::vector<std::int32_t> piece_pairs;  // indices into pairs, those of bundles first
  /// Pieces that are tested together; `piece` has their balls.
  struct Group {
    std::int32_t piece;
    std::int32_t begin, end;  // of group_members
  };
  std::vector<Group> groups;
  std::vector<std::int32_t> group_members;  // pieces
  /// The pairs of a group's pieces with another piece.
  struct Bundle {
    std::int32_t group, other;
    std::int32_t begin, end;                  // of piece_pairs
    std::int32_t motions_begin, motions_end;  // of bundle_motions: see addBundle()
    float above;                              // at least cover_above of each pair
    std::uint8_t kind;
  };
  std::vector<Bundle> bundles;
  std::vector<std::int32_t> bundle_motions;
  std::shared_ptr<const ObstacleBoxes> boxes;  // of the world; null if there is none
  /// The number of the pair of a piece with the shape in a slot of `boxes`; -1: the slot is empty.
  std::int32_t pairOf(const LanePiece& piece, std::size_t slot) const {
    const std::int32_t place = boxes->obstacle(slot);
    return place < 0 ? -1
                     : static_cast<std::int32_t>(pairs.size() +
                                                 static_cast<std::size_t>(piece.row) * places) +
                           place;
  }
  std::shared_ptr<const LaneWorld> world;
  std::vector<Row> rows;
  std::size_t places = 0;
  double scale_of_world = 0;  // see setWorld() [m]
  /// A pair of `pairs` with an obstacle. Pieces outside the box are not near the obstacle.
  struct Loose {
    std::int32_t pair;
    float low[3], high[3];
  };
  std::vector<Loose> loose_pairs;
  std::vector<int> placed_obstacles;  // obstacles in places, in ascending order of the places
  /// The obstacle in a place; -1 if none was added.
  int obstacleAt(std::int32_t place) const;
  /// Makes the obstacle of a shape in a place that was not added.
  Obstacle obstacleIn(std::int32_t place) const;
  /// The pair with a number beyond those of `pairs`; its kind is 0 if the two may touch.
  Pair pairWithWorld(std::int32_t number) const;
  /// Makes a pair; `o` is the obstacle with number `b`.
  Pair pairWith(int id, int piece, const Obstacle& o, int b, int balls, double threshold,
                bool by_parts) const;
  void setParts(Pair& pair) const;
  void findRows();
  void findLoosePairs();
  static Obstacle obstacleOf(const Shape& shape, const Pose& X_WG);
  /// The box around a shape in the world, without rounding [m].
  static Eigen::AlignedBox3d boxOf(const Shape& shape, const Pose& X_WG);
  static Obstacle partOf(const CoverPart& part, const Pose& X_WG);
  void finish();
  void addParts();
  void makeViews(std::vector<LanePiece>& of) const;
  void findBundles();
  void addBundle(std::int32_t group, std::int32_t other, std::span<const std::int32_t> of);
  /// Adds all points of a cover to the points of `piece`.
  void addPoints(const PointCover& cover, LanePiece& piece);
  static void addCluster(Stock& stock, int begin, int end);
};

struct LaneSweep::Scratch::Impl {
  Impl(collision::Scratch& queries, Work& of_runs) : distance(queries), work(of_runs) {}

  struct Placed {
    LaneValues center[3];  // in the middle of each interval
    LaneValues way[3];     // displacement over half an interval
  };
  struct Candidate {
    float key;
    std::int32_t pair;
    std::int32_t piece;  // its first piece; -1: inner balls are not tested (again)
    std::uint32_t lanes;
  };
  SpareArray<Placed> outer, balls;  // one for each piece, one for each ball
  // The run in which the balls of a piece's cover, its inner balls, and a part's ball were placed.
  std::vector<std::uint64_t> cover_stamp, inner_stamp, part_stamp;
  std::vector<float> low, high;  // boxes around pieces' sweeps, three numbers each
  std::vector<char> group_near;  // whether any obstacle is near a group
  std::vector<Candidate> candidates;
  bool is_full = false;
  PairTable<LaneSweep::Impl::Pair> known;     // with the world
  PairTable<LaneSweep::Impl::Obstacle> made;  // by places
  std::vector<Open> open;
  std::vector<std::int32_t> open_pairs;  // indices into pairs, one for each of `open`
  /// A plane in B's frame with a normal from B to A: no point of B is beyond `offset` along it.
  struct Plane {
    float normal[3], offset;
    bool known = false;
  };
  PairTable<Plane> planes;        // the plane that last separated a pair
  PairTable<PairCache> searches;  // of the last query for a plane
  /// The stored data of a pair, or of a pair of parts.
  struct Memory {
    Plane* plane;
    PairCache* search;
  };
  Memory memoryOf(std::int32_t pair) { return {&planes.of(pair), &searches.of(pair)}; }
  /// Hints for a pair with parts: whether its parts were apart in the last run in which the hulls
  /// of its wholes were not, and the pair of parts that was last open.
  struct PartHint {
    bool by_parts = false;
    std::int32_t blocking = 0;
  };
  PairTable<PartHint> part_hints;
  struct PartMemory {
    Plane plane;
    PairCache search;
  };
  static_assert(std::is_trivially_destructible_v<PartMemory>);
  // Blocks whose size is the largest number of part pairs of any pair, addressed as in a PairTable.
  // A block is initialized when a pair is first tried by parts, because few pairs are.
  static constexpr std::size_t kPartBlocks = 1U << 8U;
  SpareArray<std::byte> part_memory;
  std::vector<std::int32_t> part_owners;  // the pair that owns a block; -1: none
  /// The memory of the pairs of parts of a pair.
  PartMemory* partsOf(const LaneSweep::Impl::Pair& pair, std::size_t most_parts);
  collision::Scratch& distance;
  Work& work;  // counts passes and the queries of `distance`
  std::uint64_t stamp = 0;
  /// A pair that was found in contact, and the point that was inside; point -1: found by balls.
  struct PastContact {
    std::int32_t pair = -1, point = -1;
  };
  // This many are tested first. With four, searches of ur5 take a fifth longer.
  static constexpr int kContacts = 12;
  PastContact contacts[kContacts];  // the most recent first
};

/// One run's arguments, and its steps.
struct LaneSweepKernel {
  using Sweep = LaneSweep::Impl;
  using Scratch = LaneSweep::Scratch::Impl;
  using Open = LaneSweep::Open;
  using Contact = LaneSweep::Contact;
  const Sweep& sweep;
  Scratch& scratch;
  const LaneFrame* frames;
  const float* growth;
  float slack;
  LaneSweep::Asked asked = {};

  /// The pair with a number. A pair with the world is valid until the next such call.
  const Sweep::Pair& pair(std::int32_t number) const {
    const auto added = static_cast<std::int32_t>(sweep.pairs.size());
    if (number < added) return sweep.pairs[static_cast<std::size_t>(number)];
    Sweep::Pair& pair = scratch.known.of(
        number - added, [this, number](std::int32_t) { return sweep.pairWithWorld(number); });
    if (pair.made == nullptr ? !pair.hasObstacle() : scratch.made.isShared()) findObstacle(pair);
    return pair;
  }
  /// Sets Pair::made.
  void findObstacle(Sweep::Pair& pair) const;
  /// The obstacle of a pair that does not join two pieces; `b`: one of partsOfB().
  const Sweep::Obstacle& obstacle(const Sweep::Pair& pair) const { return obstacle(pair, pair.b); }
  const Sweep::Obstacle& obstacle(const Sweep::Pair& pair, int b) const {
    return b >= 0 ? sweep.obstacles[static_cast<std::size_t>(b)] : *pair.made;
  }
  /// Stores a contact and returns it, in the first of `lanes`.
  Contact noteContact(std::int32_t pair, std::int32_t point, std::uint32_t lanes) const;
  /// Finds a plane between the pair's bodies in the middle of a lane's interval; false if they are
  /// not apart. `closely`: by fine points and to a smaller tolerance. `cache`: that of the pair's
  /// last such query, or null.
  bool findPlane(const Sweep::Pair& pair, int lane, bool closely, Scratch::Plane& plane,
                 PairCache* cache = nullptr) const;
  /// A plane for each lane: the lanes that are still open, those of them in which the search
  /// reached the obstacle, and the normals of the others.
  struct OwnPlanes {
    std::uint32_t open = 0, touching = 0;
    LaneValues normal[3];
  };
  /// The lanes of a pair that planes leave open, and the state of its hulls in the middle of these
  /// intervals: apart in all of them, or in contact in one, as far as the search can determine.
  struct Separation {
    std::uint32_t open;
    bool apart, touching;
  };
  // The following functions take a pair of wholes or of parts, with its stored data.

  /// Separates by a plane for each lane.
  Separation separateByOwnPlanes(const Sweep::Pair& pair, Scratch::Memory memory,
                                 std::uint32_t lanes) const;
  /// Separates by planes between the hulls, found by distance queries, each for all of the lanes:
  /// removes the lanes that these separate. Returns whether the hulls are apart in the median of
  /// the others.
  bool separateByQueries(const Sweep::Pair& pair, Scratch::Memory memory, bool closely,
                         std::uint32_t& lanes) const;
  /// Separates by both methods.
  Separation separatePair(const Sweep::Pair& pair, Scratch::Memory memory, std::uint32_t lanes,
                          bool closely) const;
  /// Separates a pair of parts, first by the plane that last separated it.
  Separation separateParts(const Sweep::Pair& pair, Scratch::PartMemory& memory,
                           std::uint32_t lanes, bool closely) const;
  /// Stores a lane's plane as the one that last separated the pair.
  void remember(const Sweep::Pair& pair, const OwnPlanes& planes, int lane,
                Scratch::Plane& plane) const;

  /// Separates by the pairs of its parts; apart if all open ones are.
  Separation separateByParts(std::int32_t pair, std::uint32_t lanes, bool closely) const;
  /// Sets the plane's offset: the obstacle's support along its normal.
  void placePlane(const Sweep::Obstacle& obstacle, Scratch::Plane& plane) const;
  /// Searches for a few points of each open pair in its obstacle.
  Contact contactOfOpen() const;
  /// Tries planes on the open pairs, then searches for more points in obstacles.
  Contact separateOpen(bool closely) const;
};

}  // namespace leeway::collision
