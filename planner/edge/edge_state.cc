// One configuration against the margins: coarse bounds first, then distance().

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "collision/scene/scene_access.h"
#include "planner/edge/edge_certifier_impl.h"
#include "planner/edge/edge_model.h"

namespace leeway::planner {

EdgeCertifier::Impl::PairState EdgeCertifier::Impl::coarseState(int slot,
                                                                const EdgePair& pair) const {
  const collision::GeometryBounds& a = *frames.pieces()[at(pair.a)].bounds;
  const collision::GeometryBounds& b = *frames.pieces()[at(pair.b)].bounds;
  const double lower = b.coarse.lower(frames.inFrameOf(slot, pair.b, frames.center(slot, pair.a)));
  if (lower - a.outer.radius > pair.threshold) return PairState::kFree;
  const int link = frames.pieces()[at(pair.a)].link;
  for (const collision::Ball& ball : a.inner) {
    const Eigen::Vector3d center_W =
        link < 0 ? ball.center : frames.links(slot)[at(link)] * ball.center;
    const double upper = b.coarse.upper(frames.inFrameOf(slot, pair.b, center_W));
    if (upper - ball.radius <= pair.threshold) return PairState::kNotFree;
  }
  return PairState::kOpen;
}

collision::DistanceResult EdgeCertifier::Impl::stateDistance(
    int slot, const EdgePair& pair, const collision::DistanceRequest& request) {
  ++queries;
  ++statistics->distance_queries;
  collision::DistanceResult result = collision::distance(
      frames.pieces()[at(pair.a)].geometry->shape, frames.piecePose(slot, pair.a),
      frames.pieces()[at(pair.b)].geometry->shape, frames.piecePose(slot, pair.b), request,
      collision::SceneAccess::scratch(workspace),
      &collision::SceneAccess::cache(workspace, pair.scene_pair));
  if (scene->edgeModel().pairs[at(pair.scene_pair)].is_reversed) {
    std::swap(result.point_a, result.point_b);
    std::swap(result.triangle_a, result.triangle_b);
    result.normal = -result.normal;
  }
  return result;
}

EdgeCertifier::Impl::PairState EdgeCertifier::Impl::exactState(int slot, const EdgePair& pair,
                                                               int nodes) {
  collision::DistanceRequest request;
  if (nodes > 0) request.node_limit = nodes;
  request.threshold = pair.threshold;
  request.depth = pair.threshold < 0;
  Interval distance = stateDistance(slot, pair, request).distance;
  const auto isOpen = [&] {
    return !(distance.lower > pair.threshold) && !(distance.upper <= pair.threshold);
  };
  if (request.depth && isOpen()) {
    // A full depth query of meshes may find a shorter way out than one that stops at the threshold.
    request.threshold = std::numeric_limits<double>::quiet_NaN();
    distance = stateDistance(slot, pair, request).distance;
  }
  if (distance.lower > pair.threshold) return PairState::kFree;
  return distance.upper <= pair.threshold ? PairState::kNotFree : PairState::kOpen;
}

/// Lanes know where things are; without them, it is all pairs.
void EdgeCertifier::Impl::listNearPairs(int slot, double reach) {
  near_pairs.clear();
  if (lanes_fit && lanes.isUsable()) {
    lanes.nearPairs(frames, slot, reach, near_pairs);
    std::sort(near_pairs.begin(), near_pairs.end());
    return;
  }
  near_pairs.resize(frames.pairs().size());
  std::iota(near_pairs.begin(), near_pairs.end(), 0);
}

Verdict EdgeCertifier::Impl::checkState(int slot, double t, int& offender) {
  // Balls first, for all pairs: most collisions are deep. The last contact is likely to be the
  // next.
  open_pairs.clear();
  if (frames.pairs().empty()) return Verdict::kFree;
  const auto look = [&](int p) {
    const PairState coarse = coarseState(slot, frames.pairs()[at(p)]);
    if (coarse == PairState::kOpen) open_pairs.push_back(p);
    if (coarse == PairState::kNotFree) offender = last_contact = p;
    return coarse != PairState::kNotFree;
  };
  const int first = last_contact;
  if (!look(first)) return Verdict::kNotFree;
  listNearPairs(slot, 0);
  for (const int p : near_pairs)
    if (p != first && !look(p)) return Verdict::kNotFree;
  Verdict verdict = Verdict::kFree;
  for (const int p : open_pairs) {
    if (frames.keepsGap(frames.pairs()[at(p)], t, t)) continue;
    const PairState exact = exactState(slot, frames.pairs()[at(p)]);
    if (exact == PairState::kFree) continue;
    offender = p;
    if (exact == PairState::kNotFree) {
      last_contact = p;
      return Verdict::kNotFree;
    }
    verdict = Verdict::kUndecided;
  }
  return verdict;
}

}  // namespace leeway::planner
