// Queries of a scene: coarse bounds, then exact distances.

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/pair_table.h"
#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/lanes/obstacle_boxes.h"
#include "collision/scene/scene_access.h"
#include "leeway/collision/deformable_mesh.h"

namespace leeway::collision {
namespace {

/// Number of pairs that clearance() sorts at once [count].
constexpr std::size_t kMostNearest = 1U << 11U;
/// Up to this many pairs, their coarse bounds cost less than a search for a reach [count].
constexpr std::size_t kFewPairs = 64;

/// The number of bodies that are not in places; all bodies if there are no places.
std::size_t bodiesOutsidePlaces(const Scene& scene) {
  return scene.pairs().places() > 0 ? at(scene.pairs().firstStill()) : scene.bodies().size();
}

}  // namespace

struct Workspace::Impl {
  std::vector<Pose> poses;  // one for each body that is not in a place
  PairTable<PairCache> caches;
  Scratch scratch;
  int blocking = -1;                            // the pair that was last not free; -1: none
  std::vector<std::pair<double, int>> nearest;  // clearance(): coarse lower bounds [m], and pairs
};

Workspace::Workspace(const Scene& scene) : impl_(std::make_unique<Impl>()) {
  const ScenePairs& pairs = scene.pairs();
  const Bodies bodies = scene.bodies();
  const std::size_t end = bodiesOutsidePlaces(scene);
  impl_->poses.reserve(end);
  for (std::size_t b = 0; b < end; ++b) impl_->poses.push_back(bodies[b].X_WB);
  impl_->caches.resize(pairs.numbers());
  impl_->nearest.resize(std::min(pairs.size(), kMostNearest));
  prepare(scene);
}

void Workspace::prepare(const Scene& scene) {
  const auto take = [&](const Geometry& g) {
    if (g.shape.type() == ShapeType::kDeformable)
      collision::prepare(impl_->scratch, *g.shape.deformable());
  };
  const Bodies bodies = scene.bodies();
  const std::size_t end = bodiesOutsidePlaces(scene);
  for (std::size_t b = 0; b < end; ++b)
    for (const Geometry& g : bodies[b].geometries) take(g);
  if (end == bodies.size()) return;
  // A deforming geometry may be anywhere, even if all other geometries are half-spaces.
  ObstacleBoxes::Box nowhere;
  std::fill_n(nowhere.low, 3, kFar);
  std::fill_n(nowhere.high, 3, kFar);
  const ObstacleBoxes& boxes = *SceneAccess::boxes(scene);
  boxes.forEachNear(nowhere, [&](std::size_t slot) {
    if (boxes.obstacle(slot) >= 0)
      take(SceneAccess::geometryIn(scene, boxes.obstacle(slot)).geometry());
    return true;
  });
}

Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;
Workspace& Workspace::operator=(Workspace&&) noexcept = default;

void Workspace::setPose(int body, const Pose& X_WB) {
  if (at(body) < impl_->poses.size()) impl_->poses[at(body)] = X_WB;
}
const Pose& Workspace::pose(int body) const { return impl_->poses.at(at(body)); }

Scratch& SceneAccess::scratch(Workspace& workspace) { return workspace.impl_->scratch; }
PairCache& SceneAccess::cache(Workspace& workspace, int pair) {
  return workspace.impl_->caches.of(pair);
}

namespace {

const Pose& poseOf(const Scene& scene, const Workspace& workspace, int body) {
  const Body& b = scene.bodies()[at(body)];
  return b.moving ? workspace.pose(body) : b.X_WB;
}

/// Transforms a point from the frame of body `from` to that of body `to`. The frame of a fixed body
/// is the world's.
Eigen::Vector3d transferred(const Scene& scene, const Workspace& workspace,
                            const Eigen::Vector3d& p, int from, int to) {
  Eigen::Vector3d p_W = p;
  if (scene.bodies()[at(from)].moving) p_W = workspace.pose(from) * p;
  if (!scene.bodies()[at(to)].moving) return p_W;
  const Pose& X_WB = workspace.pose(to);
  return X_WB.rotation.transpose() * (p_W - X_WB.translation);
}

/// Rounding of two transformations, plus the error of the poses themselves [m].
double transferSlack(const Scene& scene, const Workspace& workspace, int a, int b,
                     const Eigen::Vector3d& p) {
  const double error =
      scene.bodies()[at(b)].moving ? 2 * workspace.pose_error : workspace.pose_error;
  return error +
         kTransferRounding * (poseOf(scene, workspace, a).translation.lpNorm<1>() +
                              poseOf(scene, workspace, b).translation.lpNorm<1>() + p.lpNorm<1>());
}

/// Calls use(outer, coarse) with the bounds of a pair's second geometry.
template <class Use>
double withBounds(const Scene& scene, const ScenePair& pair, const Use& use) {
  const Body& body = scene.bodies()[at(pair.body_b)];
  const std::size_t number = at(pair.geometry_b), stored = body.geometries.size();
  if (number >= stored) {
    const BallBounds of(body, (*body.balls)[number - stored]);
    return use(of.outer, of.coarse);
  }
  const GeometryBounds& of = SceneAccess::bounds(scene, pair.body_b, pair.geometry_b);
  return use(of.outer, of.coarse);
}

/// Lower bound on the separation: the outer ball of each body against the coarse shape of the
/// other.
double coarseLower(const Scene& scene, const Workspace& workspace, const ScenePair& pair) {
  const GeometryBounds& a = SceneAccess::bounds(scene, pair.body_a, pair.geometry_a);  // moves
  return withBounds(scene, pair, [&](const Ball& outer, const CoarseShape& coarse) {
    const Eigen::Vector3d center_B =
        transferred(scene, workspace, a.outer.center, pair.body_a, pair.body_b);
    double lower = coarse.lower(center_B) - a.outer.radius;
    if (std::isfinite(outer.radius)) {
      const Eigen::Vector3d center_A =
          transferred(scene, workspace, outer.center, pair.body_b, pair.body_a);
      lower = std::max(lower, a.coarse.lower(center_A) - outer.radius);
    }
    // A NaN pose must not count as far away.
    return std::isnan(lower)
               ? -kInfinity
               : lower - transferSlack(scene, workspace, pair.body_a, pair.body_b, center_B);
  });
}

/// Upper bound on the separation from A's inner balls in B's coarse shape. Stops at the first ball
/// that proves contact.
double coarseUpper(const Scene& scene, const Workspace& workspace, const ScenePair& pair) {
  const GeometryBounds& a = SceneAccess::bounds(scene, pair.body_a, pair.geometry_a);  // moves
  return withBounds(scene, pair, [&](const Ball&, const CoarseShape& coarse) {
    double upper = kInfinity;
    for (const Ball& ball : a.inner) {
      const Eigen::Vector3d center_B =
          transferred(scene, workspace, ball.center, pair.body_a, pair.body_b);
      const double slack = transferSlack(scene, workspace, pair.body_a, pair.body_b, center_B);
      upper = std::min(upper, coarse.upper(center_B) - ball.radius + slack);
      if (upper <= pair.margin) break;
    }
    return std::isnan(upper) ? kInfinity : upper;
  });
}

Verdict verdictOf(const Interval& distance, double margin) {
  if (distance.lower > margin) return Verdict::kFree;
  if (distance.upper <= margin) return Verdict::kNotFree;
  return Verdict::kUndecided;
}

/// kNotFree takes precedence over kUndecided, and kUndecided over kFree.
Verdict worse(Verdict x, Verdict y) {
  if (x == Verdict::kNotFree || y == Verdict::kNotFree) return Verdict::kNotFree;
  if (x == Verdict::kUndecided || y == Verdict::kUndecided) return Verdict::kUndecided;
  return Verdict::kFree;
}

/// Calls visit(pair) for all listed pairs, and for pairs of the table that may be closer than
/// `reach` [m], until it returns false.
template <class Visit>
void forEachNear(const Scene& scene, const Workspace& workspace, double reach, const Visit& visit) {
  const ScenePairs& pairs = scene.pairs();
  bool going = true;
  const auto visited = [&](int p) { return going = visit(p); };
  for (std::size_t p = 0; p < pairs.listedCount() && going; ++p) visited(static_cast<int>(p));
  for (std::size_t row = 0; row < pairs.rows().size() && going; ++row)
    forEachNearInRow(scene, workspace, row, reach, visited);
}

/// Whether the outer balls of a pair are farther apart than `reach` [m], up to rounding.
bool areBallsApart(const Scene& scene, const Workspace& workspace, const ScenePair& pair,
                   double reach) {
  const Ball& a = SceneAccess::bounds(scene, pair.body_a, pair.geometry_a).outer;  // moves
  const Eigen::Vector3d center_W = poseOf(scene, workspace, pair.body_a) * a.center;
  const double apart = withBounds(scene, pair, [&](const Ball& b, const CoarseShape&) {
    const bool moves = scene.bodies()[at(pair.body_b)].moving;
    const Eigen::Vector3d other_W = moves ? workspace.pose(pair.body_b) * b.center : b.center;
    return (center_W - other_W).norm() - a.radius - b.radius;
  });
  return apart > reach;
}

/// Decides one pair against its margin. `result` has at least the interval, and all other members
/// if the exact query was needed.
Verdict decidePair(const Scene& scene, Workspace& workspace, int p, DistanceResult& result) {
  const ScenePair pair = scene.pairs()[at(p)];
  ++workspace.statistics.pairs;
  result = {};
  result.distance = {coarseLower(scene, workspace, pair), kInfinity};
  if (result.distance.lower > pair.margin) {
    ++workspace.statistics.coarse_decided;
    return Verdict::kFree;
  }
  result.distance.upper = coarseUpper(scene, workspace, pair);
  if (result.distance.upper <= pair.margin) {
    ++workspace.statistics.coarse_decided;
    return Verdict::kNotFree;
  }
  DistanceRequest request;
  request.threshold = pair.margin;
  request.depth = pair.margin < 0;
  result = pairDistance(scene, workspace, p, request);
  return verdictOf(result.distance, pair.margin);
}

}  // namespace

ObstacleBoxes::Box boxOfRow(const Scene& scene, const Workspace& workspace, std::size_t row,
                            double reach) {
  const ScenePairs::Row& of = scene.pairs().rows()[row];
  const Ball& ball = SceneAccess::bounds(scene, of.body, of.geometry).outer;
  const Eigen::Vector3d center = workspace.pose(of.body) * ball.center;
  const double slack = transferSlack(scene, workspace, of.body, of.body, ball.center);
  const double radius = ball.radius + reach + 2 * slack;
  ObstacleBoxes::Box box;
  bool is_bounded = true;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = floatBelow(center[k] - radius);
    box.high[k] = floatAbove(center[k] + radius);
    // Boxes are limited to kFar, and those of half-spaces represent the whole space, so this box
    // must, too.
    is_bounded = is_bounded && -box.low[k] < kFar && box.high[k] < kFar;
  }
  if (is_bounded) return box;
  // If one coordinate is unknown, distances along the others are unknown, too.
  std::fill_n(box.low, 3, std::numeric_limits<float>::quiet_NaN());
  std::fill_n(box.high, 3, std::numeric_limits<float>::quiet_NaN());
  return box;
}

