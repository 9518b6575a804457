#include <algorithm>
#include <stdexcept>
#include <utility>

#include "collision/mesh/descent/sweep_fronts.h"
#include "collision/scene/scene_access.h"
#include "leeway/planner/edge_certifier.h"
#include "planner/base/tolerances.h"
#include "planner/compiled/edge_model.h"
#include "planner/edge/edge_certifier_impl.h"

namespace leeway::planner {

namespace {

/// The largest number of pairs that a pass of lanes has room for.
std::size_t mostOpen(const EdgeFrames& frames) {
  return std::min(frames.pairs().size(),
                  frames.pairs().listed().size() + collision::LaneSweep::kMostNear);
}

/// Up to 2^14 pairs may be open in all intervals of a pass; with more, each may be open in four.
std::size_t mostTasks(const EdgeFrames& frames) {
  const std::size_t pairs = mostOpen(frames);
  return std::max({std::size_t{1} << 16U,
                   collision::kLanes * std::min(pairs, std::size_t{1} << 14U), 4 * pairs});
}

}  // namespace

EdgeCertifier::Impl::Impl(std::shared_ptr<const CompiledScene> compiled)
    : scene(std::move(compiled)),
      frames(scene, kEdgeSlots),
      workspace(scene->scene()),
      lanes(frames, collision::SceneAccess::scratch(workspace), work),
      queue(frames, mostTasks(frames)),
      queries(frames, workspace, work, asked, memory),
      contacts(frames, lanes, queries, work, memory),
      parts(frames, lanes, contacts, queue, work, mostOpen(frames), mostTasks(frames)) {
  workspace.pose_error = scene->edgeModel().rounding;
  collision::countInto(collision::SceneAccess::scratch(workspace), work);
  frames.countInto(work);
  if (!frames.edges().areAllNear()) world = std::make_unique<World>(frames, workspace);
  cost_parts.reserve(kEdgeSlots);
  near_pairs.reserve(mostOpen(frames));
  asked_pairs.reserve(mostOpen(frames));
  order.reserve(std::min(mostTasks(frames), frames.pairs().size()));
  memory.resize(frames.pairs().numbers());
}

namespace {

std::shared_ptr<const CompiledScene> required(std::shared_ptr<const CompiledScene> scene) {
  if (!scene) throw std::invalid_argument("EdgeCertifier: a compiled scene is expected");
  return scene;
}

}  // namespace

EdgeCertifier::EdgeCertifier(std::shared_ptr<const CompiledScene> scene)
    : impl_(std::make_unique<Impl>(required(std::move(scene)))) {
  impl_->statistics = impl_->queries.statistics = &statistics;
}
EdgeCertifier::~EdgeCertifier() = default;

const CompiledScene& EdgeCertifier::scene() const { return *impl_->scene; }

EdgeCertifier::Statistics& EdgeCertifier::Statistics::operator+=(const Statistics& more) {
  states += more.states;
  edges += more.edges;
  distance_queries += more.distance_queries;
  undecided_edges += more.undecided_edges;
  intervals += more.intervals;
  work += more.work;
  return *this;
}

void EdgeCertifier::rebind(std::shared_ptr<const CompiledScene> scene) {
  if (!required(scene)->hasPairsOf(*impl_->scene))
    throw std::invalid_argument(
        "EdgeCertifier::rebind(): a scene with other pairs; a variant of the scene before, with "
        "other shapes or margins, is expected");
  impl_->frames.rebind(scene);
  impl_->scene = std::move(scene);
  impl_->workspace.prepare(impl_->scene->scene());
  impl_->queries.startInterval();
}

Verdict EdgeCertifier::decide(std::span<const double> point) {
  ++statistics.states;
  Impl& impl = *impl_;
  impl.startWork();
  int offender = -1;
  if (!impl.frames.begin(point, point)) return Verdict::kUndecided;
  if (const std::optional<Verdict> verdict = impl.decideByLanes()) return *verdict;
  const int slot = impl.frames.place(0);
  return slot < 0 ? Verdict::kUndecided : impl.checkState(slot, 0, offender);
}

StateCheck EdgeCertifier::clearance(std::span<const double> point, double tolerance) {
  ++statistics.states;
  Impl& impl = *impl_;
  impl.startWork();
  StateCheck check;
  if (!impl.frames.begin(point, point)) return check;
  const int slot = impl.frames.place(0);
  if (slot < 0) return check;
  if (impl.world != nullptr) {
    // Among many obstacles, apart from all of them.
    const EdgeClearance found = edgeClearance(point, point, {.tolerance = tolerance});
    --statistics.edges;
    const double most = std::max(impl.scene->scene().pairs().mostMargin(), 0.0);
    if (found.pair >= 0 && found.clearance.lower > most && found.clearance.width() <= tolerance)
      return {Verdict::kFree, found.clearance, found.pair, found.closest};
    impl.frames.release(0);
    if (!impl.frames.begin(point, point) || impl.frames.place(0) < 0) return check;
    impl.startWork();
  }
  const std::span<const Pose> X_WL = impl.frames.links(slot);
  for (int b = 0; b < impl.scene->bodiesOfRobot(); ++b) {
    const int link = impl.scene->bodyLink(b);
    if (link >= 0) impl.workspace.setPose(b, X_WL[at(link)]);
  }
  const std::uint64_t before = impl.workspace.statistics.exact;
  const collision::SceneResult result =
      collision::clearance(impl.scene->scene(), impl.workspace, tolerance);
  statistics.distance_queries += impl.workspace.statistics.exact - before;
  check.verdict = result.verdict;
  check.clearance = result.clearance;
  check.clearance.lower = std::min(check.clearance.lower, impl.scene->completeWithin());
  check.pair = result.pair;
  check.closest = result.closest;
  return check;
}

StateCheck EdgeCertifier::tooNear(std::span<const double> point, double tolerance) {
  StateCheck check = clearance(point, tolerance);
  const auto& pairs = scene().scene().pairs();
  if (check.verdict != Verdict::kNotFree || check.pair < 0 ||
      check.clearance.upper <= pairs[at(check.pair)].margin)
    return check;
  Impl& impl = *impl_;  // whose workspace has the poses of clearance()
  const std::uint64_t before = impl.workspace.statistics.exact;
  const collision::SceneResult found = collision::decide(impl.scene->scene(), impl.workspace);
  if (found.verdict == Verdict::kNotFree && found.pair >= 0) {
    collision::DistanceRequest request;
    request.tolerance = tolerance;
    check.pair = found.pair;
    check.closest =
        collision::pairDistance(impl.scene->scene(), impl.workspace, found.pair, request);
    check.clearance = check.closest.distance;
  }
  statistics.distance_queries += impl.workspace.statistics.exact - before;
  return check;
}

EdgeRequest EdgeRequest::persistent() {
  EdgeRequest request;
  request.work_limit = kPersistentWork;
  return request;
}

std::int64_t EdgeCertifier::Impl::defaultWork() const {
  return frames.edges().has_surface_pairs ? kFlightWork : kEdgeWork;
}

EdgeRequest EdgeCertifier::searching() const {
  EdgeRequest request;
  const std::uint64_t doublings =
      std::min<std::uint64_t>(statistics.undecided_edges / kEscalation, 20);
  request.work_limit = std::min(impl_->defaultWork() << doublings, kPersistentWork);
  return request;
}

EdgeCheck EdgeCertifier::certify(std::span<const double> a, std::span<const double> b,
                                 const EdgeRequest& request) {
  ++statistics.edges;
  if (trace != nullptr) {
    trace->emplace_back(a.begin(), a.end());
    trace->emplace_back(b.begin(), b.end());
  }
  Impl& impl = *impl_;
  impl.startWork(request.work_limit > 0 ? request.work_limit : impl.defaultWork());
  impl.queries.least_interval = request.smallest_interval;
  const Impl::Asking asking(impl, {.beyond = request.beyond});
  const bool begins = request.beyond >= 0 && request.beyond < kInfinity && impl.frames.begin(a, b);
  EdgeCheck check = begins ? impl.decideEdge() : EdgeCheck();
  if (check.verdict == Verdict::kUndecided) ++statistics.undecided_edges;
  if (check.verdict == Verdict::kFree)
    check.last_valid = 1;
  else if (request.last_valid && begins)
    check.last_valid = impl.lastValid();
  return check;
}

EdgeCheck EdgeCertifier::Impl::decideEdge() {
  ++edge;
  const collision::SweepFronts fronts(collision::SceneAccess::scratch(workspace));
  const PairVerdict verdict = lanes.begin(frames) ? certifyByLanes() : certifyByBisection();
  statistics->work += work.done;
  return checkOf(verdict);
}

EdgeCheck EdgeCertifier::Impl::checkOf(const PairVerdict& verdict) {
  EdgeCheck check;
  check.verdict = verdict.verdict;
  check.pair = verdict.pair < 0 ? -1 : frames.pairs().numberInScene(verdict.pair);
  check.t = verdict.t;
  last_named = verdict.pair;
  if (verdict.verdict == Verdict::kNotFree && verdict.pair >= 0) {
    last_contact = verdict.pair;
    contacts.remember(verdict.pair);
  }
  return check;
}

/// The stages that decide whether an edge is free. Each stage passes on the pairs that it leaves
/// open, with their sixteenths of the edge. The numbers are those of edge_certifier_impl.h.
PairVerdict EdgeCertifier::Impl::certifyByLanes() {
  constexpr PairVerdict free{Verdict::kFree}, undecided{Verdict::kUndecided};
  const EdgeLanes::Parts& whole = EdgeLanes::wholeEdge();
  const auto contactAt = [&](const collision::LaneSweep::Contact& contact) {
    return PairVerdict{Verdict::kNotFree, contact.id, whole.middle(contact.interval)};
  };
  contacts.begin();

  // 1. Balls swept to capsules; planes and points that decided a pair before.
  if (const auto contact = lanes.sweep(frames, asked); contact.id >= 0) return contactAt(contact);
  if (lanes.isFull()) return undecided;
  // 2. Gaps between two links, proven by the angles of two joints.
  lanes.closeGaps(frames, asked);
  if (lanes.open().empty()) return free;
  // 3. Contacts of pairs that are likely to have one.
  if (const auto verdict = contacts.searchLikely(whole)) return *verdict;
  // 4. New planes between hulls.
  if (const auto contact = lanes.searchPlanes(); contact.id >= 0) return contactAt(contact);
  if (lanes.open().empty()) return free;
  if (work.isSpent()) return {Verdict::kUndecided, lanes.open().front().id};
  // 5. Contacts of pairs whose hulls meet.
  if (const auto verdict = contacts.search(whole)) return *verdict;
  if (!parts.begin()) return undecided;
  // 6. Planes over finer parts.
  if (const auto verdict = parts.certify()) return *verdict;
  // Growth over the whole edge; the growth over an interval falls with the square of its width.
  const auto mayJoin = [&](int p, double width) {
    const EdgePair& pair = frames.pair(p);
    const double growth = lanes.growth(pair.motion) * collision::kLanes * collision::kLanes;
    return !pair.by_surfaces && width * width * growth <= kMergedAgainGrowth;
  };
  if (!queue.join(mayJoin)) return undecided;
  if (queue.empty()) return free;
  if (work.isSpent())
    return {Verdict::kUndecided, queue.pairs().front(), queue.intervals().front().t0};
  // 7. Containment, which sweeps of surfaces do not detect.
  if (const auto verdict = checkContainment()) return *verdict;
  // 8. Exact sweeps.
  return sweepAll();
}

PairVerdict EdgeCertifier::Impl::certifyByBisection() {
  const int end = frames.place(1);
  int offender = -1;
  // The end comes first because it decides most edges. It also settles containment, which cannot
  // change along a certified edge.
  const Verdict at_end = end < 0 ? Verdict::kUndecided : checkState(end, 1, offender);
  if (at_end != Verdict::kFree) return {at_end, offender, 1};
  const int start = frames.place(0);
  if (start < 0 || !takeWholeEdge(start, end, beyondMargins())) return {Verdict::kUndecided};
  return sweepAll();
}

}  // namespace leeway::planner
