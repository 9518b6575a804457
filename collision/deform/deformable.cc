#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "collision/base/round_box.h"
#include "collision/base/round_up.h"
#include "collision/base/scratch.h"
#include "collision/base/tolerances.h"
#include "collision/deform/bounds/cached_bounds.h"
#include "collision/deform/bounds/motion_boxes.h"
#include "collision/deform/motion/motion_input.h"
#include "collision/deform/snapshot_pool.h"
#include "collision/deform/tree/tree_builder.h"
#include "collision/deform/tree/tree_fit.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/vertex_motion.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::uint64_t nextNumber() {
  static std::atomic<std::uint64_t> last{0};
  return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

// The cost model of `auto`: what a query against a hierarchy that fits, and a triangle of a rebuild
// by surface area, take [us]; only their ratio counts. Measured by bench_deform, rounded.
constexpr double kQueryMicroseconds = 3;
constexpr double kRebuildMicroseconds = 0.2;
// What a query takes longer among boxes of modes, waves' too, which add up where crests do not
// meet, or of bones, and what a triangle costs an update that reads its vertices [us]; from leeway
// report deform, rounded. Blended morph targets are as close as boxes of vertices.
constexpr double kModesMicroseconds = 3.5;
constexpr double kReadMicroseconds = 0.001;
// What reading a vertex takes longer where its neighbours in the hierarchy no longer stand beside
// it in memory [us], likewise: after a rebuild of what has decayed all may be read so.
constexpr double kApartMicroseconds = 0.004;
// Triangles that are looked at to see whether the hierarchy or the mesh itself has grown.
constexpr std::size_t kSampledTriangles = 256;
// Where it is known how far vertices can have moved, branches are read in turns and the boxes of
// the others grow: by no more than this share of their longest sides in the mean. Larger: cheaper
// updates, dearer queries: at 0.5 a sixth and a quarter, on waves of 200k triangles.
constexpr double kTurnGrowth = 0.35;
// When more than this share of the branches is due, all are read: growing the others is work, too.
constexpr double kTurnWorth = 0.75;
// Fewer branches are read sooner than moved [count].
constexpr std::size_t kTurnBranches = 16;
// Vertices of so small a mesh [count] are still near when they have just been written, and the
// order in which they are read does not matter.
constexpr int kNearVertices = 40000;
// auto weighs a rebuild at the end of a turn: it reads this share of the branches a frame at least,
// or less where reading them would take more than kTurnQueries of what queries take.
constexpr double kTurnShare = 0.125;
constexpr double kTurnQueries = 0.1;
// Weighing it takes about so long [us], and no larger share of what queries take, either.
constexpr double kWeighMicroseconds = 7;

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

// Each with its name, the value and what is accepted; false for a NaN.
void requireSensible(const DeformOptions& options) {
  const auto require = [](bool good, const char* field, const std::string& value,
                          const char* accepted) {
    if (!good)
      throw std::invalid_argument(std::string("deformable: ") + field + " is " + value + "; " +
                                  accepted + " is accepted");
  };
  require(options.hybrid_split >= 0, "hybrid_split", std::to_string(options.hybrid_split),
          "a count of at least 0");
  require(options.restructure_factor > 1, "restructure_factor", shown(options.restructure_factor),
          "a number above 1");
  require(options.speed_horizon >= 0 && std::isfinite(options.speed_horizon), "speed_horizon",
          shown(options.speed_horizon), "a finite number of at least 0 s");
  require(options.expected_queries >= 0, "expected_queries",
          std::to_string(options.expected_queries), "a count of at least 0");
}

}  // namespace

