#include "planner/guard/setpoint_proof.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/base/tolerances.h"

namespace leeway::planner {

SetpointProof::SetpointProof(const Problem& problem, const GuardOptions& options,
                             std::shared_ptr<const CompiledScene> scene)
    : scene_(std::move(scene)),
      period_(options.period),
      horizon_(options.horizon),
      obstacles_(problem, scene_),
      still_(obstacles_.still()),
      rows_(*scene_) {
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
      std::shared_ptr<const CompiledScene>& where = movers_[g].slices[at(k)];
      where = obstacles_.place(g, slice.begin, slice.end, false).grown;
      movers_[g].certifier->rebind(where);  // makes what certifiers share, which allocates
    }
  }
  is_stale_ = false;
}

void SetpointProof::begin(std::int64_t work) {
  rows_.setWork(work);
  rows_.lengthen();
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

int SetpointProof::untilIn(EdgeCertifier& certifier, const SetpointMotion& motion, int from, int to,
                           bool all) {
  const auto row = [&](int k) { return motion.row(k); };
  const int reached = rows_.until(certifier, row, from, to, all, bend_);
  if (reached == to) return to;
  const EdgeCheck& check = rows_.failed();
  // The straight line with its bend is not free; the polynomial beside it may be.
  failure_ = {check.verdict == Verdict::kNotFree && !(bend_ > 0) ? GuardReason::kNotFree
              : isSpent()                                        ? GuardReason::kWork
                                                                 : GuardReason::kNotCertified,
              {},
              {}};
  if (check.pair >= 0) {
    const collision::Scene& scene = certifier.scene().scene();
    const collision::ScenePair& pair = scene.pairs()[at(check.pair)];
    failure_.a = scene.bodies()[at(pair.body_a)].name;
    failure_.b = scene.bodies()[at(pair.body_b)].name;
  }
  return reached;
}

int SetpointProof::untilInSlice(std::size_t slice, const SetpointMotion& motion, int from, int to,
                                bool all) {
  int last = to;
  Failure of_last;
  for (Mover& mover : movers_) {
    mover.certifier->rebind(mover.slices[slice]);
    const int reached = untilIn(*mover.certifier, motion, from, last, all);
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
  int reached = untilIn(still_, motion, from, to, all);
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
