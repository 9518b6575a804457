#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <mutex>
#include <numbers>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/scene/scene_access.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "planner/compiled/edge_model.h"
#include "planner/compiled/prepared_robot.h"
#include "planner/compiled/robot_pairs.h"
#include "planner/edge/edge_frames.h"
#include "planner/edge/edge_lanes.h"
#include "planner/edge/why_undecided.h"
#include "planner/validate/checks.h"
#include "robots/model/same_robot.h"

namespace leeway::planner {
namespace {

bool hasShapes(const Object& object) {
  return !object.geometries.empty() || (object.cloud && !object.cloud->balls.empty());
}

/// Returns an object as a body, which shares the cloud's balls.
collision::Body bodyOf(const Object& object) {
  collision::Body body{object.name, object.geometries, false, object.X_WO};
  if (object.cloud && !object.cloud->balls.empty())
    body.balls = {object.cloud, &object.cloud->balls};
  return body;
}

/// The data that a problem adds to its robot: objects of the world, and rules for pairs by name.
class Surroundings {
 public:
  Surroundings(const Problem& problem, const PreparedRobot& robot, const robots::Stop& stop)
      : problem_(problem), robot_(robot), words_(problem), builder_(robot.scene()) {
    names_matter_ = !problem.margins.pairs.empty();
    addObjects(stop);
    if (names_matter_) listNames();
    allow();
    builder_.setDefaultMargin(problem.margins.common);
    setMargins();
  }

  collision::Scene build() && {
    try {
      return std::move(builder_).build();
    } catch (const std::invalid_argument& error) {
      throw robots::InputError(problem_.name, 0, error.what());
    }
  }

  /// Pairs of the robot, and pairs with the world that the problem allows.
  std::shared_ptr<const std::vector<CompiledScene::Dropped>> dropped() const {
    return dropped_ ? dropped_ : robot_.dropped();
  }
  /// Parts of the problem that have no effect.
  std::vector<std::string> takeWarnings() { return std::move(warnings_); }
  /// The number of bodies that are objects; those of deforming obstacles follow.
  int objects() const {
    return static_cast<int>(objects_.size() - problem_.world.deforming.size());
  }

 private:
  int carried() const { return static_cast<int>(robot_.scene().bodies().size()); }

  void addObjects(const robots::Stop& stop) {
    const std::size_t most = problem_.world.objects.size() + problem_.world.deforming.size();
    // Objects that move are added by a change, so that they can move at the cost of their number.
    builder_.reserve(most);
    objects_.reserve(most);
    std::size_t added = 0;
    const auto addOne = [&](const Object& object) {
      if (++added % 1024 == 0) robots::throwIfStopped(stop, "the problem was compiled");
      add(object);
    };
    for (const Object& o : problem_.world.objects)
      if (!o.motion) addOne(o);
    for (const DeformingObstacle& o : problem_.world.deforming) addOne(o.object);
  }

  void add(const Object& object) {
    if (!hasShapes(object)) {
      if (!isNamed(object.name))
        warnings_.push_back(
            fmt::format("object '{}' has no shape: nothing is checked against it", object.name));
      return;
    }
    objects_.push_back(&object);
    names_matter_ = names_matter_ || robot_.isAllowedName(object.name);
    builder_.add(bodyOf(object));
  }

  /// Whether margins, wishes or contacts mention the name. O(pairs).
  bool isNamed(const std::string& name) const {
    const auto isIn = [&](const auto& pair) { return pair.first == name || pair.second == name; };
    const Margins& margins = problem_.margins;
    return robot_.isAllowedName(name) ||
           std::any_of(margins.pairs.begin(), margins.pairs.end(),
                       [&](const PairMargin& m) { return m.a == name || m.b == name; }) ||
           std::any_of(margins.wishes.begin(), margins.wishes.end(), [&](const Wish& wish) {
             return std::any_of(wish.pairs.begin(), wish.pairs.end(), isIn);
           });
  }

  void listNames() {
    const auto bodies = robot_.scene().bodies();
    for (std::size_t i = 0; i < bodies.size(); ++i)
      named_[bodies[i].name].push_back(static_cast<int>(i));
    for (std::size_t i = 0; i < objects_.size(); ++i)
      named_[objects_[i]->name].push_back(carried() + static_cast<int>(i));
  }
  std::span<const int> named(const std::string& name) const {
    const auto found = named_.find(name);
    return found == named_.end() ? std::span<const int>() : found->second;
  }

  /// The bodies that a name or keyword in margins stands for. Contacts have no such keywords.
  std::vector<int> namedInMargins(const std::string& name) const {
    const bool is_robot = words_.robot && name == kRobotWord;
    if (!is_robot && !(words_.world && name == kWorldWord)) {
      const std::span<const int> bodies = named(name);
      return {bodies.begin(), bodies.end()};
    }
    std::vector<int> all(is_robot ? at(carried()) : objects_.size());
    std::iota(all.begin(), all.end(), is_robot ? 0 : carried());
    return all;
  }

