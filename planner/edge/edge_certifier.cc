#include "leeway/planner/edge_certifier.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "collision/mesh/descent/sweep_fronts.h"
#include "collision/scene/scene_access.h"
#include "planner/base/tolerances.h"
#include "planner/edge/edge_certifier_impl.h"
#include "planner/edge/edge_model.h"

namespace leeway::planner {

EdgeCertifier::Impl::Impl(std::shared_ptr<const CompiledScene> compiled)
    : scene(std::move(compiled)),
      frames(scene, kEdgeSlots),
      lanes(frames),
      workspace(scene->scene()) {
  workspace.pose_error = scene->edgeModel().rounding;
  collision::countInto(collision::SceneAccess::scratch(workspace), work);
  lanes.countInto(work);
  frames.countInto(work);
  // As many as a pass of lanes has room for.
  const std::size_t pairs = std::min(
      frames.pairs().size(), frames.pairs().listed().size() + collision::LaneSweep::kMostNear);
  motion.resize(scene->edgeModel().motions.size());
  world_balls.resize(scene->edges().moving.size());
  shared_slots.resize(kSharedSlots + 1);
  // Each of 2^14 pairs may be open in all lanes; of more, each in four.
  const std::size_t lists = std::max<std::size_t>(
      {std::size_t{kEdgeOpen},
       std::size_t{collision::kLanes} * std::min(pairs, std::size_t{1} << 14U), 4 * pairs});
  for (collision::SpareVector<int>* list : {&open_pairs, &next_open_pairs, &part_pairs})
    list->reserve(lists);
  for (collision::SpareVector<EdgeInterval>* list : {&intervals, &next_intervals})
    list->reserve(kEdgeIntervals);
  spans.reserve(kEdgeSpans);
  cost_parts.reserve(kEdgeSlots);
  edge_parts.reserve(kEdgeParts);
  near_pairs.reserve(pairs);
  asked_pairs.reserve(pairs);
  pass_pairs.reserve(pairs);
  never_parted.reserve(pairs);
  order.reserve(std::min(lists, frames.pairs().size()));
  likely_looks.reserve(kContactLooks);
  pair_memory.resize(frames.pairs().numbers());
  takePairs();
}

void EdgeCertifier::Impl::takePairs() {
  most_rounding = frames.pairs().mostRounding();
  const collision::ScenePairs& all = scene->scene().pairs();
  looks_at_all = all.numbers() <= kManyPairs;
  looked_at.clear();
  for (std::size_t p = 0; p < (looks_at_all ? all.numbers() : all.listedCount()); ++p)
    if (all.has(p)) looked_at.push_back(static_cast<int>(p));
  const int robot = scene->bodiesOfRobot();
  const double of_world = scene->scene().pairs().leastMargin(robot, true);
  const double of_robot = scene->scene().pairs().leastMargin(robot, false);
  least_margin[static_cast<std::size_t>(Pairs::kAll)] = std::min(of_world, of_robot);
  least_margin[static_cast<std::size_t>(Pairs::kSelf)] = of_robot;
  least_margin[static_cast<std::size_t>(Pairs::kWorld)] = of_world;
}

namespace {

std::shared_ptr<const CompiledScene> required(std::shared_ptr<const CompiledScene> scene) {
  if (!scene) throw std::invalid_argument("EdgeCertifier: a compiled scene is expected");
  return scene;
}

}  // namespace

EdgeCertifier::EdgeCertifier(std::shared_ptr<const CompiledScene> scene)
    : impl_(std::make_unique<Impl>(required(std::move(scene)))) {
  impl_->statistics = &statistics;
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
  impl_->lanes_fit = false;
  impl_->scene = std::move(scene);
  impl_->takePairs();
  impl_->workspace.prepare(impl_->scene->scene());
  impl_->startInterval();
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
  check.pair = result.pair;
  check.closest = result.closest;
  return check;
}

EdgeRequest EdgeRequest::persistent() {
  EdgeRequest request;
  request.work_limit = kPersistentWork;
  return request;
}

std::int64_t EdgeCertifier::Impl::defaultWork() const {
  return frames.hasSurfacePairs() ? kFlightWork : kEdgeWork;
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
  impl.work_limit = request.work_limit > 0 ? request.work_limit : impl.defaultWork();
  impl.smallest = request.smallest_interval;
  EdgeCheck check = impl.decideEdge(a, b);
  if (check.verdict == Verdict::kUndecided) ++statistics.undecided_edges;
  if (check.verdict == Verdict::kFree)
    check.last_valid = 1;
  else if (request.last_valid && impl.has_begun)
    impl.findLastValid(check);
  return check;
}

EdgeCheck EdgeCertifier::Impl::decideEdge(std::span<const double> a, std::span<const double> b) {
  ++edge;
  startWork(work_limit);
  has_begun = frames.begin(a, b);
  if (!has_begun) return {};
  const collision::SweepFronts fronts(collision::SceneAccess::scratch(workspace));
  const bool by_lanes = lanes_fit && lanes.begin(frames);
  const EdgeCheck check = by_lanes ? certifyByLanes() : certifyByBisection();
  statistics->work += work.done;
  return check;
}

EdgeCheck EdgeCertifier::Impl::makeCheck(Verdict verdict, int p, double t) {
  EdgeCheck check;
  check.verdict = verdict;
  check.pair = p < 0 ? -1 : frames.pairs().numberInScene(p);
  check.t = t;
  last_named = p;
  if (verdict == Verdict::kNotFree && p >= 0) {
    last_contact = p;
    PairMemory& known = pair_memory.of(p);
    known.contact_score = std::max(known.contact_score, 1);
    known.lane_contact_score = 1;
  }
  return check;
}

/// What decides that an edge is free. Each stage hands on what it leaves open: pairs, and the
/// sixteenths of the edge in which they are. The numbers are those of edge_certifier_impl.h.
EdgeCheck EdgeCertifier::Impl::certifyByLanes() {
  constexpr std::uint32_t all_lanes = (1U << collision::kLanes) - 1;
  const EdgeLanes::Parts& whole = EdgeLanes::wholeEdge();

  // 1. Balls swept to capsules; planes and points that decided a pair before.
  if (const auto contact = lanes.sweep(frames, asked, demanded); contact.id >= 0)
    return makeCheck(whole, contact);
  if (lanes.isFull()) return makeCheck(Verdict::kUndecided);
  // 2. Gaps between two links that the angles of two joints prove.
  lanes.closeGaps(frames, demanded);
  if (lanes.open().empty()) return makeCheck(Verdict::kFree);
  // 3. Contacts, of pairs that are likely to have one.
  if (const auto check = searchLikelyContacts(whole)) return *check;
  // 4. New planes between hulls.
  if (const auto contact = lanes.searchPlanes(); contact.id >= 0) return makeCheck(whole, contact);
  if (lanes.open().empty()) return makeCheck(Verdict::kFree);
  if (work.isSpent()) return makeCheck(Verdict::kUndecided, lanes.open().front().id);
  // 5. Contacts, of pairs whose hulls meet.
  contact_looks = 0;
  if (const auto check = searchContacts(whole)) return *check;

  never_parted.clear();
  for (const collision::LaneSweep::Open& pair : lanes.open())
    if (pair.lanes == all_lanes && !frames.isConvex(frames.pair(pair.id)))
      never_parted.push_back(pair.id);
  intervals.clear();
  open_pairs.clear();
  edge_parts.clear();
  part_pairs.clear();
  if (!listOpenLanes() || !listParts(whole)) return makeCheck(Verdict::kUndecided);
  // 6. Planes over finer parts.
  if (const auto check = certifyParts()) return *check;
  if (!mergeIntervals()) return makeCheck(Verdict::kUndecided);
  if (intervals.empty()) return makeCheck(Verdict::kFree);
  if (work.isSpent()) {
    const EdgeInterval& first = intervals.front();
    return makeCheck(Verdict::kUndecided, open_pairs[at(first.begin)], first.t0);
  }
  // 7. Containment, which no sweep of surfaces sees.
  if (const auto check = checkContainment()) return *check;
  // 8. Exact sweeps.
  return bisectIntervals();
}

}  // namespace leeway::planner
