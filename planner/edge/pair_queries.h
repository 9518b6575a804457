#pragma once

// Private to planner/: exact queries of one pair, at one configuration of an edge or over an
// interval of it. They are the most expensive stage of a proof, for the tasks that other stages
// leave open.

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

/// Data about a pair from earlier edges. It steers which queries are tried, but proves nothing.
struct PairMemory {
  /// Growth up to which a sweep is tried [m]: a failure lowers it, a success raises it.
  double growth_limit = kSweepGrowth;
  std::uint64_t sweep_failed = 0;  ///< PairQueries::interval() of the last failure
  std::uint64_t end_checked = 0;   ///< the last edge at whose end the pair was checked
  /// Scores for contact checks by distance() and by lanes: a contact raises the score, a check
  /// without contact lowers it; below 0 no check is made.
  int contact_score = 0, lane_contact_score = 0;
};
using EdgeMemory = collision::PairTable<PairMemory>;

enum class PairState : unsigned char { kFree, kNotFree, kOpen };

/// The verdict on an edge, with its pair (-1: no single pair) and t.
struct PairVerdict {
  Verdict verdict;
  int pair = -1;
  double t = 0;
};

/// Queries of the pairs of the edge that `frames` have begun. Answers are proofs; each pair's
/// threshold includes the rounding of poses.
class PairQueries {
 public:
  /// Refers to all of these. The workspace's scratch counts the cost of queries into `work`.
  PairQueries(EdgeFrames& frames, collision::Workspace& workspace, const collision::Work& work,
              const Asked& asked, EdgeMemory& memory);

  EdgeCertifier::Statistics* statistics = nullptr;  ///< counts queries; must be set
  int count = 0;                                    ///< exact queries since the caller set it to 0
  double least_interval = 0;  ///< no part of an edge shorter than this, in t, is divided

  // Queries at a configuration, placed in a slot.

  /// By balls and coarse shapes.
  PairState coarseState(int slot, const EdgePair& pair) const;
  /// By distance(). Visits at most `nodes` pairs of nodes; 0: no limit.
  PairState exactState(int slot, const EdgePair& pair, int nodes = 0);
  /// Witness points are in the scene's order of the two bodies.
  collision::DistanceResult distanceAt(int slot, const EdgePair& pair,
                                       const collision::DistanceRequest& request);

  // Queries over an interval. Separate surfaces do not prove that no body is inside the other, so
  // containment is checked at one configuration of the edge.

  /// Starts a new interval: discards the bounds and balls of the previous one.
  void startInterval() { ++interval_; }
  /// The number of the current interval.
  std::uint64_t interval() const { return interval_; }
  /// kFree: the pair keeps its threshold on the whole interval; kNotFree: it does not at `t`.
  PairState sweep(const EdgeInterval& interval, int p, double& t);
  /// Lower bound on the separation, from balls, and the growth of a sweep [m].
  double coarseSweep(const EdgeInterval& interval, const EdgePair& pair, double& growth);
  /// Separation, from the hull of a's two placements grown by `growth`, as narrow as `threshold`
  /// requires. `nodes`: see exactState().
  Interval hullSweep(const EdgeInterval& interval, const EdgePair& pair, double growth,
                     double threshold, int nodes = 0);
  const robots::MotionBound& motionOf(const EdgeInterval& interval, int motion);

 private:
  /// Bounds on a motion over the current interval, and over its right half, which the next interval
  /// uses for its left half.
  struct MotionMemory {
    std::uint64_t interval = 0, generation = 0;
    int slot = -1;  ///< at the right end
    double half = 0;
    robots::MotionBound bound, right;
  };
  /// A ball that contains a piece over an interval, in some frame. `growth`: how far points may
  /// leave the chord between their two positions [m].
  struct SweptBall {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    double radius = 0, growth = 0;
    std::uint64_t interval = 0;
  };

  PairState sweepExactly(const EdgeInterval& interval, int p, double growth, double& t);
  SweptBall sweptBall(const EdgeInterval& interval, const EdgePair& pair, const Eigen::Vector3d& c0,
                      const Eigen::Vector3d& c1);
  /// sweptBall() in the world, for pairs whose other piece is static; computed once per interval
  /// and piece.
  const SweptBall& worldBall(const EdgeInterval& interval, const EdgePair& pair);
  /// Sweeps both surfaces of a pair that is by_surfaces.
  collision::MeshSweepResult sweepSurfaces(const EdgeInterval& interval, const EdgePair& pair);

  EdgeFrames& frames_;
  collision::Workspace& workspace_;
  const collision::Work& work_;
  const Asked& asked_;
  EdgeMemory& memory_;
  std::uint64_t interval_ = 0;
  std::vector<MotionMemory> motion_;    // one per motion
  std::vector<SweptBall> world_balls_;  // one per moving piece
};

}  // namespace leeway::planner
