#pragma once

// Private to collision/: how the hierarchy of a deforming mesh follows its vertices. Each strategy
// has one file and one function.
//
// To add a strategy:
//   1. deformable_mesh.h, deformable_mesh.cc: an enumerator of DeformStrategy and its word;
//   2. here and in a new file: a function follow...() that updates the next snapshot's tree and
//      bounds for its vertices, and its state, if any, in UpdateState;
//   3. strategy.cc: a case in follow();
//   4. automatic.cc, if kAuto is to choose it;
// 5. tests/collision/deform/deformable_conformance_test.cc: a line in kChoices. The suite then
//    checks for the same answers as brute force.
// Queries see only the snapshot. A strategy that leaves bounds to them sets Demand (snapshot.h).

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "collision/deform/bounds/cached_bounds.h"
#include "collision/deform/bounds/node_bounds.h"
#include "collision/deform/snapshot.h"
#include "collision/deform/tree/deform_tree.h"
#include "collision/deform/tree/refit.h"
#include "collision/deform/tree/tree_builder.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/vertex_motion.h"

namespace leeway::collision {

/// Known properties of the next snapshot's vertices before a strategy reads them.
struct KnownVertices {
  bool bounded;    ///< they are finite, and within the next snapshot's low .. high
  bool by_motion;  ///< they are the motion's, for the next snapshot's parameters
  double moved;    ///< none is farther from its place in the current snapshot; may be infinite [m]
};

/// The state that an owner of a deforming mesh keeps between updates.
struct UpdateState {
  // Constant after construction.
  std::shared_ptr<const DeformableMesh> mesh;
  std::shared_ptr<const VertexMotion> motion;  ///< may be null
  DeformOptions options;
  int split = 0;  ///< limit on the triangles of a branch

  std::shared_ptr<const DeformTree> tree;  ///< the current hierarchy; rebuilds replace it
  /// The first hierarchy. Bounds from the motion belong to it; each may be null.
  std::shared_ptr<const DeformTree> motion_tree;
  std::shared_ptr<const NodeBounds> bounds;           ///< of all nodes
  std::shared_ptr<const NodeBounds> upper_bounds;     ///< boxes of the upper nodes
  std::unique_ptr<const CachedBounds> cached_bounds;  ///< of the upper nodes, for a vertex cache

  std::shared_ptr<const DeformableSnapshot> current;
  /// The time of the current snapshot's vertices in the motion [s]; NaN if they are not the
  /// motion's.
  double current_motion_time = std::numeric_limits<double>::quiet_NaN();
  UpdateStatistics statistics;

  /// kHybrid: if known motion allows it, branches are read round robin. A round reads each once.
  struct BranchRound {
    std::size_t next = 0;  ///< branch to be read next
    std::size_t read = 0;  ///< branches read in the last update
    int frames = 0;        ///< kAuto: updates since a round ended
    double area = 0;    ///< kAuto: half the surface area of the branches read in this round [m^2]
    double length = 0;  ///< their longest sides, summed [m]
  };
  BranchRound round;
  std::vector<BranchBox> branch_room;  ///< see DeformKernels::allBranches
  double branch_length = 0;  ///< mean longest side of a branch's box over the last whole round [m]

  /// kRestructure.
  std::vector<float> fit, built_fit;  ///< of the nodes, now and when they were built
  std::vector<std::int32_t> decayed;  ///< nodes

  /// Values when the tree was built, for comparison with its decay.
  double built_cost = 0;        ///< surfaceCost() of all nodes
  double built_upper_cost = 0;  ///< surfaceCost() of the upper nodes
  double built_looseness = 0;   ///< kAuto: looseness of the branches
  double excess = 0;            ///< kAuto: cost of decay for queries since then [us]

  std::span<const Eigen::Vector3d> vertices(const DeformableSnapshotImpl& snapshot) const {
    return {snapshot.vertices.data(), mesh->rest().size()};
  }
};

/// A strategy and the reason for choosing it (UpdateStatistics::reason).
struct StrategyChoice {
  DeformStrategy strategy;
  const char* reason;
};

/// Whether a strategy computes its bounds from the motion.
bool needsMotion(DeformStrategy strategy);
/// The strategy for a kind of motion; kHybrid if the kind has no bounds of its own.
DeformStrategy strategyOf(MotionKind kind);

/// The strategy in the options, or the one that kAuto chooses. `by_motion` as in KnownVertices.
StrategyChoice chooseStrategy(const UpdateState& state, bool by_motion);

/// Updates the next snapshot's tree, bounds, low and high for its vertices. `choice` returns what
/// was done in the end, because kAuto may also rebuild. False if a vertex is not finite, or is
/// clearly beyond kLargestSize.
bool follow(UpdateState& state, StrategyChoice& choice, DeformableSnapshotImpl& next,
            const KnownVertices& known);

// The strategies. Each returns false if it finds a vertex that is not finite.

/// kRefit: one backward loop over all nodes (DeformKernels::refit).
bool followByRefit(UpdateState& state, DeformableSnapshotImpl& next);
/// kRebuild, kRebuildLinear: a new hierarchy.
bool followByRebuild(UpdateState& state, DeformableSnapshotImpl& next, DeformMethod method,
                     bool bounded);
/// kRestructure: a refit; decayed subtrees are rebuilt.
bool followByRestructure(UpdateState& state, DeformableSnapshotImpl& next);
/// kHybrid: the upper nodes; those of branches are left to the queries.
bool followByHybrid(UpdateState& state, DeformableSnapshotImpl& next, const KnownVertices& known);
/// kLazy, kOctree: the box of all vertices; everything else is left to the queries.
bool followOnDemand(UpdateState& state, DeformableSnapshotImpl& next, Demand demand, bool bounded);
/// kMorph, kSkinned, kReduced: the root's box; queries compute bounds of nodes from the motion.
bool followByMotion(UpdateState& state, DeformableSnapshotImpl& next);
/// kAuto, after kHybrid: rebuilds if the hierarchy's decay has cost more than a rebuild.
bool rebuildIfDecayed(UpdateState& state, StrategyChoice& choice, DeformableSnapshotImpl& next,
                      const KnownVertices& known);

// Functions that strategies share.

/// Records the values of a tree that was just built, all of whose boxes `snapshot` has.
void measureBuilt(UpdateState& state, const DeformableSnapshotImpl& snapshot);
/// kHybrid: records that the branches from round.next to `end` have been read.
void addToRound(UpdateState& state, const DeformableSnapshotImpl& snapshot, std::size_t end);
/// kAuto: the least share of the branches that kHybrid reads.
double leastShare(const UpdateState& state);
/// kAuto: surface area of the nodes and leaves below the upper nodes, divided by that of the
/// triangles' own boxes. `branch_area`: half that of the branches [m^2].
double looseness(const UpdateState& state, const DeformableSnapshotImpl& snapshot,
                 double branch_area);

}  // namespace leeway::collision
