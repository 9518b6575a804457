// Scenes that differ from another scene in a few bodies.

#include <algorithm>
#include <iterator>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/scene/scene_access.h"
#include "collision/scene/scene_checks.h"

namespace leeway::collision {
namespace {

[[noreturn]] void refuse(const std::string& what) {
  throw std::invalid_argument("scene: " + what + " is expected");
}

}  // namespace

bool SceneChange::isAdded(int body) const {
  const std::size_t before = scene_.bodies().size();
  if (used_again_.count(body) != 0) return true;
  return body >= 0 && at(body) >= before && at(body) < before + bodies_.size();
}

/// The number of a removed body that a change had added; -1: none has as many geometries and balls.
int SceneChange::numberToUse(const Body& like) const {
  const Bodies bodies = scene_.bodies();
  const auto first = static_cast<int>(scene_.things_->bodies.size());
  if (scene_.pairs_.places_ == 0 || first < scene_.pairs_.firstStill()) return -1;
  const auto fits = [&](int body) {
    return body >= first && bodies[at(body)].geometries.size() == like.geometries.size() &&
           bodies[at(body)].size() == like.size() && used_again_.count(body) == 0;
  };
  const auto found = std::find_if(removed_.begin(), removed_.end(), fits);
  if (found != removed_.end()) return *found;
  const std::vector<int>& before = scene_.removed_;
  const auto earlier =
      std::find_if(std::lower_bound(before.begin(), before.end(), first), before.end(), fits);
  return earlier == before.end() ? -1 : *earlier;
}

void SceneChange::requireStill(int body) const {
  const Bodies bodies = scene_.bodies();
  if (body < 0 || at(body) >= bodies.size() || bodies[at(body)].moving || scene_.isRemoved(body) ||
      std::find(removed_.begin(), removed_.end(), body) != removed_.end())
    refuse("body " + std::to_string(body) +
           " is removed; one of the scene before, which stands still and was not removed,");
}

void SceneChange::remove(int body) {
  requireStill(body);
  removed_.push_back(body);
}

void SceneChange::removeBalls(int body, std::span<const std::int32_t> balls) {
  requireStill(body);
  const Body& of = scene_.bodies()[at(body)];
  std::vector<std::int32_t>& removed = removed_balls_[body];
  for (const std::int32_t ball : balls) {
    if (ball < 0 || at(ball) >= of.size() - of.geometries.size())
      refuse("ball " + std::to_string(ball) + " of '" + of.name + "' is removed; one from 0 to " +
             std::to_string(of.size() - of.geometries.size()) + ", exclusive,");
    removed.push_back(ball + static_cast<std::int32_t>(of.geometries.size()));
  }
  std::sort(removed.begin(), removed.end());
}

int SceneChange::add(Body body) {
  requirePoses(body);
  requireBalls(body);
  if (body.moving) refuse("'" + body.name + "' moves and is added; a body that stands still");
  if (const int number = numberToUse(body); number >= 0) {
    used_again_.emplace(number, std::move(body));
    return number;
  }
  bodies_.push_back(std::move(body));
  return static_cast<int>(scene_.bodies().size() + bodies_.size()) - 1;
}

std::pair<int, int> SceneChange::movingAndAdded(int body_a, int body_b) const {
  const int moving = isAdded(body_a) ? body_b : body_a, added = isAdded(body_a) ? body_a : body_b;
  if (!isAdded(added) || moving < 0 || at(moving) >= scene_.bodies().size() ||
      !scene_.bodies()[at(moving)].moving)
    refuse("something is said of the bodies " + std::to_string(body_a) + " and " +
           std::to_string(body_b) + "; one that moves and one that this change adds");
  return {moving, added};
}

void SceneChange::allow(int body_a, int body_b) { allowed_.insert(movingAndAdded(body_a, body_b)); }

void SceneChange::setDefaultMargin(double margin) {
  requireMargin(margin);
  default_margin_ = margin;
}

void SceneChange::setMargin(int body_a, int body_b, double margin) {
  requireMargin(margin);
  margins_[movingAndAdded(body_a, body_b)] = margin;
}

Scene SceneChange::build() && {
  removePairs();
  if (!bodies_.empty() || !used_again_.empty()) {
    const std::size_t first = scene_.bodies().size();
    const Scene::Things& built = *scene_.things_;
    auto added = scene_.added_ ? std::make_shared<Scene::Things>(*scene_.added_)
                               : std::make_shared<Scene::Things>();
    for (auto& [number, body] : used_again_)
      added->replace(at(number) - built.bodies.size(), std::move(body));
    for (Body& body : bodies_) added->add(std::move(body), built.size + added->size);
    scene_.added_ = std::move(added);
    useAgain();
    if (!bodies_.empty()) addPairs(first);
  }
  scene_.pairs_.count();
  return std::move(scene_);
}

void SceneChange::removePairs() {
  if (removed_.empty() && removed_balls_.empty()) return;
  std::sort(removed_.begin(), removed_.end());
  std::vector<int> all;
  std::merge(scene_.removed_.begin(), scene_.removed_.end(), removed_.begin(), removed_.end(),
             std::back_inserter(all));
  scene_.removed_ = std::move(all);  // with those whose numbers are used again
  ScenePairs& pairs = scene_.pairs_;
  const auto isRemoved = [&](int body) {
    return std::binary_search(removed_.begin(), removed_.end(), body);
  };
  const auto isRemovedBall = [&](int body, std::int32_t geometry) {
    const auto of = removed_balls_.find(body);
    return of != removed_balls_.end() &&
           std::binary_search(of->second.begin(), of->second.end(), geometry);
  };
  std::erase_if(pairs.listed_, [&](const ScenePair& pair) {
    return isRemoved(pair.body_a) || isRemoved(pair.body_b) ||
           isRemovedBall(pair.body_b, pair.geometry_b);
  });
  if (pairs.places_ == 0) return;
  const int first = SceneAccess::geometryIndex(scene_, pairs.firstStill(), 0);
  const auto placeOf = [&](int body) {
    return at(SceneAccess::geometryIndex(scene_, body, 0) - first);
  };
  for (const int body : removed_)
    for (std::size_t g = 0; body >= pairs.firstStill() && g < scene_.bodies()[at(body)].size(); ++g)
      pairs.clearPlace(placeOf(body) + g);
  for (const auto& [body, balls] : removed_balls_)
    for (std::size_t i = 0; body >= pairs.firstStill() && i < balls.size(); ++i)
      pairs.clearPlace(placeOf(body) + at(balls[i]));
}

std::optional<double> SceneChange::marginOf(int moving, std::size_t added) const {
  const std::pair<int, int> pair{moving, static_cast<int>(added)};
  if (allowed_.count(pair) != 0) return std::nullopt;
  const auto found = margins_.find(pair);
  return found == margins_.end() ? default_margin_ : found->second;
}

/// Gives the bodies that have numbers of removed ones their pairs with all that moves.
void SceneChange::useAgain() {
  if (used_again_.empty()) return;
  ScenePairs& pairs = scene_.pairs_;
  std::erase_if(scene_.removed_, [&](int body) { return used_again_.count(body) != 0; });
  const int first = SceneAccess::geometryIndex(scene_, pairs.firstStill(), 0);
  for (const auto& [number, moved_from] : used_again_) {
    requireNoHalfSpaces(at(number));
    const std::size_t place = at(SceneAccess::geometryIndex(scene_, number, 0) - first);
    for (std::size_t g = 0; g < scene_.bodies()[at(number)].size(); ++g) {
      pairs.restorePlace(place + g);
      for (std::size_t row = 0; row < pairs.rows_.size(); ++row)
        pairs.set({row, place + g}, marginOf(pairs.rows_[row].body, at(number)));
    }
  }
  scene_.findAddedStill();
}

/// Refuses a body with a half-space that has a pair with another.
void SceneChange::requireNoHalfSpaces(std::size_t body) const {
  const Bodies bodies = scene_.bodies();
  const std::vector<Geometry>& of = bodies[body].geometries;
  if (std::none_of(of.begin(), of.end(), [](const Geometry& g) { return isHalfSpace(g); })) return;
  for (const ScenePairs::Row& a : scene_.pairs_.rows_)
    if (isHalfSpace(bodies[at(a.body)], at(a.geometry)) && marginOf(a.body, body))
      refuseHalfSpaces(bodies[at(a.body)], bodies[body]);
}

/// Adds pairs of the bodies from `first` on with all moving bodies.
void SceneChange::addPairs(std::size_t first) {
  ScenePairs& pairs = scene_.pairs_;
  const Bodies bodies = scene_.bodies();
  if (pairs.places_ == 0) {
    pairs.first_still_ = static_cast<int>(first);
    pairs.rows_.clear();
    for (std::size_t b = 0; b < first; ++b)
      for (std::size_t g = 0; bodies[b].moving && g < bodies[b].geometries.size(); ++g)
        pairs.rows_.push_back(
            {static_cast<std::int32_t>(b), static_cast<std::int32_t>(g), default_margin_});
  }
  for (std::size_t b = first; b < bodies.size(); ++b) requireNoHalfSpaces(b);
  addPlaces(first);
}

/// Adds places for the geometries of bodies from `first` on, and exceptions for their pairs.
void SceneChange::addPlaces(std::size_t first) {
  ScenePairs& pairs = scene_.pairs_;
  const Bodies bodies = scene_.bodies();
  const std::size_t first_place = pairs.places_;
  std::size_t count = 0;
  bool is_one_each = pairs.geometries_.empty();
  for (std::size_t b = first; b < bodies.size(); ++b) {
    count += bodies[b].size();
    is_one_each = is_one_each && bodies[b].size() == 1;
  }
  if (pairs.rows_.empty() || count == 0) {
    if (first_place == 0) pairs.rows_.clear();
    return;
  }
  requireNumbers(pairs.rows_.size(), first_place + count);
  if (!is_one_each) {
    if (pairs.geometries_.empty()) {
      std::vector<ScenePairs::Geometry> before;
      before.reserve(first_place + count);
      for (std::size_t place = 0; place < first_place; ++place)
        before.push_back(pairs.geometryIn(place));
      pairs.geometries_ = std::move(before);
    }
    for (std::size_t b = first; b < bodies.size(); ++b)
      for (std::size_t g = 0; g < bodies[b].size(); ++g)
        pairs.geometries_.push_back({static_cast<std::int32_t>(b), static_cast<std::int32_t>(g)});
  }
  pairs.places_ += count;
  for (std::size_t row = 0; row < pairs.rows_.size(); ++row) {
    std::size_t place = first_place;
    for (std::size_t b = first; b < bodies.size(); ++b) {
      const std::optional<double> margin = marginOf(pairs.rows_[row].body, b);
      const std::size_t end = place + bodies[b].size();
      // New places have no exceptions yet.
      if (ScenePairs::isUsual(pairs.rows_[row], margin)) place = end;
      for (; place < end; ++place) pairs.set({row, place}, margin);
    }
  }
  scene_.findAddedStill();
}

}  // namespace leeway::collision