struct Deformable::Impl {
  std::shared_ptr<const DeformableMesh> mesh;
  std::shared_ptr<const VertexMotion> motion;
  DeformOptions options;
  int split = 0;
  std::uint64_t number = 0;
  std::shared_ptr<DeformPool> pool = std::make_shared<DeformPool>();
  std::shared_ptr<const DeformTree> tree;
  std::shared_ptr<const NodeBounds> bounds;  // from the motion, of motion_tree; may be null
  std::shared_ptr<const DeformTree> motion_tree;
  std::shared_ptr<const NodeBounds> upper_bounds;     // likewise, of its upper nodes; boxes
  std::unique_ptr<const CachedBounds> cached_bounds;  // or these, of a vertex cache
  DeformPool::Slot* next = nullptr;                   // being prepared
  std::shared_ptr<const DeformableSnapshot> current;
  UpdateStatistics statistics;
  int bad_vertex = -1;
  bool all_used = false;  // every vertex is a triangle's corner
  // What stands in the next snapshot's vertices.
  enum class Prepared : unsigned char {
    kNothing,  // nothing since the last commit: what an older snapshot had
    kGiven,    // what the caller writes: its span is valid until the commit
    kMotion,   // the motion's vertices at `evaluated`, and nobody has a span to change them
    kMixed,    // likewise, or a refused evaluate(), but somebody has
  };
  Prepared prepared = Prepared::kNothing;
  double evaluated = kNaN;
  double current_evaluated = kNaN;  // of the current snapshot; NaN: they are not the motion's
  // Since the tree was built.
  double built_cost = 0;        // surfaceCost() of all nodes, then
  double built_upper_cost = 0;  // of the upper ones
  double built_looseness = 0;   // looseness() of the branches then
  double excess = 0;            // what queries have paid for its decay, see kQueryMicroseconds
  std::vector<float> fit, built_fit;
  std::vector<std::int32_t> decayed;
  // The turn in which the branches are read, see upperLevels().
  struct Turn {
    std::size_t next = 0;  // branch
    std::size_t due = 0;   // branches that were read in the last frame
    int frames = 0;        // of auto: since the last turn that ended, those of turns cut short, too
    double area = 0, length = 0;  // sums over the branches that were read, as they were then; the
                                  // area for auto alone
  };
  Turn turn;
  std::vector<BranchBox> branch_room;
  double branch_length = 0;  // longest side of a branch's box, in the mean over the last whole turn

  // What is to be done with vertices that stand in the next snapshot. Of those that are given, none
  // is farther than `moved` from where the current one has it. Ends what was prepared, whatever it
  // returns.
  UpdateStatus take(double time, double speed_bound, bool checked, double moved);
  /// What is known of the vertices that stand in the next snapshot.
  struct Known {
    bool bounded;    ///< they are within the next snapshot's box, which is finite
    bool by_motion;  ///< they are the motion's, for the next snapshot's parameters
    double moved;    ///< none is farther from where the current snapshot has it; may be infinite
  };
  double movedSince() const;
  DeformableSnapshotImpl& prepareNext();
  UpdateStatus evaluate(double time);
  void choose(bool by_motion, DeformStrategy& strategy, const char*& reason) const;
  bool follow(DeformStrategy& strategy, const char*& reason, DeformableSnapshotImpl& s,
              const Known& known);
  bool refit(DeformableSnapshotImpl& s);
  bool rebuild(DeformMethod method, DeformableSnapshotImpl& s, bool bounded);
  bool restructure(DeformableSnapshotImpl& s);
  bool upperLevels(DeformableSnapshotImpl& s, const Known& known);
  bool blendsCache(const Known& known) const;
  double displace(DeformableSnapshotImpl& s, const Known& known) const;
  std::size_t branchesDue(double growth) const;
  std::span<const std::int32_t> turnVertices() const;
  void addToTurn(const DeformableSnapshotImpl& s, std::size_t end);
  bool rebuildPays(const DeformableSnapshotImpl& s);
  void measureBuilt(const DeformableSnapshotImpl& s);
  double looseness(const DeformableSnapshotImpl& s, double of_branches) const;
  std::span<const Vector3d> given(const DeformableSnapshotImpl& s) const {
    return {s.vertices.data(), mesh->rest().size()};
  }
  void findBadVertex(const DeformableSnapshotImpl& snapshot);
};

DeformableSnapshotImpl& Deformable::Impl::prepareNext() {
  if (next == nullptr) {
    next = &pool->take();
    DeformableSnapshotImpl& s = next->snapshot;
    s.mesh = mesh;
    s.owner = number;
    if (s.vertices.empty()) {
      s.vertices.assign(mesh->rest().size() + 1, Vector3d::Zero());
      if (motion) s.parameters.resize(static_cast<std::size_t>(motion->parameterCount()));
    }
  }
  return next->snapshot;
}

void Deformable::Impl::choose(bool by_motion, DeformStrategy& strategy, const char*& reason) const {
  strategy = options.strategy;
  reason = "asked for";
  if (needsMotion(strategy) && !by_motion) {
    strategy = DeformStrategy::kHybrid;
    reason = "the vertices are not the motion's";
  }
  if (strategy != DeformStrategy::kAuto) return;
  const bool bounded = by_motion && bounds && needsMotion(strategyOf(motion->kind()));
  const bool loose = bounded && motion->kind() != MotionKind::kMorph;
  if (bounded && !(loose && options.expected_queries * kModesMicroseconds >
                                mesh->triangleCount() * kReadMicroseconds)) {
    strategy = strategyOf(motion->kind());
    reason = "the motion bounds its own nodes";
    return;
  }
  strategy = DeformStrategy::kHybrid;
  reason = loose ? "reading the vertices costs less than looser boxes from the motion"
                 : "vertices come one by one, few queries a frame";
}

