#pragma once

// Private to collision/: the data of LaneSweep, as its kernels read it.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "collision/base/work.h"
#include "collision/convex/gjk/convex_view.h"
#include "collision/lanes/lane_sweep.h"
#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

struct LaneSweep::Impl {
  enum class Kind : unsigned char { kBox, kCylinder, kHalfSpace };
  /// A box or cylinder grown by a radius (balls and segments are boxes without size), or z <= 0.
  struct Obstacle {
    Kind kind = Kind::kBox;
    bool exact = false;    // not a stand-in
    bool aligned = false;  // its axes are the world's
    float rotation[9];     // from the world into its own axes, row by row
    float center[3], half[3];
    float radius = 0;
    double scale = 0;  // what rounding grows with [m]
    Shape shape = Shape::sphere(0);
    Pose X_WG;
    ConvexView view;  // of the shape or its hull; borrows from it
    bool has_view = false;
    Eigen::Vector3d low, high;           // in the world
    int parts_begin = 0, parts_end = 0;  // indices into obstacles
  };
  struct LaneBall {
    float center[3], radius;
  };
  struct LanePiece {
    int frame, motion;
    LaneBall outer;
    int cover, inner, end;  // balls [cover, inner) and [inner, end)
    double reach;
    bool has_obstacles = false;
    float inner_reach = 0;  // no inner ball comes farther out from outer's centre
    // Points whose hull, grown by a radius, holds the piece: a few, and more with a smaller radius.
    // Without a finer choice both are the same.
    struct Points {
      int begin = 0, end = 0;
      float radius = 0;
      int clusters_begin = 0, clusters_end = 0;  // together all of them; or none
    };
    Points points, fine;
    float own = -1;   // all points are the piece's own to within this [m]; below 0: they are not
    ConvexView view;  // of `points`; borrows from Impl::points
    ConvexView fine_view;
    int parts_begin = 0, parts_end = 0;  // indices into pieces
  };
  struct Pair {
    int id, a, b;
    int balls;  // of b: the piece that stands for it besides an obstacle; -1: none
    int motion;
    bool pieces;  // b is a piece, too
    // The threshold, less and more this pass's own rounding.
    float free_above, contact_below;
    // For the balls of a cover one by one, 0 at least: how deep each of them is says nothing of how
    // deep all of them are, as each may have a way out of its own.
    float cover_above;
    // The same for planes, without the points' radius; below 0: no planes. And for planes that a
    // lane has for itself.
    float part_above, part_each_above;
    bool by_parts = false;
    // What stands for it where its hulls are not apart: pairs of parts (or of one side's parts with
    // the other as a whole), those of b's parts side by side. Indices into pairs.
    int parts_begin = 0, parts_end = 0;
  };
  /// More pairs of parts than this are not looked at.
  static constexpr int kMostPartPairs = kCoverParts * kCoverParts;

  std::vector<LanePiece> pieces;  // parts stand behind all wholes
  std::size_t wholes = 0;
  std::vector<LanePiece> parts;  // until finish()
  std::vector<LaneBall> balls;
  std::vector<Eigen::Vector3d> points;
  std::vector<float> point[3];  // the same, coordinate by coordinate
  // Of each point, where a next look begins: itself, or the nearest of its piece's fine ones.
  std::vector<std::int32_t> begin_with;
  /// Points that stand together, most of which need not be looked at: a ball around them that is
  /// larger by what rounding does to either.
  struct Cluster {
    float center[3], radius;
    int begin, end;
  };
  std::vector<Cluster> clusters;
  std::vector<Obstacle> obstacles;  // the same
  std::size_t whole_obstacles = 0;
  std::vector<Obstacle> obstacle_parts;
  std::vector<Pair> pairs;                // those of parts stand behind all others
  std::vector<std::int32_t> piece_pairs;  // indices into pairs
  // Of obstacles in the world, grown by the largest threshold of any of their pairs; padded to
  // kLanes with boxes that nothing meets.
  std::vector<float> low[3], high[3];
  std::vector<std::int32_t> pair_of;  // piece by piece, paddedObstacles() each; -1: no pair
  std::size_t paddedObstacles() const { return (whole_obstacles + kLanes - 1) / kLanes * kLanes; }
  static Obstacle obstacleOf(const Shape& shape, const Pose& X_WG);
  static Obstacle partOf(const CoverPart& part, const Pose& X_WG);
  void finish();
  void addParts();
  /// All points of a piece's cover, those of `of` that are told.
  void addPoints(const PointCover& cover, LanePiece& of);
  void addCluster(int begin, int end);
};

