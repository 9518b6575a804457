#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "collision/base/work.h"
#include "collision/cover/ball_cover.h"
#include "collision/cover/coarse_shape.h"
#include "collision/cover/point_cover.h"
#include "collision/lanes/lane_frames.h"

namespace leeway::collision {

/// Balls of moving pieces, swept to capsules over kLanes intervals at once, against each other and
/// against what stands still: the coarse pass of edge certification. A ball's centre is within
/// `growth` of the straight way through its place in the middle of the interval, so that the ball
/// stays in a capsule; a capsule is told from a convex shape by the plane through the shape's point
/// that is nearest to the capsule's middle. What capsules leave open is tried with planes between
/// the hulls of points of both bodies, that which parted them last; with the points themselves,
/// each of which proves a contact where it is inside an obstacle; and with planes that a distance
/// query finds in the middle of the open intervals. Pieces that are far from convex are looked at
/// in parts where planes between the whole hulls will not do. Constant once built.
class LaneSweep {
 public:
  /// A thing on a frame (-1: the world), its balls in that frame's axes.
  struct Piece {
    int frame = -1;
    int motion = -1;          ///< that of its points seen from the world: a place in run()'s growth
    Ball outer;               ///< holds the piece
    std::vector<Ball> cover;  ///< together they hold the piece, its inside included
    std::vector<Ball> inner;  ///< each inside the piece
    PointCover points;        ///< may be without points: no planes then
    std::vector<CoverPart> parts;  ///< together they hold the piece, its inside included; or none
    double reach = 0;  ///< no centre of a ball comes farther from the world's origin [m]
  };

  LaneSweep();
  ~LaneSweep();
  LaneSweep(LaneSweep&&) noexcept;
  LaneSweep& operator=(LaneSweep&&) noexcept;

  int addPiece(const Piece& piece);
  /// A shape that stands still: spheres, capsules, boxes, cylinders and half-spaces as they are,
  /// everything else as a box around it. O(vertices).
  int addObstacle(const Shape& shape, const Pose& X_WG);
  /// Piece and obstacle must keep a separation above `threshold` [m]; `id` is told in answers.
  /// `balls`: a piece of the world whose balls hold the obstacle as well, or -1: lanes that the
  /// obstacle's box leaves open may be settled by them. `by_parts`: parts of pieces may settle
  /// them, too.
  void addPair(int id, int piece, int obstacle, int balls, double threshold, bool by_parts = true);
  /// The same for two pieces; `motion` is that of the first's points, seen from the second's frame.
  void addPiecePair(int id, int a, int b, int motion, double threshold, bool by_parts = true);
  /// After all additions, before any Scratch.
  void finish();
  std::size_t bytes() const;

  /// A pair and the lanes in which it is not certified.
  struct Open {
    int id;
    std::uint32_t lanes;
    /// Hulls were apart in the middle of them by more than rounding takes: over shorter intervals
    /// planes may part them.
    bool apart = false;
  };
  /// A pair proven not to keep its threshold, and the lane in the middle of which it does not.
  struct Contact {
    int id = -1;  ///< -1: none found
    int lane = 0;
  };

  /// What a run changes. Allocates in its constructor only, which comes after all additions.
  class Scratch {
   public:
    explicit Scratch(const LaneSweep& sweep);
    ~Scratch();
    /// All that the last run did not certify, when it found no contact.
    std::span<const Open> open() const;
    /// After run(): lanes of each open() pair that are known to be free otherwise; where none is
    /// left, it is no longer open. O(open pairs).
    void close(std::span<const std::uint32_t> lanes);

    /// What runs cost counts into `work` from now on, which has to outlive this. Where it is spent
    /// planes are looked for no more, and what they might have parted stays open.
    void countInto(Work& work);

   private:
    friend class LaneSweep;
    friend struct LaneSweepKernel;
    struct Impl;
    std::unique_ptr<Impl> impl_;
  };

  /// A look at what was in contact last alone, in the middle of the intervals: most of what a
  /// planner is told not to be free is so for the same reason. Frames need only be placed, not
  /// moved.
  Contact meetAgain(std::span<const LaneFrame> frames, float slack, Scratch& scratch) const;
  /// One pass over frames that are placed and moved, by balls, planes that parted a pair last, and
  /// points. growth: h^2 A / 8 of each motion [m]; slack: how far the frames' rounding moves any
  /// capsule [m]. Which contacts are found, and what planes leave open, depends on the runs before:
  /// what is told is proven whatever they were. O(pieces + pairs); never throws or allocates.
  Contact run(std::span<const LaneFrame> frames, std::span<const float> growth, float slack,
              Scratch& scratch) const;
  /// After a run() that found no contact, with the same frames, growth and slack: planes are looked
  /// for between what it left open; Open::apart is told from here on. O(open pairs), a distance
  /// query of a few points for some of them.
  Contact part(std::span<const LaneFrame> frames, std::span<const float> growth, float slack,
               Scratch& scratch) const;
  /// Planes and points alone, for some pairs in some lanes; their ids are here the pairs' places in
  /// the order of addition. Planes are looked for more closely than in run().
  Contact runPairs(std::span<const Open> pairs, std::span<const LaneFrame> frames,
                   std::span<const float> growth, float slack, Scratch& scratch) const;
  /// A look for a contact of one pair in the middle of the intervals, by balls and all points,
  /// `pair` being its place in the order of addition. Frames need only be placed.
  Contact meet(int pair, std::span<const LaneFrame> frames, float slack, Scratch& scratch) const;
  /// False for pairs of which neither balls nor points can ever prove a contact. O(1).
  bool canMeet(int pair) const;
  /// run() and part() for single configurations: frames need not be moved.
  Contact runStill(std::span<const LaneFrame> frames, float slack, Scratch& scratch) const;

 private:
  friend struct LaneSweepKernel;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace leeway::collision