namespace {

void reserve(std::pmr::vector<WideBox>& boxes, std::int32_t nodes) {
  if (boxes.size() < static_cast<std::size_t>(nodes)) boxes.resize(static_cast<std::size_t>(nodes));
}

double halfArea(const Vector3d& side) {
  return side.x() * side.y() + side.y() * side.z() + side.z() * side.x();
}

// Of a lane that is not empty.
Vector3d sideOf(const WideBox& box, std::int32_t lane) {
  Vector3d side;
  for (int k = 0; k < 3; ++k)
    side[k] = static_cast<double>(box.high[k][lane]) - static_cast<double>(box.low[k][lane]);
  return side;
}

// The root's children together.
void boundRoot(const WideBox& root, Vector3d& low, Vector3d& high) {
  for (int k = 0; k < 3; ++k) {
    low[k] = static_cast<double>(*std::min_element(root.low[k], root.low[k] + kWidth));
    high[k] = static_cast<double>(*std::max_element(root.high[k], root.high[k] + kWidth));
  }
}

}  // namespace

bool Deformable::Impl::refit(DeformableSnapshotImpl& s) {
  s.tree = tree;
  s.demand = Demand::kNothing;
  reserve(s.boxes, tree->nodeCount());
  statistics.nodes_touched += tree->nodeCount();
  statistics.vertices_touched +=
      static_cast<std::int64_t>(tree->refitVertices().size()) - DeformTree::kAhead;
  if (!deformKernels().refit(*tree, s.vertices.data(), 0, tree->nodeCount(), s.boxes.data()))
    return false;
  boundRoot(s.boxes[0], s.low, s.high);
  return true;
}

bool Deformable::Impl::rebuild(DeformMethod method, DeformableSnapshotImpl& s, bool bounded) {
  // Places that are no numbers must not reach the builder.
  if (!bounded && !deformKernels().bound(s.vertices.data(), mesh->rest().size(), kLargestDeformed,
                                         s.low, s.high))
    return false;
  tree = buildDeformTree(given(s), mesh->triangles(), method, split);
  statistics.triangles_rebuilt = mesh->triangleCount();
  if (!refit(s)) return false;
  measureBuilt(s);
  excess = 0;
  statistics.decay = 1;
  return true;
}

// What later states are compared with.
void Deformable::Impl::measureBuilt(const DeformableSnapshotImpl& s) {
  const std::span<const WideBox> boxes(s.boxes.data(), tree->nodes().size());
  built_cost = surfaceCost(boxes, tree->nodeCount());
  built_upper_cost = surfaceCost(boxes, tree->upperCount());
  turn = {};
  addToTurn(s, tree->branches().size());
  built_looseness = looseness(s, turn.area);
  if (options.strategy == DeformStrategy::kRestructure) measureFit(*tree, boxes, built_fit);
}

bool Deformable::Impl::restructure(DeformableSnapshotImpl& s) {
  if (!refit(s)) return false;
  std::span<const WideBox> boxes(s.boxes.data(), tree->nodes().size());
  measureFit(*tree, boxes, fit);
  findDecayed(*tree, fit, built_fit, options.restructure_factor, decayed);
  const double cost = surfaceCost(boxes, tree->nodeCount());
  statistics.decay = built_cost > 0 ? cost / built_cost : 1;
  // Slow decay everywhere escapes the comparison of single nodes once some of them were built anew.
  if (statistics.decay > options.restructure_factor * options.restructure_factor)
    decayed.assign(1, 0);
  if (decayed.empty()) return true;
  if (decayed[0] == 0) return rebuild(DeformMethod::kBinned, s, true);
  for (const std::int32_t root : decayed) statistics.triangles_rebuilt += tree->slotsBelow(root);
  tree = restructureDeformTree(*tree, given(s), mesh->triangles(), decayed, split);
  if (!refit(s)) return false;
  boxes = {s.boxes.data(), tree->nodes().size()};
  measureFit(*tree, boxes, built_fit);
  return true;
}

