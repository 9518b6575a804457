#pragma once

// Private to collision/: the state that the stages of a descent share. Each stage has its own file.

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "collision/base/scratch.h"
#include "collision/base/tolerances.h"
#include "collision/deform/bounds/probe_bounds.h"
#include "collision/deform/query/deform_side.h"
#include "collision/deform/query/probe.h"
#include "collision/mesh/descent/descent_bounds.h"

namespace leeway::collision {

/// A rigid body is compared as a whole with one triangle after the other; mesh_descent.cc opens the
/// hierarchy of a rigid mesh if its hull does not decide.
inline bool isRigid(const DeformSide& side) { return side.snapshot == nullptr; }

/// The triangles of a deforming mesh are identified by their slots; this value is a rigid body as a
/// whole.
inline constexpr int kWholeBody = -1;

/// An exact piece of a body: the triangle in a slot, whose corners are written to `corners`, or a
/// rigid convex body.
ConvexView pieceOf(const DeformSide& side, int slot, Eigen::Vector3d* corners);

/// The interval found so far, bounds by boxes, and the comparison of exact pieces. Compare Descent
/// in mesh_descent.cc.
class DescentState : public DescentBounds {
 public:
  DescentState(const DeformSide& a, const DeformSide& b, const DescentPlacement& placement,
               const DistanceRequest& request, Scratch& scratch, PairCache& cache);

  // Bounds by boxes.

  /// A part of A in a box of A's frame, grown by `radius`.
  Probe probeOf(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double radius) const {
    return makeProbe(low, high, radius, placement.X_BA0,
                     placement.swept ? &placement.X_BA1 : nullptr, extent_b, placement.slack);
  }
  /// A rigid A: the box of its core, grown by its radius.
  Probe rigidProbe() const;
  /// Raises the bounds of a node of B by the volumes of its motion, and closes columns accordingly.
  void tighten(std::int32_t node, const Probe& probe, WideBounds& bounds) const {
    if (has_volumes) tightenByVolumes(node, probe, bounds);
  }

  // Exact pieces: piece_pairs.cc.

  /// Compares two pieces, by slot or kWholeBody.
  void comparePieces(int slot_a, int slot_b);
  /// Compares a piece of A with the pieces of B in slots [begin_b, end_b), nearest first. `lower`
  /// is a bound for all of them, `bounds.lower` for each; its entries are overwritten.
  void compareWithLeaf(int slot_a, int begin_b, int end_b, double lower, WideBounds& bounds);
  /// Compares the pair that was nearest in the last query, which gives an upper bound at once.
  void warmStart();
  /// Records that this pair was compared first. When it comes up again and its distance is known as
  /// accurately as requested, it is not compared again.
  void rememberWarm(int slot_a, int slot_b);
  /// Records the plane perpendicular to the shortest displacement so far, at A's end: points beyond
  /// it are at least as far from A as from the plane. This closes most triangles that share the
  /// nearest vertex or edge.
  void rememberPlane(const DistanceResult& nearest);
  /// Whether these vertices, and all points that they span, are so far beyond that plane that they
  /// need no further comparison; they are settled in that case.
  bool isBeyondPlane(std::span<const std::int32_t> vertices) {
    return has_plane_ && areBeyondPlane(vertices);
  }

  const DeformSide& a;
  const DeformSide& b;
  const DescentPlacement& placement;
  Scratch& scratch;
  PairCache& cache;
  const ProbeKernels& kernels;
  BoxSource boxes_a, boxes_b;
  bool half_space = false;   // one of the bodies is a half-space
  bool has_volumes = false;  // B's motion provides bounds for nodes other than boxes
  double extent_b = 0;       // sum of magnitudes of B's coordinates, see makeProbe()
  Probe rigid_probe{};       // of a rigid A

 private:
  bool areBeyondPlane(std::span<const std::int32_t> vertices);
  void tightenByVolumes(std::int32_t node, const Probe& probe, WideBounds& bounds) const;
  DistanceResult compareWithMesh(const DescentSide& side_a, const DescentSide& side_b,
                                 double threshold, bool depth);
  DistanceResult compareConvex(const ConvexView& piece_a, const ConvexView& piece_b,
                               double threshold, bool depth);

  static constexpr int kNoSlot = -2;
  int warm_a_ = kNoSlot, warm_b_ = kNoSlot;  // see rememberWarm()
  double warm_lower_ = 0;                    // proven for that pair
  bool has_plane_ = false;
  Eigen::Vector3d plane_normal_ = Eigen::Vector3d::Zero();
  double plane_offset_ = 0;  // along the normal
};

// The stages. `root`: a lower bound for the two bodies as a whole, not pruned.

/// A sphere or a capsule A: finds the triangle nearest to its core. False if the question stays
/// open (contact with a requested depth, or rounding that is not small compared with the
/// tolerance). In that case nothing is settled, but there is an upper bound. Computes
/// result.hull_lower in either case.
bool isRound(const DescentState& state);
bool descendRound(DescentState& state);
/// Demand::kNoTree: all pieces of both bodies, by an octree.
void descendOctree(DescentState& state, double root);
/// A rigid A against the nodes of B.
void descendRigid(DescentState& state, double root);
/// A deforming A: pairs of nodes.
void descendPairs(DescentState& state, double root);

}  // namespace leeway::collision
