#include <algorithm>
#include <cmath>

#include "collision/deform/tree/tree_fit.h"
#include "collision/deform/update/snapshot_box.h"
#include "collision/deform/update/strategy.h"

// The choices of kAuto. They never change an answer: every constant here only tunes speed.

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

// Cost model [us]; only ratios matter. Measured by `leeway report deform`, rounded.
// A query of a hierarchy that fits.
constexpr double kQueryMicroseconds = 3;
// A rebuild by the surface area heuristic, for each triangle.
constexpr double kRebuildMicroseconds = 0.2;
// The additional time of a query with boxes from modes, waves or bones, which add extremes that
// never occur together. Boxes of blended morph targets are as tight as boxes of vertices.
constexpr double kModesMicroseconds = 3.5;
// An update that reads the vertices, for each triangle.
constexpr double kReadMicroseconds = 0.001;
// The additional time for reading a vertex whose neighbours in the hierarchy are not its neighbours
// in memory. After a rebuild of decayed subtrees, this may apply to all vertices.
constexpr double kScatteredMicroseconds = 0.004;
// The decision about a rebuild.
constexpr double kWeighMicroseconds = 7;

// Decay is evaluated at the end of a round of branches. Therefore kAuto reads at least this share
// of the branches in every update, unless that would take more than kOverhead of the queries' time.
// It also evaluates nothing that costs more than this share.
constexpr double kLeastShare = 0.125;
constexpr double kOverhead = 0.1;
// Number of sampled triangles, to distinguish growth of the mesh from decay of the hierarchy
// [count].
constexpr std::size_t kSampledTriangles = 256;

double frameMicroseconds(const DeformOptions& options) {
  return kQueryMicroseconds * std::max(options.expected_queries, 0);
}

// Whether the decay since the last rebuild has cost queries more than a rebuild costs. This is the
// ski rental rule: if decay were known in every frame, the cost would be at most twice the least
// possible. Decay is only known at the end of a round, and is then charged to all frames since the
// last round.
bool rebuildPays(UpdateState& state, const DeformableSnapshotImpl& next) {
  const DeformTree& tree = *state.tree;
  UpdateState::BranchRound& round = state.round;
  const double cost = surfaceCost({next.boxes.data(), next.boxes.size()}, tree.upperCount());
  state.statistics.decay = state.built_upper_cost > 0 ? cost / state.built_upper_cost : 1;
  ++round.frames;
  if (round.next < tree.branches().size()) return false;
  const double fresh = round.frames * state.options.expected_queries * kQueryMicroseconds;
  if (kOverhead * fresh < kWeighMicroseconds) return false;
  const double looser =
      state.built_looseness > 0 ? looseness(state, next, round.area) / state.built_looseness : 1;
  // Queries slow down by less than the factor by which boxes grow in length: in an explosion, 1.4
  // times at 10 times the area, 2.7 times at 65 times.
  const double queries = fresh * std::max(std::sqrt(looser) - 1, 0.0);
  const double dearer_updates =
      kScatteredMicroseconds * std::max(state.mesh->vertexCount() - tree.branchSingles(), 0);
  round.frames = 0;
  state.excess += std::max(queries - dearer_updates, 0.0);
  return state.excess > kRebuildMicroseconds * state.mesh->triangleCount();
}

}  // namespace

bool needsMotion(DeformStrategy strategy) {
  return strategy == DeformStrategy::kMorph || strategy == DeformStrategy::kSkinned ||
         strategy == DeformStrategy::kReduced;
}

DeformStrategy strategyOf(MotionKind kind) {
  switch (kind) {
    case MotionKind::kMorph:
      return DeformStrategy::kMorph;
    case MotionKind::kSkinned:
      return DeformStrategy::kSkinned;
    case MotionKind::kReduced:
    case MotionKind::kWaves:  // two modes a wave
      return DeformStrategy::kReduced;
    default:
      return DeformStrategy::kHybrid;
  }
}

StrategyChoice chooseStrategy(const UpdateState& state, bool by_motion) {
  // The rest position need not be one of the motion's positions, and the motion's bounds hold for
  // no other vertices.
  if (!state.current) return {DeformStrategy::kRefit, "the first snapshot is at rest"};
  const DeformOptions& options = state.options;
  if (needsMotion(options.strategy) && !by_motion)
    return {DeformStrategy::kHybrid, "the vertices are not the motion's"};
  if (options.strategy != DeformStrategy::kAuto) return {options.strategy, "asked for"};
  const bool bounded = by_motion && state.bounds && needsMotion(strategyOf(state.motion->kind()));
  const bool loose = bounded && state.motion->kind() != MotionKind::kMorph;
  if (bounded && !(loose && options.expected_queries * kModesMicroseconds >
                                state.mesh->triangleCount() * kReadMicroseconds))
    return {strategyOf(state.motion->kind()), "the motion bounds its own nodes"};
  return {DeformStrategy::kHybrid,
          loose ? "reading the vertices costs less than looser boxes from the motion"
                : "vertices come one by one, few queries a frame"};
}

double leastShare(const UpdateState& state) {
  if (state.options.strategy != DeformStrategy::kAuto) return 0;
  const double read = kReadMicroseconds * state.mesh->triangleCount();
  return std::min(kLeastShare, kOverhead * frameMicroseconds(state.options) / read);
}

// The area of the nodes and leaves below the upper nodes, relative to that of the triangles, some
// of which are sampled. A rebuild improves this ratio. If the triangles themselves grow, as in an
// explosion, all hierarchies grow with them and a rebuild gains nothing. A tree without branches
// has only upper nodes; in that case their children count, because leaves alone do not show how
// they are arranged.
double looseness(const UpdateState& state, const DeformableSnapshotImpl& snapshot,
                 double branch_area) {
  const std::span<const DeformableMesh::Triangle> triangles = state.mesh->triangles();
  const std::size_t step = std::max<std::size_t>(1, triangles.size() / kSampledTriangles);
  double area = 0;
  int count = 0;
  for (std::size_t i = 0; i < triangles.size(); i += step, ++count) {
    const auto corner = [&](std::size_t k) -> const Vector3d& {
      return snapshot.vertices[static_cast<std::size_t>(triangles[i][k])];
    };
    area += halfArea(corner(0).cwiseMax(corner(1)).cwiseMax(corner(2)) -
                     corner(0).cwiseMin(corner(1)).cwiseMin(corner(2)));
  }
  area *= static_cast<double>(triangles.size()) / count;
  const DeformTree& tree = *state.tree;
  const bool no_branches = tree.branches().empty();
  double below = branch_area;
  for (std::int32_t node = 0; node < tree.upperCount(); ++node) {
    for (std::int32_t column = 0; column < kWidth; ++column) {
      const std::int32_t child = tree.node(node).child[column];
      if (child == DeformTree::kNone) break;
      if (no_branches || DeformTree::isLeaf(child))
        below += halfArea(sidesOf(snapshot.boxes[static_cast<std::size_t>(node)], column));
    }
  }
  return area > 0 ? below / area : 0;
}

bool rebuildIfDecayed(UpdateState& state, StrategyChoice& choice, DeformableSnapshotImpl& next,
                      const KnownVertices& known) {
  if (!rebuildPays(state, next)) return true;
  choice = {DeformStrategy::kRebuild,
            "the hierarchy has decayed by more than building it anew costs"};
  state.statistics.nodes_touched = state.statistics.vertices_touched = 0;
  return followByRebuild(state, next, DeformMethod::kBinned, known.bounded);
}

}  // namespace leeway::collision