// The boxes of the branches are read from all their vertices. Where it is known how far a vertex
// can have moved since the current snapshot, that snapshot's boxes, moved and grown by as much,
// hold, too: then a share of the branches is read, in turns, so that none grows by more than
// kTurnGrowth of the branches' mean length before it is read again. Between two stored frames all
// boxes are blended, and none is read. Nodes below are read when a query comes to them, and so as
// close as ever.
bool Deformable::Impl::upperLevels(DeformableSnapshotImpl& s, const Known& known) {
  s.tree = tree;
  s.demand = Demand::kBranches;
  const std::int32_t upper = tree->upperCount();
  reserve(s.boxes, upper);
  statistics.nodes_touched += upper;
  const std::size_t all = tree->branches().size();
  const bool blended = blendsCache(known);
  const std::size_t due = branchesDue(blended ? 0 : displace(s, known));
  if (due == all || turn.next == all) turn = {.frames = turn.frames};
  turn.due = due;
  const std::size_t begin = turn.next, end = std::min(begin + due, all);
  if (blended) {
    for (std::int32_t node = 0; node < upper; ++node) {
      cached_bounds->fetch(node + kNodesAhead, s.parameters);
      cached_bounds->bound(node, s.parameters, s.boxes[static_cast<std::size_t>(node)]);
    }
    addToTurn(s, end);
    boundRoot(s.boxes[0], s.low, s.high);
    return true;
  }
  if (branch_room.size() < all) branch_room.resize(all);
  const bool finite =
      due == all && mesh->vertexCount() > kNearVertices
          ? deformKernels().allBranches(*tree, s.vertices.data(), branch_room.data(),
                                        s.boxes.data())
          : deformKernels().branches(*tree, s.vertices.data(), begin, end, s.boxes.data());
  if (!finite || !deformKernels().refit(*tree, s.vertices.data(), 0, upper, s.boxes.data()))
    return false;
  addToTurn(s, end);
  if (begin < end) {
    const DeformTree::Runs &first = tree->branches()[begin].runs,
                           &last = tree->branches()[end - 1].runs;
    statistics.vertices_touched +=
        4 * (last.four_end - first.four_begin) + last.single_end - first.single_begin;
  }
  boundRoot(s.boxes[0], s.low, s.high);
  return true;
}

// Whether the boxes come from the stored frames, which no vertex has to be read for.
bool Deformable::Impl::blendsCache(const Known& known) const {
  return known.by_motion && cached_bounds && tree == motion_tree;
}

namespace {

// Starts to bring near four vertices that stand side by side.
void fetchFour(const Vector3d* first) {
  const char* from = reinterpret_cast<const char*>(first);
  __builtin_prefetch(from);
  __builtin_prefetch(from + 64);
}

}  // namespace

// The boxes of branches from those of the current snapshot, and from how far their vertices can
// have come since then; returns what they grow by at either end, along the axis where that is the
// most, in the mean. Infinite when the current snapshot has no boxes of them, or nothing is known,
// or reading all is as quick. The motion's own bounds tell of each branch what its vertices have in
// common, which moves its box and does not make it larger. Other lanes of these nodes are left with
// anything, for the refit to put right.
double Deformable::Impl::displace(DeformableSnapshotImpl& s, const Known& known) const {
  const DeformableSnapshotImpl& last = current->impl();
  if (tree->branches().size() < kTurnBranches) return kInfinity;
  if (last.tree != tree || (last.demand != Demand::kNothing && last.demand != Demand::kBranches))
    return kInfinity;
  const bool by_motion =
      known.by_motion && std::isfinite(current_evaluated) && upper_bounds && tree == motion_tree;
  // Much too far is not worth a closer look.
  if (!by_motion && !(known.moved < branch_length)) return kInfinity;
  const float low = roundedDown(-known.moved), high = roundedUpToFloat(known.moved);
  WideBox moved;
  for (int k = 0; k < 3; ++k) {
    std::fill_n(moved.low[k], kWidth, low);
    std::fill_n(moved.high[k], kWidth, high);
  }
  const std::int32_t upper = tree->upperCount();
  const double rounding =
      by_motion ? upper_bounds->displacementRounding(last.parameters, s.parameters) : 0;
  double sum = 0;
  // What will be read comes from far: as much of it as last time is fetched while the boxes are
  // moved, node by node; reading takes less than half the time then.
  std::span<const std::int32_t> ahead = turnVertices();
  const std::size_t step = ahead.size() / static_cast<std::size_t>(upper) + 1;
  for (std::int32_t node = 0; node < upper; ++node) {
    const std::size_t count = std::min(step, ahead.size());
    for (const std::int32_t four : ahead.first(count)) fetchFour(s.vertices.data() + four);
    ahead = ahead.subspan(count);
    const auto& children = tree->node(node).child;
    const auto isBranch = [upper](std::int32_t child) { return child >= upper; };
    if (std::none_of(children, children + kWidth, isBranch)) continue;
    if (by_motion) upper_bounds->displacement(node, last.parameters, s.parameters, rounding, moved);
    const auto i = static_cast<std::size_t>(node);
    WideBox& box = s.boxes[i];
    float side[kWidth];  // the longest
    motionKernels().move(last.boxes[i], low, high, moved, box, side);
    for (int lane = 0; lane < kWidth; ++lane) {
      if (!isBranch(children[lane])) continue;
      sum += 0.5 * static_cast<double>(side[lane]);
      // The boxes above, made from these as from those that are read, would not show a NaN.
      for (int k = 0; k < 3; ++k)
        if (!(box.low[k][lane] <= box.high[k][lane])) return kInfinity;
    }
  }
  return sum / static_cast<double>(tree->branches().size());
}

