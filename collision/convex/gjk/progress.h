#pragma once

// The bounds that a query has proven so far, and whether they meet its request.

#include <algorithm>
#include <limits>

#include "collision/base/status.h"
#include "collision/convex/gjk/support.h"

namespace leeway::collision {

/// A request in terms of two cores.
struct CoreQuery {
  DistanceRequest request;
  double radius_a = 0, radius_b = 0;
  /// A support plane at core distance d proves d - lower_offset, and a witness at core distance d
  /// proves d - upper_offset [m]. The offsets include radii, rounding and excess.
  double lower_offset = 0, upper_offset = 0;
  /// The part of lower_offset by which a swept body may leave the hull of its placements [m].
  double growth = 0;
  /// Rounding of a coordinate: kUnitRoundoff * (extents + |translation|) [m].
  double roundoff = 0;
};

/// The best lower end with its plane and the best upper end with its witness.
class Progress {
 public:
  explicit Progress(const CoreQuery& query) : query_(query) {}

  /// Offers a plane: every point w of the difference has w . n >= value.
  void offerLower(double value, const Vector& n) {
    const double lower = value - query_.lower_offset;
    if (lower > lower_) {
      lower_ = lower;
      normal_ = n;
    }
  }

  /// Replaces a plane that is better only by rounding: `normal` then belongs to the witness.
  void preferLower(double value, const Vector& n) {
    lower_ = value - query_.lower_offset;
    normal_ = n;
  }

  /// Offers a point w of the difference at `distance` from the origin; `a` is A's part of it.
  void offerWitness(double distance, const Vector& w, const Vector& a) {
    const double upper = distance - query_.upper_offset;
    if (upper <= upper_) {
      upper_ = upper;
      witness_w_ = w;
      witness_a_ = a;
    }
  }

  /// Offers a witness and the plane next to it. If the two meet the tolerance, they replace others,
  /// even slightly better ones, because radii are laid off along `normal`, which must be that of
  /// the witness. Otherwise offers the plane alone and returns false.
  bool offerTogether(double distance, const Vector& w, const Vector& a, double value,
                     const Vector& n) {
    const double upper = distance - query_.upper_offset, lower = value - query_.lower_offset;
    if (!(upper - lower <= query_.request.tolerance) || aboveThreshold()) {
      offerLower(value, n);
      return false;
    }
    upper_ = std::min(upper_, upper);
    witness_w_ = w, witness_a_ = a;
    lower_ = lower, normal_ = n;
    return true;
  }

  /// offerWitness() without its points, which must follow.
  void offerUpper(double distance) { upper_ = std::min(upper_, distance - query_.upper_offset); }

  /// Offers a point of a swept hull at `distance`. A single placement need not reach it, so it is
  /// not an upper end, but it bounds what the lower end can gain.
  void offerSweptWitness(double distance) {
    const double upper = distance - query_.upper_offset - query_.growth;
    if (upper < swept_upper_) swept_upper_ = upper;
  }

  // A threshold or tolerance of NaN decides nothing.

  bool aboveThreshold() const { return lower_ > query_.request.threshold; }
  bool converged() const {
    return upper_ - lower_ <= query_.request.tolerance ||
           swept_upper_ - lower_ <= query_.request.tolerance;
  }

  bool decided() const { return isDecided({lower_, upper_}, query_.request); }
  bool enough() const { return decided() || (converged() && signKnown()); }

  /// False while the interval holds 0: a query continues until the sign is known, however narrow
  /// the interval.
  bool signKnown() const { return isSignKnown({lower_, upper_}); }

  DistanceStatus status() const {
    return converged() ? DistanceStatus::kConverged : statusOf({lower_, upper_}, query_.request);
  }

  const CoreQuery& query() const { return query_; }
  double lower() const { return lower_; }
  double upper() const { return upper_; }
  const Vector& normal() const { return normal_; }
  const Vector& witnessW() const { return witness_w_; }
  const Vector& witnessA() const { return witness_a_; }
  int iterations = 0;
  int facet_cells = 0;  ///< of CurvedFacets; they count as work in addition to the iterations

 private:
  const CoreQuery& query_;
  double lower_ = -std::numeric_limits<double>::infinity();
  double upper_ = std::numeric_limits<double>::infinity();
  double swept_upper_ = std::numeric_limits<double>::infinity();
  Vector normal_ = Vector::UnitX();
  Vector witness_w_ = Vector::Zero(), witness_a_ = Vector::Zero();
};

}  // namespace leeway::collision
