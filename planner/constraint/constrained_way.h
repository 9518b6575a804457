#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "leeway/robots/inverse_kinematics.h"
#include "planner/base/random.h"
#include "planner/constraint/constraint_proof.h"

namespace leeway::planner {

/// Ways on which a problem's constraints hold: straight steps towards a target, whose ends are
/// brought back to where the constraints hold by inverse kinematics (Berenson, Srinivasa, Kuffner,
/// "Task Space Regions", 2011, who only look at the ends; here each edge is proven). Has buffers:
/// one thread at a time. Deterministic.
class ConstrainedWay {
 public:
  using IsFree = std::function<bool(std::span<const double>, std::span<const double>)>;

  /// `is_free` decides whether an edge keeps its margins. `range`: the longest step, in the space's
  /// distance. The scene and the function must outlive the way.
  ConstrainedWay(const CompiledScene& scene, const Problem& problem, const IsFree& is_free,
                 double range);

  ConstraintProof& proof() { return proof_; }

  /// Whether the edge is free and the constraints hold on it.
  bool isFree(std::span<const double> a, std::span<const double> b);

  /// From `from`, where the constraints hold, towards `target`, nearer with each step. Appends the
  /// points that it reaches, each joined to the one before by an edge that isFree(); true when the
  /// last one is the target. At most kWayEdges edges.
  bool go(std::span<const double> from, std::span<const double> target,
          std::vector<double>& points);

 private:
  /// Moves a point to a near one where the constraints hold. False where none is found.
  bool project(std::vector<double>& point);

  const CompiledScene& scene_;
  const IsFree& is_free_;
  double range_;
  ConstraintProof proof_;
  robots::InverseKinematics kinematics_;
  std::vector<robots::PoseRegion> regions_;
  std::vector<double> at_, next_, q_;
};

/// Shortens a path of edges that isFree() and keeps its ends: cuts between random points by ways,
/// then leaves points out. The path never gets longer. `stop` is called before each cut.
void shorten(ConstrainedWay& way, const ConfigurationSpace& space,
             std::vector<std::vector<double>>& path, std::uint64_t seed,
             const std::function<bool()>& stop);

}  // namespace leeway::planner