  void setMargins() {
    std::map<std::string_view, bool> groups;  // by name, whether one of its pairs is checked
    for (const PairMargin& m : problem_.margins.pairs) {
      std::string reason;  // why no pair of these names is checked
      bool is_checked = false;
      const std::vector<int> others = namedInMargins(m.b);
      for (const int i : namedInMargins(m.a))
        for (const int j : others) {
          if (i == j) continue;  // a group may contain both
          builder_.setMargin(i, j, m.margin);
          if (!is_checked) reason = reasonOf(i, j);
          is_checked = is_checked || reason.empty();
        }
      if (!m.group.empty())
        groups[m.group] |= is_checked || isToCome(m.a) || isToCome(m.b);
      else if (!is_checked && !isToCome(m.a) && !isToCome(m.b))
        warnings_.push_back(
            fmt::format("the margin of '{}' and '{}' has no effect: the pair is not checked ({})",
                        m.a, m.b, reason.empty() ? "without a shape" : reason));
    }
    for (const auto& [group, is_checked] : groups)
      if (!is_checked)
        warnings_.push_back(
            fmt::format("the margin of {} has no effect: none of its pairs is checked", group));
  }
  /// The reason why a pair of bodies is not checked; empty: it is checked. O(1), except for two
  /// bodies of the robot.
  std::string reasonOf(int i, int j) {
    const auto bodies = robot_.scene().bodies();
    const int a = std::min(i, j), b = std::max(i, j);
    if (a >= carried()) return "neither moves";
    if (b >= carried()) {
      if (!bodies[at(a)].moving) return "neither moves";
      const auto allowed = allowed_.find({a, b});
      return allowed == allowed_.end() ? "" : toString(allowed->second);
    }
    if (reasons_.empty())
      for (const CompiledScene::Dropped& d : *robot_.dropped()) reasons_[{d.a, d.b}] = d.reason;
    const auto found = reasons_.find({bodies[at(a)].name, bodies[at(b)].name});
    return found == reasons_.end() ? std::string() : std::string(found->second);
  }
  /// An object without a shape, which may still be added.
  bool isToCome(const std::string& name) const {
    if (words_.world && name == kWorldWord) return objects_.empty();
    return namedInMargins(name).empty() && problem_.robot.model->findLink(name) < 0;
  }

  /// Contacts of the robot with the world that the problem or the SRDF allows. Contacts between
  /// objects of the world need no reason, and there may be many of them.
  void allow() {
    if (names_matter_)
      for (const auto& [x, y] : problem_.contacts.allowed)
        for (const int i : named(x))
          for (const int j : named(y))
            if ((i < carried()) != (j < carried()))
              allowed_.emplace(std::minmax(i, j), Unchecked::kAllowed);
    for (const int i : robot_.uncheckedBodies())
      for (int j = 0; j < static_cast<int>(objects_.size()); ++j)
        allowed_.emplace(std::pair(i, carried() + j), Unchecked::kSrdf);
    if (allowed_.empty()) return;
    const std::vector<CompiledScene::Dropped>& of_robot = *robot_.dropped();
    std::vector<CompiledScene::Dropped> dropped;
    auto next = allowed_.begin();
    std::size_t d = 0;
    for (int i = 0; i < carried(); ++i) {
      for (; d < robot_.droppedEnd(i); ++d) dropped.push_back(of_robot[d]);
      for (; next != allowed_.end() && next->first.first == i; ++next) {
        const auto& [pair, why] = *next;
        builder_.allow(i, pair.second);
        dropped.push_back({robot_.scene().bodies()[at(i)].name,
                           objects_[at(pair.second - carried())]->name, why});
      }
    }
    dropped.insert(dropped.end(), of_robot.begin() + static_cast<std::ptrdiff_t>(d),
                   of_robot.end());
    dropped_ = std::make_shared<const std::vector<CompiledScene::Dropped>>(std::move(dropped));
  }

  const Problem& problem_;
  const PreparedRobot& robot_;
  MarginWords words_;
  collision::SceneBuilder builder_;
  std::vector<const Object*> objects_;  // with geometries
  bool names_matter_;  // bodies are listed by name only if names matter, because there may be many
  std::unordered_map<std::string, std::vector<int>> named_;  // bodies by name
  std::map<std::pair<int, int>, Unchecked> allowed_;  // pairs of a robot body and a world body
  std::map<std::pair<std::string_view, std::string_view>, std::string_view> reasons_;
  std::shared_ptr<const std::vector<CompiledScene::Dropped>> dropped_;
  std::vector<std::string> warnings_;
};

using BodiesByName = std::multimap<std::string_view, int>;

/// Calls visit(i, j) for bodies of the robot and of the world that have the two names, or that
/// `words` stand for, in either order. O(log of both + calls).
template <class Visit>
void forEachNamed(const BodiesByName& robot, const BodiesByName& world, const std::string& a,
                  const std::string& b, const Visit& visit, const MarginWords* words = nullptr) {
  const auto find = [](const BodiesByName& bodies, const std::string& name, bool all) {
    return all ? std::pair(bodies.begin(), bodies.end()) : bodies.equal_range(name);
  };
  for (const auto& [x, y] : {std::pair(&a, &b), std::pair(&b, &a)}) {
    const auto [i, i_end] = find(robot, *x, words && words->robot && *x == kRobotWord);
    const auto [j, j_end] = find(world, *y, words && words->world && *y == kWorldWord);
    for (auto r = i; r != i_end; ++r)
      for (auto w = j; w != j_end; ++w) visit(r->second, w->second);
  }
}

std::shared_ptr<const EdgeModel> makeEdgeModel(std::shared_ptr<const PreparedRobot> robot) {
  auto model = std::make_shared<EdgeModel>();
  const RobotMotions& motions = robot->motions();
  model->pairs = motions.pairs;
  model->motions = motions.motions;
  model->gaps = motions.gaps;
  model->rounding = motions.rounding;
  model->reach = motions.reach;
  model->jumping_circles = motions.jumping_circles;
  model->robot = std::move(robot);
  return model;
}

}  // namespace

/// The rules of a problem for its world, in addition to the contacts that a PreparedRobot has.
struct CompiledScene::NamedRules {
  std::string problem;  // its name, for messages
  Margins margins;
  double most_margin;  // mostMargin()
  double kept;         // keptClearance()
  MarginWords words;
  double execution_start;
  int objects;                               // bodies of its objects, after those of the robot
  std::vector<DeformingObstacle> deforming;  // whose bodies come next
  /// The compiled world's bodies by name, created for the first change.
  struct Index {
    std::once_flag once;
    std::unique_ptr<const NameTable> names;
  };
  std::shared_ptr<Index> index = std::make_shared<Index>();
  /// Objects whose clouds were cropped or carved for the place where they stand.
  std::set<std::string> fitted = {};
  /// Objects with clouds of which a ball may stand for several points, and bodies of such clouds
  /// that were seen in regions of others (Part::body).
  std::set<std::string> thinned = {};
  std::set<int> thinned_parts = {};
  /// PointCloud::completeWithin() of all clouds, and of those that were removed since [m].
  double complete_within = kInfinity;
  std::string grasp = {};  // firstGrasp()
  /// The bodies of objects that have a motion, and where these stand at the start of the execution.
  std::map<int, robots::Pose> moving = {};
  /// Forgets the bodies of a cloud of which regions were renewed.
  void dropParts(const std::string& name) {
    for (const Part& part : parts[name]) thinned_parts.erase(part.body);
    parts.erase(name);
  }
  /// The bodies of clouds of which regions were renewed, by the object's name; see partsOf().
  std::map<std::string, std::vector<Part>> parts = {};

