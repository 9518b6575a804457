#include "leeway/planner/compiled_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/scene/scene_access.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "planner/edge/edge_frames.h"
#include "planner/edge/edge_lanes.h"
#include "planner/edge/edge_model.h"
#include "planner/edge/prepared_robot.h"
#include "planner/edge/robot_pairs.h"

namespace leeway::planner {
namespace {

constexpr const char* kAllowed = "allowed by the problem";
constexpr const char* kOwnName =
    "has the name of another object or link; a name of its own is expected";

[[noreturn]] void refuseDeforming(const std::string& problem, const std::string& name,
                                  const std::string& message) {
  throw robots::InputError(problem, 0, fmt::format("deforming obstacle '{}' {}", name, message));
}

/// What a problem adds to its robot: objects of the world, and what is said of pairs by name.
class Surroundings {
 public:
  Surroundings(const Problem& problem, const PreparedRobot& robot, const robots::Stop& stop)
      : problem_(problem), robot_(robot), builder_(robot.scene()) {
    names_matter_ = !problem.margins.pairs.empty() || !problem.world.deforming.empty();
    addObjects(stop);
    if (names_matter_) listNames();
    for (const DeformingObstacle& o : problem.world.deforming) expectSnapshot(o);
    allow();
    builder_.setDefaultMargin(problem.margins.common);
    for (const PairMargin& m : problem.margins.pairs)
      for (const int i : named(m.a))
        for (const int j : named(m.b)) builder_.setMargin(i, j, m.margin);
  }

  collision::Scene build() && {
    try {
      return std::move(builder_).build();
    } catch (const std::invalid_argument& error) {
      throw robots::InputError(problem_.name, 0, error.what());
    }
  }

  /// Pairs of the robot, and those that the problem allows with the world.
  std::shared_ptr<const std::vector<CompiledScene::Dropped>> dropped() const {
    return dropped_ ? dropped_ : robot_.dropped();
  }

 private:
  int carried() const { return static_cast<int>(robot_.scene().bodies().size()); }

  void addObjects(const robots::Stop& stop) {
    const std::size_t most = problem_.world.objects.size() + problem_.world.deforming.size();
    builder_.reserve(most);
    objects_.reserve(most);
    std::size_t added = 0;
    const auto addOne = [&](const Object& object) {
      if (++added % 1024 == 0) robots::throwIfStopped(stop, "the problem was compiled");
      add(object);
    };
    for (const Object& o : problem_.world.objects) addOne(o);
    for (const DeformingObstacle& o : problem_.world.deforming) addOne(o.object);
  }

