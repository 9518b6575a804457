#pragma once

// Private to planner/: exact queries of one pair, at one configuration of an edge or over an
// interval of it. The dearest stage of a proof, which decides what others leave open.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/base/pair_table.h"
#include "collision/base/work.h"
#include "collision/sweep/mesh_sweep.h"
#include "leeway/collision/scene.h"
#include "leeway/planner/edge_certifier.h"
#include "planner/base/tolerances.h"
#include "planner/edge/edge_frames.h"
#include "planner/edge/edge_queue.h"

namespace leeway::planner {

/// What is asked of an edge's pairs.
struct Asked {
  Pairs pairs = Pairs::kAll;       ///< all others are left out
  double separation = -kInfinity;  ///< to be kept where a pair's margin is less [m]

  bool has(const EdgePair& pair) const {
    return pairs == Pairs::kAll || pair.is_self == (pairs == Pairs::kSelf);
  }
  /// What a pair's separation must exceed [m].
  double thresholdOf(const EdgePair& pair) const {
    return std::max(pair.threshold, separation + pair.rounding);
  }
};

/// What earlier edges taught of a pair. It steers which queries are tried, never what they prove.
struct PairMemory {
  /// Growth up to which a sweep is tried [m]: falls where it fails, rises where it succeeds.
  double growth_limit = kSweepGrowth;
  std::uint64_t sweep_failed = 0;  ///< PairQueries::interval() of the last failure
  std::uint64_t end_checked = 0;   ///< the edge at whose end it was last asked
  /// Looks for a contact, by distance() and by lanes: up by a contact, down by a look that finds
  /// none; below 0 no look is taken.
  int contact_score = 0, lane_contact_score = 0;
};
using EdgeMemory = collision::PairTable<PairMemory>;

enum class PairState : unsigned char { kFree, kNotFree, kOpen };

/// The verdict on an edge, by one pair (-1: by none) at t.
struct PairVerdict {
  Verdict verdict;
  int pair = -1;
  double t = 0;
};

/// Queries of the pairs of the edge that `frames` have begun. Answers are proofs, with the rounding
/// of poses in each pair's threshold.
class PairQueries {
 public:
  /// Refers to all of these. What queries cost is counted by the workspace's scratch, into `work`.
  PairQueries(EdgeFrames& frames, collision::Workspace& workspace, const collision::Work& work,
              const Asked& asked, EdgeMemory& memory);

  EdgeCertifier::Statistics* statistics = nullptr;  ///< counts queries; must be set
  int count = 0;              ///< of exact queries, since the caller set it to 0
  double least_interval = 0;  ///< no shorter part of an edge is divided, in t

  // At a configuration, placed in a slot.

  /// By balls and coarse shapes.
  PairState coarseState(int slot, const EdgePair& pair) const;
  /// By distance(). Looks at no more than `nodes` pairs of nodes; 0: as many as it takes.
  PairState exactState(int slot, const EdgePair& pair, int nodes = 0);
  /// Witnesses in the scene's order of the two bodies.
  collision::DistanceResult distanceAt(int slot, const EdgePair& pair,
                                       const collision::DistanceRequest& request);

  // Over an interval. Surfaces that keep apart do not tell whether one body holds another: that is
  // asked at one configuration of the edge.

  /// Comes before the queries of an interval: forgets the bounds and balls of the one before.
  void startInterval() { ++interval_; }
  /// The number of the present interval.
  std::uint64_t interval() const { return interval_; }
  /// kFree: the pair keeps its threshold all over the interval; kNotFree: it does not at `t`.
  PairState sweep(const EdgeInterval& interval, int p, double& t);
  /// Lower bound on the separation, from balls, and the growth of a sweep [m].
  double coarseSweep(const EdgeInterval& interval, const EdgePair& pair, double& growth);
  /// Separation, from the hull of a's two placements grown by `growth`, as far as `threshold` needs
  /// it. `nodes`: see exactState().
  Interval hullSweep(const EdgeInterval& interval, const EdgePair& pair, double growth,
                     double threshold, int nodes = 0);
  const robots::MotionBound& motionOf(const EdgeInterval& interval, int motion);

 private:
  /// Bounds on a motion, of the present interval, and of its right half, which the next interval
  /// needs as its left one.
  struct MotionMemory {
    std::uint64_t interval = 0, generation = 0;
    int slot = -1;  ///< at the right end
    double half = 0;
    robots::MotionBound bound, right;
  };
  /// Holds a piece over an interval, in some frame. `growth`: how far points may leave the chord
  /// between their two places [m].
  struct SweptBall {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    double radius = 0, growth = 0;
    std::uint64_t interval = 0;
  };

  PairState sweepExactly(const EdgeInterval& interval, int p, double growth, double& t);
  SweptBall sweptBall(const EdgeInterval& interval, const EdgePair& pair, const Eigen::Vector3d& c0,
                      const Eigen::Vector3d& c1);
  /// sweptBall() in the world, for pairs whose other piece stands still: made once an interval and
  /// piece.
  const SweptBall& worldBall(const EdgeInterval& interval, const EdgePair& pair);
  /// Both surfaces of a pair that is by_surfaces.
  collision::MeshSweepResult sweepSurfaces(const EdgeInterval& interval, const EdgePair& pair);

  EdgeFrames& frames_;
  collision::Workspace& workspace_;
  const collision::Work& work_;
  const Asked& asked_;
  EdgeMemory& memory_;
  std::uint64_t interval_ = 0;
  std::vector<MotionMemory> motion_;    // one a motion
  std::vector<SweptBall> world_balls_;  // one a moving piece
};

}  // namespace leeway::planner