// The first of four vertices each of the branches whose turn comes next, as many as in the last
// frame.
std::span<const std::int32_t> Deformable::Impl::turnVertices() const {
  const std::span<const DeformTree::Branch> branches = tree->branches();
  const std::size_t begin = turn.next < branches.size() ? turn.next : 0,
                    end = std::min(begin + turn.due, branches.size());
  // (All of them would not stay near.)
  if (begin >= end || turn.due == branches.size()) return {};
  const auto first = static_cast<std::size_t>(branches[begin].runs.four_begin),
             last = static_cast<std::size_t>(branches[end - 1].runs.four_end);
  return tree->fours().subspan(first, last - first);
}

// How many branches have to be read.
std::size_t Deformable::Impl::branchesDue(double growth) const {
  const std::size_t all = tree->branches().size();
  // Written so that what is no number reads all.
  const double share = growth / (kTurnGrowth * branch_length);
  if (!(share < kTurnWorth)) return all;
  double least = 0;
  if (options.strategy == DeformStrategy::kAuto) {
    const double read = kReadMicroseconds * mesh->triangleCount(),
                 queries = kQueryMicroseconds * std::max(options.expected_queries, 0);
    least = std::min(kTurnShare, kTurnQueries * queries / read);
  }
  return std::min(all,
                  1 + static_cast<std::size_t>(std::max(share, least) * static_cast<double>(all)));
}

// The branches from turn.next to `end` have been read.
void Deformable::Impl::addToTurn(const DeformableSnapshotImpl& s, std::size_t end) {
  const std::span<const DeformTree::Branch> branches = tree->branches();
  for (; turn.next < end; ++turn.next) {
    const DeformTree::Up& up = tree->up(branches[turn.next].root);
    const Vector3d side = sideOf(s.boxes[static_cast<std::size_t>(up.parent)], up.lane);
    if (options.strategy == DeformStrategy::kAuto) turn.area += halfArea(side);
    turn.length += std::max({side.x(), side.y(), side.z()});
  }
  if (end == branches.size()) branch_length = turn.length / static_cast<double>(end);
}

// Surface area of what hangs below the upper levels, which is the branches, as they were read, and
// leaves, over that of the triangles' own boxes (of some of them): what a rebuild could better.
// Where the triangles themselves grow, as when every vertex flies its own way, the nodes around
// them grow with them and no other hierarchy is better off. Without branches the upper levels are
// the whole hierarchy: then of all its nodes, for leaves alone tell nothing of how they lie apart.
double Deformable::Impl::looseness(const DeformableSnapshotImpl& s, double of_branches) const {
  const std::span<const DeformableMesh::Triangle> triangles = mesh->triangles();
  const std::size_t step = std::max<std::size_t>(1, triangles.size() / kSampledTriangles);
  double area = 0;
  int count = 0;
  for (std::size_t i = 0; i < triangles.size(); i += step, ++count) {
    const auto corner = [&](std::size_t k) -> const Vector3d& {
      return s.vertices[static_cast<std::size_t>(triangles[i][k])];
    };
    area += halfArea(corner(0).cwiseMax(corner(1)).cwiseMax(corner(2)) -
                     corner(0).cwiseMin(corner(1)).cwiseMin(corner(2)));
  }
  area *= static_cast<double>(triangles.size()) / count;
  const bool whole = tree->branches().empty();
  double below = of_branches;
  for (std::int32_t node = 0; node < tree->upperCount(); ++node) {
    for (std::int32_t lane = 0; lane < kWidth; ++lane) {
      const std::int32_t child = tree->node(node).child[lane];
      if (child == DeformTree::kNone) break;
      if (whole || DeformTree::isLeaf(child))
        below += halfArea(sideOf(s.boxes[static_cast<std::size_t>(node)], lane));
    }
  }
  return area > 0 ? below / area : 0;
}

// Whether what queries have paid for the decay since the last rebuild, beyond what updates would
// have cost more after one, comes to what a rebuild costs. As for renting or buying skis, that
// would pay at most twice the least if decay were known in every frame; it is told at the end of a
// turn alone, for all frames since the last that ended, those of turns cut short, too.
bool Deformable::Impl::rebuildPays(const DeformableSnapshotImpl& s) {
  const double cost = surfaceCost({s.boxes.data(), s.boxes.size()}, tree->upperCount());
  statistics.decay = built_upper_cost > 0 ? cost / built_upper_cost : 1;
  ++turn.frames;
  if (turn.next < tree->branches().size()) return false;
  const double fresh = turn.frames * options.expected_queries * kQueryMicroseconds;
  if (kTurnQueries * fresh < kWeighMicroseconds) return false;
  const double looser = built_looseness > 0 ? looseness(s, turn.area) / built_looseness : 1;
  // Queries grow less than boxes do in length (seen on two sizes of an explosion: 1.4 times at 10
  // times the surface, 2.7 times at 65).
  const double queries = fresh * std::max(std::sqrt(looser) - 1, 0.0);
  const double dearer =
      kApartMicroseconds * std::max(mesh->vertexCount() - tree->branchSingles(), 0);
  turn.frames = 0;
  excess += std::max(queries - dearer, 0.0);
  return excess > kRebuildMicroseconds * mesh->triangleCount();
}

