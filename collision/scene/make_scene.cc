// Scenes: bodies that must not touch.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include "collision/base/greatest.h"
#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/lanes/lane_sweep.h"
#include "collision/lanes/obstacle_boxes.h"
#include "collision/scene/scene_access.h"
#include "collision/scene/scene_checks.h"
#include "leeway/collision/scene.h"

namespace leeway::collision {

Geometry Body::geometry(std::size_t number) const {
  if (number < geometries.size()) return geometries[number];
  const Ball& ball = (*balls)[number - geometries.size()];
  return {Shape::sphere(ball.radius), {Eigen::Matrix3d::Identity(), ball.center}, {}};
}

namespace {

/// Grows a ball by the rounding of its place.
Ball grown(const Ball& ball) {
  return {ball.center, ball.radius + kTransferRounding * (ball.center.lpNorm<1>() + ball.radius)};
}

}  // namespace

BallBounds::BallBounds(const Body& body, const Ball& ball)
    : outer(grown({body.X_WB * ball.center, ball.radius})),
      coarse(Ball{outer.center, ball.radius}) {}

GeometryBounds boundsOf(const Body& body, const Geometry& geometry) {
  const Pose X_FG = body.moving ? Pose{} * geometry.X_BG : body.X_WB * geometry.X_BG;
  GeometryBounds bounds;
  bounds.outer = grown({X_FG * geometry.shape.boundingCenter(), geometry.shape.boundingRadius()});
  bounds.coarse = CoarseShape(geometry.shape, X_FG);
  if (body.moving) bounds.inner = innerBalls(geometry.shape, X_FG);
  return bounds;
}

void Scene::Things::add(Body body, std::size_t first) {
  first_geometry.push_back(static_cast<int>(first));
  first_bounds.push_back(bounds.size());
  for (const Geometry& g : body.geometries) bounds.push_back(boundsOf(body, g));
  size += body.size();
  bodies.push_back(std::move(body));
}

void Scene::Things::replace(std::size_t body, Body by) {
  std::size_t next = first_bounds[body];
  for (const Geometry& g : by.geometries) bounds[next++] = boundsOf(by, g);
  bodies[body] = std::move(by);
}

const std::shared_ptr<Scene::Things>& Scene::nothing() {
  static const std::shared_ptr<Things> things = std::make_shared<Things>();
  return things;
}

Scene::Scene() : things_(nothing()) {}
Scene::~Scene() = default;

Scene::Scene(const Scene& other)
    : things_(other.things_),
      added_(other.added_),
      removed_(other.removed_),
      pairs_(other.pairs_),
      still_(other.still_) {
  other.is_shared_.store(true, std::memory_order_relaxed);
}

Scene::Scene(Scene&& other) noexcept
    : things_(std::exchange(other.things_, nothing())),
      added_(std::move(other.added_)),
      removed_(std::exchange(other.removed_, {})),
      is_shared_(other.is_shared_.exchange(true, std::memory_order_relaxed)),
      pairs_(std::exchange(other.pairs_, {})),
      still_(std::exchange(other.still_, {})) {}

Scene& Scene::operator=(const Scene& other) {
  if (this != &other) *this = Scene(other);
  return *this;
}

Scene& Scene::operator=(Scene&& other) noexcept {
  things_ = std::exchange(other.things_, nothing());
  added_ = std::move(other.added_);
  removed_ = std::exchange(other.removed_, {});
  is_shared_.store(other.is_shared_.exchange(true, std::memory_order_relaxed),
                   std::memory_order_relaxed);
  pairs_ = std::exchange(other.pairs_, {});
  still_ = std::exchange(other.still_, {});
  return *this;
}

Scene::Things& Scene::own() {
  if (is_shared_.load(std::memory_order_relaxed)) {
    things_ = std::make_shared<Things>(*things_);
    is_shared_.store(false, std::memory_order_relaxed);
  }
  return *things_;
}

int Scene::find(const std::string& name) const {
  const Bodies all = bodies();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].name == name && !isRemoved(static_cast<int>(i))) return static_cast<int>(i);
  return -1;
}