  void add(const Object& object) {
    expectPose(problem_.name, object.X_WO, object.name);
    if (object.geometries.empty()) return;
    objects_.push_back(&object);
    names_matter_ = names_matter_ || robot_.isAllowedName(object.name);
    builder_.add({object.name, object.geometries, false, object.X_WO});
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

  /// Queries find a deforming obstacle by its name, and see it as it is when execution starts.
  void expectSnapshot(const DeformingObstacle& obstacle) const {
    const std::string& name = obstacle.object.name;
    const auto refuse = [&](const std::string& message) {
      refuseDeforming(problem_.name, name, message);
    };
    const collision::DeformableSnapshot* snapshot =
        obstacle.mesh && obstacle.object.geometries.size() == 1
            ? obstacle.object.geometries[0].shape.deformable()
            : nullptr;
    if (snapshot == nullptr) refuse("has no snapshot; see makeDeformingObstacle()");
    if (snapshot->time() != problem_.execution.start)
      refuse(fmt::format("is as it is at {} s; execution starts at {} s", snapshot->time(),
                         problem_.execution.start));
    if (named(name).size() != 1) refuse(kOwnName);
  }

  /// Contacts of the robot with the world that the problem allows. That things of the world stand
  /// beside each other needs no reason, and there may be many of them.
  void allow() {
    if (!names_matter_) return;
    std::set<std::pair<int, int>> allowed;  // of the robot, of the world
    for (const auto& [x, y] : problem_.contacts.allowed)
      for (const int i : named(x))
        for (const int j : named(y))
          if ((i < carried()) != (j < carried())) allowed.emplace(std::min(i, j), std::max(i, j));
    if (allowed.empty()) return;
    const std::vector<CompiledScene::Dropped>& of_robot = *robot_.dropped();
    std::vector<CompiledScene::Dropped> dropped;
    auto next = allowed.begin();
    std::size_t d = 0;
    for (int i = 0; i < carried(); ++i) {
      for (; d < robot_.droppedEnd(i); ++d) dropped.push_back(of_robot[d]);
      for (; next != allowed.end() && next->first == i; ++next) {
        builder_.allow(i, next->second);
        dropped.push_back({robot_.scene().bodies()[at(i)].name,
                           objects_[at(next->second - carried())]->name, kAllowed});
      }
    }
    dropped.insert(dropped.end(), of_robot.begin() + static_cast<std::ptrdiff_t>(d),
                   of_robot.end());
    dropped_ = std::make_shared<const std::vector<CompiledScene::Dropped>>(std::move(dropped));
  }

  const Problem& problem_;
  const PreparedRobot& robot_;
  collision::SceneBuilder builder_;
  std::vector<const Object*> objects_;  // that have geometries
  bool names_matter_;                   // listed only where they do: there may be many
  std::unordered_map<std::string, std::vector<int>> named_;  // bodies by name
  std::shared_ptr<const std::vector<CompiledScene::Dropped>> dropped_;
};

using BodiesByName = std::multimap<std::string_view, int>;

/// Calls visit(i, j) for bodies of the robot and of the world that bear the two names, in either
/// order. O(log of both).
template <class Visit>
void forEachNamed(const BodiesByName& robot, const BodiesByName& world, const std::string& a,
                  const std::string& b, const Visit& visit) {
  for (const auto& [x, y] : {std::pair(&a, &b), std::pair(&b, &a)}) {
    const auto [i, i_end] = robot.equal_range(*x);
    const auto [j, j_end] = world.equal_range(*y);
    for (auto r = i; r != i_end; ++r)
      for (auto w = j; w != j_end; ++w) visit(r->second, w->second);
  }
}

std::shared_ptr<const EdgeModel> makeEdgeModel(std::shared_ptr<const PreparedRobot> robot) {
  auto model = std::make_shared<EdgeModel>();
  const RobotMotions& motions = robot->motions();
  model->pairs = motions.pairs;
  model->motions = motions.motions;
  model->rounding = motions.rounding;
  model->reach = motions.reach;
  model->needs_limits = robot->hasProven();
  model->jumping_circles = motions.jumping_circles;
  model->robot = std::move(robot);
  return model;
}

}  // namespace

/// What a problem says of objects by name, besides the contacts that a PreparedRobot has.
struct CompiledScene::NamedRules {
  std::string problem;  // its name, for messages
  double margin;
  std::vector<PairMargin> margins;
  std::vector<std::string> deforming;

