// Scenes: what may not touch what.

#include "leeway/collision/scene.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include "collision/base/pose_check.h"
#include "collision/base/tolerances.h"
#include "collision/scene/scene_access.h"

namespace leeway::collision {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Bounds in frame F of a geometry whose body is placed in F by X_FB.
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

}  // namespace

// Here because GeometryBounds is complete here only.
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
  bounds_[at(SceneAccess::geometryIndex(*this, body, geometry))] =
      boundsOf(g, changed.moving ? Pose{} : changed.X_WB);
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
  return static_cast<int>(base_.bodies().size() + bodies_.size()) - 1;
}

void SceneBuilder::allow(int body_a, int body_b) { allowed_.emplace_back(body_a, body_b); }

void SceneBuilder::setDefaultMargin(double margin) { default_margin_ = margin; }

void SceneBuilder::setMargin(int body_a, int body_b, double margin) {
  margins_.push_back({body_a, body_b, margin});
}

namespace {

void requireFinite(double margin) {
  if (!std::isfinite(margin))
    throw std::invalid_argument("scene: a margin must be a finite number of metres");
}

void requirePose(const Pose& X, const std::string& body) {
  if (!isPose(X)) {
    throw std::invalid_argument("scene: the pose of '" + body +
                                "' must be finite, its rotation orthogonal");
  }
}

bool isHalfSpace(const Geometry& g) { return g.shape.type() == ShapeType::kHalfSpace; }

/// All pairs of geometries of two bodies, of which A moves.
void addPairs(std::span<const Body> bodies, int a, int b, double margin,
              std::vector<ScenePair>& pairs) {
  const std::vector<Geometry>&of_a = bodies[at(a)].geometries, &of_b = bodies[at(b)].geometries;
  for (std::size_t g = 0; g < of_a.size(); ++g) {
    for (std::size_t h = 0; h < of_b.size(); ++h) {
      if (isHalfSpace(of_a[g]) && isHalfSpace(of_b[h])) {
        throw std::invalid_argument("half-space of '" + bodies[at(a)].name +
                                    "' with half-space of '" + bodies[at(b)].name +
                                    "': two of them have no distance; a pair that may touch, or "
                                    "another shape for one of them is expected");
      }
      pairs.push_back({a, static_cast<std::int32_t>(g), b, static_cast<std::int32_t>(h), margin});
    }
  }
}

/// What is said of a pair of bodies.
struct Exception {
  bool allowed = false, has_margin = false;
  double margin = 0;
};

/// The pairs of bodies of which something is said.
class Exceptions {
 public:
  template <class Margins>
  Exceptions(std::size_t bodies, std::span<const std::pair<int, int>> allowed,
             const Margins& margins)
      : is_named_(bodies, 0) {
    for (const auto& [a, b] : allowed) of(a, b).allowed = true;
    for (const auto& m : margins) {  // the last one counts
      Exception& exception = of(m.a, m.b);
      exception.has_margin = true;
      exception.margin = m.margin;
    }
  }
  const Exception* find(int a, int b) const {
    if (is_named_[at(a)] == 0 || is_named_[at(b)] == 0) return nullptr;
    const auto found = of_pair_.find(key(a, b));
    return found == of_pair_.end() ? nullptr : &found->second;
  }

 private:
  static std::uint64_t key(int a, int b) {
    return static_cast<std::uint64_t>(std::min(a, b)) << 32U |
           static_cast<std::uint64_t>(std::max(a, b));
  }
  Exception& of(int a, int b) {
    is_named_[at(a)] = is_named_[at(b)] = 1;
    return of_pair_[key(a, b)];
  }
  std::vector<char> is_named_;  // one a body
  std::unordered_map<std::uint64_t, Exception> of_pair_;
};

/// Pairs of geometries of which at least one moves and one is of a body from `added` on, at most.
std::size_t mostPairs(const Scene& scene, int added, std::span<const int> moving) {
  std::size_t all = 0, all_moving = 0, base = 0, base_moving = 0;
  const std::span<const Body> bodies = scene.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    all += bodies[i].geometries.size();
    if (i < at(added)) base += bodies[i].geometries.size();
  }
  for (const int i : moving) {
    all_moving += bodies[at(i)].geometries.size();
    if (i < added) base_moving += bodies[at(i)].geometries.size();
  }
  return base_moving * (all - base) + (all_moving - base_moving) * all;
}

}  // namespace

Scene SceneBuilder::build() && {
  requireFinite(default_margin_);
  for (const PairMargin& m : margins_) requireFinite(m.margin);
  for (const Body& body : bodies_) {
    requirePose(body.X_WB, body.name);
    for (const Geometry& g : body.geometries) requirePose(g.X_BG, body.name);
  }

  Scene scene = std::move(base_);
  const std::vector<ScenePair> base_pairs = std::move(scene.pairs_);
  scene.pairs_.clear();
  const auto added = static_cast<int>(scene.bodies_.size());
  scene.bodies_.reserve(scene.bodies_.size() + bodies_.size());
  scene.first_geometry_.reserve(scene.bodies_.capacity());
  for (Body& body : bodies_) {
    scene.first_geometry_.push_back(static_cast<int>(scene.bounds_.size()));
    for (const Geometry& g : body.geometries)
      scene.bounds_.push_back(boundsOf(g, body.moving ? Pose{} : body.X_WB));
    scene.bodies_.push_back(std::move(body));
  }
  const std::span<const Body> bodies = scene.bodies_;
  const Exceptions exceptions(bodies.size(), allowed_, margins_);
  const auto count = static_cast<int>(bodies.size());
  std::vector<int> moving;
  for (int i = 0; i < count; ++i)
    if (bodies[at(i)].moving) moving.push_back(i);
  // The margin of two bodies; none: they may touch.
  const auto marginOf = [&](int i, int j) -> std::optional<double> {
    const Exception* exception = exceptions.find(i, j);
    if (exception == nullptr) return default_margin_;
    if (exception->allowed) return std::nullopt;
    return exception->has_margin ? exception->margin : default_margin_;
  };
  const auto add = [&](int i, int j) {
    const int a = bodies[at(i)].moving ? i : j, b = a == i ? j : i;
    if (const std::optional<double> margin = marginOf(i, j))
      addPairs(bodies, a, b, *margin, scene.pairs_);
  };
  scene.pairs_.reserve(mostPairs(scene, added, moving) + base_pairs.size());
  // Pairs stand in the order of the first of their bodies, then of the second.
  auto known = base_pairs.begin();
  for (int i = 0; i < count; ++i) {
    for (; known != base_pairs.end() && std::min(known->body_a, known->body_b) == i; ++known)
      if (const std::optional<double> margin = marginOf(known->body_a, known->body_b)) {
        scene.pairs_.push_back(*known);
        scene.pairs_.back().margin = *margin;
      }
    const int first = std::max(i + 1, added);
    if (bodies[at(i)].moving) {
      for (int j = first; j < count; ++j) add(i, j);
    } else {
      for (auto j = std::lower_bound(moving.begin(), moving.end(), first); j != moving.end(); ++j)
        add(i, *j);
    }
  }
  return scene;
}

}  // namespace leeway::collision