namespace {

/// The box around a geometry in the world, rounding included; unbounded if the geometry may change.
ObstacleBoxes::Box boxOf(const Shape& shape, const Pose& X_WG) {
  ObstacleBoxes::Box box = LaneSweep::boxAround(shape, X_WG);
  if (shape.type() != ShapeType::kDeformable) return box;
  std::fill_n(box.low, 3, -kFar);
  std::fill_n(box.high, 3, kFar);
  return box;
}

/// The scale of a geometry in the world, see SceneAccess::scaleOfStill() [m].
double scaleOf(const Shape& shape, const Pose& X_WG, const Ball& outer) {
  return greatest(
      (X_WG.rotation.transpose() * X_WG.translation).lpNorm<1>() + outer.center.lpNorm<1>(),
      LaneSweep::scaleOf(shape, X_WG));
}

/// Bounds of fixed geometries, in the order of their places.
class StillGeometries {
 public:
  explicit StillGeometries(std::size_t first_place) : first_place_(first_place) {}
  void reserve(std::size_t count) { boxes.reserve(count); }
  void take(const Body& body, const GeometryBounds* bounds) {
    for (const Geometry& g : body.geometries) {
      const Pose X_WG = body.X_WB * g.X_BG;
      if (LaneSweep::needsObstacle(g.shape))
        added.push_back(static_cast<std::int32_t>(first_place_ + boxes.size()));
      boxes.push_back(boxOf(g.shape, X_WG));
      scale = greatest(scale, scaleOf(g.shape, X_WG, (bounds++)->outer));
    }
    if (body.balls) takeBalls(body);
  }

  std::vector<ObstacleBoxes::Box> boxes;
  std::vector<std::int32_t> added;
  double scale = 0;

 private:
  /// As for spheres at the balls' centres, without their poses and bounds.
  void takeBalls(const Body& body) {
    const Pose& X_WB = body.X_WB;
    const double origin = (X_WB.rotation.transpose() * X_WB.translation).lpNorm<1>();
    double most = 0;
    for (const Ball& ball : *body.balls) {
      const Eigen::Vector3d center = X_WB * ball.center;
      boxes.push_back(LaneSweep::boxAroundBall({center, ball.radius}, X_WB.translation));
      most = greatest(most,
                      center.lpNorm<1>() + std::max(ball.center.lpNorm<1>() + origin, ball.radius));
    }
    // At least scaleOf(): R^T (R c + t) is c + R^T t, up to rounding.
    scale = greatest(scale, most * (1 + kTransferRounding));
  }

  std::size_t first_place_;
};

}  // namespace

void Scene::findStill() {
  const auto first = std::min(at(pairs_.firstStill()), things_->bodies.size());
  StillGeometries built(0);
  built.reserve(pairs_.places());
  for (std::size_t b = first; b < things_->bodies.size(); ++b)
    built.take(things_->bodies[b], things_->bounds.data() + things_->first_bounds[b]);
  still_ = {};
  if (!built.boxes.empty()) still_.boxes = std::make_shared<const ObstacleBoxes>(built.boxes);
  still_.added = std::make_shared<const std::vector<std::int32_t>>(std::move(built.added));
  still_.scale = still_.built_scale = built.scale;
  if (added_) findAddedStill();
}

void Scene::findAddedStill() {
  std::size_t count = 0;  // number of geometries that were added and are in places
  const std::size_t built = things_->bodies.size();
  const std::size_t first = std::max(at(pairs_.firstStill()), built) - built;
  for (std::size_t b = first; b < added_->bodies.size(); ++b) count += added_->bodies[b].size();
  const std::size_t first_place = pairs_.places() - count;
  StillGeometries still(first_place);
  still.reserve(count);
  for (std::size_t b = first; b < added_->bodies.size(); ++b)
    still.take(added_->bodies[b], added_->bounds.data() + added_->first_bounds[b]);
  std::shared_ptr<const ObstacleBoxes> of_built;
  if (first_place > 0) of_built = still_.boxes->first() ? still_.boxes->first() : still_.boxes;
  std::vector<std::int32_t> places;
  if (still_.added)
    std::copy_if(still_.added->begin(), still_.added->end(), std::back_inserter(places),
                 [&](std::int32_t place) { return at(place) < first_place; });
  places.insert(places.end(), still.added.begin(), still.added.end());
  still_.added = std::make_shared<const std::vector<std::int32_t>>(std::move(places));
  still_.boxes = std::make_shared<const ObstacleBoxes>(still.boxes, std::move(of_built),
                                                       static_cast<std::int32_t>(first_place));
  still_.scale = greatest(still_.built_scale, still.scale);
}

