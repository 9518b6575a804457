#pragma once

// Private to collision/: the data of LaneSweep, as its kernels read it.

#include <cstddef>
#include <cstdint>
#include <vector>

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
    double scale = 0;           // what rounding grows with [m]
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
  };
  struct Pair {
    int id, a, b;
    int balls;  // of b: the piece that stands for it besides an obstacle; -1: none
    int motion;
    bool pieces;  // b is a piece, too
    // The threshold, less and more this pass's own rounding.
    float free_above, contact_below;
  };

  std::vector<LanePiece> pieces;
  std::vector<LaneBall> balls;
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
};

}  // namespace leeway::collision
