#include "leeway/collision/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "collision/base/pose_check.h"
#include "collision/base/tolerances.h"
#include "collision/scene/geometry_bounds.h"
#include "leeway/collision/deformable_mesh.h"

namespace leeway::collision {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t at(int i) { return static_cast<std::size_t>(i); }

GeometryBounds boundsOf(const Geometry& geometry, const Pose& X_FB) {
  const Pose X_FG = X_FB * geometry.X_BG;
  GeometryBounds bounds;
  bounds.outer.center = X_FG * geometry.shape.boundingCenter();
  const double radius = geometry.shape.boundingRadius();
  bounds.outer.radius = radius + kTransferRounding * (bounds.outer.center.lpNorm<1>() + radius);
  bounds.coarse = CoarseShape(geometry.shape, X_FG);
  bounds.inner = innerBalls(geometry.shape, X_FG);
  return bounds;
}

bool samePair(int a, int b, int c, int d) { return (a == c && b == d) || (a == d && b == c); }

}  // namespace

// Here, where GeometryBounds is known.
Scene::Scene() = default;
Scene::~Scene() = default;
Scene::Scene(const Scene&) = default;
Scene& Scene::operator=(const Scene&) = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

int Scene::find(const std::string& name) const {
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (bodies_[i].name == name) return static_cast<int>(i);
  return -1;
}

void Scene::setShape(int body, int geometry, const Shape& shape) {
  Body& changed = bodies_[at(body)];
  Geometry& g = changed.geometries[at(geometry)];
  g.shape = shape;
  bounds_[at(geometryIndex(body, geometry))] = boundsOf(g, changed.moving ? Pose{} : changed.X_WB);
}

std::size_t Scene::bytes() const {
  std::size_t bytes = pairs_.size() * sizeof(ScenePair) + bounds_.size() * sizeof(GeometryBounds);
  for (const GeometryBounds& b : bounds_) bytes += b.inner.size() * sizeof(Ball);
  return bytes;
}

void Scene::growMargins(int body, int geometry, double growth) {
  if (growth <= 0) return;
  for (ScenePair& pair : pairs_)
    if ((pair.body_a == body && pair.geometry_a == geometry) ||
        (pair.body_b == body && pair.geometry_b == geometry))
      pair.margin = std::max(pair.margin, 0.0) + growth;
}

int SceneBuilder::add(Body body) {
  bodies_.push_back(std::move(body));
  return static_cast<int>(bodies_.size()) - 1;
}

void SceneBuilder::allow(int body_a, int body_b) { allowed_.emplace_back(body_a, body_b); }

void SceneBuilder::setDefaultMargin(double margin) { default_margin_ = margin; }

void SceneBuilder::setMargin(int body_a, int body_b, double margin) {
  margins_.push_back({body_a, body_b, margin});
}

Scene SceneBuilder::build() const {
  const auto finite = [](double margin) {
    if (!std::isfinite(margin))
      throw std::invalid_argument("scene: a margin must be a finite number of metres");
  };
  finite(default_margin_);
  for (const PairMargin& m : margins_) finite(m.margin);
  const auto placed = [](const Pose& X, const std::string& name) {
    if (!isPose(X)) {
      throw std::invalid_argument("scene: the pose of '" + name +
                                  "' must be finite, its rotation orthogonal");
    }
  };
  for (const Body& body : bodies_) {
    placed(body.X_WB, body.name);
    for (const Geometry& g : body.geometries) placed(g.X_BG, body.name);
  }

  Scene scene;
  scene.bodies_ = bodies_;
  for (const Body& body : bodies_) {
    scene.first_geometry_.push_back(static_cast<int>(scene.bounds_.size()));
    for (const Geometry& g : body.geometries)
      scene.bounds_.push_back(boundsOf(g, body.moving ? Pose{} : body.X_WB));
  }
  const int count = static_cast<int>(bodies_.size());
  std::vector<char> allowed(at(count), 0);
  for (int i = 0; i < count; ++i) {
    std::fill(allowed.begin(), allowed.end(), 0);
    for (const auto& [x, y] : allowed_) {
      if (x == i) allowed[at(y)] = 1;
      if (y == i) allowed[at(x)] = 1;
    }
    for (int j = i + 1; j < count; ++j) {
      if (allowed[at(j)] || !(bodies_[at(i)].moving || bodies_[at(j)].moving)) continue;
      double margin = default_margin_;
      for (const PairMargin& m : margins_)  // the last one said stands
        if (samePair(m.a, m.b, i, j)) margin = m.margin;
      const int a = bodies_[at(i)].moving ? i : j, b = a == i ? j : i;
      const std::vector<Geometry>&of_a = bodies_[at(a)].geometries,
            &of_b = bodies_[at(b)].geometries;
      for (std::size_t g = 0; g < of_a.size(); ++g)
        for (std::size_t h = 0; h < of_b.size(); ++h) {
          if (of_a[g].shape.type() == ShapeType::kHalfSpace &&
              of_b[h].shape.type() == ShapeType::kHalfSpace)
            throw std::invalid_argument("half-space of '" + bodies_[at(a)].name +
                                        "' with half-space of '" + bodies_[at(b)].name +
                                        "': nothing is told of two; a pair that may touch, or "
                                        "another shape for one of them is expected");
          scene.pairs_.push_back(
              {a, static_cast<std::int32_t>(g), b, static_cast<std::int32_t>(h), margin});
        }
    }
  }
  return scene;
}

