#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "collision/base/large_pages.h"
#include "collision/base/numbers.h"
#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/deform/bounds/make_node_bounds.h"
#include "collision/deform/motion/motion_input.h"
#include "collision/deform/snapshot_pool.h"
#include "collision/deform/update/snapshot_box.h"
#include "collision/deform/update/strategy.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/vertex_motion.h"

// The owner of a deforming mesh: checks the input, lets a strategy (strategy.h) update the
// hierarchy for the new vertices, and publishes the snapshot.

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

// A number for owners and snapshots; unique in this process.
std::uint64_t nextNumber() {
  static std::atomic<std::uint64_t> last{0};
  return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

// Throws std::invalid_argument with the option's name, its value and the accepted values. NaN is
// rejected.
void requireOptions(const DeformOptions& options) {
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

void requireMotion(const DeformableMesh& mesh, const VertexMotion* motion,
                   DeformStrategy strategy) {
  if (motion != nullptr && motion->vertexCount() != mesh.vertexCount()) {
    throw std::invalid_argument("deformable: the motion has " +
                                std::to_string(motion->vertexCount()) + " vertices, the mesh " +
                                std::to_string(mesh.vertexCount()));
  }
  if (!needsMotion(strategy) || (motion != nullptr && strategyOf(motion->kind()) == strategy))
    return;
  throw std::invalid_argument(std::string("deformable: the strategy ") + toString(strategy) +
                              " needs a " + toString(strategy) + " motion" +
                              (strategy == DeformStrategy::kReduced ? " or waves" : "") +
                              "; this one is of the kind " +
                              (motion != nullptr ? toString(motion->kind()) : "own vertices") +
                              ", which auto, rebuild, rebuild-linear, refit, hybrid, lazy, "
                              "restructure and octree follow");
}

// Whether every vertex is a corner of a triangle.
bool areAllUsed(const DeformableMesh& mesh) {
  std::vector<bool> used(mesh.rest().size());
  for (const DeformableMesh::Triangle& t : mesh.triangles())
    for (const std::int32_t corner : t) used[static_cast<std::size_t>(corner)] = true;
  return std::find(used.begin(), used.end(), false) == used.end();
}

}  // namespace

struct Deformable::Impl {
  UpdateState state;
  std::uint64_t number = 0;  // of this owner
  std::shared_ptr<SnapshotPool> pool = std::make_shared<SnapshotPool>();
  SnapshotPool::Slot* next = nullptr;  // of the next snapshot
  int bad_vertex = -1;
  bool all_used = false;  // every vertex is a corner of a triangle

  // State of the next snapshot's vertices.
  enum class Prepared : unsigned char {
    kNothing,  // old values of an earlier snapshot
    kGiven,    // the caller's, who has a span to write them until the commit
    kMotion,   // the motion's at `evaluated`; no caller has a span to change them
    kMixed,    // the motion's, or old values from a refused evaluate(), but the caller has a span
  };
  Prepared prepared = Prepared::kNothing;
  double evaluated = kNaN;  // [s]

  void makeBounds();
  DeformableSnapshotImpl& prepareNext();
  UpdateStatus evaluate(double time);
  /// Makes the next snapshot the current one. `checked`: the caller guarantees finite vertices.
  /// `moved` [m]: no given vertex is farther from its place in the current snapshot. In every case,
  /// nothing is prepared afterwards.
  UpdateStatus take(double time, double speed_bound, bool checked, double moved);
  double movedByMotion() const;
  bool staysWithinLimits(double moved) const;
  bool boundVertices(DeformableSnapshotImpl& snapshot) const;
  bool followVertices(DeformableSnapshotImpl& snapshot, StrategyChoice& choice, bool by_motion,
                      bool checked, double moved);
  void findBadVertex(const DeformableSnapshotImpl& snapshot);
};

DeformableSnapshotImpl& Deformable::Impl::prepareNext() {
  if (next == nullptr) {
    next = &pool->take();
    DeformableSnapshotImpl& s = next->snapshot;
    s.mesh = state.mesh;
    s.owner = number;
    if (s.vertices.empty()) {
      s.vertices.assign(state.mesh->rest().size() + 1, Vector3d::Zero());
      if (state.motion)
        s.parameters.resize(static_cast<std::size_t>(state.motion->parameterCount()));
    }
  }
  return next->snapshot;
}

// Leaves -1 if all are finite and within the limit.
void Deformable::Impl::findBadVertex(const DeformableSnapshotImpl& s) {
  bad_vertex = -1;
  for (int i = 0; i < state.mesh->vertexCount(); ++i) {
    const Vector3d& v = s.vertices[static_cast<std::size_t>(i)];
    // A NaN fails these comparisons.
    if (v.cwiseAbs().maxCoeff() <= kLargestSize && v.sum() == v.sum()) continue;
    bad_vertex = i;
    return;
  }
}

// Upper bound on the distance by which the motion has moved a vertex from its place in the current
// snapshot [m].
double Deformable::Impl::movedByMotion() const {
  if (!std::isfinite(state.current_motion_time)) return kInfinity;
  const double t0 = std::min(state.current_motion_time, evaluated),
               t1 = std::max(state.current_motion_time, evaluated);
  if (t0 == t1) return 0;
  const VertexMotion& motion = *state.motion;
  const double moved =
      roundedUp(motion.speedBound(t0, t1) * (t1 - t0) + 2 * motion.rounding(t0, t1), 5);
  return moved >= 0 ? moved : kInfinity;  // NaN: 0 m/s times an infinite duration
}

// Whether vertices that have moved by at most this distance are finite and within the limit.
bool Deformable::Impl::staysWithinLimits(double moved) const {
  const DeformableSnapshotImpl& last = state.current->impl();
  return last.low.minCoeff() - moved >= -kLargestSize &&
         last.high.maxCoeff() + moved <= kLargestSize;
}

// Finds the box of all vertices; false if one is not finite or beyond the limit.
bool Deformable::Impl::boundVertices(DeformableSnapshotImpl& s) const {
  return deformKernels().bound(s.vertices.data(), state.mesh->rest().size(), kLargestSize, s.low,
                               s.high);
}

// Updates the hierarchy for the new vertices, and checks these unless they are known to be finite
// and within the limit. A strategy that reads all vertices detects those that are not finite
// itself, and a box within the limit contains no vertex beyond it, so the check then needs no
// separate pass.
bool Deformable::Impl::followVertices(DeformableSnapshotImpl& s, StrategyChoice& choice,
                                      bool by_motion, bool checked, double moved) {
  const bool reads_all =
      all_used && !by_motion && !(moved < kInfinity) &&
      (choice.strategy == DeformStrategy::kRefit || choice.strategy == DeformStrategy::kHybrid);
  const bool bounded = !checked && !reads_all;
  if (bounded && !boundVertices(s)) return false;
  if (!follow(state, choice, s, {bounded, by_motion, moved})) return false;
  // Boxes are rounded outwards, so only a box beyond the limit requires a closer look.
  return checked || bounded || isWithin(s, kLargestSize) || boundVertices(s);
}

UpdateStatus Deformable::Impl::take(double time, double speed_bound, bool checked, double moved) {
  DeformableSnapshotImpl& s = prepareNext();
  bad_vertex = -1;
  const Prepared was = std::exchange(prepared, Prepared::kNothing);
  if (!std::isfinite(time) || !(speed_bound >= 0) || !(moved >= 0)) return UpdateStatus::kBadTime;
  const bool by_motion = was == Prepared::kMotion;
  if (was != Prepared::kGiven) moved = by_motion ? movedByMotion() : kInfinity;
  // An embedding program's own motion may violate its bounds.
  if (by_motion && state.motion->kind() != MotionKind::kOwn)
    checked = checked || staysWithinLimits(moved);
  StrategyChoice choice = chooseStrategy(state, by_motion);
  const UpdateStatistics before = state.statistics;
  if (!followVertices(s, choice, by_motion, checked, moved)) {
    state.statistics = before;
    findBadVertex(s);
    return UpdateStatus::kNotFinite;
  }
  state.statistics.strategy = choice.strategy;
  state.statistics.reason = choice.reason;
  s.strategy = choice.strategy;
  s.time = time;
  s.speed_bound = speed_bound;
  s.id = nextNumber();
  state.current_motion_time = by_motion ? evaluated : kNaN;
  state.current = pool->publish(*next);
  next = nullptr;
  return UpdateStatus::kUpdated;
}

// Makes the motion's bounds, for the strategies that may use them.
void Deformable::Impl::makeBounds() {
  const DeformStrategy strategy = state.options.strategy;
  const bool automatic = strategy == DeformStrategy::kAuto;
  const DeformTree& tree = *state.tree;
  if (state.motion && (needsMotion(strategy) || automatic))
    state.bounds = makeNodeBounds(*state.motion, tree, state.options.volume, tree.nodeCount());
  if (needsMotion(strategy) && !state.bounds) {
    throw std::invalid_argument(std::string("deformable: this motion has no bounds for ") +
                                toString(strategy));
  }
  if (!state.motion || !(automatic || strategy == DeformStrategy::kHybrid)) return;
  state.upper_bounds = makeNodeBounds(*state.motion, tree, DeformVolume::kBox, tree.upperCount());
  if (const auto* cached = dynamic_cast<const CachedVertices*>(state.motion.get()))
    state.cached_bounds = std::make_unique<CachedBounds>(*cached, tree, tree.upperCount());
}

Deformable::Deformable(std::shared_ptr<const DeformableMesh> mesh,
                       std::shared_ptr<const VertexMotion> motion, const DeformOptions& options)
    : impl_(std::make_unique<Impl>()) {
  if (!mesh) throw std::invalid_argument("deformable: no mesh");
  requireOptions(options);
  requireMotion(*mesh, motion.get(), options.strategy);
  UpdateState& state = impl_->state;
  state.mesh = std::move(mesh);
  state.motion = std::move(motion);
  state.options = options;
  state.split = options.hybrid_split > 0 ? options.hybrid_split : kHybridSplit;
  impl_->all_used = areAllUsed(*state.mesh);
  impl_->number = nextNumber();
  // Copied into large pages, with arrays of exact size. Rebuilt trees are not copied, because the
  // next rebuild may replace them soon.
  state.tree =
      std::make_shared<DeformTree>(*buildDeformTree(state.mesh->rest(), state.mesh->triangles(),
                                                    DeformMethod::kBinned, state.split),
                                   largePages());
  state.motion_tree = state.tree;
  impl_->makeBounds();
  const std::span<Vector3d> vertices = nextVertices();
  std::copy(state.mesh->rest().begin(), state.mesh->rest().end(), vertices.begin());
  impl_->take(0, kInfinity, true, kInfinity);
  measureBuilt(state, state.current->impl());
}

Deformable::~Deformable() = default;
Deformable::Deformable(Deformable&&) noexcept = default;
Deformable& Deformable::operator=(Deformable&&) noexcept = default;

UpdateStatus Deformable::Impl::evaluate(double time) {
  const bool changeable = prepared == Prepared::kGiven || prepared == Prepared::kMixed;
  prepared = changeable ? Prepared::kMixed : Prepared::kNothing;
  if (!state.motion) return UpdateStatus::kNoMotion;
  if (!std::isfinite(time)) return UpdateStatus::kBadTime;
  DeformableSnapshotImpl& s = prepareNext();
  state.motion->parameters(time, s.parameters);
  state.motion->vertices(s.parameters, 0, {s.vertices.data(), state.mesh->rest().size()});
  if (!changeable) prepared = Prepared::kMotion;
  evaluated = time;
  return UpdateStatus::kUpdated;
}

UpdateStatus Deformable::evaluate(double time) { return impl_->evaluate(time); }

UpdateStatus Deformable::update(double time) {
  Impl& impl = *impl_;
  impl.prepared = Impl::Prepared::kNothing;  // update() ends the validity of a span
  const UpdateStatus status = impl.evaluate(time);
  if (status != UpdateStatus::kUpdated) return status;
  const double until = time + impl.state.options.speed_horizon;
  return impl.take(time, impl.state.motion->speedBound(time, until), false, kInfinity);
}

UpdateStatus Deformable::update(std::span<const Vector3d> vertices, double time,
                                double speed_bound) {
  if (vertices.size() != mesh()->rest().size()) {
    impl_->bad_vertex = -1;
    return UpdateStatus::kWrongVertexCount;
  }
  const std::span<Vector3d> next = nextVertices();
  std::copy(vertices.begin(), vertices.end(), next.begin());
  return impl_->take(time, speed_bound, false, kInfinity);
}

std::span<Vector3d> Deformable::nextVertices() {
  DeformableSnapshotImpl& s = impl_->prepareNext();
  impl_->prepared = Impl::Prepared::kGiven;
  return {s.vertices.data(), mesh()->rest().size()};
}

UpdateStatus Deformable::commit(double time, double speed_bound, Vertices vertices, double moved) {
  return impl_->take(time, speed_bound, vertices == Vertices::kFinite, moved);
}

std::shared_ptr<const DeformableSnapshot> Deformable::snapshot() const {
  return impl_->state.current;
}
const UpdateStatistics& Deformable::statistics() const { return impl_->state.statistics; }
int Deformable::badVertex() const { return impl_->bad_vertex; }
const std::shared_ptr<const DeformableMesh>& Deformable::mesh() const { return impl_->state.mesh; }
const std::shared_ptr<const VertexMotion>& Deformable::motion() const {
  return impl_->state.motion;
}
const DeformOptions& Deformable::options() const { return impl_->state.options; }

std::size_t Deformable::bytes() const {
  const UpdateState& state = impl_->state;
  std::size_t bytes = state.tree->bytes() + state.branch_room.capacity() * sizeof(BranchBox) +
                      (state.fit.capacity() + state.built_fit.capacity()) * sizeof(float) +
                      state.decayed.capacity() * sizeof(std::int32_t);
  if (state.motion_tree != state.tree) bytes += state.motion_tree->bytes();
  if (state.bounds) bytes += state.bounds->bytes();
  if (state.upper_bounds) bytes += state.upper_bounds->bytes();
  if (state.cached_bounds) bytes += state.cached_bounds->bytes();
  for (std::size_t i = 0; i < impl_->pool->slotCount(); ++i) {
    const DeformableSnapshotImpl& s = impl_->pool->slot(i).snapshot;
    bytes += sizeof(SnapshotPool::Slot) + s.vertices.capacity() * sizeof(Vector3d) +
             s.boxes.capacity() * sizeof(WideBox) + s.parameters.capacity() * sizeof(double);
  }
  return bytes;
}

}  // namespace leeway::collision
