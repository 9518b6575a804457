#pragma once

// Private to planner/: proofs of a robot's motion through setpoints.

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/guard.h"
#include "planner/execute/obstacles.h"
#include "planner/execute/rows_proof.h"
#include "planner/guard/setpoint_motion.h"

namespace leeway::planner {

/// Proves that motions keep all margins. Allocates in the constructor and in look() only.
class SetpointProof {
 public:
  SetpointProof(const Problem& problem, const GuardOptions& options,
                std::shared_ptr<const CompiledScene> scene);

  /// See Guard::look().
  void look(double time);
  /// Drops the bounds on obstacles: no motion is proven free of them until the next look().
  void forget() { is_stale_ = true; }
  Obstacles& obstacles() { return obstacles_; }
  bool hasObstacles() const { return !movers_.empty(); }

  /// Begins a call: what it may cost.
  void begin(std::int64_t work);
  /// Takes work that was done elsewhere from what the call may cost.
  void charge(std::int64_t work) { rows_.charge(work); }
  /// The last row up to which the motion is proven from row `from` on; at most `to`, and `from` - 1
  /// where not even that row is known to be free. Where it is less than `to`, failure() says why.
  int freeUntil(const SetpointMotion& motion, int from, int to) {
    bend_ = motion.curved > from ? rows_.displacement().of(motion.bend) : 0;
    return until(motion, from, to, false);
  }
  /// Whether all of it is proven, which is on no polynomial. If it is not, failure() says why.
  bool isFree(const SetpointMotion& motion, int from, int to) {
    bend_ = 0;
    return until(motion, from, to, true) == to;
  }

  struct Failure {
    GuardReason reason = GuardReason::kPassed;
    std::string_view a, b;
  };
  const Failure& failure() const { return failure_; }
  bool isSpent() const { return rows_.isSpent(); }
  /// Since begin(); `work` is what it was charged.
  EdgeCertifier::Statistics statistics() const;

 private:
  /// The times of a part of the horizon.
  struct Slice {
    double begin = 0, end = 0;  ///< [s]
  };
  /// A group of obstacles, and where they can be in each slice.
  struct Mover {
    std::unique_ptr<EdgeCertifier> certifier;
    std::vector<std::shared_ptr<const CompiledScene>> slices;
  };
  int until(const SetpointMotion& motion, int from, int to, bool all);
  int untilAmongObstacles(const SetpointMotion& motion, int from, int to, bool all);
  int untilInSlice(std::size_t slice, const SetpointMotion& motion, int from, int to, bool all);
  int untilIn(EdgeCertifier& certifier, const SetpointMotion& motion, int from, int to, bool all);
  EdgeCertifier::Statistics sum() const;

  std::shared_ptr<const CompiledScene> scene_;
  double period_, horizon_;
  Obstacles obstacles_;
  EdgeCertifier still_;
  std::vector<Mover> movers_;  ///< by group; none without obstacles
  std::vector<Slice> slices_;
  bool is_stale_ = false;  ///< the slices do not hold
  RowsProof rows_;
  double bend_ = 0;  ///< how far points are from where straight lines place them, at most [m]
  EdgeCertifier::Statistics before_;
  Failure failure_;
};

}  // namespace leeway::planner