struct LaneSweep::Scratch::Impl {
  struct Placed {
    LaneValues center[3], way[3];
  };
  struct Candidate {
    float key;
    std::int32_t pair;
    std::uint32_t lanes;
  };
  std::vector<Placed> outer, balls;
  std::vector<std::uint64_t> cover_stamp, inner_stamp;  // the run in which a piece's were placed
  std::vector<std::uint64_t> part_stamp;                // and a part's ball
  std::vector<float> low, high;                         // of pieces' sweeps, three each
  std::vector<Candidate> candidates;
  std::vector<Open> open;
  std::vector<std::int32_t> open_pairs;  // the same as indices into pairs
  /// From B to A, in B's frame: nothing of B is beyond `offset` along it.
  struct Plane {
    float normal[3], offset;
    bool known = false;
  };
  std::vector<Plane> planes;        // one a pair: what parted it last
  std::vector<PairCache> searches;  // one a pair: of the last query for a plane
  /// Of a pair that has parts: hulls of wholes did not part it, parts did; and those that were in
  /// the way last.
  struct Manner {
    bool by_parts = false;
    std::int32_t stubborn = 0;
  };
  std::vector<Manner> manners;  // one a pair
  collision::Scratch distance;
  Work own;
  Work* work = &own;  // what is counted; queries of `distance` count there, too
  std::uint64_t stamp = 0;
  /// A pair last found in contact, and the point that was inside; -1: balls.
  struct Killer {
    std::int32_t pair = -1, point = -1;
  };
  static constexpr int kKillers = 4;
  Killer killers[kKillers];
};

/// What the kernels are given.
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

  /// Notes what is in contact, in the first of `lanes`.
  Contact told(std::int32_t pair, std::int32_t point, std::uint32_t lanes) const;
  /// A plane between the pair's bodies in the middle of a lane; false when there is none.
  /// `closely`: all points are looked at, and the plane is nearer to the best. `cache`: of the last
  /// such query of the pair, or null.
  bool findPlane(const Sweep::Pair& pair, int lane, bool closely, Scratch::Plane& plane,
                 PairCache* cache = nullptr) const;
  /// Planes that the lanes have for themselves: lanes that they leave, those in which the search
  /// came to the obstacle, and the normals of the others.
  struct Each {
    std::uint32_t open = 0, touching = 0;
    LaneValues normal[3];
  };
  /// What planes leave of a pair, and what its hulls are in the middle of these lanes: apart in all
  /// of them, or in contact, to the eye, in one.
  struct Parted {
    std::uint32_t open;
    bool apart, touching;
  };
  Parted partEach(std::int32_t pair, std::uint32_t lanes) const;
  /// The same by all planes that are looked for.
  Parted partPair(std::int32_t pair, std::uint32_t lanes, bool closely) const;
  /// The same for a pair of parts: the plane that parted them last comes first.
  Parted partParts(std::int32_t pair, std::uint32_t lanes, bool closely) const;
  /// What the parts of a pair leave: apart where all of those are that are still open.
  Parted partByParts(std::int32_t pair, std::uint32_t lanes, bool closely) const;
  /// The plane of a lane is what parted the pair last.
  void remember(std::int32_t pair, const Each& each, int lane) const;
  /// Tells a plane how far the obstacle goes along its normal.
  void placePlane(const Sweep::Obstacle& obstacle, Scratch::Plane& plane) const;
  /// Planes between the hulls, one for all of the lanes, by distance queries: takes away the lanes
  /// that these part, and tells whether the hulls are apart in the middle one of the others.
  bool partByQueries(std::int32_t pair, bool closely, std::uint32_t& lanes) const;
  /// A few points of each pair that is open are looked for in its obstacle.
  Contact meetOpen() const;
  /// What is open is tried with planes, and then with more points.
  Contact partOpen(bool closely) const;
};

}  // namespace leeway::collision
