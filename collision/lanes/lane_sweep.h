#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "collision/base/spare_memory.h"
#include "collision/base/work.h"
#include "collision/cover/ball_cover.h"
#include "collision/cover/coarse_shape.h"
#include "collision/cover/point_cover.h"
#include "collision/lanes/lane_frames.h"
#include "collision/lanes/obstacle_boxes.h"

namespace leeway::collision {

/// The world of a LaneSweep: what stands still, by place. Constant.
class LaneWorld {
 public:
  virtual ~LaneWorld() = default;
  /// The shape in a place and its pose; the shape lives as long as this.
  virtual std::pair<const Shape*, Pose> placed(int place) const = 0;
  struct Pair {
    double threshold = 0;  ///< [m]
    bool by_parts = true;  ///< see LaneSweep::addPair()
  };
  /// The pair of a row's piece with the shape in a place; nothing: they may touch.
  virtual std::optional<Pair> pairOf(int row, int place) const = 0;
};

/// The coarse pass of edge certification: moving pieces against each other and against obstacles
/// that stand still, over kLanes intervals of one motion at once. Constant once built.
///
/// Over an interval the centre of a ball stays within `growth` of a segment through its position in
/// the middle, so the ball stays in a capsule. A capsule is apart from a convex shape where the
/// plane through the shape's point nearest to the capsule's middle separates them. Pairs whose
/// capsules leave lanes open are tried with
///   1. the plane that separated the hulls of both bodies' points last;
///   2. the points themselves: one inside an obstacle proves a contact;
///   3. planes found for each lane, and by distance queries in the middle of open intervals;
///   4. convex parts of both, where the bodies are far from convex and their hulls are not apart.
class LaneSweep {
 public:
  /// A geometry on a frame (-1: the world), its balls in that frame's axes.
  struct Piece {
    int frame = -1;
    int motion = -1;          ///< of its points, seen from the world: index into run()'s growth
    Ball outer;               ///< holds the piece
    std::vector<Ball> cover;  ///< their union holds the piece, its inside included
    std::vector<Ball> inner;  ///< each inside the piece
    PointCover points;        ///< without points: no planes
    std::vector<CoverPart> parts;  ///< their union holds the piece, its inside included; or empty
    double reach = 0;  ///< centres of its balls stay within this of the world's origin [m]
  };

  LaneSweep();
  ~LaneSweep();
  LaneSweep(LaneSweep&&) noexcept;
  LaneSweep& operator=(LaneSweep&&) noexcept;
  /// All that was added so far, before finish(), to add more: balls and points are shared until
  /// pieces are added. May be copied by many threads at once. O(pieces + obstacles + pairs).
  LaneSweep(const LaneSweep& begun);
  LaneSweep& operator=(const LaneSweep&) = delete;

  int addPiece(const Piece& piece);
  /// Pieces of one frame that are looked at together first: where the balls of all are apart from
  /// something, no piece is asked by itself. `balls`: of the group, in the frame's axes; they hold
  /// all pieces with their insides, and their centres are in the hull of those of the pieces'
  /// balls.
  void addGroup(std::span<const int> pieces, std::span<const Ball> balls);
  /// A shape that stands still: spheres, capsules, boxes, cylinders and half-spaces as they are, a
  /// cone as a cylinder, all else as a box around it. `place`: its place in the world; -1: it is in
  /// none, and is kept. O(vertices).
  int addObstacle(const Shape& shape, const Pose& X_WG, int place = -1);
  /// Around such a shape in the world, rounding included.
  static ObstacleBoxes::Box boxAround(const Shape& shape, const Pose& X_WG);
  /// Whether a shape of the world must be added as an obstacle: it has balls or parts besides its
  /// box, or deforms, and then is near everything. All others are made when they are near.
  static bool needsObstacle(const Shape& shape) {
    const ShapeType type = shape.type();
    return type == ShapeType::kMesh || type == ShapeType::kConvexHull ||
           type == ShapeType::kDeformable;
  }
  /// What rounding of such an obstacle is relative to, as it stands in the world [m].
  static double scaleOf(const Shape& shape, const Pose& X_WG);
  /// Adds a pair: piece and obstacle must keep a separation above `threshold` [m]. Such pairs
  /// should be few; setWorld() adds many. Answers name a pair by its number in the order of
  /// addition. `balls`: a piece of the world whose balls hold the obstacle, too, or -1; they may
  /// settle lanes that the obstacle's box leaves open. `by_parts`: convex parts may settle them,
  /// too. `kind`: a bit, see Asked. `has_proof`: run() looks for a proof of it.
  void addPair(int piece, int obstacle, int balls, double threshold, bool by_parts = true,
               std::uint8_t kind = 1, bool has_proof = false);
  void reservePairs(std::size_t count);
  /// addPair() of two pieces; `motion` is that of A's points, seen from B's frame.
  void addPiecePair(int a, int b, int motion, double threshold, bool by_parts = true,
                    std::uint8_t kind = 1, bool has_proof = false);
  /// Pairs of each row's piece with what stands in `boxes`, a place each. Their numbers follow
  /// those that were added, row by row, one a place; they are of kind kOfWorld. `scale`: at least
  /// scaleOf() of everything in a place [m].
  static constexpr std::uint8_t kOfWorld = 1;
  struct Row {
    int piece;
    double most_threshold;  ///< of its pairs, at least 0; NaN where one is [m]
  };
  void setWorld(std::shared_ptr<const LaneWorld> world, std::span<const Row> rows,
                std::size_t places, std::shared_ptr<const ObstacleBoxes> boxes, double scale);
  /// See addPair(): for an obstacle in a place.
  void setBalls(int obstacle, int balls);
  /// Pairs with the world that a pass has room for [count].
  static constexpr std::size_t kMostNear = std::size_t{1} << 16U;
  /// Before a sweep is copied: what finish() makes of its pieces alone is made once, here.
  /// O(points).
  void finishPieces();
  /// After all additions, before any Scratch.
  void finish();
  std::size_t bytes() const;