double coarseLowerBound(const Scene& scene, const Workspace& workspace, int pair) {
  return coarseLower(scene, workspace, scene.pairs()[at(pair)]);
}

namespace {

DistanceResult distanceOf(const Scene& scene, Workspace& workspace, int p,
                          const DistanceRequest& request, PairCache* cache) {
  const ScenePair pair = scene.pairs()[at(p)];
  const Geometry& a = scene.bodies()[at(pair.body_a)].geometries[at(pair.geometry_a)];  // moves
  const SceneGeometry of_b = SceneAccess::geometry(scene, pair.body_b, pair.geometry_b);
  const Geometry& b = of_b.geometry();
  const double slack =
      transferSlack(scene, workspace, pair.body_a, pair.body_b, Eigen::Vector3d::Zero()) +
      kTransferRounding * (a.X_BG.translation.lpNorm<1>() + b.X_BG.translation.lpNorm<1>());
  DistanceRequest raised = request;
  raised.threshold += slack;  // a bound above it stays above when widened; NaN stays NaN
  DistanceResult result = distance(a.shape, poseOf(scene, workspace, pair.body_a) * a.X_BG, b.shape,
                                   poseOf(scene, workspace, pair.body_b) * b.X_BG, raised,
                                   SceneAccess::scratch(workspace), cache);
  ++workspace.statistics.exact;
  workspace.statistics.iterations += static_cast<std::uint64_t>(result.iterations);
  // A NaN interval would drop out of the minimum over pairs: std::min() ignores it.
  if (!std::isfinite(slack)) {
    result.status = DistanceStatus::kInvalid;
    result.distance = {-kInfinity, kInfinity};
    return result;
  }
  result.distance.lower -= slack;
  result.distance.upper += slack;
  return result;
}

}  // namespace