  /// Adds the objects to a change; returns their bodies.
  BodiesByName add(std::span<const Object> objects, collision::SceneChange& change) const {
    BodiesByName bodies;
    for (const Object& object : objects) {
      expectPose(problem, object.X_WO, object.name);
      if (std::find(deforming.begin(), deforming.end(), object.name) != deforming.end())
        refuseDeforming(problem, object.name, kOwnName);
      if (!object.geometries.empty())
        bodies.emplace(object.name,
                       change.add({object.name, object.geometries, false, object.X_WO}));
    }
    return bodies;
  }
};

CompiledScene::CompiledScene(const Problem& problem, const robots::Stop& stop)
    : model_(problem.robot.model),
      space_(std::make_shared<ConfigurationSpace>(problem.robot.model, problem.robot.variables)),
      base_configuration_(problem.start) {
  const std::shared_ptr<const PreparedRobot> robot = PreparedRobot::of(problem, *space_, stop);
  Surroundings world(problem, *robot, stop);
  dropped_ = world.dropped();
  auto rules = std::make_shared<NamedRules>(
      NamedRules{problem.name, problem.margins.common, problem.margins.pairs, {}});
  for (const DeformingObstacle& o : problem.world.deforming)
    rules->deforming.push_back(o.object.name);
  rules_ = std::move(rules);
  robots::throwIfStopped(stop, "the problem was compiled");
  scene_ = std::move(world).build();
  edge_model_ = makeEdgeModel(robot);
  // What moves stands as the start has it.
  std::vector<robots::Pose> X_WL(model_->links.size());
  robots::forwardKinematics(*model_, problem.start, X_WL);
  body_link_.assign(robot->carriers().size(), -1);
  for (std::size_t b = 0; b < robot->carriers().size(); ++b) {
    if (!scene_.bodies()[b].moving) continue;
    body_link_[b] = robot->carriers()[b];
    collision::SceneAccess::place(scene_, static_cast<int>(b), X_WL[at(body_link_[b])]);
  }
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

std::shared_ptr<const CompiledScene> CompiledScene::withObjects(
    std::span<const Object> added, std::span<const int> removed) const {
  if (!rules_)
    throw std::invalid_argument(
        "CompiledScene::withObjects(): of a variant with other margins or pairs than the problem "
        "says; the scene that was compiled is expected");
  auto changed = std::make_shared<CompiledScene>(*this);
  changed->pairs_token_ = std::make_shared<const int>();
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
    const BodiesByName objects = rules_->add(added, change);
    change.setDefaultMargin(rules_->margin);
    changed->dropped_ = applyRules(objects, removed_names, change);
    changed->scene_ = std::move(change).build();
  } catch (const std::invalid_argument& error) {
    throw robots::InputError(rules_->problem, 0, error.what());
  }
  return changed;
}

std::shared_ptr<const std::vector<CompiledScene::Dropped>> CompiledScene::applyRules(
    const BodiesByName& objects, const std::set<std::string>& removed_names,
    collision::SceneChange& change) const {
  BodiesByName robot;
  for (int i = 0; i < bodiesOfRobot(); ++i) robot.emplace(scene_.bodies()[at(i)].name, i);
  const auto moves = [this](int body) { return scene_.bodies()[at(body)].moving; };
  for (const PairMargin& m : rules_->margins)
    forEachNamed(robot, objects, m.a, m.b, [&](int i, int j) {
      if (moves(i)) change.setMargin(i, j, m.margin);
    });

  const auto isOfRemoved = [&](const Dropped& d) {
    return d.reason == kAllowed && removed_names.count(d.b) != 0;
  };
  const PreparedRobot& prepared = *edge_model_->robot;
  // There may be many contacts, of which none names these objects.
  if (std::none_of(objects.begin(), objects.end(),
                   [&](const auto& o) { return prepared.isAllowedName(std::string(o.first)); }) &&
      std::none_of(dropped_->begin(), dropped_->end(), isOfRemoved))
    return dropped_;
  std::vector<Dropped> dropped;
  std::remove_copy_if(dropped_->begin(), dropped_->end(), std::back_inserter(dropped), isOfRemoved);
  std::set<std::pair<int, int>> allowed;
  for (const auto& contact : prepared.contacts().allowed) {
    forEachNamed(robot, objects, contact.first, contact.second, [&](int i, int j) {
      if (!allowed.emplace(i, j).second) return;
      if (moves(i)) change.allow(i, j);
      const std::string& link = scene_.bodies()[at(i)].name;
      dropped.push_back({link, link == contact.first ? contact.second : contact.first, kAllowed});
    });
  }
  return std::make_shared<const std::vector<Dropped>>(std::move(dropped));
}

std::shared_ptr<CompiledScene> CompiledScene::variant() const {
  auto other = std::make_shared<CompiledScene>(*this);
  other->rules_ = nullptr;
  return other;
}

std::shared_ptr<const CompiledScene> CompiledScene::withShapes(
    std::span<const Replacement> shapes) const {
  auto changed = std::make_shared<CompiledScene>(*this);
  for (const Replacement& r : shapes) {
    if (!(r.growth <= 0)) changed->rules_ = nullptr;
    // The robot's lanes are made once.
    if (isOfRobot(r.body))
      throw std::invalid_argument("CompiledScene::withShapes(): body " + std::to_string(r.body) +
                                  " is the robot's; a deforming obstacle is expected");
    changed->scene_.setShape(r.body, r.geometry, r.shape);
    changed->scene_.growMargins(r.body, r.geometry, r.growth);
  }
  return changed;
}

std::shared_ptr<const CompiledScene> CompiledScene::withMarginAtLeast(double margin) const {
  auto raised = variant();
  raised->scene_.raiseMargins(margin);
  return raised;
}

std::shared_ptr<const CompiledScene> CompiledScene::withWorldMarginAtLeast(double margin) const {
  auto raised = variant();
  collision::SceneAccess::raiseMargins(raised->scene_, margin, bodiesOfRobot());
  return raised;
}

std::shared_ptr<const CompiledScene> CompiledScene::withMarginsGrown(double growth) const {
  auto grown = variant();
  for (std::size_t body = 0; body < body_link_.size(); ++body)
    if (scene_.bodies()[body].moving)  // one of every pair is
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
  // keep() is called once a pair: were a second answer another, pairs would get the motions of
  // others, and proofs would not hold.
  auto next = edge_model_->pairs.begin();
  collision::SceneAccess::keepPairs(reduced->scene_, [&](const collision::ScenePair& pair) {
    const bool is_kept = keep(pair);
    if (!isOfRobot(pair)) return is_kept;
    if (is_kept) model->pairs.push_back(*next);
    ++next;
    return is_kept;
  });
  reduced->edge_model_ = std::move(model);
  return reduced;
}

void CompiledScene::expand(std::span<const double> point, std::span<double> q) const {
  std::copy(base_configuration_.begin(), base_configuration_.end(), q.begin());
  const std::span<const int> variables = space_->variables();
  for (std::size_t i = 0; i < variables.size(); ++i) q[at(variables[i])] = point[i];
}

}  // namespace leeway::planner
