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
/// with a separation that covers how far they are from it; where that is not proven, by two chords.
/// Allocates in the constructor only.
class RowsProof {
 public:
  explicit RowsProof(const CompiledScene& scene) : scene_(scene), displacement_(scene) {}

  /// The margins of a scene's pairs. O(listed pairs).
  struct Margins {
    double most = 0;  ///< [m]
    /// All are that, and a chord of rows on a line keeps no more: if it is not free, nor are they.
    bool are_plain = false;
  };
  static Margins marginsOf(const CompiledScene& scene);

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
  /// row 0 are within the limits. `margins` are those of the certifier's scene.
  template <class Row>
  int until(EdgeCertifier& certifier, const Margins& margins, const Row& row, int from, int to,
            bool all) {
    if (to - from <= 1) {
      if (edgeFree(certifier, row(from), row(to), -kInfinity, kWholeWork)) return to;
      return from == to ? from - 1 : from;
    }
    // Outside the limits, bounds on displacements do not hold.
    const bool is_bounded = from > 0 || scene_.space().withinLimits(row(0));
    const double growth = is_bounded ? displacement_.fromChord(row, from, to) : kInfinity;
    if (growth <= growth_limit_) {
      const bool decides = all && margins.are_plain && growth < kGuardOnLine;
      const double separation = std::max(0.0, margins.most) + growth;
      if (edgeFree(certifier, row(from), row(to), separation,
                   decides ? kWholeWork : kGuardChordWork)) {
        growth_limit_ = std::min(kGuardMostGrowth, std::max(growth_limit_, 1.5 * growth));
        return to;
      }
      if (isSpent() || decides) return from;
      if (growth > kGuardLeastGrowth) growth_limit_ = std::max(kGuardLeastGrowth, growth / 2);
    }
    const int middle = from + (to - from) / 2;
    const int first = until(certifier, margins, row, from, middle, all);
    return first < middle ? first : until(certifier, margins, row, middle, to, all);
  }

  /// The last edge that was not free. Its verdict is kUndecided where no work was left for it.
  const EdgeCheck& failed() const { return failed_; }

  Displacement& displacement() { return displacement_; }

 private:
  static constexpr std::int64_t kWholeWork = 0;  ///< that of EdgeRequest::persistent()
  bool edgeFree(EdgeCertifier& certifier, std::span<const double> a, std::span<const double> b,
                double separation, std::int64_t most_work);

  const CompiledScene& scene_;
  Displacement displacement_;
  double growth_limit_ = kGuardFirstGrowth;
  std::int64_t left_ = 0;  ///< work
  EdgeCheck failed_;
};

}  // namespace leeway::planner