  /// A pair and the lanes in which it is not certified.
  struct Open {
    int id;
    std::uint32_t lanes;
    /// The hulls are apart in the middle of these intervals by more than rounding: over shorter
    /// ones planes may separate them.
    bool apart = false;
  };
  /// A pair that is proven not to keep its threshold in the middle of this lane's interval.
  struct Contact {
    int id = -1;  ///< -1: none found
    int lane = 0;
  };

  /// What else the caller can prove: asked of pairs whose balls are near in some lane, before what
  /// costs more.
  class Proofs {
   public:
    virtual ~Proofs() = default;
    /// Whether the pair keeps what it is asked for in all lanes. Must not allocate.
    virtual bool keeps(int id) const = 0;
  };

  /// What run() looks at.
  struct Asked {
    std::uint8_t kinds = 0xFF;       ///< pairs of these alone
    const Proofs* proofs = nullptr;  ///< null: there are none
  };

  /// What a run changes. Made after finish(); only the constructor allocates.
  class Scratch {
   public:
    explicit Scratch(const LaneSweep& sweep);
    ~Scratch();
    /// What the last run did not certify, where it found no contact.
    std::span<const Open> open() const;
    /// More than kMostNear pairs were near in the last pass over all: nothing is known of some.
    bool isFull() const;
    /// After run(): takes away, for each open() pair, lanes that the caller knows to be free; pairs
    /// without a lane left are no longer open. O(open pairs).
    void close(std::span<const std::uint32_t> lanes);

    /// Runs count their work into `work` from now on, which has to outlive this. Once it is spent,
    /// no more planes are searched, and pairs stay open.
    void countInto(Work& work);

   private:
    friend class LaneSweep;
    friend struct LaneSweepKernel;
    struct Impl;
    std::unique_ptr<Impl> impl_;
  };

  /// Looks for the last contacts alone, in the middle of the intervals: most colliding edges of a
  /// planner collide as the last ones did. Frames need only be placed, not moved.
  Contact meetAgain(std::span<const LaneFrame> frames, float slack, Scratch& scratch,
                    std::uint8_t kinds = 0xFF) const;
  /// One pass over frames that are placed and moved: by balls, by the last plane of each pair, by
  /// points. growth: h^2 A / 8 of each motion [m]; slack: how far the frames' rounding moves any
  /// capsule [m]. Which contacts are found and what planes leave open depends on the runs before;
  /// every answer is proven regardless. O(pieces + pairs) at worst, and a descent of the world's
  /// boxes for each row; never throws or allocates.
  Contact run(std::span<const LaneFrame> frames, std::span<const float> growth, float slack,
              Scratch& scratch, const Asked& asked) const;
  /// After a run() that found no contact, with the same frames, growth and slack: searches planes
  /// between the pairs that it left open, and sets Open::apart. O(open pairs), with a distance
  /// query of a few points for some of them.
  Contact separate(std::span<const LaneFrame> frames, std::span<const float> growth, float slack,
                   Scratch& scratch) const;
  /// Planes and points alone, for some pairs in some lanes. Planes are searched to a smaller
  /// tolerance than in separate().
  Contact runPairs(std::span<const Open> pairs, std::span<const LaneFrame> frames,
                   std::span<const float> growth, float slack, Scratch& scratch) const;
  /// Looks for a contact of one pair in the middle of the intervals: by balls and all points.
  /// Frames need only be placed.
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
