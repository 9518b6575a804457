// One configuration against the margins: coarse bounds first, then distance().

#include <cmath>
#include <limits>
#include <utility>

#include "collision/scene/scene_access.h"
#include "planner/edge/edge_certifier_impl.h"

namespace leeway::planner {
namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

EdgeCertifier::Impl::Pair EdgeCertifier::Impl::coarseState(int slot, const EdgePair& pair) const {
  const collision::GeometryBounds& a = *frames.pieces()[at(pair.a)].bounds;
  const collision::GeometryBounds& b = *frames.pieces()[at(pair.b)].bounds;
  const double lower = b.coarse.lower(frames.inFrameOf(slot, pair.b, frames.center(slot, pair.a)));
  if (lower - a.outer.radius > pair.threshold) return Pair::kFree;
  const int link = frames.pieces()[at(pair.a)].link;
  for (const collision::Ball& ball : a.inner) {
    const Eigen::Vector3d center_W =
        link < 0 ? ball.center : frames.links(slot)[at(link)] * ball.center;
    const double upper = b.coarse.upper(frames.inFrameOf(slot, pair.b, center_W));
    if (upper - ball.radius <= pair.threshold) return Pair::kNotFree;
  }
  return Pair::kOpen;
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
  if (scene->isReversed(pair.scene_pair)) {  // told in the scene's order
    std::swap(result.point_a, result.point_b);
    std::swap(result.triangle_a, result.triangle_b);
    result.normal = -result.normal;
  }
  return result;
}

EdgeCertifier::Impl::Pair EdgeCertifier::Impl::exactState(int slot, const EdgePair& pair,
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
    // What of meshes is not needed for the threshold may show the better way out.
    request.threshold = std::numeric_limits<double>::quiet_NaN();
    distance = stateDistance(slot, pair, request).distance;
  }
  if (distance.lower > pair.threshold) return Pair::kFree;
  return distance.upper <= pair.threshold ? Pair::kNotFree : Pair::kOpen;
}

Verdict EdgeCertifier::Impl::checkState(int slot, double t, int& offender) {
  const auto count = static_cast<int>(frames.pairs().size());
  // Balls first, for all pairs: most collisions are deep and need no more.
  open.clear();
  for (int i = -1; i < count; ++i) {
    const int p = i < 0 ? killer : i;  // what was in the way last is likely to be again
    if (count == 0 || (i >= 0 && p == killer)) continue;
    const Pair coarse = coarseState(slot, frames.pairs()[at(p)]);
    if (coarse == Pair::kFree) continue;
    if (coarse == Pair::kNotFree) {
      offender = killer = p;
      return Verdict::kNotFree;
    }
    open.push_back(p);
  }
  Verdict verdict = Verdict::kFree;
  for (const int p : open) {
    if (frames.keepsGap(frames.pairs()[at(p)], t, t)) continue;
    const Pair exact = exactState(slot, frames.pairs()[at(p)]);
    if (exact == Pair::kFree) continue;
    offender = p;
    if (exact == Pair::kNotFree) {
      killer = p;
      return Verdict::kNotFree;
    }
    verdict = Verdict::kUndecided;
  }
  return verdict;
}

}  // namespace leeway::planner