namespace {

// The box of the whole mesh. Written so that a NaN fails.
bool isWithin(const DeformableSnapshotImpl& s, double limit) {
  return (s.low.array() >= -limit).all() && (s.high.array() <= limit).all();
}

// Rounded outward, hence a little more.
bool withinLimits(const DeformableSnapshotImpl& s) { return isWithin(s, 1.01 * kLargestDeformed); }

bool areAllUsed(const DeformableMesh& mesh) {
  std::vector<bool> used(mesh.rest().size());
  for (const DeformableMesh::Triangle& t : mesh.triangles())
    for (const std::int32_t corner : t) used[static_cast<std::size_t>(corner)] = true;
  return std::find(used.begin(), used.end(), false) == used.end();
}

}  // namespace

// The hierarchy, or what is to be known of it. False when a vertex is not finite.
bool Deformable::Impl::follow(DeformStrategy& strategy, const char*& reason,
                              DeformableSnapshotImpl& s, const Known& known) {
  statistics.nodes_touched = statistics.vertices_touched = statistics.triangles_rebuilt = 0;
  statistics.decay = 0;
  s.bounds = nullptr;
  bool good = true;
  switch (strategy) {
    case DeformStrategy::kRebuild:
      good = rebuild(DeformMethod::kBinned, s, known.bounded);
      break;
    case DeformStrategy::kRebuildLinear:
      good = rebuild(DeformMethod::kLinear, s, known.bounded);
      break;
    case DeformStrategy::kRestructure:
      good = restructure(s);
      break;
    case DeformStrategy::kHybrid:
      good = upperLevels(s, known);
      // Boxes that were only moved and grown may leave the limits though no vertex does.
      if (good && !withinLimits(s)) good = upperLevels(s, {known.bounded, false, kInfinity});
      good = good && withinLimits(s);
      if (good && options.strategy == DeformStrategy::kAuto && rebuildPays(s)) {
        strategy = DeformStrategy::kRebuild;
        reason = "the hierarchy has decayed by more than building it anew costs";
        statistics.nodes_touched = statistics.vertices_touched = 0;
        good = rebuild(DeformMethod::kBinned, s, known.bounded);
      }
      break;
    case DeformStrategy::kLazy:
    case DeformStrategy::kOctree:
      s.tree = tree;
      s.demand = strategy == DeformStrategy::kLazy ? Demand::kVertices : Demand::kNoTree;
      good = known.bounded || deformKernels().bound(s.vertices.data(), mesh->rest().size(),
                                                    kLargestDeformed, s.low, s.high);
      statistics.vertices_touched = mesh->vertexCount();
      break;
    case DeformStrategy::kMorph:
    case DeformStrategy::kSkinned:
    case DeformStrategy::kReduced: {
      s.tree = motion_tree;
      s.bounds = bounds;
      s.demand = Demand::kMotion;
      WideBox root;
      bounds->bound(0, s.parameters, root);
      boundRoot(root, s.low, s.high);
      statistics.nodes_touched = 1;
      break;
    }
    default:
      good = refit(s);
      break;
  }
  return good && withinLimits(s);
}

void Deformable::Impl::findBadVertex(const DeformableSnapshotImpl& s) {
  bad_vertex = -1;
  for (int i = 0; i < mesh->vertexCount(); ++i) {
    const Vector3d& v = s.vertices[static_cast<std::size_t>(i)];
    // Written so that a NaN fails.
    if (v.cwiseAbs().maxCoeff() <= kLargestDeformed && v.sum() == v.sum()) continue;
    bad_vertex = i;
    return;
  }
}

// How far the motion can have taken a vertex from where the current snapshot has it.
double Deformable::Impl::movedSince() const {
  if (!std::isfinite(current_evaluated)) return kInfinity;
  const double t0 = std::min(current_evaluated, evaluated),
               t1 = std::max(current_evaluated, evaluated);
  if (t0 == t1) return 0;
  const double moved =
      roundedUp(motion->speedBound(t0, t1) * (t1 - t0) + 2 * motion->rounding(t0, t1), 5);
  return moved >= 0 ? moved : kInfinity;  // 0 m/s for longer than a double holds says nothing
}

