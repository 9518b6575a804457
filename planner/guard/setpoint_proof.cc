#include "planner/guard/setpoint_proof.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/base/tolerances.h"

namespace leeway::planner {

SetpointProof::Margins SetpointProof::marginsOf(const CompiledScene& scene) {
  const double most = scene.scene().pairs().mostMargin();
  return {most, scene.scene().pairs().leastMargin() == most};
}

SetpointProof::SetpointProof(const Problem& problem, const GuardOptions& options,
                             std::shared_ptr<const CompiledScene> scene)
    : scene_(std::move(scene)),
      period_(options.period),
      horizon_(options.horizon),
      obstacles_(problem, scene_),
      still_(obstacles_.still()),
      still_margins_(marginsOf(still_.scene())),
      displacement_(*scene_),
      growth_limit_(kGuardFirstGrowth) {
  if (obstacles_.empty()) return;
  movers_.resize(obstacles_.groups());
  slices_.resize(at(kGuardSlices));
}

void SetpointProof::look(double time) {
  if (movers_.empty()) return;
  is_stale_ = true;  // until all is bounded: a motion may fail
  obstacles_.look(time);
  for (std::size_t g = 0; g < movers_.size(); ++g) {
    Mover& mover = movers_[g];
    mover.slices.resize(slices_.size());
    const std::shared_ptr<const CompiledScene> scene = obstacles_.sceneOf(g);
    if (!mover.certifier || !scene->hasPairsOf(mover.certifier->scene()))
      mover.certifier = std::make_unique<EdgeCertifier>(scene);
  }
  for (int k = 0; k < kGuardSlices; ++k) {
    Slice& slice = slices_[at(k)];
    slice.begin = k == 0 ? time : slices_[at(k) - 1].end;
    const double share = (k + 1.0) / kGuardSlices;
    slice.end = time + horizon_ * share * share;  // near ones are short: less is grown in them
    for (std::size_t g = 0; g < movers_.size(); ++g) {
      Mover::Where& where = movers_[g].slices[at(k)];
      where.scene = obstacles_.place(g, slice.begin, slice.end, false).grown;
      where.margins = marginsOf(*where.scene);
      movers_[g].certifier->rebind(where.scene);  // makes what certifiers share, which allocates
    }
  }
  is_stale_ = false;
}

void SetpointProof::begin(std::int64_t work) {
  left_ = work;
  growth_limit_ = std::min(kGuardFirstGrowth, 2 * growth_limit_);  // what failed may hold again
  before_ = sum();
  failure_ = {};
}

EdgeCertifier::Statistics SetpointProof::sum() const {
  EdgeCertifier::Statistics all = still_.statistics;
  for (const Mover& mover : movers_)
    if (mover.certifier) all += mover.certifier->statistics;
  return all;
}

EdgeCertifier::Statistics SetpointProof::statistics() const {
  EdgeCertifier::Statistics now = sum();
  now.edges -= before_.edges;
  now.distance_queries -= before_.distance_queries;
  now.work -= before_.work;
  return now;
}

bool SetpointProof::edgeFree(EdgeCertifier& certifier, const SetpointMotion& motion, int from,
                             int to, double separation, std::int64_t most_work) {
  if (isSpent()) {
    failure_ = {GuardReason::kWork, {}, {}};
    return false;
  }
  EdgeRequest request;
  request.work_limit = std::min(most_work, left_);
  request.separation = separation;
  const std::int64_t before = certifier.statistics.work;
  const EdgeCheck check = certifier.certify(motion.row(from), motion.row(to), request);
  // Placing the robot is not counted: it takes about a microsecond.
  left_ -= std::max<std::int64_t>(certifier.statistics.work - before, kGuardLeastWork);
  if (check.verdict == Verdict::kFree) return true;
  failure_ = {check.verdict == Verdict::kNotFree ? GuardReason::kNotFree
              : isSpent()                        ? GuardReason::kWork
                                                 : GuardReason::kNotCertified,
              {},
              {}};
  if (check.pair >= 0) {
    const collision::Scene& scene = certifier.scene().scene();
    const collision::ScenePair& pair = scene.pairs()[at(check.pair)];
    failure_.a = scene.bodies()[at(pair.body_a)].name;
    failure_.b = scene.bodies()[at(pair.body_b)].name;
  }
  return false;
}

int SetpointProof::untilIn(EdgeCertifier& certifier, const Margins& margins,
                           const SetpointMotion& motion, int from, int to, bool all) {
  if (to - from <= 1) {
    if (edgeFree(certifier, motion, from, to, -kInfinity, EdgeRequest::persistent().work_limit))
      return to;
    return from == to ? from - 1 : from;
  }
  // Only a measured start may be outside the limits, where bounds on displacements do not hold.
  const bool is_bounded = from > 0 || scene_->space().withinLimits(motion.row(0));
  const auto row = [&](int k) { return motion.row(k); };
  const double growth = is_bounded ? displacement_.fromChord(row, from, to) : kInfinity;
  if (growth <= growth_limit_) {
    const double separation = std::max(0.0, margins.most) + growth;
    if (edgeFree(certifier, motion, from, to, separation, kGuardChordWork)) {
      growth_limit_ = std::min(kGuardMostGrowth, std::max(growth_limit_, 1.5 * growth));
      return to;
    }
    if (isSpent() || (all && margins.are_equal && growth < kGuardOnLine)) return from;
    if (growth > kGuardLeastGrowth) growth_limit_ = std::max(kGuardLeastGrowth, growth / 2);
  }
  const int middle = from + (to - from) / 2;
  const int first = untilIn(certifier, margins, motion, from, middle, all);
  return first < middle ? first : untilIn(certifier, margins, motion, middle, to, all);
}

int SetpointProof::untilInSlice(std::size_t slice, const SetpointMotion& motion, int from, int to,
                                bool all) {
  int last = to;
  Failure of_last;
  for (Mover& mover : movers_) {
    const Mover::Where& where = mover.slices[slice];
    mover.certifier->rebind(where.scene);
    const int reached = untilIn(*mover.certifier, where.margins, motion, from, last, all);
    if (reached >= last) continue;
    of_last = failure_;
    last = reached;
    if (all || last < from) break;
  }
  if (last < to) failure_ = of_last;
  return last;
}

int SetpointProof::untilAmongObstacles(const SetpointMotion& motion, int from, int to, bool all) {
  double begin = motion.time + from * period_, end = motion.time + to * period_;
  const double same = sameTime(motion.time, period_);
  const auto stale = [&] { failure_ = {GuardReason::kStale, {}, {}}; };
  if (is_stale_ || begin < slices_.front().begin - same || begin > slices_.back().end) {
    stale();
    return from - 1;
  }
  // Rest just before the first slice is looked at in that one.
  begin = std::max(begin, slices_.front().begin);
  end = std::max(end, slices_.front().begin);
  for (std::size_t k = 0; k < slices_.size(); ++k) {
    const Slice& slice = slices_[k];
    if (slice.end < begin || slice.begin > end) continue;
    const int first =
        std::max(from, static_cast<int>(std::floor((slice.begin - motion.time - same) / period_)));
    const int last =
        std::min(to, static_cast<int>(std::ceil((slice.end - motion.time + same) / period_)));
    const int reached = untilInSlice(k, motion, first, last, all);
    if (reached < last) return reached;
  }
  if (end <= slices_.back().end) return to;
  stale();
  return std::clamp(static_cast<int>((slices_.back().end - motion.time) / period_), from, to - 1);
}

int SetpointProof::until(const SetpointMotion& motion, int from, int to, bool all) {
  int reached = untilIn(still_, still_margins_, motion, from, to, all);
  if (!movers_.empty() && reached >= from && (reached == to || !all)) {
    const Failure of_still = failure_;
    const int among = untilAmongObstacles(motion, from, reached, all);
    if (among == reached) failure_ = of_still;
    reached = among;
  }
  if (reached == to) failure_ = {};
  return reached;
}

}  // namespace leeway::planner