  /// Enters the cloud of an object.
  void note(const Object& object) {
    const auto enter = [&](std::set<std::string>& names, bool is_one) {
      if (is_one)
        names.insert(object.name);
      else
        names.erase(object.name);
    };
    enter(fitted, isFitted(object));
    enter(thinned, object.cloud && object.cloud->isThinned());
    if (object.cloud) complete_within = std::min(complete_within, object.cloud->completeWithin());
  }
};

CompiledScene::CompiledScene(const Problem& problem, const robots::Stop& stop)
    : model_((validate(problem), problem.robot.model)),
      space_(std::make_shared<ConfigurationSpace>(problem.robot.model, problem.robot.variables)),
      base_configuration_(problem.start) {
  const std::shared_ptr<const PreparedRobot> robot = PreparedRobot::of(problem, *space_, stop);
  Surroundings world(problem, *robot, stop);
  dropped_ = world.dropped();
  NamedRules rules{problem.name,           problem.margins,        mostMargin(problem),
                   keptClearance(problem), MarginWords(problem),   problem.execution.start,
                   world.objects(),        problem.world.deforming};
  for (const Object& object : problem.world.objects) rules.note(object);
  rules.grasp = firstGrasp(problem);
  rules_ = std::make_shared<const NamedRules>(std::move(rules));
  std::vector<std::string> warnings = robot->warnings();
  // Later steps may change the objects that have no effect now.
  if (problem.steps.empty())
    for (std::string& warning : world.takeWarnings()) warnings.push_back(std::move(warning));
  if (!warnings.empty())
    warnings_ = std::make_shared<const std::vector<std::string>>(std::move(warnings));
  robots::throwIfStopped(stop, "the problem was compiled");
  scene_ = std::move(world).build();
  edge_model_ = makeEdgeModel(robot);
  // Moving bodies have the poses of the start.
  std::vector<robots::Pose> X_WL(model_->links.size());
  robots::forwardKinematics(*model_, problem.start, X_WL);
  body_link_.assign(robot->carriers().size(), -1);
  for (std::size_t b = 0; b < robot->carriers().size(); ++b) {
    if (!scene_.bodies()[b].moving) continue;
    body_link_[b] = robot->carriers()[b];
    collision::SceneAccess::place(scene_, static_cast<int>(b), X_WL[at(body_link_[b])]);
  }
  if (std::isfinite(rules_->kept))
    collision::SceneAccess::raiseMargins(scene_, rules_->kept, bodiesOfRobot());
  std::vector<Object> moving;
  for (const Object& object : problem.world.objects)
    if (object.motion) moving.push_back(object);
  if (!moving.empty()) *this = *changed(moving, {});
}

struct CompiledScene::Shared {
  std::once_flag edges_once, lanes_once;
  std::unique_ptr<const EdgeScene> edges;
  std::unique_ptr<const SceneLanes> lanes;
};

CompiledScene::OwnShared::OwnShared() : made(std::make_shared<Shared>()) {}

CompiledScene::OwnShared& CompiledScene::OwnShared::operator=(const OwnShared& other) {
  if (this != &other) made = std::make_shared<Shared>();
  return *this;
}

const EdgeScene& CompiledScene::edges() const {
  Shared& shared = *shared_.made;
  std::call_once(shared.edges_once,
                 [&] { shared.edges = std::make_unique<const EdgeScene>(*this); });
  return *shared.edges;
}

const SceneLanes& CompiledScene::lanes() const {
  Shared& shared = *shared_.made;
  std::call_once(shared.lanes_once,
                 [&] { shared.lanes = std::make_unique<const SceneLanes>(*this, edges()); });
  return *shared.lanes;
}

double CompiledScene::completeWithin() const { return rules_->complete_within; }

int CompiledScene::findThing(const std::string& name) const {
  const auto nameOf = [this](int body) -> std::string_view {
    return scene_.bodies()[at(body)].name;
  };
  const int compiled = worldEnd();
  NamedRules::Index& index = *rules_->index;
  std::call_once(index.once, [&] {
    auto names = std::make_unique<NameTable>(at(compiled));
    for (int body = 0; body < compiled; ++body) names->insert(body, nameOf(body), nameOf);
    index.names = std::move(names);
  });
  const int found = index.names->numberOf(name, nameOf);
  if (found >= 0 && !scene_.isRemoved(found)) return found;
  for (int body = compiled; at(body) < scene_.bodies().size(); ++body)
    if (nameOf(body) == name && !scene_.isRemoved(body)) return body;
  return -1;
}

int CompiledScene::worldEnd() const {
  return bodiesOfRobot() + rules_->objects + static_cast<int>(rules_->deforming.size());
}

BodiesByName CompiledScene::addTo(collision::SceneChange& change, std::span<const Object> added,
                                  std::span<const int> removed) const {
  std::set<std::string_view> names;
  BodiesByName bodies;
  const auto needs = [this]() -> CropNeeds {
    const auto attachments = edge_model_->robot->attachments();
    Problem alone;
    alone.robot.model = model_;
    alone.robot.variables.assign(space_->variables().begin(), space_->variables().end());
    alone.robot.attachments.assign(attachments.begin(), attachments.end());
    alone.start = base_configuration_;
    return {rules_->most_margin, robotReach(alone), rules_->grasp};
  };
  for (const Object& object : added) {
    if (const std::string fault = objectFault(object); !fault.empty())
      throw std::invalid_argument(fault);
    if (object.cloud && !object.cloud->crops.empty())
      if (const std::string fault = cropFault(object, needs()); !fault.empty())
        throw std::invalid_argument(fault);
    const int other = findThing(object.name);
    const bool goes = std::find(removed.begin(), removed.end(), other) != removed.end();
    const bool is_taken = object.name.empty() || !names.insert(object.name).second ||
                          (other >= 0 && !goes) || model_->findLink(object.name) >= 0;
    if (const std::string fault = objectNameFault(object.name, is_taken); !fault.empty())
      throw std::invalid_argument(fmt::format("object '{}' {}", object.name, fault));
    if (hasShapes(object)) bodies.emplace(object.name, change.add(bodyOf(object)));
  }
  return bodies;
}

std::shared_ptr<const CompiledScene> CompiledScene::withObjects(
    std::span<const Object> added, std::span<const int> removed) const {
  if (is_variant_)
    throw std::invalid_argument(
        "CompiledScene::withObjects(): of a variant with other margins or pairs than the problem "
        "says; the scene that was compiled is expected");
  for (const Object& object : added)
    if (object.motion)
      throw robots::InputError(
          rules_->problem, 0,
          fmt::format("CompiledScene::withObjects(): object '{}' has a motion; an object that "
                      "stands still is expected, or a problem with this one to compile",
                      object.name));
  return changed(added, removed);
}

std::vector<CompiledScene::Part> CompiledScene::partsOf(int body) const {
  const auto found = rules_->parts.find(scene_.bodies()[at(body)].name);
  return found == rules_->parts.end() ? std::vector<Part>{{body, nullptr}} : found->second;
}

std::vector<collision::Ball> CompiledScene::ballsOf(std::span<const Part> parts) const {
  std::vector<collision::Ball> balls;
  for (const Part& part : parts)
    if (const auto& of = scene_.bodies()[at(part.body)].balls)
      for (std::size_t b = 0; b < of->size(); ++b)
        if (part.has(b)) balls.push_back((*of)[b]);
  return balls;
}

std::shared_ptr<CompiledScene> CompiledScene::changed(std::span<const Object> added,
                                                      std::span<const int> removed_first) const {
  auto changed = std::make_shared<CompiledScene>(*this);
  std::vector<int> removed;  // with the other bodies of their objects
  for (const int body : removed_first) {
    if (body < 0 || at(body) >= scene_.bodies().size()) {
      removed.push_back(body);  // refused below
      continue;
    }
    for (const Part& part : partsOf(body)) removed.push_back(part.body);
  }
  changed->pairs_token_ = std::make_shared<const int>();
  const auto changeRules = [&](const auto& change) {
    NamedRules rules = *changed->rules_;
    change(rules);
    changed->rules_ = std::make_shared<const NamedRules>(std::move(rules));
  };
  for (const Object& object : added)
    if (isFitted(object) || rules_->fitted.count(object.name) != 0 ||
        (object.cloud && object.cloud->isThinned()) || rules_->thinned.count(object.name) != 0)
      changeRules([&](NamedRules& rules) { rules.note(object); });
  for (const int body : removed)
    if (rules_->moving.count(body) != 0)
      changeRules([&](NamedRules& rules) { rules.moving.erase(body); });
  for (const int body : removed_first)
    if (body >= 0 && at(body) < scene_.bodies().size() &&
        rules_->parts.count(scene_.bodies()[at(body)].name) != 0)
      changeRules([&](NamedRules& rules) { rules.dropParts(scene_.bodies()[at(body)].name); });
  collision::SceneChange change(std::move(changed->scene_));
  std::set<std::string> removed_names;
  for (const int body : removed) {
    if (isOfRobot(body))
      throw std::invalid_argument("CompiledScene::withObjects(): body " + std::to_string(body) +
                                  " is the robot's; an object's number is expected, from " +
                                  std::to_string(bodiesOfRobot()) + " on");
    change.remove(body);
    removed_names.insert(scene_.bodies()[at(body)].name);
  }
  try {
    const BodiesByName objects = addTo(change, added, removed);
    for (const Object& object : added)
      if (const auto body = objects.find(object.name); object.motion && body != objects.end())
        changeRules([&](NamedRules& rules) { rules.moving[body->second] = object.X_WO; });
    change.setDefaultMargin(std::max(rules_->margins.common, rules_->kept));
    changed->dropped_ = applyRules(objects, removed_names, change);
    changed->scene_ = std::move(change).build();
  } catch (const std::invalid_argument& error) {
    throw robots::InputError(rules_->problem, 0, error.what());
  }
  return changed;
}

std::shared_ptr<const CompiledScene> CompiledScene::withObjectAt(const std::string& name,
                                                                 const robots::Pose& X_WO) const {
  const int body = findThing(name);
  const int deforming = bodiesOfRobot() + rules_->objects;
  const bool is_moving = rules_->moving.count(body) != 0;
  if (body < bodiesOfRobot() || is_moving || (body >= deforming && body < worldEnd()))
    throw std::invalid_argument(
        fmt::format("CompiledScene::withObjectAt(): '{}' is {}; the name of an object of the world "
                    "that stands still is expected",
                    name,
                    body < bodiesOfRobot() ? "no object"
                    : is_moving            ? "an object with a motion"
                                           : "a deforming obstacle"));
  if (rules_->fitted.count(name) != 0)
    throw std::invalid_argument(fmt::format(
        "CompiledScene::withObjectAt(): the cloud of '{}' was cropped or carved for its "
        "place; withObjects() with a cloud made for the new one is expected",
        name));
  const collision::Body& before = scene_.bodies()[at(body)];
  Object moved{name, before.geometries, X_WO};
  if (before.balls) {
    auto cloud = std::make_shared<PointCloud>();
    cloud->balls = ballsOf(partsOf(body));
    const auto isThinned = [this](const Part& part) {
      return rules_->thinned_parts.count(part.body) != 0;
    };
    const std::vector<Part> parts = partsOf(body);
    // The record of a filter keeps the fact; nothing reads its count.
    if (rules_->thinned.count(name) != 0 || std::any_of(parts.begin(), parts.end(), isThinned))
      cloud->filters.push_back({"thin", "balls", 1});
    const bool is_empty = cloud->balls.empty();
    // No cloud is made of no balls: it moves with those that it had, and loses them there.
    if (is_empty) cloud->balls = *before.balls;
    moved.cloud = std::move(cloud);
    if (is_empty)
      return withObjects({&moved, 1}, {&body, 1})
          ->withRegion(
              name, {Eigen::Vector3d::Constant(-kInfinity), Eigen::Vector3d::Constant(kInfinity)},
              {});
  }
  return withObjects({&moved, 1}, {&body, 1});
}

std::shared_ptr<const CompiledScene> CompiledScene::withRegion(const std::string& name,
                                                               const CloudRegion& region,
                                                               const PointCloud& seen) const {
  const auto refuse = [](const std::string& why) {
    throw std::invalid_argument("CompiledScene::withRegion(): " + why);
  };
  const int body = findThing(name);
  if (body < bodiesOfRobot() || !scene_.bodies()[at(body)].balls || rules_->moving.count(body) != 0)
    refuse(fmt::format(
        "'{}' is no cloud of the world that has balls and stands still; the name of one is "
        "expected",
        name));
  if (is_variant_)
    refuse(
        "of a variant with other margins or pairs than the problem says; the scene that was "
        "compiled is expected");
  const collision::Bodies bodies = scene_.bodies();
  Object again{name, {}, bodies[at(body)].X_WB};
  if (!seen.balls.empty()) again.cloud = std::make_shared<const PointCloud>(seen);
  for (const std::string& fault : {regionFault(region, seen), objectFault(again)})
    if (!fault.empty()) refuse(fault);

  auto changed = std::make_shared<CompiledScene>(*this);
  changed->pairs_token_ = std::make_shared<const int>();
  collision::SceneChange change(std::move(changed->scene_));
  NamedRules rules = *rules_;
  std::vector<Part> left;
  for (const Part& part : partsOf(body)) {
    const bool is_thinned = part.body == body ? rules_->thinned.count(name) != 0
                                              : rules_->thinned_parts.count(part.body) != 0;
    const collision::Body& of = bodies[at(part.body)];
    std::vector<std::int32_t> gone;
    std::size_t before = 0;
    for (std::size_t b = 0; b < of.balls->size(); ++b) {
      if (!part.has(b)) continue;
      ++before;
      if (region.replaces((*of.balls)[b], is_thinned)) gone.push_back(static_cast<std::int32_t>(b));
    }
    // One body stays, also without balls, because the object does.
    if (gone.size() == before && part.body != body) {
      change.remove(part.body);
      rules.thinned_parts.erase(part.body);
      continue;
    }
    left.push_back(part);
    if (gone.empty()) continue;
    change.removeBalls(part.body, gone);
    auto is_gone = part.is_gone ? std::make_shared<std::vector<char>>(*part.is_gone)
                                : std::make_shared<std::vector<char>>(of.balls->size());
    for (const std::int32_t b : gone) (*is_gone)[at(b)] = 1;
    left.back().is_gone = std::move(is_gone);
  }
  BodiesByName objects;
  if (again.cloud) {
    left.push_back({change.add(bodyOf(again)), nullptr});
    objects.emplace(name, left.back().body);
  }
  if (isFitted(again)) rules.fitted.insert(name);
  if (again.cloud && seen.isThinned()) rules.thinned_parts.insert(left.back().body);
  rules.parts[name] = std::move(left);
  changed->rules_ = std::make_shared<const NamedRules>(std::move(rules));
  change.setDefaultMargin(std::max(rules_->margins.common, rules_->kept));
  if (!objects.empty()) changed->dropped_ = applyRules(objects, {name}, change);
  changed->scene_ = std::move(change).build();
  return changed;
}

std::shared_ptr<const std::vector<CompiledScene::Dropped>> CompiledScene::applyRules(
    const BodiesByName& objects, const std::set<std::string>& removed_names,
    collision::SceneChange& change) const {
  BodiesByName robot;
  for (int i = 0; i < bodiesOfRobot(); ++i) robot.emplace(scene_.bodies()[at(i)].name, i);
  const auto moves = [this](int body) { return scene_.bodies()[at(body)].moving; };
  for (const PairMargin& m : rules_->margins.pairs)
    forEachNamed(
        robot, objects, m.a, m.b,
        [&](int i, int j) {
          if (moves(i)) change.setMargin(i, j, std::max(m.margin, rules_->kept));
        },
        &rules_->words);

  const auto isOfRemoved = [&](const Dropped& d) { return removed_names.count(d.b) != 0; };
  const PreparedRobot& prepared = *edge_model_->robot;
  // There may be many contacts, and none of them may mention these objects.
  if ((prepared.uncheckedBodies().empty() || objects.empty()) &&
      std::none_of(objects.begin(), objects.end(),
                   [&](const auto& o) { return prepared.isAllowedName(std::string(o.first)); }) &&
      std::none_of(dropped_->begin(), dropped_->end(), isOfRemoved))
    return dropped_;
  std::vector<Dropped> dropped;
  std::remove_copy_if(dropped_->begin(), dropped_->end(), std::back_inserter(dropped), isOfRemoved);
  std::set<std::pair<int, int>> allowed;
  const auto allow = [&](int i, int j, const std::string& object, Unchecked why) {
    if (!allowed.emplace(i, j).second) return;
    if (moves(i)) change.allow(i, j);
    dropped.push_back({scene_.bodies()[at(i)].name, object, why});
  };
  for (const auto& names : prepared.contacts().allowed) {
    const std::string &a = names.first, &b = names.second;  // clang 14 captures no bindings
    forEachNamed(robot, objects, a, b, [&](int i, int j) {
      allow(i, j, scene_.bodies()[at(i)].name == a ? b : a, Unchecked::kAllowed);
    });
  }
  for (const int i : prepared.uncheckedBodies())
    for (const auto& [name, j] : objects) allow(i, j, std::string(name), Unchecked::kSrdf);
  return std::make_shared<const std::vector<Dropped>>(std::move(dropped));
}

std::string CompiledScene::nothingChecked() const {
  if (!scene_.pairs().empty()) return {};
  bool can_move = false;
  for (int b = 0; b < bodiesOfRobot(); ++b) can_move = can_move || scene_.bodies()[at(b)].moving;
  if (!can_move) return kNothingMoves;
  // A robot with shapes that is alone cannot collide. (Removed objects keep their numbers.)
  if (std::none_of(dropped().begin(), dropped().end(),
                   [&](const Dropped& d) { return scene_.find(d.b) >= bodiesOfRobot(); }))
    return {};
  return "no pair with the world is checked; " + toString(countUnchecked(dropped()));
}

std::string whyUndecided(const CompiledScene& scene, std::span<const double> point) {
  const robots::Model& model = scene.model();
  for (const EdgeModel::JumpingCircle circle : scene.edgeModel().jumping_circles) {
    const double value = point[at(circle.place)];
    if (value >= -std::numbers::pi && value < std::numbers::pi) continue;
    const std::string& name = model.variables[at(scene.space().variables()[at(circle.place)])].name;
    return fmt::format(
        "joint {} mimics {} and would jump where that wraps around; {} is {}, and a value from -pi "
        "to pi is expected",
        model.joints[at(circle.mimic)].name, name, name, value);
  }
  return {};
}

std::shared_ptr<CompiledScene> CompiledScene::variant() const {
  auto other = std::make_shared<CompiledScene>(*this);
  other->is_variant_ = true;
  return other;
}

std::shared_ptr<const CompiledScene> CompiledScene::withShapes(
    std::span<const Replacement> shapes) const {
  auto changed = std::make_shared<CompiledScene>(*this);
  const auto bodies = scene_.bodies();
  std::vector<std::pair<int, robots::Pose>> poses;
  for (const Replacement& r : shapes) {
    if (const auto* X_WB = std::get_if<robots::Pose>(&r.now)) {
      if (rules_->moving.count(r.body) == 0 || r.geometry != 0)
        throw std::invalid_argument(fmt::format(
            "CompiledScene::withShapes(): geometry {} of body {} gets a pose; geometry 0 of an "
            "object with a motion is expected",
            r.geometry, r.body));
      poses.emplace_back(r.body, *X_WB);
      continue;
    }
    const int first = bodiesOfRobot() + rules_->objects;
    if (r.body < first || r.body >= worldEnd() || r.geometry != 0)
      throw std::invalid_argument(fmt::format(
          "CompiledScene::withShapes(): geometry {} of body {}{} is no deforming obstacle; "
          "geometry "
          "0 of a body from {} to {} is expected",
          r.geometry, r.body,
          r.body >= 0 && at(r.body) < bodies.size() ? " ('" + bodies[at(r.body)].name + "')" : "",
          first, worldEnd() - 1));
    const auto& shape = std::get<collision::Shape>(r.now);
    const collision::DeformableSnapshot* snapshot = shape.deformable();
    const DeformingObstacle& obstacle = rules_->deforming[at(r.body - first)];
    if (snapshot == nullptr || &snapshot->mesh() != obstacle.mesh.get())
      throw std::invalid_argument(
          fmt::format("CompiledScene::withShapes(): '{}' gets another shape; a snapshot of its own "
                      "mesh is expected",
                      obstacle.object.name));
    changed->scene_.setShape(r.body, r.geometry, shape);
  }
  changed->scene_.setPoses(poses);
  for (const Replacement& r : shapes) {
    if (r.growth < 0)
      throw std::invalid_argument(
          fmt::format("CompiledScene::withShapes(): the growth of body {} is {}; at least 0 m is "
                      "expected",
                      r.body, r.growth));
    if (r.growth == 0) continue;  // NaN grows, too: such a pair is never free
    changed->is_variant_ = true;
    for (std::size_t g = 0; g < bodies[at(r.body)].size(); ++g)
      changed->scene_.growMargins(r.body, static_cast<int>(g), r.growth);
  }
  return changed;
}

namespace {

void requireMargin(const char* call, double margin) {
  if (std::isnan(margin))
    throw std::invalid_argument(
        fmt::format("CompiledScene::{}(): the margin is {}; a number is expected", call, margin));
}

}  // namespace

std::shared_ptr<const CompiledScene> CompiledScene::withMarginAtLeast(double margin) const {
  requireMargin("withMarginAtLeast", margin);
  auto raised = variant();
  raised->scene_.raiseMargins(margin);
  return raised;
}

std::shared_ptr<const CompiledScene> CompiledScene::withWorldMarginAtLeast(double margin) const {
  requireMargin("withWorldMarginAtLeast", margin);
  auto raised = variant();
  collision::SceneAccess::raiseMargins(raised->scene_, margin, bodiesOfRobot());
  return raised;
}

std::shared_ptr<const CompiledScene> CompiledScene::withMarginsGrown(double growth) const {
  if (!(growth >= 0))
    throw std::invalid_argument(fmt::format(
        "CompiledScene::withMarginsGrown(): the growth is {}; zero or more is expected", growth));
  auto grown = variant();
  for (std::size_t body = 0; body < body_link_.size(); ++body)
    if (scene_.bodies()[body].moving)  // one body of every pair is moving
      for (std::size_t g = 0; g < scene_.bodies()[body].geometries.size(); ++g)
        grown->scene_.growMargins(static_cast<int>(body), static_cast<int>(g), growth);
  return grown;
}

std::shared_ptr<const CompiledScene> CompiledScene::withPairs(
    const std::function<bool(const collision::ScenePair&)>& keep) const {
  auto reduced = variant();
  reduced->pairs_token_ = std::make_shared<const int>();
  auto model = std::make_shared<EdgeModel>(*edge_model_);
  model->pairs.clear();
  // keep() is called once per pair. If a second call gave another answer, pairs would get the
  // motions of other pairs, and proofs would not hold.
  auto next = edge_model_->pairs.begin();
  collision::SceneAccess::keepPairs(reduced->scene_, [&](const collision::ScenePair& pair) {
    const bool is_kept = keep(pair);
    reduced->lacks_pairs_ = reduced->lacks_pairs_ || !is_kept;
    if (!isOfRobot(pair)) return is_kept;
    if (is_kept) model->pairs.push_back(*next);
    ++next;
    return is_kept;
  });
  reduced->edge_model_ = std::move(model);
  return reduced;
}

namespace {

/// The difference between an object and a body of the world that stands at X_WB, or starts there
/// if it moves, with these balls; empty: they are equal.
std::string differenceOf(const Object& object, const collision::Body& body,
                         const robots::Pose& X_WB, bool moves,
                         std::span<const collision::Ball> known) {
  if (moves != (object.motion != nullptr)) return moves ? "moves" : "stands still";
  if (!robots::isSamePose(object.X_WO, X_WB)) return "stands elsewhere";
  if (!robots::areSameGeometries(object.geometries, body.geometries)) return "has another shape";
  const std::span<const collision::Ball> balls =
      object.cloud ? object.cloud->balls : std::span<const collision::Ball>();
  const bool is_same = balls.data() == known.data() ||
                       std::equal(balls.begin(), balls.end(), known.begin(), known.end(),
                                  [](const collision::Ball& x, const collision::Ball& y) {
                                    return x.radius == y.radius && x.center == y.center;
                                  });
  return is_same ? "" : "has another cloud";
}

bool areSameWishes(const Margins& x, const Margins& y) {
  return std::equal(x.wishes.begin(), x.wishes.end(), y.wishes.begin(), y.wishes.end(),
                    [](const Wish& m, const Wish& n) { return m.pairs == n.pairs; });
}

}  // namespace

/// Compares the problem's objects with those of the scene: as they were compiled, or as they are
/// now.
std::string CompiledScene::objectsDifference(const Problem& problem) const {
  const auto bodies = scene_.bodies();
  const std::vector<Object>& objects = problem.world.objects;
  const auto ballsIn = [&](std::size_t b) {
    return bodies[b].balls ? std::span<const collision::Ball>(*bodies[b].balls)
                           : std::span<const collision::Ball>();
  };
  int body = bodiesOfRobot();
  const int end = body + rules_->objects;
  const bool is_as_compiled = std::all_of(objects.begin(), objects.end(), [&](const Object& o) {
    if (!hasShapes(o)) return true;
    const std::size_t b = at(body);
    const bool is_same = body < end && o.name == bodies[b].name &&
                         differenceOf(o, bodies[b], bodies[b].X_WB, false, ballsIn(b)).empty();
    ++body;
    return is_same;
  });
  if (is_as_compiled && body == end && rules_->moving.empty()) return {};
  // In any order, after all changes.
  std::size_t left = bodies.size() - at(bodiesOfRobot()) - rules_->deforming.size();
  for (std::size_t b = at(bodiesOfRobot()); b < bodies.size(); ++b)
    if (scene_.isRemoved(static_cast<int>(b))) --left;
  for (const Object& object : objects) {
    const auto parts = rules_->parts.find(object.name);
    const bool is_renewed = parts != rules_->parts.end();
    if (!hasShapes(object) && !is_renewed) continue;
    const int found = findThing(object.name);
    if (found < 0) return fmt::format("the scene has no object '{}'", object.name);
    const auto moving = rules_->moving.find(found);
    const bool moves = moving != rules_->moving.end();
    std::vector<collision::Ball> renewed;
    if (is_renewed) {
      renewed = ballsOf(parts->second);
      left -= parts->second.size() - 1;
    }
    const std::string difference =
        differenceOf(object, bodies[at(found)], moves ? moving->second : bodies[at(found)].X_WB,
                     moves, is_renewed ? renewed : ballsIn(at(found)));
    if (!difference.empty()) return fmt::format("object '{}' {} there", object.name, difference);
    --left;
  }
  if (left == 0) return {};
  for (std::size_t b = at(bodiesOfRobot()); b < bodies.size(); ++b)
    if (!scene_.isRemoved(static_cast<int>(b)) &&
        std::none_of(objects.begin(), objects.end(),
                     [&](const Object& o) { return o.name == bodies[b].name; }))
      return fmt::format("the scene has an object '{}' besides", bodies[b].name);
  return "the scene has other objects";
}

namespace {

std::string differs(const std::string& what) { return what + " differs"; }

}  // namespace

const Margins& CompiledScene::margins() const { return rules_->margins; }

std::string CompiledScene::robotDifference(const Problem& problem) const {
  if (problem.robot.model != model_) return differs("robot.model");
  if (problem.start.size() != base_configuration_.size()) return differs("the size of start");
  for (const int v : problem.robot.variables)
    if (v < 0 || at(v) >= model_->variables.size()) return differs("robot.variables");
  if (const char* part = edge_model_->robot->differenceFrom(problem)) return differs(part);
  for (const Constraint& constraint : problem.constraints) {
    const auto object =
        std::find_if(problem.world.objects.begin(), problem.world.objects.end(),
                     [&](const Object& o) { return o.name == constraint.relative_to; });
    if (object == problem.world.objects.end() || !hasShapes(*object)) continue;
    const int body = findThing(object->name);
    if (body < 0 || !robots::isSamePose(object->X_WO, scene_.bodies()[at(body)].X_WB))
      return fmt::format(
          "object '{}', which constraint '{}' is relative to, stands elsewhere there", object->name,
          constraint.name);
  }
  return {};
}

std::string CompiledScene::differenceFrom(const Problem& problem) const {
  if (std::string difference = robotDifference(problem); !difference.empty()) return difference;
  if (!areSameMargins(rules_->margins, problem.margins)) return differs("margins");
  if (rules_->kept > keptClearance(problem)) return differs("objective, in its clearance,");
  if (!areSameWishes(rules_->margins, problem.margins))
    return differs("margins.wishes, in the pairs that they name,");
  const std::vector<DeformingObstacle>& deforming = problem.world.deforming;
  if (deforming.size() != rules_->deforming.size()) return differs("world.deforming");
  for (std::size_t i = 0; i < deforming.size(); ++i) {
    const Object &mine = rules_->deforming[i].object, &other = deforming[i].object;
    if (mine.name != other.name || rules_->deforming[i].mesh != deforming[i].mesh ||
        !robots::isSamePose(mine.X_WO, other.X_WO) ||
        !robots::areSameGeometries(mine.geometries, other.geometries))
      return differs("world.deforming, at '" + other.name + "',");
  }
  if ((!deforming.empty() || !rules_->moving.empty()) &&
      problem.execution.start != rules_->execution_start)
    return differs("execution.start");
  return objectsDifference(problem);
}

namespace {

void refuseDifference(const Problem& problem, const std::string& difference) {
  if (!difference.empty())
    throw robots::InputError(
        problem.name, 0,
        fmt::format("the problem is not the one that the scene was compiled from: {}; that problem "
                    "is expected, or a scene compiled from this one",
                    difference));
}

}  // namespace

void CompiledScene::requireProblem(const Problem& problem) const {
  refuseDifference(problem, lacks_pairs_ ? "it has some of the pairs only (withPairs())"
                                         : differenceFrom(problem));
  validate(problem);
}

void CompiledScene::requireConstraints(const Problem& problem) const {
  refuseDifference(problem, robotDifference(problem));
  for (std::size_t i = 0; i < problem.constraints.size(); ++i)
    if (const auto fault =
            constraintFault(problem, problem.constraints[i], fmt::format("constraints[{}]", i)))
      throw robots::InputError(problem.name, 0, fault->message);
}

void CompiledScene::expand(std::span<const double> point, std::span<double> q) const {
  std::copy(base_configuration_.begin(), base_configuration_.end(), q.begin());
  const std::span<const int> variables = space_->variables();
  for (std::size_t i = 0; i < variables.size(); ++i) q[at(variables[i])] = point[i];
}

}  // namespace leeway::planner
