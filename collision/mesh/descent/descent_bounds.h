#pragma once

// Private to collision/: what branch and bounds for the distance of two bodies have proven, and
// what they still need.

#include <algorithm>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/base/scratch.h"
#include "collision/base/tolerances.h"
#include "collision/base/work.h"
#include "leeway/collision/query.h"

namespace leeway::collision {

/// The distance between the surfaces of two bodies: the minimum over all pairs of triangles (or
/// convex shapes). Solids' insides are not considered.
struct DescentResult {
  /// No pair is closer (or, below 0, deeper); -infinity if no bound is known.
  double lower = kInfinity;
  double upper = kInfinity;  ///< some pair is as close as this
  /// A lower bound on the distance of the bodies' hulls, and so of everything inside them.
  double hull_lower = -kInfinity;
  DistanceResult witness;  ///< of the pair that determines `upper`, in B
  int iterations = 0;
  int visited = 0;         ///< nodes and pairs, limited by request.node_limit
  bool misplaced = false;  ///< a deforming triangle that was tested is not finite
};

/// The interval found so far, the bar that pairs must stay below to matter, and the limits: the
/// `Bounds` of BranchAndBound for rigid, deforming, swept and self queries.
class DescentBounds {
 public:
  struct Rules {
    bool swept = false;  ///< only the lower end is needed, as far as it exceeds the threshold and 0
    bool depth = false;  ///< once surfaces overlap, deeper pairs are searched ...
    bool limits_depth = true;  ///< ... with limited effort (kDeeperNodes, kDeeperShare), because
                               ///< the depth of two meshes is not that of their deepest triangles
    double near = 0;  ///< pairs no farther apart touch, and all of those are compared, because they
                      ///< show whether the bodies overlap [m]
  };

  DescentBounds(const DistanceRequest& asked, Scratch& scratch, const Rules& rules)
      : request(asked), rules_(rules), work_(*scratch.impl().work), node_limit_(asked.node_limit) {
    updateBar();
  }

  /// Pairs whose lower bound is above this need no closer look.
  double bar() const { return rules_.swept ? std::min(bar_, result.lower) : bar_; }
  bool isPruned(double lower) const {
    return lower > bar_ || (rules_.swept && lower >= result.lower);
  }
  template <class Open>
  bool isPruned(const Open& open) const {
    return isPruned(static_cast<double>(open.lower));
  }

  /// Records the lower bound of anything that is dropped without a closer look.
  void settle(double lower) { result.lower = std::min(result.lower, lower); }
  template <class Open>
  void settle(const Open& open) {
    settle(static_cast<double>(open.lower));
  }

  bool isDone() const {
    if (result.upper <= request.threshold) return true;  // false for NaN
    if (!rules_.swept) return result.upper <= 0 && !rules_.depth;
    // A single pair that does not exceed this decides, because a sweep needs only its lower end.
    return result.upper <= 0 || result.lower <= floor();
  }

  /// Limit on result.visited.
  int limit() const { return work_.isSpent() ? 0 : std::min(node_limit_, overlap_limit_); }
  bool isSpent() const { return result.visited >= limit(); }
  void visit() { ++result.visited; }
  /// Reduces the limit by nodes that were visited elsewhere.
  void reduceLimit(int nodes) { node_limit_ -= nodes; }
  /// The nodes that the request's limit still allows.
  int nodesLeft() const { return node_limit_ - result.visited; }

  bool hasUpper() const { return result.upper < kInfinity; }
  /// Takes the upper end that a pair proves. False if it is not below the present one.
  bool offer(const DistanceResult& pair, double upper, int triangle_a, int triangle_b) {
    if (!(upper < result.upper)) return false;
    if (upper <= 0 && result.upper > 0 && rules_.limits_depth) {
      const int most = std::numeric_limits<int>::max() - kDeeperNodes;
      overlap_limit_ = std::min(result.visited, most) + kDeeperNodes;
    }
    result.upper = upper;
    updateBar();
    result.witness = pair;
    result.witness.triangle_a = triangle_a;
    result.witness.triangle_b = triangle_b;
    return true;
  }
  /// Prunes by an upper end that is known, but whose witness is not good enough for an answer.
  void pruneBy(double upper) {
    known_upper_ = upper;
    updateBar();
  }

  /// Warm start: compares a pair before its turn, for an upper end. At rest, the pair is compared
  /// again in its turn, and may get a better lower end than now.
  template <class Compare>
  void compareFirst(const Compare& compare) {
    const double lower = result.lower;
    compare();
    if (!rules_.swept) result.lower = lower;
  }

  const DistanceRequest& request;
  DescentResult result;

 private:
  // The lower end of a sweep helps only above this, because below 0 pieces bound only themselves.
  double floor() const { return request.threshold > 0 ? request.threshold : 0; }

  void updateBar() {
    double nearer = rules_.near;
    if (!(result.upper > 0 && result.upper <= rules_.near)) {
      // Accepts only pairs that are closer by the tolerance, or deeper by kDeeperShare.
      const bool shares = result.upper <= 0 && rules_.limits_depth;
      nearer = result.upper - (shares ? std::max(request.tolerance, -kDeeperShare * result.upper)
                                      : request.tolerance);
    }
    // In this order, so that a tolerance of NaN leaves the threshold.
    bar_ = std::min(request.threshold == request.threshold ? floor() : kInfinity,
                    std::min(nearer, known_upper_));
  }

  const Rules rules_;
  const Work& work_;
  double bar_ = kInfinity;  // a sweep's result.lower excluded
  double known_upper_ = kInfinity;
  int node_limit_;
  int overlap_limit_ = std::numeric_limits<int>::max();
};

}  // namespace leeway::collision
