// One configuration against the margins: as an edge without length by lanes; where these do not
// tell, by coarse bounds, then distance().

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "collision/scene/scene_access.h"
#include "planner/base/tolerances.h"
#include "planner/edge/edge_certifier_impl.h"
#include "planner/edge/edge_model.h"

namespace leeway::planner {

EdgeCertifier::Impl::PairState EdgeCertifier::Impl::coarseState(int slot,
                                                                const EdgePair& pair) const {
  const collision::GeometryBounds& a = *frames.piece(pair.a).bounds;
  const collision::GeometryBounds& b = *frames.piece(pair.b).bounds;
  const double lower = b.coarse.lower(frames.inFrameOf(slot, pair.b, frames.center(slot, pair.a)));
  const double threshold = thresholdOf(pair);
  if (lower - a.outer.radius > threshold) return PairState::kFree;
  const int link = frames.piece(pair.a).link;
  for (const collision::Ball& ball : a.inner) {
    const Eigen::Vector3d center_W =
        link < 0 ? ball.center : frames.links(slot)[at(link)] * ball.center;
    const double upper = b.coarse.upper(frames.inFrameOf(slot, pair.b, center_W));
    if (upper - ball.radius <= threshold) return PairState::kNotFree;
  }
  return PairState::kOpen;
}

collision::DistanceResult EdgeCertifier::Impl::stateDistance(
    int slot, const EdgePair& pair, const collision::DistanceRequest& request) {
  ++queries;
  ++statistics->distance_queries;
  collision::DistanceResult result =
      collision::distance(frames.piece(pair.a).geometry->shape, frames.piecePose(slot, pair.a),
                          frames.piece(pair.b).geometry->shape, frames.piecePose(slot, pair.b),
                          request, collision::SceneAccess::scratch(workspace),
                          &collision::SceneAccess::cache(workspace, pair.scene_pair));
  if (pair.is_reversed) {
    std::swap(result.point_a, result.point_b);
    std::swap(result.triangle_a, result.triangle_b);
    result.normal = -result.normal;
  }
  return result;
}

EdgeCertifier::Impl::PairState EdgeCertifier::Impl::exactState(int slot, const EdgePair& pair,
                                                               int nodes) {
  const double threshold = thresholdOf(pair);
  collision::DistanceRequest request;
  if (nodes > 0) request.node_limit = nodes;
  request.threshold = threshold;
  request.depth = threshold < 0;
  Interval distance = stateDistance(slot, pair, request).distance;
  const auto isOpen = [&] {
    return !(distance.lower > threshold) && !(distance.upper <= threshold);
  };
  if (request.depth && isOpen()) {
    // A full depth query of meshes may find a shorter way out than one that stops at the threshold.
    request.threshold = std::numeric_limits<double>::quiet_NaN();
    distance = stateDistance(slot, pair, request).distance;
  }
  if (distance.lower > threshold) return PairState::kFree;
  return distance.upper <= threshold ? PairState::kNotFree : PairState::kOpen;
}

std::span<const int> EdgeCertifier::Impl::nearPairs(int slot, double reach) {
  near_pairs_full = false;
  if (looks_at_all) return looked_at;
  near_pairs.assign(looked_at.begin(), looked_at.end());
  for (std::size_t row = 0; row < frames.pairs().rows().size(); ++row)
    near_pairs_full = !frames.nearInRow(row, slot, reach, near_pairs) || near_pairs_full;
  std::sort(near_pairs.begin(), near_pairs.end());
  return near_pairs;
}

std::optional<Verdict> EdgeCertifier::Impl::decideByLanes() {
  if (!lanes_fit || !lanes.begin(frames)) return std::nullopt;
  if (lanes.sweep(frames, asked, demanded).id >= 0) return Verdict::kNotFree;
  if (lanes.isFull()) return std::nullopt;
  lanes.closeGaps(frames, demanded);
  if (!lanes.open().empty() && lanes.searchPlanes().id >= 0) return Verdict::kNotFree;
  if (lanes.open().empty()) return Verdict::kFree;
  return std::nullopt;
}

Verdict EdgeCertifier::Impl::checkState(int slot, double t, int& offender) {
  if (frames.pairs().empty()) return Verdict::kFree;
  // Balls first, for all pairs: most collisions are deep. The last contact is likely to be the
  // next.
  const std::span<const int> near = nearPairs(slot, beyondMargins());
  if (near_pairs_full) return Verdict::kUndecided;
  const auto count = static_cast<int>(near.size());
  const int first = last_contact;
  open_pairs.clear();
  for (int i = -1; i < count; ++i) {
    const int p = i < 0 ? first : near[at(i)];
    if (i < 0 ? first < 0 : p == first) continue;
    if (!isAsked(frames.pair(p))) continue;
    const PairState coarse = coarseState(slot, frames.pair(p));
    if (coarse == PairState::kFree) continue;
    if (coarse == PairState::kNotFree) {
      offender = last_contact = p;
      return Verdict::kNotFree;
    }
    open_pairs.push_back(p);
  }
  Verdict verdict = Verdict::kFree;
  for (const int p : open_pairs) {
    const EdgePair& pair = frames.pair(p);
    if (frames.keepsGap(pair, thresholdOf(pair), t, t)) continue;
    const PairState exact = exactState(slot, pair);
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