UpdateStatus Deformable::Impl::take(double time, double speed_bound, bool checked, double moved) {
  DeformableSnapshotImpl& s = prepareNext();
  bad_vertex = -1;
  const Prepared was = std::exchange(prepared, Prepared::kNothing);
  if (!std::isfinite(time) || !(speed_bound >= 0) || !(moved >= 0)) return UpdateStatus::kBadTime;
  const bool by_motion = was == Prepared::kMotion;
  if (was != Prepared::kGiven) moved = by_motion ? movedSince() : kInfinity;
  if (by_motion && motion->kind() != MotionKind::kOwn) {
    // Then they are numbers, too, and no larger than this. An embedding program's own motion is
    // not believed that its vertices are what its bounds say.
    const DeformableSnapshotImpl& last = current->impl();
    checked = checked || (last.low.minCoeff() - moved >= -kLargestDeformed &&
                          last.high.maxCoeff() + moved <= kLargestDeformed);
  }
  DeformStrategy strategy = DeformStrategy::kAuto;
  const char* reason = "";
  choose(by_motion, strategy, reason);
  const auto boundAll = [&] {
    return deformKernels().bound(s.vertices.data(), mesh->rest().size(), kLargestDeformed, s.low,
                                 s.high);
  };
  // An update that reads all vertices finds those that are not finite, too, and a box within the
  // limit holds none beyond it: no pass of its own then.
  const bool reads_all =
      all_used && !by_motion && !(moved < kInfinity) &&
      (strategy == DeformStrategy::kRefit || strategy == DeformStrategy::kHybrid);
  const bool bounded = !checked && !reads_all;
  bool good = !bounded || boundAll();
  const UpdateStatistics before = statistics;
  if (good) good = follow(strategy, reason, s, {bounded, by_motion, moved});
  // (Boxes are rounded outwards.)
  if (good && !checked && !bounded && !isWithin(s, kLargestDeformed)) good = boundAll();
  if (!good) {
    statistics = before;
    findBadVertex(s);
    return UpdateStatus::kNotFinite;
  }
  statistics.strategy = strategy;
  statistics.reason = reason;
  s.strategy = strategy;
  s.time = time;
  s.speed_bound = speed_bound;
  s.id = nextNumber();
  current_evaluated = by_motion ? evaluated : kNaN;
  current = pool->publish(*next);
  next = nullptr;
  return UpdateStatus::kUpdated;
}

Deformable::Deformable(std::shared_ptr<const DeformableMesh> mesh,
                       std::shared_ptr<const VertexMotion> motion, const DeformOptions& options)
    : impl_(std::make_unique<Impl>()) {
  if (!mesh) throw std::invalid_argument("deformable: no mesh");
  requireSensible(options);
  if (motion && motion->vertexCount() != mesh->vertexCount()) {
    throw std::invalid_argument("deformable: the motion has " +
                                std::to_string(motion->vertexCount()) + " vertices, the mesh " +
                                std::to_string(mesh->vertexCount()));
  }
  if (needsMotion(options.strategy) &&
      (!motion || strategyOf(motion->kind()) != options.strategy)) {
    throw std::invalid_argument(
        std::string("deformable: the strategy ") + toString(options.strategy) + " needs a " +
        toString(options.strategy) + " motion" +
        (options.strategy == DeformStrategy::kReduced ? " or waves" : "") +
        "; this one is of the kind " + (motion ? toString(motion->kind()) : "own vertices") +
        ", which auto, rebuild, rebuild-linear, refit, hybrid, lazy, "
        "restructure and octree follow");
  }
  Impl& impl = *impl_;
  impl.mesh = std::move(mesh);
  impl.motion = std::move(motion);
  impl.all_used = areAllUsed(*impl.mesh);
  impl.options = options;
  impl.split = options.hybrid_split > 0 ? options.hybrid_split : kHybridSplit;
  impl.number = nextNumber();
  // (Copied, since not all arrays are made at their size; what is built anew later may not last.)
  impl.tree =
      std::make_shared<DeformTree>(*buildDeformTree(impl.mesh->rest(), impl.mesh->triangles(),
                                                    DeformMethod::kBinned, impl.split),
                                   largePages());
  impl.motion_tree = impl.tree;
  const bool wanted = needsMotion(options.strategy) || options.strategy == DeformStrategy::kAuto;
  if (wanted && impl.motion) {
    impl.bounds = makeNodeBounds(*impl.motion, *impl.tree, options.volume, impl.tree->nodeCount());
  }
  if (needsMotion(options.strategy) && !impl.bounds) {
    throw std::invalid_argument(std::string("deformable: this motion has no bounds for ") +
                                toString(options.strategy));
  }
  if (impl.motion &&
      (options.strategy == DeformStrategy::kHybrid || options.strategy == DeformStrategy::kAuto)) {
    impl.upper_bounds =
        makeNodeBounds(*impl.motion, *impl.tree, DeformVolume::kBox, impl.tree->upperCount());
    if (const auto* cached = dynamic_cast<const CachedVertices*>(impl.motion.get())) {
      impl.cached_bounds =
          std::make_unique<CachedBounds>(*cached, *impl.tree, impl.tree->upperCount());
    }
  }
  // The rest position need not be one of the motion's, whose bounds hold for no other vertices.
  DeformStrategy& strategy = impl.options.strategy;
  const DeformStrategy asked = std::exchange(strategy, DeformStrategy::kRefit);
  const std::span<Vector3d> vertices = nextVertices();
  std::copy(impl.mesh->rest().begin(), impl.mesh->rest().end(), vertices.begin());
  impl.take(0, kInfinity, true, kInfinity);
  strategy = asked;
  impl.measureBuilt(impl.current->impl());
}

