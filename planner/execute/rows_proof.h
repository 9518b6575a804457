#pragma once

// Private to planner/: proofs of a robot's motion through rows.

#include <algorithm>
#include <cstdint>
#include <span>

#include "collision/base/numbers.h"
#include "leeway/planner/edge_certifier.h"
#include "planner/base/tolerances.h"
#include "planner/compiled/displacement.h"

namespace leeway::planner {

/// Proves motions that pass rows in straight lines. Many rows are proven by one edge, their chord,
/// with margins that grow by how far the rows are from it; where that is not proven, by two chords.
/// Allocates in the constructor only.
class RowsProof {
 public:
  explicit RowsProof(const CompiledScene& scene) : scene_(scene), displacement_(scene) {}

  /// Sets what the calls below may cost together [units of collision::Work].
  void setWork(std::int64_t work) { left_ = work; }
  /// Takes work that was done elsewhere from that.
  void charge(std::int64_t work) { left_ -= work; }
  bool isSpent() const { return !(left_ > 0); }
  /// Tries longer chords again: what failed may hold.
  void lengthen() { growth_limit_ = std::min(kGuardFirstGrowth, 2 * growth_limit_); }

  /// Returns the last row up to which the motion is proven from row `from` on; at most `to`, and
  /// `from` - 1 where not even that row is known to be free. With `all`, a beginning is of no use:
  /// any row before `to` is returned where not all is proven. `row(k)` is a configuration; all but
  /// row 0 are within the limits. `bend`: how far points are from where straight lines place them,
  /// at most [m].
  template <class Row>
  int until(EdgeCertifier& certifier, const Row& row, int from, int to, bool all, double bend = 0) {
    if (to - from <= 1) {
      if (edgeFree(certifier, row(from), row(to), bend, kWholeWork)) return to;
      return from == to ? from - 1 : from;
    }
    // Outside the limits, bounds on displacements do not hold.
    const bool is_bounded = from > 0 || scene_.space().withinLimits(row(0));
    const double growth = is_bounded ? displacement_.fromChord(row, from, to) + bend : kInfinity;
    if (growth <= growth_limit_) {
      // If the chord of rows on a line is not free, nor are they.
      const bool decides = all && growth < kGuardOnLine;
      if (edgeFree(certifier, row(from), row(to), growth, decides ? kWholeWork : kGuardChordWork)) {
        growth_limit_ = std::min(kGuardMostGrowth, std::max(growth_limit_, 1.5 * growth));
        return to;
      }
      if (isSpent() || decides) return from;
      if (growth > kGuardLeastGrowth) growth_limit_ = std::max(kGuardLeastGrowth, growth / 2);
    }
    const int middle = from + (to - from) / 2;
    const int first = until(certifier, row, from, middle, all, bend);
    return first < middle ? first : until(certifier, row, middle, to, all, bend);
  }

  /// The last edge that was not free. Its verdict is kUndecided where no work was left for it.
  const EdgeCheck& failed() const { return failed_; }

  Displacement& displacement() { return displacement_; }

 private:
  static constexpr std::int64_t kWholeWork = 0;  ///< that of EdgeRequest::persistent()
  bool edgeFree(EdgeCertifier& certifier, std::span<const double> a, std::span<const double> b,
                double beyond, std::int64_t most_work);

  const CompiledScene& scene_;
  Displacement displacement_;
  double growth_limit_ = kGuardFirstGrowth;
  std::int64_t left_ = 0;  ///< work
  EdgeCheck failed_;
};

}  // namespace leeway::planner
