// Queries of a scene: coarse bounds, then exact distances.

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "collision/base/pair_table.h"
#include "collision/base/tolerances.h"
#include "collision/scene/scene_access.h"
#include "leeway/collision/deformable_mesh.h"

namespace leeway::collision {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

struct Workspace::Impl {
  std::vector<Pose> poses;  // one a body
  PairTable<PairCache> caches;
  Scratch scratch;
  int blocking = -1;          // the pair that was not free last; -1: none
  std::vector<double> lower;  // clearance(): coarse lower bound of each pair [m]
  std::vector<int> order;     // clearance(): pairs, the nearest first
};

Workspace::Workspace(const Scene& scene) : impl_(std::make_unique<Impl>()) {
  for (const Body& body : scene.bodies()) impl_->poses.push_back(body.X_WB);
  impl_->caches.resize(scene.pairs().size());
  impl_->lower.resize(scene.pairs().size());
  impl_->order.resize(scene.pairs().size());
  prepare(scene);
}

void Workspace::prepare(const Scene& scene) {
  for (const Body& body : scene.bodies()) {
    for (const Geometry& g : body.geometries) {
      if (g.shape.type() == ShapeType::kDeformable)
        collision::prepare(impl_->scratch, *g.shape.deformable());
    }
  }
}

Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;
Workspace& Workspace::operator=(Workspace&&) noexcept = default;

void Workspace::setPose(int body, const Pose& X_WB) { impl_->poses[at(body)] = X_WB; }
const Pose& Workspace::pose(int body) const { return impl_->poses[at(body)]; }

Scratch& SceneAccess::scratch(Workspace& workspace) { return workspace.impl_->scratch; }
PairCache& SceneAccess::cache(Workspace& workspace, int pair) {
  return workspace.impl_->caches.of(pair);
}

namespace {

/// A point from the frame of body `from` to that of body `to`. The frame of a body that stands
/// still is the world's.
Eigen::Vector3d transferred(const Scene& scene, const Workspace& workspace,
                            const Eigen::Vector3d& p, int from, int to) {
  Eigen::Vector3d p_W = p;
  if (scene.bodies()[at(from)].moving) p_W = workspace.pose(from) * p;
  if (!scene.bodies()[at(to)].moving) return p_W;
  const Pose& X_WB = workspace.pose(to);
  return X_WB.rotation.transpose() * (p_W - X_WB.translation);
}

/// Rounding of two transfers, and the error of the poses themselves [m].
double transferSlack(const Scene& scene, const Workspace& workspace, int a, int b,
                     const Eigen::Vector3d& p) {
  const double error =
      scene.bodies()[at(b)].moving ? 2 * workspace.pose_error : workspace.pose_error;
  return error + kTransferRounding * (workspace.pose(a).translation.lpNorm<1>() +
                                      workspace.pose(b).translation.lpNorm<1>() + p.lpNorm<1>());
}

const GeometryBounds& boundsOf(const Scene& scene, int body, int geometry) {
  return SceneAccess::bounds(scene, SceneAccess::geometryIndex(scene, body, geometry));
}

/// Lower bound on the separation: the outer ball of each body from the stand-in of the other.
double coarseLower(const Scene& scene, const Workspace& workspace, const ScenePair& pair) {
  const GeometryBounds& a = boundsOf(scene, pair.body_a, pair.geometry_a);
  const GeometryBounds& b = boundsOf(scene, pair.body_b, pair.geometry_b);
  const Eigen::Vector3d center_B =
      transferred(scene, workspace, a.outer.center, pair.body_a, pair.body_b);
  double lower = b.coarse.lower(center_B) - a.outer.radius;
  if (std::isfinite(b.outer.radius)) {
    const Eigen::Vector3d center_A =
        transferred(scene, workspace, b.outer.center, pair.body_b, pair.body_a);
    lower = std::max(lower, a.coarse.lower(center_A) - b.outer.radius);
  }
  // A NaN pose must not pass for far away.
  return std::isnan(lower)
             ? -kInfinity
             : lower - transferSlack(scene, workspace, pair.body_a, pair.body_b, center_B);
}

/// Upper bound on the separation from A's inner balls in B's stand-in. Stops at the first that
/// proves contact.
double coarseUpper(const Scene& scene, const Workspace& workspace, const ScenePair& pair) {
  const GeometryBounds& a = boundsOf(scene, pair.body_a, pair.geometry_a);
  const GeometryBounds& b = boundsOf(scene, pair.body_b, pair.geometry_b);
  double upper = kInfinity;
  for (const Ball& ball : a.inner) {
    const Eigen::Vector3d center_B =
        transferred(scene, workspace, ball.center, pair.body_a, pair.body_b);
    const double slack = transferSlack(scene, workspace, pair.body_a, pair.body_b, center_B);
    upper = std::min(upper, b.coarse.upper(center_B) - ball.radius + slack);
    if (upper <= pair.margin) break;
  }
  return std::isnan(upper) ? kInfinity : upper;
}

Verdict verdictOf(const Interval& distance, double margin) {
  if (distance.lower > margin) return Verdict::kFree;
  if (distance.upper <= margin) return Verdict::kNotFree;
  return Verdict::kUndecided;
}

/// kNotFree before kUndecided before kFree.
Verdict worse(Verdict x, Verdict y) {
  if (x == Verdict::kNotFree || y == Verdict::kNotFree) return Verdict::kNotFree;
  if (x == Verdict::kUndecided || y == Verdict::kUndecided) return Verdict::kUndecided;
  return Verdict::kFree;
}

/// One pair against its margin. `result` has at least the interval, and all else where the exact
/// query was needed.
Verdict decidePair(const Scene& scene, Workspace& workspace, int p, DistanceResult& result) {
  const ScenePair& pair = scene.pairs()[at(p)];
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

double coarseLowerBound(const Scene& scene, const Workspace& workspace, int pair) {
  return coarseLower(scene, workspace, scene.pairs()[at(pair)]);
}

DistanceResult pairDistance(const Scene& scene, Workspace& workspace, int p,
                            const DistanceRequest& request) {
  const ScenePair& pair = scene.pairs()[at(p)];
  const Geometry& a = scene.bodies()[at(pair.body_a)].geometries[at(pair.geometry_a)];
  const Geometry& b = scene.bodies()[at(pair.body_b)].geometries[at(pair.geometry_b)];
  const double slack =
      transferSlack(scene, workspace, pair.body_a, pair.body_b, Eigen::Vector3d::Zero()) +
      kTransferRounding * (a.X_BG.translation.lpNorm<1>() + b.X_BG.translation.lpNorm<1>());
  DistanceRequest raised = request;
  raised.threshold += slack;  // what is above it stays above when widened; NaN stays NaN
  DistanceResult result = distance(
      a.shape, workspace.pose(pair.body_a) * a.X_BG, b.shape, workspace.pose(pair.body_b) * b.X_BG,
      raised, SceneAccess::scratch(workspace), &SceneAccess::cache(workspace, p));
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
  // What blocked last is likely to block again.
  bool going = impl.blocking < 0 || look(impl.blocking);
  const int count = static_cast<int>(scene.pairs().size());
  for (int p = 0; going && p < count; ++p)
    if (p != impl.blocking) going = look(p);
  if (!going) result.clearance.lower = -kInfinity;  // the other pairs were not looked at
  return result;
}

SceneResult clearance(const Scene& scene, Workspace& workspace, double tolerance) {
  ++workspace.statistics.queries;
  auto& impl = SceneAccess::impl(workspace);
  const std::span<const ScenePair> pairs = scene.pairs();
  double largest_margin = -kInfinity;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    impl.order[p] = static_cast<int>(p);
    impl.lower[p] = coarseLower(scene, workspace, pairs[p]);
    if (std::isnan(impl.lower[p])) impl.lower[p] = -kInfinity;  // NaN would break the order
    largest_margin = std::max(largest_margin, pairs[p].margin);
  }
  // A heap: of many pairs few are looked at, nearest first.
  const auto farther = [&](int x, int y) {
    return impl.lower[at(x)] > impl.lower[at(y)] ||
           (impl.lower[at(x)] == impl.lower[at(y)] && x > y);
  };
  auto end = impl.order.end();
  std::make_heap(impl.order.begin(), end, farther);
  SceneResult result;
  result.verdict = Verdict::kFree;
  result.clearance = {kInfinity, kInfinity};
  while (end != impl.order.begin()) {
    std::pop_heap(impl.order.begin(), end, farther);
    const int p = *--end;
    if (impl.lower[at(p)] > std::max(result.clearance.upper, largest_margin)) {
      // So are all that are left.
      result.clearance.lower = std::min(result.clearance.lower, impl.lower[at(p)]);
      break;
    }
    const double margin = pairs[at(p)].margin;
    // Above this the pair is neither the closest nor at its margin.
    const double enough = std::max(result.clearance.upper, margin);
    if (impl.lower[at(p)] > enough) {
      result.clearance.lower = std::min(result.clearance.lower, impl.lower[at(p)]);
      continue;
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
  return result;
}

}  // namespace leeway::collision