void Scene::setShape(int body, int geometry, const Shape& shape) {
  const std::size_t built = things_->bodies.size();
  const bool is_added = at(body) >= built;
  const std::shared_ptr<Things> more = is_added ? std::make_shared<Things>(*added_) : nullptr;
  Things& things = is_added ? *more : own();
  Body& changed = things.bodies[at(body) - (is_added ? built : 0)];
  Geometry& g = changed.geometries.at(at(geometry));
  const bool is_boxed =
      pairs_.places() > 0 && body >= pairs_.firstStill() &&
      !(g.shape.type() == ShapeType::kDeformable && shape.type() == ShapeType::kDeformable);
  g.shape = shape;
  GeometryBounds& bounds =
      things.bounds[things.first_bounds[at(body) - (is_added ? built : 0)] + at(geometry)];
  bounds = boundsOf(changed, g);
  if (is_added) added_ = more;
  if (is_boxed) {
    findStill();
  } else if (still_.boxes) {
    const double scale = scaleOf(shape, changed.X_WB * g.X_BG, bounds.outer);
    still_.scale = greatest(still_.scale, scale);
    if (!is_added) still_.built_scale = greatest(still_.built_scale, scale);
  }
}

void Scene::setPoses(std::span<const std::pair<int, Pose>> X_WB) {
  if (X_WB.empty()) return;
  const std::size_t built = things_->bodies.size();
  auto moved = added_ ? std::make_shared<Things>(*added_) : std::make_shared<Things>();
  for (const auto& [body, pose] : X_WB) {
    if (body < 0 || at(body) < built || at(body) >= bodies().size() || isRemoved(body))
      throw std::invalid_argument("scene: body " + std::to_string(body) +
                                  " is moved; one that a change has added is expected");
    const std::size_t i = at(body) - built;
    Body changed = moved->bodies[i];
    changed.X_WB = pose;
    requirePoses(changed);
    moved->replace(i, std::move(changed));
  }
  added_ = std::move(moved);
  if (still_.boxes) findAddedStill();
}

void Scene::growMargins(int body, int geometry, double growth) {
  if (growth <= 0) return;
  const bool has_place = pairs_.places() > 0 && body >= pairs_.firstStill();
  const int first = has_place ? SceneAccess::geometryIndex(*this, body, 0) -
                                    SceneAccess::geometryIndex(*this, pairs_.firstStill(), 0)
                              : 0;
  pairs_.grow(body, geometry, growth, at(first));
}

void SceneBuilder::reserve(std::size_t bodies) { bodies_.reserve(bodies); }

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

/// Rejects pairs of two half-spaces in the table.
void requireNoHalfSpaces(std::span<const Body> bodies, const ScenePairs& pairs) {
  for (std::size_t row = 0; row < pairs.rows().size(); ++row) {
    const Body& a = bodies[at(pairs.rows()[row].body)];
    if (!isHalfSpace(a, at(pairs.rows()[row].geometry))) continue;
    for (std::size_t place = 0; place < pairs.places(); ++place) {
      const auto [body, geometry] = pairs.geometryIn(place);
      const Body& b = bodies[at(body)];
      if (isHalfSpace(b, at(geometry)) && pairs.numberOf(row, place) >= 0) refuseHalfSpaces(a, b);
    }
  }
}

/// Adds all pairs of geometries of two bodies, of which A moves.
void addPairs(std::span<const Body> bodies, int a, int b, double margin,
              std::vector<ScenePair>& pairs) {
  const Body &of_a = bodies[at(a)], &of_b = bodies[at(b)];
  for (std::size_t g = 0; g < of_a.size(); ++g) {
    for (std::size_t h = 0; h < of_b.size(); ++h) {
      if (isHalfSpace(of_a, g) && isHalfSpace(of_b, h))
        refuseHalfSpaces(bodies[at(a)], bodies[at(b)]);
      pairs.push_back({a, static_cast<std::int32_t>(g), b, static_cast<std::int32_t>(h), margin});
    }
  }
}

