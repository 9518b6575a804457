#pragma once

// Private to planner/: the geometry of cut corners, and its proof. `before` and `after` are the
// differences of the two edges at the corner; see ConfigurationSpace::difference().

#include <memory>
#include <span>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/trajectory.h"
#include "planner/compiled/displacement.h"

namespace leeway::planner {

/// The point of a blend at t in [0, 1] of its time.
void blendPoint(std::span<const double> corner, std::span<const double> before,
                std::span<const double> after, const Blend& blend, double t,
                std::span<double> result);

/// Its derivative with respect to t, or its second one.
void blendDerivative(std::span<const double> before, std::span<const double> after,
                     const Blend& blend, double t, bool second, std::span<double> result);

/// How far a blend departs from the two edges at most: at t, it is a share of this difference, of
/// at most 1, from the point that passes the corner at half of the time.
std::vector<double> blendDeparture(std::span<const double> before, std::span<const double> after,
                                   const Blend& blend);

/// Proves blends of one path.
class BlendProof {
 public:
  explicit BlendProof(const std::shared_ptr<const CompiledScene>& scene);

  /// Whether the whole blend is proven to keep the margins, and joints their limits. Certifies up
  /// to kBlendChords edges.
  bool holds(std::span<const double> corner, std::span<const double> before,
             std::span<const double> after, const Blend& blend);

 private:
  bool wraps(std::span<const double> corner, std::span<const double> before,
             std::span<const double> after, const Blend& blend) const;

  const ConfigurationSpace& space_;
  EdgeCertifier certifier_;
  std::size_t size_;
  std::vector<double> bend_, point_, next_;
  Displacement displacement_;
};

}  // namespace leeway::planner
