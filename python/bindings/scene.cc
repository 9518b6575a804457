#include "python/bindings/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "leeway/planner/cloud_notes.h"
#include "leeway/planner/plan.h"
#include "python/base/at.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/settings.h"
#include "python/bindings/world.h"

namespace leeway::python {
namespace {

using planner::EdgeCertifier;
using planner::Verdict;

/// A certifier for the time of a call.
class Lent {
 public:
  explicit Lent(Certifiers& from) : from_(from), certifier_(from.take()) {}
  ~Lent() { from_.giveBack(std::move(certifier_)); }
  Lent(const Lent&) = delete;
  Lent& operator=(const Lent&) = delete;
  EdgeCertifier* operator->() const { return certifier_.get(); }
  EdgeCertifier& operator*() const { return *certifier_; }

 private:
  Certifiers& from_;
  std::unique_ptr<EdgeCertifier> certifier_;
};

/// Calls ask(certifier, i) for i below `count`, without the interpreter's lock.
template <typename Ask>
void forEach(const Scene& scene, std::size_t count, Ask&& ask) {
  Interrupt interrupt;
  const std::shared_ptr<Certifiers> certifiers = scene.certifiers;
  released([&] {
    const Lent certifier(*certifiers);
    for (std::size_t i = 0; i < count && !interrupt(); ++i) ask(*certifier, i);
  });
  interrupt.rethrow();
}

py::object bools(const std::vector<char>& values, const std::vector<py::ssize_t>& shape) {
  if (shape.empty()) return py::bool_(values.front() != 0);
  py::array_t<bool> result(shape);
  std::copy(values.begin(), values.end(), result.mutable_data());
  return result;
}

py::object valid(const Scene& self, const py::object& states) {
  const Rows points = rows(states, "states", self.size());
  std::vector<char> answers(points.count());
  const planner::ConfigurationSpace& space = self.compiled->space();
  const bool proves = self.compiled->nothingChecked().empty();
  const auto problem = self.current();
  forEach(self, points.count(), [&](EdgeCertifier& certifier, std::size_t i) {
    answers[i] = proves && space.withinLimits(points.row(i)) &&
                 certifier.decide(points.row(i)) == Verdict::kFree &&
                 (problem->constraints.empty() ||
                  planner::brokenConstraint(*self.compiled, *problem, points.row(i)).empty());
  });
  return bools(answers, points.shape);
}

double positiveTolerance(double tolerance) {
  if (!(tolerance > 0) || std::isinf(tolerance))
    throw py::value_error("tolerance is " + text(tolerance) + "; a positive length is expected");
  return tolerance;
}

py::array_t<double> clearances(const Scene& self, const py::object& states, double tolerance) {
  Rows points = rows(states, "states", self.size());
  positiveTolerance(tolerance);
  std::vector<double> intervals(2 * points.count());
  forEach(self, points.count(), [&](EdgeCertifier& certifier, std::size_t i) {
    const planner::Interval found = certifier.clearance(points.row(i), tolerance).clearance;
    intervals[2 * i] = found.lower;
    intervals[2 * i + 1] = found.upper;
  });
  points.shape.push_back(2);
  return array(std::move(intervals), points.shape);
}

/// Both ends of edges, of equal shape.
std::pair<Rows, Rows> edges(const Scene& self, const py::object& a, const py::object& b) {
  std::pair<Rows, Rows> ends = {rows(a, "a", self.size()), rows(b, "b", self.size())};
  if (ends.first.shape != ends.second.shape)
    throw py::value_error("a holds " + std::to_string(ends.first.count()) + " states, b " +
                          std::to_string(ends.second.count()) + "; equal shapes are expected");
  return ends;
}

/// Whether all constraints of the problem are proven to hold along an edge.
bool keepsConstraints(const Scene& scene, const planner::Problem& problem,
                      std::span<const double> a, std::span<const double> b) {
  if (problem.constraints.empty()) return true;
  planner::Path path;
  for (const int v : scene.compiled->space().variables())
    path.names.push_back(scene.compiled->model().variables[at(v)].name);
  path.positions = {{a.begin(), a.end()}, {b.begin(), b.end()}};
  return planner::proveConstraints(*scene.compiled, problem, path).has_value();
}

py::object validEdges(const Scene& self, const py::object& a, const py::object& b,
                      bool persistent) {
  const std::pair<Rows, Rows> ends = edges(self, a, b);
  const Rows &from = ends.first, &to = ends.second;
  const planner::EdgeRequest request =
      persistent ? planner::EdgeRequest::persistent() : planner::EdgeRequest{};
  std::vector<char> answers(from.count());
  const planner::ConfigurationSpace& space = self.compiled->space();
  const bool proves = self.compiled->nothingChecked().empty();
  const auto problem = self.current();
  forEach(self, from.count(), [&](EdgeCertifier& certifier, std::size_t i) {
    answers[i] = proves && space.withinLimits(from.row(i)) && space.withinLimits(to.row(i)) &&
                 certifier.certify(from.row(i), to.row(i), request).verdict == Verdict::kFree &&
                 keepsConstraints(self, *problem, from.row(i), to.row(i));
  });
  return bools(answers, from.shape);
}

py::array_t<double> edgeClearances(const Scene& self, const py::object& a, const py::object& b,
                                   double tolerance) {
  auto [from, to] = edges(self, a, b);
  positiveTolerance(tolerance);
  std::vector<double> intervals(2 * from.count());
  forEach(
      self, from.count(), [&, &start = from, &end = to](EdgeCertifier& certifier, std::size_t i) {
        const planner::Interval found =
            certifier.edgeClearance(start.row(i), end.row(i), {.tolerance = tolerance}).clearance;
        intervals[2 * i] = found.lower;
        intervals[2 * i + 1] = found.upper;
      });
  from.shape.push_back(2);
  return array(std::move(intervals), from.shape);
}

/// How far an edge is certified.
struct Edge {
  planner::EdgeCheck check;
  std::string a, b;
};

Edge certify(const Scene& self, const py::object& a, const py::object& b) {
  const auto [from, to] = edges(self, a, b);
  if (!from.shape.empty())
    throw py::value_error("a is more than one state; valid_edges() takes many");
  planner::EdgeRequest request = planner::EdgeRequest::persistent();
  request.last_valid = true;
  const auto problem = self.current();
  Edge edge;
  forEach(self, 1, [&, &start = from, &end = to](EdgeCertifier& certifier, std::size_t) {
    edge.check = certifier.certify(start.values, end.values, request);
    if (!certifier.scene().nothingChecked().empty()) edge.check = {};
    const planner::ConfigurationSpace& space = certifier.scene().space();
    if (!space.withinLimits(start.values) || !space.withinLimits(end.values)) {
      edge.check = {};
      edge.check.verdict = Verdict::kNotFree;
    }
    if (edge.check.verdict == Verdict::kFree &&
        !keepsConstraints(self, *problem, start.values, end.values)) {
      edge.check.verdict = Verdict::kUndecided;
      edge.check.last_valid = 0;
    }
    std::tie(edge.a, edge.b) = pairNames(certifier.scene(), edge.check.pair);
  });
  return edge;
}

State check(const Scene& self, const py::object& state, double tolerance) {
  State result;
  result.point = statePoint(self.problem, state);
  positiveTolerance(tolerance);
  const planner::CompiledScene& scene = *self.compiled;
  result.limit = scene.space().brokenLimit(result.point);
  const std::shared_ptr<const planner::Problem> problem = self.current();
  if (result.limit.empty()) result.limit = planner::brokenConstraint(scene, *problem, result.point);
  result.nothing_checked = scene.nothingChecked();
  result.notes = planner::cloudNotes(*problem);
  forEach(self, 1, [&](EdgeCertifier& certifier, std::size_t) {
    result.check = certifier.clearance(result.point, tolerance);
    std::tie(result.a, result.b) = pairNames(scene, result.check.pair);
    if (result.check.verdict == Verdict::kNotFree)
      std::tie(result.near_a, result.near_b) =
          pairNames(scene, certifier.tooNear(result.point, tolerance).pair);
  });
  return result;
}

Scene withObjectAt(const Scene& self, const std::string& name, const py::object& place) {
  collision::Pose X_WO = givenPose(place, "pose");
  if (realArray(place, "pose").size() == 3) {  // a position: it stays turned as it is
    const auto before = self.moved.find(name);
    if (before != self.moved.end())
      X_WO.rotation = before->second.rotation;
    else
      for (const planner::Object& object : self.problem->world.objects)
        if (object.name == name) X_WO.rotation = object.X_WO.rotation;
  }
  Scene moved(self.problem, released([&] { return self.compiled->withObjectAt(name, X_WO); }));
  moved.moved = self.moved;
  moved.renewed = self.renewed;
  moved.moved[name] = X_WO;
  return moved;
}

/// A bound that may be infinite, where the greatest number serves as well.
Eigen::Vector3d boundOf(const py::object& value, const char* name) {
  constexpr double kMost = std::numeric_limits<double>::max();
  return vector3(py::module_::import("numpy").attr("clip")(realArray(value, name), -kMost, kMost),
                 name);
}

Scene withRegion(const Scene& self, const std::string& name, const py::object& low,
                 const py::object& high, const py::object& points, const py::object& radius) {
  const planner::CloudRegion region{boundOf(low, "low"), boundOf(high, "high")};
  const planner::PointCloud seen = cloudOf(points, radius);
  Scene renewed(self.problem,
                released([&] { return self.compiled->withRegion(name, region, seen); }));
  renewed.moved = self.moved;
  renewed.renewed = self.renewed;
  const auto problem = self.current();
  for (const planner::Object& object : problem->world.objects)
    if (object.name == name)
      renewed.renewed[name] = std::make_shared<const planner::PointCloud>(
          planner::renewed(*object.cloud, region, seen));
  return renewed;
}

bool isValid(const State& state) {
  return state.limit.empty() && state.nothing_checked.empty() &&
         state.check.verdict == Verdict::kFree;
}

std::string stateText(const State& state) {
  std::string result = std::string("<leeway.State: ") + (isValid(state) ? "valid" : "not valid");
  if (!state.limit.empty()) result += " (" + state.limit + ")";
  if (!state.nothing_checked.empty()) result += ", nothing was checked: " + state.nothing_checked;
  if (!state.a.empty())
    result += ", clearance " + text(state.check.clearance.lower) + " to " +
              text(state.check.clearance.upper) + " m between " + state.a + " and " + state.b;
  return result + ">";
}

std::shared_ptr<const planner::CompiledScene> compile(const planner::Problem& problem) {
  Interrupt interrupt;
  return interrupt.released([&] {
    return std::make_shared<const planner::CompiledScene>(problem, interrupt.callback());
  });
}

Scene makeScene(const py::args& args, const py::kwargs& kwargs) {
  py::dict keywords = kwargs.attr("copy")();
  Problem problem = problemOf("Scene", args, keywords);
  noMore("Scene", keywords);
  const std::shared_ptr<const planner::Problem> value = problem.value();
  auto compiled = compile(*value);
  return Scene(problem, std::move(compiled));
}

State checkProblem(const py::args& args, const py::kwargs& kwargs) {
  py::dict keywords = kwargs.attr("copy")();
  py::object state = py::str("start");
  double tolerance = 1e-6;
  if (keywords.contains("state")) state = keywords.attr("pop")("state");
  if (keywords.contains("tolerance"))
    tolerance = number(keywords.attr("pop")("tolerance"), "tolerance");
  Problem problem = problemOf("check", args, keywords);
  noMore("check", keywords);
  const std::shared_ptr<const planner::Problem> value = problem.value();
  auto compiled = compile(*value);
  return check(Scene(problem, std::move(compiled)), state, tolerance);
}

void defineState(py::module_& module) {
  py::class_<State> state(module, "State", "One state against the margins.");
  defineConstant(
      state, "valid", isValid,
      "Within the limits, and proven to keep all margins: undecided is not valid, nor is a state "
      "where nothing is checked.");
  defineConstant(
      state, "verdict",
      [](const State& self) {
        return self.nothing_checked.empty() ? verdictName(self.check.verdict) : "nothing_checked";
      },
      "'free', 'not_free', 'undecided' or 'nothing_checked', of the margins alone.");
  defineConstant(
      state, "lower", [](const State& self) { return self.check.clearance.lower; },
      "The clearance is at least this [m]; below 0 it is a depth; inf where nothing is near.");
  defineConstant(
      state, "upper", [](const State& self) { return self.check.clearance.upper; },
      "The clearance is at most this [m].");
  defineConstant(
      state, "closest", [](const State& self) { return pairObject(self.a, self.b); },
      "Names of the closest pair, or None.");
  defineConstant(
      state, "too_near", [](const State& self) { return pairObject(self.near_a, self.near_b); },
      "Names of a pair that does not keep its margin, or None.");
  defineConstant(
      state, "point_a", [](const State& self) { return array(self.check.closest.point_a); },
      "Nearest point on the first of `closest`: (3,), world [m].");
  defineConstant(
      state, "point_b", [](const State& self) { return array(self.check.closest.point_b); },
      "Nearest point on the second: (3,), world [m].");
  defineConstant(
      state, "normal", [](const State& self) { return array(self.check.closest.normal); },
      "Unit vector from the first to the second: (3,).");
  defineConstant(
      state, "limit",
      [](const State& self) {
        return self.limit.empty() ? py::object(py::none()) : py::object(py::str(self.limit));
      },
      "The first joint limit that is broken, in words, or None.");
  defineConstant(
      state, "positions",
      [](const State& self) { return array(std::span<const double>(self.point)); },
      "The state: (joints,) [rad or m].");
  defineConstant(
      state, "notes", [](const State& self) { return listOf(self.notes); },
      "Those of the problem.");
  state.def("__bool__", isValid);
  state.def("__repr__", stateText);

  py::class_<Edge> edge(module, "Edge", "How far an edge is certified.");
  defineConstant(
      edge, "verdict", [](const Edge& self) { return verdictName(self.check.verdict); },
      "'free': every point of it is proven to keep all margins; 'not_free' or 'undecided'.");
  defineConstant(
      edge, "last_valid", [](const Edge& self) { return self.check.last_valid; },
      "Certified from 0 to this t; 1 when free.");
  defineConstant(
      edge, "t", [](const Edge& self) { return self.check.t; },
      "Where it is not free or undecided.");
  defineConstant(
      edge, "pair", [](const Edge& self) { return pairObject(self.a, self.b); },
      "And between what, or None.");
  edge.def("__bool__", [](const Edge& self) { return self.check.verdict == Verdict::kFree; });
  edge.def("__repr__", [](const Edge& self) {
    return std::string("<leeway.Edge: ") + verdictName(self.check.verdict) +
           ", certified to t = " + text(self.check.last_valid) + ">";
  });
}

}  // namespace

std::unique_ptr<EdgeCertifier> Certifiers::take() {
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      auto certifier = std::move(idle_.back());
      idle_.pop_back();
      return certifier;
    }
  }
  return std::make_unique<EdgeCertifier>(scene_);
}

