#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "collision/base/spare_memory.h"
#include "collision/base/work.h"
#include "collision/cover/ball_cover.h"
#include "collision/cover/coarse_shape.h"
#include "collision/cover/point_cover.h"
#include "collision/lanes/lane_frames.h"
#include "collision/lanes/obstacle_boxes.h"

namespace leeway::collision {

/// The world of a LaneSweep: fixed shapes, by place. Constant.
class LaneWorld {
 public:
  virtual ~LaneWorld() = default;
  struct Placed {
    const Shape* shape = nullptr;  ///< must live as long as the LaneWorld; null: `ball` is there
    Pose X_WG;                     ///< of the shape
    Ball ball;                     ///< in the world
  };
  virtual Placed placed(int place) const = 0;
  struct Pair {
    double threshold = 0;  ///< [m]
    bool by_parts = true;  ///< see LaneSweep::addPair()
  };
  /// The pair of a row's piece with the shape in a place; nullopt: they may touch.
  virtual std::optional<Pair> pairOf(int row, int place) const = 0;
};

/// The coarse pass of edge certification: moving pieces against each other and against fixed
/// obstacles, over kLanes intervals of one motion at once. Constant once built.
///
/// Over an interval, the centre of a ball stays within `growth` of a segment through its position
/// in the middle, so the ball stays in a capsule. A capsule is apart from a convex shape if the
/// plane through the shape's point nearest to the capsule's middle separates them. If the capsules
/// of a pair leave intervals open, these are tried in turn:
///   1. the plane that separated the hulls of both bodies' points last;
///   2. the points themselves: one inside an obstacle proves a contact;
///   3. planes found for each lane, and by distance queries in the middle of open intervals;
///   4. convex parts of both, where the bodies are far from convex and their hulls are not apart.
class LaneSweep {
 public:
  /// A geometry on a frame (-1: the world); its balls are in that frame's axes.
  struct Piece {
    int frame = -1;
    int motion = -1;               ///< motion of its points in the world: index into run()'s growth
    Ball outer;                    ///< holds the piece
    std::vector<Ball> cover;       ///< their union contains the piece, including its inside
    std::vector<Ball> inner;       ///< each inside the piece
    PointCover points;             ///< if empty, no planes are tried
    std::vector<CoverPart> parts;  ///< their union contains the piece, including its inside; may be
                                   ///< empty
    double reach = 0;  ///< centres of its balls stay within this of the world's origin [m]
  };

  LaneSweep();
  ~LaneSweep();
  LaneSweep(LaneSweep&&) noexcept;
  LaneSweep& operator=(LaneSweep&&) noexcept;
  /// Copies everything that was added before finish(), so that more can be added. Balls and points
  /// are shared until pieces are added. Many threads may copy at once. O(pieces + obstacles +
  /// pairs).
  LaneSweep(const LaneSweep& begun);
  LaneSweep& operator=(const LaneSweep&) = delete;

  int addPiece(const Piece& piece);
  /// Adds a group: pieces of one frame that are tested together first. If the group's balls are
  /// apart from something, its pieces are not tested separately. `balls`: those of the group, in
  /// the frame's axes. They contain all pieces with their insides, and their centres are in the
  /// hull of the centres of the pieces' balls.
  void addGroup(std::span<const int> pieces, std::span<const Ball> balls);
  /// Adds a fixed shape: spheres, capsules, boxes, cylinders and half-spaces are used exactly, a
  /// cone as a cylinder, and any other shape as a box around it. `place`: its place in the world;
  /// -1: it has none, and a copy is kept. O(vertices).
  int addObstacle(const Shape& shape, const Pose& X_WG, int place = -1);
  /// The box around such a shape in the world, rounding included.
  static ObstacleBoxes::Box boxAround(const Shape& shape, const Pose& X_WG);
  /// boxAround() a ball of a body; `origin` is that of the body's frame, in the world.
  static ObstacleBoxes::Box boxAroundBall(const Ball& ball, const Eigen::Vector3d& origin);
  /// Whether a shape of the world must be added as an obstacle: it has balls or parts in addition
  /// to its box, or it deforms and is therefore near everything. All others are made when they are
  /// near.
  static bool needsObstacle(const Shape& shape) {
    const ShapeType type = shape.type();
    return type == ShapeType::kMesh || type == ShapeType::kConvexHull ||
           type == ShapeType::kDeformable;
  }
  /// The magnitude that the rounding of such an obstacle in the world is relative to [m].
  static double scaleOf(const Shape& shape, const Pose& X_WG);
  /// Adds a pair: piece and obstacle must keep a separation above `threshold` [m]. Use it for few
  /// pairs; setWorld() adds many. Answers identify a pair by its number in the order of addition.
  /// `balls`: a piece of the world whose balls also contain the obstacle, or -1; they may settle
  /// intervals that the obstacle's box leaves open. `by_parts`: convex parts may also settle them.
  /// `kind`: a bit, see Asked. `has_proof`: run() queries the caller's Proofs for the pair.
  void addPair(int piece, int obstacle, int balls, double threshold, bool by_parts = true,
               std::uint8_t kind = 1, bool has_proof = false);
  void reservePairs(std::size_t count);
  /// addPair() for two pieces; `motion` is that of A's points in B's frame.
  void addPiecePair(int a, int b, int motion, double threshold, bool by_parts = true,
                    std::uint8_t kind = 1, bool has_proof = false);
  /// Adds pairs of each row's piece with the shapes in `boxes`, one place each. Their numbers
  /// follow those of added pairs, row by row, one for each place; they are of kind kOfWorld.
  /// `scale`: at least scaleOf() of every shape in a place [m].
  static constexpr std::uint8_t kOfWorld = 1;
  struct Row {
    int piece;
    double most_threshold;  ///< greatest threshold of its pairs, at least 0; NaN if one is NaN [m]
  };
  void setWorld(std::shared_ptr<const LaneWorld> world, std::span<const Row> rows,
                std::size_t places, std::shared_ptr<const ObstacleBoxes> boxes, double scale);
  /// The `balls` of addPair(), for an obstacle in a place.
  void setBalls(int obstacle, int balls);
  /// Limit on the pairs with the world in one pass [count].
  static constexpr std::size_t kMostNear = std::size_t{1} << 16U;
  /// Call this before a sweep is copied: it computes once the part of finish() that depends only on
  /// the pieces. O(points).
  void finishPieces();
  /// Call this after all additions, before making any Scratch.
  void finish();
  std::size_t bytes() const;