DistanceResult pairDistance(const Scene& scene, Workspace& workspace, int p,
                            const DistanceRequest& request) {
  return distanceOf(scene, workspace, p, request, &SceneAccess::cache(workspace, p));
}

SceneResult decide(const Scene& scene, Workspace& workspace) {
  ++workspace.statistics.queries;
  auto& impl = SceneAccess::impl(workspace);
  SceneResult result;
  result.verdict = Verdict::kFree;
  result.clearance = {kInfinity, kInfinity};
  const auto look = [&](int p) {
    DistanceResult pair;
    const Verdict verdict = decidePair(scene, workspace, p, pair);
    result.clearance.lower = std::min(result.clearance.lower, pair.distance.lower);
    if (pair.distance.upper < result.clearance.upper) {
      result.clearance.upper = pair.distance.upper;
      result.pair = p;
      result.closest = pair;
    }
    result.verdict = worse(result.verdict, verdict);
    if (verdict == Verdict::kNotFree) {
      impl.blocking = p;
      result.pair = p;
      result.closest = pair;
    }
    return verdict != Verdict::kNotFree;
  };
  const double most = scene.pairs().rows().empty() ? kInfinity : scene.pairs().mostMargin();
  const double reach = std::isnan(most) ? kInfinity : std::max(most, 0.0) + kDecideReach;
  // The pair that was last not free is likely to be not free again, if it is near.
  const bool is_known = impl.blocking >= 0 && at(impl.blocking) < scene.pairs().numbers() &&
                        scene.pairs().has(at(impl.blocking)) &&
                        !areBallsApart(scene, workspace, scene.pairs()[at(impl.blocking)], reach);
  const int first = is_known ? impl.blocking : -1;
  bool going = first < 0 || look(first);
  if (going) {
    forEachNear(scene, workspace, reach, [&](int p) {
      if (p != first) going = look(p);
      return going;
    });
  }
  // Pairs that are not near are farther apart than `reach`.
  result.clearance.lower = std::min(result.clearance.lower, reach);
  if (!going) result.clearance.lower = -kInfinity;  // the other pairs were not tested
  return result;
}