void Certifiers::giveBack(std::unique_ptr<EdgeCertifier> certifier) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(certifier));
}

Scene::Scene(Problem of, std::shared_ptr<const planner::CompiledScene> scene)
    : problem(std::move(of)),
      compiled(std::move(scene)),
      certifiers(std::make_shared<Certifiers>(compiled)) {}

std::shared_ptr<const planner::Problem> Scene::current() const {
  if (moved.empty() && renewed.empty()) return problem.value();
  auto changed = std::make_shared<planner::Problem>(*problem);
  for (planner::Object& object : changed->world.objects) {
    if (const auto place = moved.find(object.name); place != moved.end())
      object.X_WO = place->second;
    if (const auto cloud = renewed.find(object.name); cloud != renewed.end())
      object.cloud = cloud->second;
  }
  return changed;
}

const char* verdictName(Verdict verdict) {
  return verdict == Verdict::kFree      ? "free"
         : verdict == Verdict::kNotFree ? "not_free"
                                        : "undecided";
}

std::pair<std::string, std::string> pairNames(const planner::CompiledScene& scene, int pair) {
  if (pair < 0) return {};
  const auto& entry = scene.scene().pairs()[static_cast<std::size_t>(pair)];
  const auto bodies = scene.scene().bodies();
  return {bodies[static_cast<std::size_t>(entry.body_a)].name,
          bodies[static_cast<std::size_t>(entry.body_b)].name};
}