/// The settings of a pair of bodies.
struct Exception {
  bool allowed = false, has_margin = false;
  double margin = 0;
};

/// The pairs of bodies that have settings.
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
  /// Calls visit(a, b, exception) for all, with a < b, in no particular order.
  template <class Visit>
  void forEach(const Visit& visit) const {
    for (const auto& [key, exception] : of_pair_)
      visit(static_cast<int>(key >> 32U), static_cast<int>(key & 0xffffffffU), exception);
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
  std::vector<char> is_named_;  // one for each body
  std::unordered_map<std::uint64_t, Exception> of_pair_;
};

/// An upper bound on the number of pairs of geometries with at least one moving geometry and at
/// least one of a body from `added` on.
std::size_t mostPairs(std::span<const Body> bodies, int added, std::span<const int> moving) {
  std::size_t all = 0, all_moving = 0, base = 0, base_moving = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    all += bodies[i].size();
    if (i < at(added)) base += bodies[i].size();
  }
  for (const int i : moving) {
    all_moving += bodies[at(i)].size();
    if (i < added) base_moving += bodies[at(i)].size();
  }
  return base_moving * (all - base) + (all_moving - base_moving) * all;
}

}  // namespace

Scene SceneBuilder::build() && {
  requireMargin(default_margin_);
  for (const PairMargin& m : margins_) requireMargin(m.margin);
  for (const Body& body : bodies_) {
    requirePoses(body);
    requireBalls(body);
  }

  Scene scene = std::move(base_);
  const ScenePairs base = std::move(scene.pairs_);
  scene.pairs_ = {};
  scene.still_ = {};
  Scene::Things& things = scene.own();
  if (scene.added_) {
    for (const Body& body : scene.added_->bodies) things.add(body, things.size);
    scene.added_ = nullptr;
  }
  scene.removed_.clear();
  const auto added = static_cast<int>(things.bodies.size());
  things.bodies.reserve(things.bodies.size() + bodies_.size());
  things.first_geometry.reserve(things.bodies.capacity());
  things.first_bounds.reserve(things.bodies.capacity());
  std::size_t geometries = things.bounds.size();
  for (const Body& body : bodies_) geometries += body.geometries.size();
  things.bounds.reserve(geometries);
  for (Body& body : bodies_) things.add(std::move(body), things.size);
  const std::span<const Body> bodies = things.bodies;
  const Exceptions exceptions(bodies.size(), allowed_, margins_);
  const auto count = static_cast<int>(bodies.size());
  std::vector<int> moving;
  for (int i = 0; i < count; ++i)
    if (bodies[at(i)].moving) moving.push_back(i);
  // Bodies from here on have places.
  const int last_moving = moving.empty() ? -1 : moving.back();
  const bool keeps_places = base.places() > 0 && last_moving < base.firstStill();
  const int end = lists_all_     ? count
                  : keeps_places ? base.firstStill()
                                 : std::max(added, last_moving + 1);
  addTable(bodies, end, scene.pairs_);
  // Pairs of a table that is kept are not listed.
  const ScenePairs::Iterator base_end =
      keeps_places && !lists_all_ ? ScenePairs::Iterator(base, base.listedCount()) : base.end();
  std::vector<ScenePair> base_pairs(base.begin(), base_end);
  const auto before = [](const ScenePair& x, const ScenePair& y) {
    return std::minmax(x.body_a, x.body_b) < std::minmax(y.body_a, y.body_b);
  };
  // Pairs of a list that a builder made are already in this order; those of a table or a change are
  // not.
  if (!std::is_sorted(base_pairs.begin(), base_pairs.end(), before))
    std::stable_sort(base_pairs.begin(), base_pairs.end(), before);
  // The margin of two bodies; nullopt: they may touch.
  const auto marginOf = [&](int i, int j) -> std::optional<double> {
    const Exception* exception = exceptions.find(i, j);
    if (exception == nullptr) return default_margin_;
    if (exception->allowed) return std::nullopt;
    return exception->has_margin ? exception->margin : default_margin_;
  };
  std::vector<ScenePair>& listed = scene.pairs_.listed_;
  const auto add = [&](int i, int j) {
    const int a = bodies[at(i)].moving ? i : j, b = a == i ? j : i;
    if (const std::optional<double> margin = marginOf(i, j))
      addPairs(bodies, a, b, *margin, listed);
  };
  listed.reserve(mostPairs(bodies.first(at(end)), added, moving) + base_pairs.size());
  // They are in the order of the first of their bodies, then of the second.
  auto known = base_pairs.begin();
  for (int i = 0; i < end; ++i) {
    for (; known != base_pairs.end() && std::min(known->body_a, known->body_b) == i; ++known)
      if (const std::optional<double> margin = marginOf(known->body_a, known->body_b)) {
        listed.push_back(*known);
        listed.back().margin = *margin;
      }
    const int first = std::max(i + 1, added);
    if (bodies[at(i)].moving) {
      for (int j = first; j < end; ++j) add(i, j);
    } else {
      for (auto j = std::lower_bound(moving.begin(), moving.end(), first); j != moving.end(); ++j)
        add(i, *j);
    }
  }
  ScenePairs& pairs = scene.pairs_;
  if (keeps_places) addTableOf(base, pairs);
  exceptions.forEach([&](int a, int b, const Exception& exception) {
    if (!bodies[at(a)].moving || b < end) return;  // (a < b)
    const auto first = at(things.first_geometry[at(b)] - things.first_geometry[at(end)]);
    for (std::size_t row = 0; row < pairs.rows_.size(); ++row) {
      if (pairs.rows_[row].body != a) continue;
      for (std::size_t h = 0; h < bodies[at(b)].size(); ++h) {
        if (exception.allowed)
          pairs.leaveOut({row, first + h});
        else
          pairs.setMargin({row, first + h}, exception.margin);
      }
    }
  });
  pairs.count();
  requireNoHalfSpaces(bodies, pairs);
  if (pairs.places() > 0) scene.findStill();
  return scene;
}