namespace {

using Candidate = std::pair<double, int>;  // a coarse lower bound [m] and its pair

Candidate candidateOf(const Scene& scene, const Workspace& workspace, int p) {
  const double lower = coarseLower(scene, workspace, scene.pairs()[at(p)]);
  return {std::isnan(lower) ? -kInfinity : lower, p};  // NaN would violate the order
}

/// Collects, among the pairs that may be closer than `reach`, those that follow `last`, up to the
/// size of `room`: a heap with the nearest first. Returns their number; if it is smaller than the
/// room, these are all the remaining ones.
std::size_t collectNearest(const Scene& scene, const Workspace& workspace, double reach,
                           const Candidate& last, std::span<Candidate> room) {
  std::size_t count = 0;
  forEachNear(scene, workspace, reach, [&](int p) {
    const Candidate candidate = candidateOf(scene, workspace, p);
    if (!(last < candidate)) return true;
    if (count < room.size()) {
      room[count++] = candidate;
      if (count == room.size()) std::make_heap(room.begin(), room.end());
    } else if (candidate < room.front()) {
      std::pop_heap(room.begin(), room.end());
      room.back() = candidate;
      std::push_heap(room.begin(), room.end());
    }
    return true;
  });
  std::make_heap(room.begin(), room.begin() + static_cast<std::ptrdiff_t>(count), std::greater<>());
  return count;
}

/// An upper bound on the distance of the closest pair: the distance of a pair that seems near [m].
double reachOfClosest(const Scene& scene, Workspace& workspace, double tolerance) {
  for (double reach = kDecideReach; reach < static_cast<double>(kFar); reach *= 4) {
    Candidate nearest{kInfinity, -1};
    forEachNear(scene, workspace, reach, [&](int p) {
      nearest = std::min(nearest, candidateOf(scene, workspace, p));
      return true;
    });
    if (nearest.second < 0) continue;
    DistanceRequest request;
    request.tolerance = tolerance;
    return distanceOf(scene, workspace, nearest.second, request, nullptr).distance.upper;
  }
  return kInfinity;
}

/// Updates the result with a pair, if it may be the closest or not keep its margin.
void look(const Scene& scene, Workspace& workspace, const Candidate& candidate, double tolerance,
          SceneResult& result) {
  const auto& [lower, p] = candidate;
  const double margin = scene.pairs()[at(p)].margin;
  // Above this distance the pair is neither the closest nor at its margin. (A margin of NaN is
  // never kept.)
  const double enough = std::isnan(margin) ? kInfinity : std::max(result.clearance.upper, margin);
  if (lower > enough) {
    result.clearance.lower = std::min(result.clearance.lower, lower);
    return;
  }
  DistanceRequest request;
  request.tolerance = tolerance;
  if (std::isfinite(enough)) request.threshold = enough;
  DistanceResult pair = pairDistance(scene, workspace, p, request);
  if (pair.status == DistanceStatus::kNotAboveThreshold && pair.distance.width() > tolerance) {
    request.threshold = std::numeric_limits<double>::quiet_NaN();
    pair = pairDistance(scene, workspace, p, request);
  }
  Verdict verdict = verdictOf(pair.distance, margin);
  if (verdict == Verdict::kUndecided) {
    request.threshold = margin;
    request.tolerance = 0;
    verdict = verdictOf(pairDistance(scene, workspace, p, request).distance, margin);
  }
  result.verdict = worse(result.verdict, verdict);
  result.clearance.lower = std::min(result.clearance.lower, pair.distance.lower);
  if (pair.distance.upper < result.clearance.upper) {
    result.clearance.upper = pair.distance.upper;
    result.pair = p;
    result.closest = pair;
  }
}

/// clearance() of the pairs that may be nearer than `reach`.
SceneResult clearanceWithin(const Scene& scene, Workspace& workspace, double tolerance,
                            double reach, double largest_margin) {
  const std::span<Candidate> room = SceneAccess::impl(workspace).nearest;
  SceneResult result;
  result.verdict = Verdict::kFree;
  result.clearance = {kInfinity, kInfinity};
  // Among many pairs only a few are tested, nearest first.
  Candidate last{-kInfinity, -1};
  std::size_t count = collectNearest(scene, workspace, reach, last, room);
  bool has_more = count == room.size();
  while (count > 0) {
    std::pop_heap(room.begin(), room.begin() + static_cast<std::ptrdiff_t>(count),
                  std::greater<>());
    last = room[--count];
    const auto& [lower, p] = last;
    if (lower > std::max(result.clearance.upper, largest_margin)) {
      // All remaining pairs are also farther.
      result.clearance.lower = std::min(result.clearance.lower, lower);
      break;
    }
    look(scene, workspace, last, tolerance, result);
    if (count > 0 || !has_more) continue;
    count = collectNearest(scene, workspace, reach, last, room);
    has_more = count == room.size();
  }
  return result;
}

}  // namespace

SceneResult clearance(const Scene& scene, Workspace& workspace, double tolerance) {
  ++workspace.statistics.queries;
  // With a margin of NaN a pair is never free, at any distance.
  const double most = scene.pairs().mostMargin();
  const double largest_margin = std::isnan(most) ? kInfinity : most;
  if (scene.pairs().rows().empty() || scene.pairs().size() <= kFewPairs)
    return clearanceWithin(scene, workspace, tolerance, kInfinity, largest_margin);
  // At least 0, so that doubling also increases it if the margins are depths.
  double reach = std::max({reachOfClosest(scene, workspace, tolerance), largest_margin, 0.0});
  for (;;) {
    const SceneResult result = clearanceWithin(scene, workspace, tolerance, reach, largest_margin);
    if (!(result.clearance.upper > reach)) return result;
    reach = 2 * result.clearance.upper;
  }
}

}  // namespace leeway::collision