struct Workspace::Impl {
  std::vector<Pose> poses;        // one a body
  std::vector<PairCache> caches;  // one a pair
  Scratch scratch;
  int killer = -1;            // the pair that last was not free
  std::vector<double> lower;  // clearance(): coarse bounds, one a pair
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
Scratch& Workspace::scratch() { return impl_->scratch; }
PairCache& Workspace::cache(int pair) { return impl_->caches[at(pair)]; }

namespace {

/// The point of frame `from` (a body's, or the world for one that does not move) in body `to`'s.
Eigen::Vector3d transferred(const Scene& scene, const Workspace& workspace,
                            const Eigen::Vector3d& p, int from, int to) {
  Eigen::Vector3d p_W = p;
  if (scene.bodies()[at(from)].moving) p_W = workspace.pose(from) * p;
  if (!scene.bodies()[at(to)].moving) return p_W;
  const Pose& X_WB = workspace.pose(to);
  return X_WB.rotation.transpose() * (p_W - X_WB.translation);
}

/// Rounding of two transfers, and what the poses themselves are worth [m].
double transferSlack(const Scene& scene, const Workspace& workspace, int a, int b,
                     const Eigen::Vector3d& p) {
  const double error =
      scene.bodies()[at(b)].moving ? 2 * workspace.pose_error : workspace.pose_error;
  return error + kTransferRounding * (workspace.pose(a).translation.lpNorm<1>() +
                                      workspace.pose(b).translation.lpNorm<1>() + p.lpNorm<1>());
}

/// Lower bound on the separation from outer balls and stand-ins, taken both ways.
double coarseLower(const Scene& scene, const Workspace& workspace, const ScenePair& pair) {
  const GeometryBounds& a = scene.bounds(scene.geometryIndex(pair.body_a, pair.geometry_a));
  const GeometryBounds& b = scene.bounds(scene.geometryIndex(pair.body_b, pair.geometry_b));
  const Eigen::Vector3d center_B =
      transferred(scene, workspace, a.outer.center, pair.body_a, pair.body_b);
  double lower = b.coarse.lower(center_B) - a.outer.radius;
  if (std::isfinite(b.outer.radius)) {
    const Eigen::Vector3d center_A =
        transferred(scene, workspace, b.outer.center, pair.body_b, pair.body_a);
    lower = std::max(lower, a.coarse.lower(center_A) - b.outer.radius);
  }
  // A pose that is no number must not pass for far away.
  return std::isnan(lower)
             ? -kInfinity
             : lower - transferSlack(scene, workspace, pair.body_a, pair.body_b, center_B);
}

/// Upper bound on the separation from points and balls of A in B's stand-in, as far as they prove
/// contact.
double coarseUpper(const Scene& scene, const Workspace& workspace, const ScenePair& pair) {
  const GeometryBounds& a = scene.bounds(scene.geometryIndex(pair.body_a, pair.geometry_a));
  const GeometryBounds& b = scene.bounds(scene.geometryIndex(pair.body_b, pair.geometry_b));
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

/// Not free outweighs undecided, and that free.
Verdict worse(Verdict x, Verdict y) {
  if (x == Verdict::kNotFree || y == Verdict::kNotFree) return Verdict::kNotFree;
  if (x == Verdict::kUndecided || y == Verdict::kUndecided) return Verdict::kUndecided;
  return Verdict::kFree;
}

/// One pair against its margin; its interval in `distance`, and all of the result when GJK was
/// asked.
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
  raised.threshold += slack;  // so that what is beyond it stays so when widened (NaN stays NaN)
  DistanceResult result = distance(a.shape, workspace.pose(pair.body_a) * a.X_BG, b.shape,
                                   workspace.pose(pair.body_b) * b.X_BG, raised,
                                   workspace.scratch(), &workspace.cache(p));
  ++workspace.statistics.exact;
  workspace.statistics.iterations += static_cast<std::uint64_t>(result.iterations);
  // Of a place that is no number nothing is known, and NaN would be lost among other pairs.
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
  Workspace::Impl& impl = workspace.impl();
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
      impl.killer = p;
      result.pair = p;
      result.closest = pair;
    }
    return verdict != Verdict::kNotFree;
  };
  // What was in the way last is likely to be in the way again.
  bool going = impl.killer < 0 || look(impl.killer);
  const int count = static_cast<int>(scene.pairs().size());
  for (int p = 0; going && p < count; ++p)
    if (p != impl.killer) going = look(p);
  if (!going) result.clearance.lower = -kInfinity;  // pairs not looked at may be anywhere
  return result;
}

SceneResult clearance(const Scene& scene, Workspace& workspace, double tolerance) {
  ++workspace.statistics.queries;
  Workspace::Impl& impl = workspace.impl();
  const std::span<const ScenePair> pairs = scene.pairs();
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    impl.order[p] = static_cast<int>(p);
    impl.lower[p] = coarseLower(scene, workspace, pairs[p]);
    if (std::isnan(impl.lower[p])) impl.lower[p] = -kInfinity;  // to be looked at, and to be sorted
  }
  std::sort(impl.order.begin(), impl.order.end(), [&](int x, int y) {
    return impl.lower[at(x)] < impl.lower[at(y)] ||
           (impl.lower[at(x)] == impl.lower[at(y)] && x < y);
  });
  SceneResult result;
  result.verdict = Verdict::kFree;
  result.clearance = {kInfinity, kInfinity};
  for (const int p : impl.order) {
    const double margin = pairs[at(p)].margin;
    // Beyond this the pair neither is the closest nor comes near its margin.
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