py::object pairObject(const std::string& a, const std::string& b) {
  if (a.empty() && b.empty()) return py::none();
  return py::make_tuple(a, b);
}

void defineScene(py::module_& module) {
  defineState(module);
  auto scene = defineClass<py::class_<Scene>>(
      module, "Scene", "(robot, world=None, start=None, goal=None, **settings)",
      "A problem compiled for questions about many states and edges; also "
      "Scene(problem, **settings). Constant: threads may share it, each call runs "
      "without the interpreter's lock.",
      makeScene);
  define(
      scene, "valid", "(self, states)",
      "Which states are within the limits and proven to keep all margins and constraints: a bool "
      "for (joints,), bools (...,) for (..., joints). Undecided is not valid.",
      valid);
  define(scene, "clearances", "(self, states, *, tolerance=1e-06)",
         "The least distance of checked pairs as proven intervals: (..., 2), lower and upper ends "
         "[m].",
         clearances);
  define(scene, "check", "(self, state, *, tolerance=1e-06)",
         "All about one state: (joints,), a group state's name, 'start', 'goal' or a dict by "
         "joint.",
         check);
  define(scene, "valid_edges", "(self, a, b, *, persistent=False)",
         "Which edges from a to b, both (..., joints), are certified: every point of the edge is "
         "proven to keep all margins and constraints. `persistent` spends a hundred times the work "
         "before it "
         "leaves an edge undecided, which counts as not valid.",
         validEdges);
  define(scene, "edge_clearances", "(self, a, b, *, tolerance=0.0001)",
         "The least clearance along each edge as proven intervals: (..., 2) [m].", edgeClearances);
  define(scene, "certify", "(self, a, b)",
         "How far the edge from a to b is certified, and what is in the way. Where a constraint is "
         "not proven, it is 'undecided'; with an end outside the limits it is 'not_free'. It is "
         "certified nowhere then.",
         certify);
  define(scene, "with_object_at", "(self, name, pose)",
         "The scene with an object of its world at another pose (a position alone leaves it turned "
         "as it is), at the cost of the change: "
         "thousands of moves cost as much each. Move an object of the last result, or always of "
         "the first scene.",
         withObjectAt);
  define(scene, "with_region", "(self, name, low, high, points, radius)",
         "The scene after a region of a cloud was seen again: balls with their centers in the box "
         "from `low` to `high` (of a thinned cloud: balls in it as a whole) are gone, and `points` "
         "(n, 3) [m] with "
         "`radius` (a number, or one a point) are there, all in the cloud's frame. It costs what "
         "the region does, plus a copy of the cloud. Start from the first scene where regions are "
         "the same, and compile again when most of a cloud was renewed.",
         withRegion);
  defineConstant(
      scene, "problem", [](const Scene& self) { return Problem(self.current(), true); },
      "The problem that was compiled, constant; copy() gives one to change.");
  defineConstant(
      scene, "robot", [](const Scene& self) { return self.problem.robot(); }, "Its robot.");
  defineConstant(
      scene, "pairs", [](const Scene& self) { return self.compiled->scene().pairs().size(); },
      "How many pairs of shapes are checked.");
  defineConstant(
      scene, "nothing_checked", [](const Scene& self) { return self.compiled->nothingChecked(); },
      "Why no answer of this scene proves anything, in words: no link that moves has a shape, or "
      "all pairs with the world are left out. Then no state and no edge is valid. Else ''.");
  defineConstant(
      scene, "dropped",
      [](const Scene& self) {
        py::list list;
        for (const auto& dropped : self.compiled->dropped())
          list.append(py::make_tuple(dropped.a, dropped.b, dropped.reason));
        return list;
      },
      "Pairs of bodies that are not checked, and why: (a, b, reason).");
  defineConstant(
      scene, "warnings", [](const Scene& self) { return listOf(self.compiled->warnings()); },
      "What the problem says that has no effect: margins of pairs that are not checked.");
  scene.def("__repr__", [](const Scene& self) {
    return "<leeway.Scene of '" + self.problem->name +
           "': " + std::to_string(self.compiled->scene().pairs().size()) + " pairs>";
  });
  define(
      module, "check",
      "(robot, world=None, start=None, goal=None, *, state='start', tolerance=1e-06, **settings)",
      "Validity and clearance of one state: Scene.check(). Also check(problem, state='goal').",
      checkProblem);
}

}  // namespace leeway::python