/// Adds a row for each moving geometry, and a place for each geometry of bodies from first_still
/// on, which are all fixed.
void SceneBuilder::addTable(std::span<const Body> bodies, int first_still,
                            ScenePairs& pairs) const {
  std::vector<ScenePairs::Row> rows;
  for (std::size_t b = 0; b < at(first_still); ++b)
    for (std::size_t g = 0; bodies[b].moving && g < bodies[b].geometries.size(); ++g)
      rows.push_back({static_cast<std::int32_t>(b), static_cast<std::int32_t>(g), default_margin_});
  std::size_t places = 0;
  bool is_one_each = true;
  for (const Body& body : bodies.subspan(at(first_still))) {
    places += body.size();
    is_one_each = is_one_each && body.size() == 1;
  }
  if (rows.empty() || places == 0) return;
  requireNumbers(rows.size(), places);
  pairs.rows_ = std::move(rows);
  pairs.places_ = places;
  pairs.first_still_ = first_still;
  if (!is_one_each) pairs.geometries_.reserve(places);
  for (std::size_t b = at(first_still); !is_one_each && b < bodies.size(); ++b)
    for (std::size_t g = 0; g < bodies[b].size(); ++g)
      pairs.geometries_.push_back({static_cast<std::int32_t>(b), static_cast<std::int32_t>(g)});
}

/// Removes the pairs that `base` leaves out, whose places are the first ones.
void SceneBuilder::addTableOf(const ScenePairs& base, ScenePairs& pairs) {
  if (base.in_table_ == pairs.rows_.size() * base.places_) return;
  for (std::size_t row = 0; row < pairs.rows_.size(); ++row) {
    const ScenePairs::Row& of = pairs.rows_[row];
    const auto known = std::find_if(base.rows_.begin(), base.rows_.end(), [&](const auto& r) {
      return r.body == of.body && r.geometry == of.geometry;
    });
    const auto in_base = static_cast<std::size_t>(known - base.rows_.begin());
    for (std::size_t place = 0; place < base.places_; ++place)
      if (known == base.rows_.end() || !base.find({in_base, place}).has_pair)
        pairs.leaveOut({row, place});
  }
}

}  // namespace leeway::collision
