#include <algorithm>
#include <cmath>

#include "collision/base/numbers.h"
#include "collision/base/rounding.h"
#include "collision/deform/bounds/motion_boxes.h"
#include "collision/deform/update/snapshot_box.h"
#include "collision/deform/update/strategy.h"

// T. Larsson, T. Akenine-Moller, "Collision detection for continuously deforming bodies", 2001: the
// upper nodes are updated bottom-up, the others when a query opens them (Demand::kBranches). The
// upper nodes follow from the boxes of the branches, which are computed from
//   - the stored frames of a vertex cache, blended, without reading a vertex; or
//   - the current snapshot's boxes, moved and grown by how far vertices can have moved since, while
//     a share of the branches is read again, round robin; or
//   - all their vertices.

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

// Between two readings, the boxes of branches grow on average by at most this share of their
// longest sides. A larger value makes updates cheaper and queries more expensive; 0.5 changes them
// by a sixth and a quarter on waves of 200k triangles.
constexpr double kRoundGrowth = 0.35;
// All branches are read if more than this share of them is due, because growing the others also
// costs time.
constexpr double kWorthwhileShare = 0.75;
// Fewer branches than this are faster to read than to move [count].
constexpr std::size_t kFewBranches = 16;
// Up to this many vertices [count] stay in the cache after they are written, so the order in which
// they are read does not matter.
constexpr int kCachedVertices = 40000;

// Prefetches four consecutive vertices.
void fetchFour(const Vector3d* first) {
  const char* from = reinterpret_cast<const char*>(first);
  __builtin_prefetch(from);
  __builtin_prefetch(from + 64);
}

// Whether the boxes are blended from the stored frames of a vertex cache.
bool blendsCache(const UpdateState& state, const KnownVertices& known) {
  return known.by_motion && state.cached_bounds && state.tree == state.motion_tree;
}

// The fours of the branches that are next in the round, for as many branches as in the last update.
// Empty if these are all branches, which would not stay in the cache.
std::span<const std::int32_t> foursAhead(const UpdateState& state) {
  const std::span<const DeformTree::Branch> branches = state.tree->branches();
  const std::size_t begin = state.round.next < branches.size() ? state.round.next : 0,
                    end = std::min(begin + state.round.read, branches.size());
  if (begin >= end || state.round.read == branches.size()) return {};
  const auto first = static_cast<std::size_t>(branches[begin].runs.four_begin),
             last = static_cast<std::size_t>(branches[end - 1].runs.four_end);
  return state.tree->fours().subspan(first, last - first);
}

// Makes the boxes of branches from those of the current snapshot and from how far their vertices
// can have moved since. Returns the growth at either end along the longest axis, on average [m].
// The result is infinite if the current snapshot has no boxes of branches, if no bound is known, or
// if reading all is as fast. Bounds from the motion include the common movement of a branch's
// vertices, which moves the box without growing it. Other columns of these nodes are left
// undefined, because the refit fills them.
double moveBranches(const UpdateState& state, DeformableSnapshotImpl& next,
                    const KnownVertices& known) {
  const DeformTree& tree = *state.tree;
  const DeformableSnapshotImpl& last = state.current->impl();
  if (tree.branches().size() < kFewBranches) return kInfinity;
  if (last.tree != state.tree ||
      (last.demand != Demand::kNothing && last.demand != Demand::kBranches))
    return kInfinity;
  const NodeBounds* const bounds =
      known.by_motion && std::isfinite(state.current_motion_time) && state.tree == state.motion_tree
          ? state.upper_bounds.get()
          : nullptr;
  // Too far in any case.
  if (bounds == nullptr && !(known.moved < state.branch_length)) return kInfinity;
  const float low = roundedDown(-known.moved), high = roundedUpToFloat(known.moved);
  WideBox moved;
  for (int k = 0; k < 3; ++k) {
    std::fill_n(moved.low[k], kWidth, low);
    std::fill_n(moved.high[k], kWidth, high);
  }
  const std::int32_t upper = tree.upperCount();
  const double rounding =
      bounds != nullptr ? bounds->displacementRounding(last.parameters, next.parameters) : 0;
  double sum = 0;
  // The vertices that are read next are prefetched meanwhile, a few of them for each node. Reading
  // them then takes less than half the time.
  std::span<const std::int32_t> ahead = foursAhead(state);
  const std::size_t step = ahead.size() / static_cast<std::size_t>(upper) + 1;
  for (std::int32_t node = 0; node < upper; ++node) {
    const std::size_t count = std::min(step, ahead.size());
    for (const std::int32_t four : ahead.first(count)) fetchFour(next.vertices.data() + four);
    ahead = ahead.subspan(count);
    const auto& children = tree.node(node).child;
    const auto isBranch = [upper](std::int32_t child) { return child >= upper; };
    if (std::none_of(children, children + kWidth, isBranch)) continue;
    if (bounds != nullptr)
      bounds->displacement(node, last.parameters, next.parameters, rounding, moved);
    const auto i = static_cast<std::size_t>(node);
    WideBox& box = next.boxes[i];
    float side[kWidth];  // the longest
    motionKernels().move(last.boxes[i], low, high, moved, box, side);
    for (int column = 0; column < kWidth; ++column) {
      if (!isBranch(children[column])) continue;
      sum += 0.5 * static_cast<double>(side[column]);
      // A NaN would not propagate to the boxes above.
      for (int k = 0; k < 3; ++k)
        if (!(box.low[k][column] <= box.high[k][column])) return kInfinity;
    }
  }
  return sum / static_cast<double>(tree.branches().size());
}

