#pragma once

// Private to collision/: what the stages of a descent share. Each stage has a file of its own.

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>

#include "collision/base/scratch.h"
#include "collision/base/tolerances.h"
#include "collision/base/work.h"
#include "collision/deform/bounds/probe_bounds.h"
#include "collision/deform/query/deform_side.h"
#include "collision/deform/query/probe.h"

namespace leeway::collision {

/// A rigid body is taken as a whole, against one triangle after the other; mesh_descent.cc opens
/// the hierarchy of a rigid mesh where its hull does not decide.
inline bool isRigid(const DeformSide& side) { return side.snapshot == nullptr; }

/// The triangles of a deforming mesh are told by their slots; this one is a rigid body as a whole.
inline constexpr int kWholeBody = -1;

/// An exact piece of a body: the triangle in a slot, whose corners are put into `corners`, or a
/// rigid convex body.
ConvexView pieceOf(const DeformSide& side, int slot, Eigen::Vector3d* corners);

/// The interval found so far, when to stop, and the comparison of exact pieces. As Descent in
/// mesh_descent.cc.
class DescentState {
 public:
  DescentState(const DeformSide& a, const DeformSide& b, const DescentPlacement& placement,
               const DistanceRequest& request, Scratch& scratch, PairCache& cache);

  // When to stop.

  /// Pairs with a lower bound above this need no closer look.
  double bar() const { return placement.swept ? std::min(bar_, result.lower) : bar_; }
  /// To be called when result.upper has changed.
  void updateBar();
  bool needless(double lower) const {
    return lower > bar() || (placement.swept && lower >= result.lower);
  }
  bool done() const {
    if (result.upper <= request.threshold) return true;
    if (!placement.swept) return result.upper <= 0 && !request.depth;
    return result.upper <= 0 || result.lower <= floor();
  }
  /// Nodes, leaves and pairs of pieces that may be visited.
  int limit() const {
    if (scratch.impl().work->isSpent()) return 0;
    const int most = request.node_limit - mesh_nodes;
    return result.upper <= 0 && !half_space ? std::min(most, overlap_limit_) : most;
  }
  /// Whatever is dropped without a closer look must pass its lower bound through here.
  void settle(double lower) { result.lower = std::min(result.lower, lower); }

  // Bounds by boxes.

  /// A part of A in a box of A's frame, grown by `radius`.
  Probe probeOf(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double radius) const {
    return makeProbe(low, high, radius, placement.X_BA0,
                     placement.swept ? &placement.X_BA1 : nullptr, extent_b, placement.slack);
  }
  /// A rigid A: the box of its core, grown by its radius.
  Probe rigidProbe() const;
  /// Raises the bounds of a node of B by the volumes of its motion, and closes lanes with them.
  void tighten(std::int32_t node, const Probe& probe, LaneBounds& bounds) const {
    if (has_volumes) tightenByVolumes(node, probe, bounds);
  }

  // Exact pieces: piece_pairs.cc.

  /// Compares two pieces, by slot or kWholeBody.
  void comparePieces(int slot_a, int slot_b);
  /// Compares a piece of A with the pieces of B in slots [begin_b, end_b), nearest first. `lower`
  /// holds for all of them, `bounds.lower` for each; its entries are overwritten.
  void compareWithLeaf(int slot_a, int begin_b, int end_b, double lower, LaneBounds& bounds);
  /// Compares the pair that was nearest in the last query: an upper bound at once.
  void warmStart();
  /// Remembers that this pair was compared first: when it comes again in its turn, and is known as
  /// well as the request asks, it need not be compared again.
  void rememberWarm(int slot_a, int slot_b);
  /// Remembers the plane perpendicular to the shortest way so far, at A's end: what is beyond it is
  /// as far from A as from the plane. Most triangles that share the nearest vertex or edge end
  /// here.
  void rememberPlane(const DistanceResult& nearest);
  /// Whether these vertices, and what they span, are so far beyond that plane that they need no
  /// closer look; they are settled then.
  bool isBeyondPlane(std::span<const std::int32_t> vertices) {
    return has_plane_ && areBeyondPlane(vertices);
  }

  const DeformSide& a;
  const DeformSide& b;
  const DescentPlacement& placement;
  const DistanceRequest& request;
  Scratch& scratch;
  PairCache& cache;
  const ProbeKernels& kernels;
  BoxSource boxes_a, boxes_b;
  bool half_space = false;   // one of the bodies is one
  bool has_volumes = false;  // B's motion bounds nodes by more than boxes
  double extent_b = 0;       // sum of magnitudes of B's coordinates, see makeProbe()
  Probe rigid_probe{};       // of a rigid A

  DescentResult result;
  int visited = 0;     // nodes, leaves and pairs of pieces
  int mesh_nodes = 0;  // visited in hierarchies of rigid meshes

 private:
  double floor() const { return request.threshold > 0 ? request.threshold : 0; }
  bool areBeyondPlane(std::span<const std::int32_t> vertices);
  void tightenByVolumes(std::int32_t node, const Probe& probe, LaneBounds& bounds) const;
  DistanceResult compareWithMesh(const DescentSide& side_a, const DescentSide& side_b,
                                 double threshold, bool depth);
  DistanceResult compareConvex(const ConvexView& piece_a, const ConvexView& piece_b,
                               double threshold, bool depth);

  double bar_ = std::numeric_limits<double>::infinity();  // without what a sweep adds, see bar()
  int overlap_limit_ = std::numeric_limits<int>::max();   // of `visited`, once bodies overlap
  static constexpr int kNoSlot = -2;
  int warm_a_ = kNoSlot, warm_b_ = kNoSlot;  // see rememberWarm()
  double warm_lower_ = 0;                    // proven for that pair
  bool has_plane_ = false;
  Eigen::Vector3d plane_normal_ = Eigen::Vector3d::Zero();
  double plane_offset_ = 0;  // along the normal
};

// The stages. `root`: a lower bound for the two bodies as a whole, not needless.

/// A sphere or a capsule A: finds the triangle nearest to its core. False where the question stays
/// open (contact with a depth asked for, or rounding not small beside the tolerance): nothing is
/// settled then, but there is an upper bound. Finds result.hull_lower in either case.
bool isRound(const DescentState& state);
bool descendRound(DescentState& state);
/// Demand::kNoTree: all pieces of both bodies, by an octree.
void descendOctree(DescentState& state, double root);
/// A rigid A against the nodes of B.
void descendRigid(DescentState& state, double root);
/// A deforming A: pairs of nodes.
void descendPairs(DescentState& state, double root);

}  // namespace leeway::collision