Deformable::~Deformable() = default;
Deformable::Deformable(Deformable&&) noexcept = default;
Deformable& Deformable::operator=(Deformable&&) noexcept = default;

UpdateStatus Deformable::Impl::evaluate(double time) {
  // Whoever has a span may still change these vertices.
  const bool changeable = prepared == Prepared::kGiven || prepared == Prepared::kMixed;
  prepared = changeable ? Prepared::kMixed : Prepared::kNothing;
  if (!motion) return UpdateStatus::kNoMotion;
  if (!std::isfinite(time)) return UpdateStatus::kBadTime;
  DeformableSnapshotImpl& s = prepareNext();
  motion->parameters(time, s.parameters);
  motion->vertices(s.parameters, 0, {s.vertices.data(), mesh->rest().size()});
  if (!changeable) prepared = Prepared::kMotion;
  evaluated = time;
  return UpdateStatus::kUpdated;
}

UpdateStatus Deformable::evaluate(double time) { return impl_->evaluate(time); }

UpdateStatus Deformable::update(double time) {
  Impl& impl = *impl_;
  impl.prepared = Impl::Prepared::kNothing;  // an update ends a span
  const UpdateStatus status = impl.evaluate(time);
  if (status != UpdateStatus::kUpdated) return status;
  return impl.take(time, impl.motion->speedBound(time, time + impl.options.speed_horizon), false,
                   kInfinity);
}

UpdateStatus Deformable::update(std::span<const Vector3d> vertices, double time,
                                double speed_bound) {
  Impl& impl = *impl_;
  if (vertices.size() != impl.mesh->rest().size()) {
    impl.bad_vertex = -1;
    return UpdateStatus::kWrongVertexCount;
  }
  const std::span<Vector3d> next = nextVertices();
  std::copy(vertices.begin(), vertices.end(), next.begin());
  return impl.take(time, speed_bound, false, kInfinity);
}

std::span<Vector3d> Deformable::nextVertices() {
  DeformableSnapshotImpl& s = impl_->prepareNext();
  impl_->prepared = Impl::Prepared::kGiven;
  return {s.vertices.data(), impl_->mesh->rest().size()};
}

UpdateStatus Deformable::commit(double time, double speed_bound, Vertices vertices, double moved) {
  return impl_->take(time, speed_bound, vertices == Vertices::kFinite, moved);
}

std::shared_ptr<const DeformableSnapshot> Deformable::snapshot() const { return impl_->current; }
const UpdateStatistics& Deformable::statistics() const { return impl_->statistics; }
int Deformable::badVertex() const { return impl_->bad_vertex; }
const std::shared_ptr<const DeformableMesh>& Deformable::mesh() const { return impl_->mesh; }
const std::shared_ptr<const VertexMotion>& Deformable::motion() const { return impl_->motion; }
const DeformOptions& Deformable::options() const { return impl_->options; }

std::size_t Deformable::bytes() const {
  std::size_t bytes = impl_->tree->bytes() + impl_->branch_room.capacity() * sizeof(BranchBox) +
                      (impl_->fit.capacity() + impl_->built_fit.capacity()) * sizeof(float) +
                      impl_->decayed.capacity() * sizeof(std::int32_t);
  if (impl_->motion_tree != impl_->tree) bytes += impl_->motion_tree->bytes();
  if (impl_->bounds) bytes += impl_->bounds->bytes();
  if (impl_->upper_bounds) bytes += impl_->upper_bounds->bytes();
  if (impl_->cached_bounds) bytes += impl_->cached_bounds->bytes();
  for (std::size_t i = 0; i < impl_->pool->slotCount(); ++i) {
    const DeformableSnapshotImpl& s = impl_->pool->slot(i).snapshot;
    bytes += sizeof(DeformPool::Slot) + s.vertices.capacity() * sizeof(Vector3d) +
             s.boxes.capacity() * sizeof(WideBox) + s.parameters.capacity() * sizeof(double);
  }
  return bytes;
}

}  // namespace leeway::collision