// The number of branches to read when the others grow by this much in an update [m].
std::size_t branchesDue(const UpdateState& state, double growth) {
  const std::size_t all = state.tree->branches().size();
  // With a NaN, all branches are read.
  const double share = growth / (kRoundGrowth * state.branch_length);
  if (!(share < kWorthwhileShare)) return all;
  const double due = std::max(share, leastShare(state)) * static_cast<double>(all);
  return std::min(all, 1 + static_cast<std::size_t>(due));
}

// Reads the branches begin .. end - 1 from their vertices, and unites the upper nodes. False if a
// vertex is not finite.
bool readBranches(UpdateState& state, DeformableSnapshotImpl& next, std::size_t begin,
                  std::size_t end, bool all) {
  const DeformTree& tree = *state.tree;
  const DeformKernels& kernels = deformKernels();
  const Vector3d* const vertices = next.vertices.data();
  if (state.branch_room.size() < tree.branches().size())
    state.branch_room.resize(tree.branches().size());
  const bool finite =
      all && state.mesh->vertexCount() > kCachedVertices
          ? kernels.allBranches(tree, vertices, state.branch_room.data(), next.boxes.data())
          : kernels.branches(tree, vertices, begin, end, next.boxes.data());
  return finite && kernels.refit(tree, vertices, 0, tree.upperCount(), next.boxes.data());
}

bool updateUpperNodes(UpdateState& state, DeformableSnapshotImpl& next,
                      const KnownVertices& known) {
  const DeformTree& tree = *state.tree;
  next.tree = state.tree;
  next.demand = Demand::kBranches;
  const std::int32_t upper = tree.upperCount();
  reserveBoxes(next, upper);
  state.statistics.nodes_touched += upper;
  const std::size_t all = tree.branches().size();
  const bool blended = blendsCache(state, known);
  const std::size_t due = branchesDue(state, blended ? 0 : moveBranches(state, next, known));
  UpdateState::BranchRound& round = state.round;
  if (due == all || round.next == all) round = {.frames = round.frames};
  round.read = due;
  const std::size_t begin = round.next, end = std::min(begin + due, all);
  if (blended) {
    for (std::int32_t node = 0; node < upper; ++node) {
      state.cached_bounds->fetch(node + kNodesAhead, next.parameters);
      state.cached_bounds->bound(node, next.parameters, next.boxes[static_cast<std::size_t>(node)]);
    }
  } else if (!readBranches(state, next, begin, end, due == all)) {
    return false;
  }
  addToRound(state, next, end);
  if (!blended && begin < end) {
    const DeformTree::Runs &first = tree.branches()[begin].runs,
                           &last = tree.branches()[end - 1].runs;
    state.statistics.vertices_touched +=
        4 * (last.four_end - first.four_begin) + last.single_end - first.single_begin;
  }
  setBox(next, next.boxes[0]);
  return true;
}

}  // namespace

bool followByHybrid(UpdateState& state, DeformableSnapshotImpl& next, const KnownVertices& known) {
  bool good = updateUpperNodes(state, next, known);
  // Boxes that were moved and grown may exceed the limits although no vertex does.
  if (good && !isWithinLimits(next))
    good = updateUpperNodes(state, next, {known.bounded, false, kInfinity});
  return good && isWithinLimits(next);
}

void addToRound(UpdateState& state, const DeformableSnapshotImpl& snapshot, std::size_t end) {
  const std::span<const DeformTree::Branch> branches = state.tree->branches();
  UpdateState::BranchRound& round = state.round;
  for (; round.next < end; ++round.next) {
    const DeformTree::Up& up = state.tree->up(branches[round.next].root);
    const Vector3d side = sidesOf(snapshot.boxes[static_cast<std::size_t>(up.parent)], up.column);
    if (state.options.strategy == DeformStrategy::kAuto) round.area += halfArea(side);
    round.length += std::max({side.x(), side.y(), side.z()});
  }
  if (end == branches.size()) state.branch_length = round.length / static_cast<double>(end);
}

}  // namespace leeway::collision
