#pragma once

// Private to collision/: the data of LaneSweep, as its kernels read it.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "collision/convex.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/lane_sweep.h"

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
    bool has_planes = false;
    Eigen::Vector3d low, high;  // in the world
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
    float inner_reach = 0;   // no inner ball comes farther out from outer's centre
    int points, points_end;  // its hull, grown by points_radius, holds the piece
    float points_radius = 0;
    ConvexView view;  // of the points; borrows from point_of
  };
  struct Pair {
    int id, a, b;
    int balls;  // of b: the piece that stands for it besides an obstacle; -1: none
    int motion;
    bool pieces;  // b is a piece, too
    // The threshold, less and more this pass's own rounding.
    float free_above, contact_below;
    // The same for planes, with the points' radius; below 0: no planes.
    float part_above;
  };

  std::vector<LanePiece> pieces;
  std::vector<LaneBall> balls;
  std::vector<Eigen::Vector3d> points;
  std::vector<float> point[3];  // the same, coordinate by coordinate
  std::vector<Obstacle> obstacles;
  std::vector<Pair> pairs;
  std::vector<std::int32_t> piece_pairs;  // indices into pairs
  // Of obstacles in the world, grown by the largest threshold of any of their pairs; padded to
  // kLanes with boxes that nothing meets.
  std::vector<float> low[3], high[3];
  std::vector<std::int32_t> pair_of;  // piece by piece, paddedObstacles() each; -1: no pair
  std::size_t paddedObstacles() const { return (obstacles.size() + kLanes - 1) / kLanes * kLanes; }
  void finish();
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
  std::vector<float> low, high;                         // of pieces' sweeps, three each
  std::vector<Candidate> candidates;
  std::vector<Open> open;
  std::vector<std::int32_t> open_pairs;  // the same as indices into pairs
  /// From B to A, in B's frame: nothing of B is beyond `offset` along it.
  struct Plane {
    float normal[3], offset;
    bool known = false;
  };
  std::vector<Plane> planes;  // one a pair: what parted it last
  collision::Scratch distance;
  std::uint64_t stamp = 0;
  static constexpr int kKillers = 4;
  std::int32_t killers[kKillers] = {-1, -1, -1, -1};  // pairs last found in contact
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

  /// A plane between the pair's bodies in the middle of a lane; false when there is none.
  bool findPlane(const Sweep::Pair& pair, int lane, Scratch::Plane& plane) const;
  /// What a run without contact left open is tried with planes; test(pair, plane, lanes) tells the
  /// lanes that one does not part.
  template <typename Test>
  void partOpen(const Test& test) const;
};

}  // namespace leeway::collision