  /// A pair and the intervals in which it is not certified, a bit for each.
  struct Open {
    int id;
    std::uint32_t intervals;
    /// The hulls are apart in the middle of these intervals by more than rounding, so planes may
    /// separate them over shorter intervals.
    bool apart = false;
  };
  /// A pair that is proven not to keep its threshold in the middle of an interval.
  struct Contact {
    int id = -1;  ///< -1: none found
    int interval = 0;
  };

  /// Additional proofs by the caller. They are queried for pairs whose balls are near in some
  /// interval, before more expensive tests.
  class Proofs {
   public:
    virtual ~Proofs() = default;
    /// Whether the pair is proven to keep its threshold in all intervals. Must not allocate.
    virtual bool keeps(int id) const = 0;
  };

  /// Selection of pairs and proofs for run().
  struct Asked {
    std::uint8_t kinds = 0xFF;       ///< only pairs of these kinds are tested
    const Proofs* proofs = nullptr;  ///< null: there are none
  };

  /// The state of a run. Made after finish(); only the constructor allocates.
  class Scratch {
   public:
    /// `queries`: for the distance queries of plane searches. Runs count their work, and that of
    /// these searches must be counted (collision::countInto()), into `work`. Once its limit is
    /// reached, no more planes are searched, and pairs stay open. Both must outlive this object.
    Scratch(const LaneSweep& sweep, collision::Scratch& queries, Work& work);
    ~Scratch();
    /// The pairs that the last run did not certify, if it found no contact.
    std::span<const Open> open() const;
    /// Whether more than kMostNear pairs were near in the last pass over all pairs, so that some
    /// were not tested.
    bool isFull() const;
    /// After run(): removes, for each open() pair, intervals that the caller knows to be free;
    /// pairs without a remaining interval are no longer open. O(open pairs).
    void close(std::span<const std::uint32_t> intervals);

   private:
    friend class LaneSweep;
    friend struct LaneSweepKernel;
    struct Impl;
    std::unique_ptr<Impl> impl_;
  };

  /// Tests only the last contacts, in the middle of the intervals, because most colliding edges of
  /// a planner collide in the same pairs as the previous ones. Frames need only be placed, not
  /// moved.
  Contact meetAgain(std::span<const LaneFrame> frames, float slack, Scratch& scratch,
                    std::uint8_t kinds = 0xFF) const;
  /// One pass over frames that are placed and moved: by balls, by the last plane of each pair, by
  /// points. growth: h^2 A / 8 of each motion [m]; slack: how far the frames' rounding moves any
  /// capsule [m]. Which contacts are found and which pairs planes leave open depends on previous
  /// runs, but every answer is proven. O(pieces + pairs) at worst, and a descent of the world's
  /// boxes for each row; never throws or allocates.
  Contact run(std::span<const LaneFrame> frames, std::span<const float> growth, float slack,
              Scratch& scratch, const Asked& asked) const;
  /// Call this after a run() that found no contact, with the same frames, growth and slack. It
  /// searches planes between the pairs that stayed open, and sets Open::apart. O(open pairs), with
  /// a distance query of a few points for some of them.
  Contact separate(std::span<const LaneFrame> frames, std::span<const float> growth, float slack,
                   Scratch& scratch) const;
  /// Tests only planes and points, for some pairs in some intervals. Planes are searched to a
  /// smaller tolerance than in separate().
  Contact runPairs(std::span<const Open> pairs, std::span<const LaneFrame> frames,
                   std::span<const float> growth, float slack, Scratch& scratch) const;
  /// Searches a contact of one pair in the middle of the intervals, by balls and all points. Frames
  /// need only be placed.
  Contact meet(int pair, std::span<const LaneFrame> frames, float slack, Scratch& scratch) const;
  /// False for pairs whose balls and points can never prove a contact. O(1).
  bool canMeet(int pair, Scratch& scratch) const;
  /// run() and separate() at single configurations: frames need only be placed.
  Contact runStill(std::span<const LaneFrame> frames, float slack, Scratch& scratch) const;

 private:
  friend struct LaneSweepKernel;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace leeway::collision
