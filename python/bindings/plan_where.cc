// Plans with a condition on states that is written in Python, by OMPL's interfaces.

#include <ompl/base/MotionValidator.h>
#include <ompl/base/ScopedState.h>
#include <ompl/datastructures/NearestNeighborsLinear.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

#include <chrono>
#include <cmath>

#include "leeway/planner/ompl_motion_validator.h"
#include "leeway/planner/ompl_state_space.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/plan.h"

namespace leeway::python {
namespace {

namespace ob = ompl::base;

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The caller's condition, asked of many states in one call.
class Condition {
 public:
  Condition(const py::object& accept, double resolution, const planner::ConfigurationSpace& space,
            Interrupt& interrupt)
      : accept_(accept), resolution_(resolution), space_(space), interrupt_(interrupt) {}

  /// Whether all states at most `resolution` apart on the edge, both ends included, are accepted.
  bool holds(std::span<const double> a, std::span<const double> b) {
    const double parts = std::max(1.0, std::ceil(space_.distance(a, b) / resolution_));
    const auto columns = static_cast<std::size_t>(space_.size());
    std::vector<double> states((static_cast<std::size_t>(parts) + 1) * columns);
    for (std::size_t i = 0; i * columns < states.size(); ++i)
      space_.interpolate(a, b, std::min(1.0, static_cast<double>(i) / parts),
                         {&states[i * columns], columns});
    const py::gil_scoped_acquire locked;
    try {
      const auto count = static_cast<py::ssize_t>(states.size() / columns);
      const py::object answer =
          accept_(array(std::move(states), {count, static_cast<py::ssize_t>(columns)}));
      const auto accepted = py::array_t<bool, py::array::c_style>::ensure(answer);
      if (!accepted || accepted.ndim() != 1 || accepted.shape(0) != count) {
        PyErr_Clear();
        throw py::type_error("accept(states) did not return " + std::to_string(count) +
                             " bools, one a state");
      }
      return std::all_of(accepted.data(), accepted.data() + count, [](bool yes) { return yes; });
    } catch (...) {
      interrupt_.fail();
      return false;
    }
  }

 private:
  const py::object& accept_;  // the caller's, which outlives this
  double resolution_;
  const planner::ConfigurationSpace& space_;
  Interrupt& interrupt_;
};

/// Certified edges on which the condition holds.
class ConditionalMotions : public ob::MotionValidator {
 public:
  ConditionalMotions(const ob::SpaceInformationPtr& information, ob::MotionValidatorPtr certified,
                     Condition& condition)
      : MotionValidator(information), certified_(std::move(certified)), condition_(condition) {}
  bool checkMotion(const ob::State* a, const ob::State* b) const override {
    const auto& space = *si_->getStateSpace()->as<planner::OmplStateSpace>();
    return certified_->checkMotion(a, b) && condition_.holds(space.point(a), space.point(b));
  }
  bool checkMotion(const ob::State*, const ob::State*,
                   std::pair<ob::State*, double>&) const override {
    return false;  // RRTConnect does not ask
  }

 private:
  ob::MotionValidatorPtr certified_;
  Condition& condition_;
};

/// OMPL tells of every search on the console.
struct Quiet {
  ompl::msg::LogLevel before = ompl::msg::getLogLevel();
  Quiet() { ompl::msg::setLogLevel(ompl::msg::LOG_ERROR); }
  ~Quiet() { ompl::msg::setLogLevel(before); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;
};

using Point = std::vector<double>;

/// Leaves out waypoints as long as the edge past them holds: from each the farthest is taken.
std::vector<Point> shortened(const std::vector<Point>& path,
                             const std::function<bool(const Point&, const Point&)>& holds) {
  std::vector<Point> result = {path.front()};
  for (std::size_t i = 0; i + 1 < path.size();) {
    std::size_t next = path.size() - 1;
    while (next > i + 1 && !holds(path[i], path[next])) --next;
    result.push_back(path[next]);
    i = next;
  }
  return result;
}

planner::PlanResult search(const planner::Problem& problem, const planner::CompiledScene& scene,
                           const ob::SpaceInformationPtr& information, const Point& start,
                           const Point& goal, const std::function<bool()>& stop) {
  const auto& space = *information->getStateSpace()->as<planner::OmplStateSpace>();
  planner::PlanResult result;
  result.seed = problem.seed;
  result.planner = "RRTConnect";
  ob::ScopedState<> from(information), to(information);
  const auto holds = [&](const Point& a, const Point& b) {
    std::copy(a.begin(), a.end(), space.point(from.get()).begin());
    std::copy(b.begin(), b.end(), space.point(to.get()).begin());
    return !stop() && information->getMotionValidator()->checkMotion(from.get(), to.get());
  };
  if (!holds(start, start))
    result.status = planner::PlanStatus::kInvalidStart;
  else if (!holds(goal, goal))
    result.status = planner::PlanStatus::kInvalidGoal;
  if (result.status != planner::PlanStatus::kUnsolved) return result;
  holds(start, goal);  // puts both into the states
  const auto definition = std::make_shared<ob::ProblemDefinition>(information);
  definition->setStartAndGoalStates(from, to);
  ompl::geometric::RRTConnect connect(information);
  connect.setProblemDefinition(definition);
  // Others draw from OMPL's generator of the whole process; samples are drawn from our seed.
  connect.setNearestNeighbors<ompl::NearestNeighborsLinear>();  // calls setup()
  if (connect.solve(ob::PlannerTerminationCondition(stop)) != ob::PlannerStatus::EXACT_SOLUTION)
    return result;
  std::vector<Point> path;
  for (const ob::State* state :
       definition->getSolutionPath()->as<ompl::geometric::PathGeometric>()->getStates()) {
    const std::span<const double> point = space.point(state);
    path.emplace_back(point.begin(), point.end());
  }
  result.path.positions = problem.planner.simplify ? shortened(path, holds) : path;
  for (const int variable : scene.space().variables())
    result.path.names.push_back(scene.model().variables[static_cast<std::size_t>(variable)].name);
  return result;
}

void certifyPlan(const std::shared_ptr<const planner::CompiledScene>& scene,
                 planner::PlanResult& result) {
  planner::EdgeCertifier certifier(scene);
  result.certificate = planner::certify(certifier, result.path, 1e-4);
  result.goal = 0;
  for (std::size_t i = 0; i + 1 < result.path.positions.size(); ++i)
    result.length +=
        scene->space().distance(result.path.positions[i], result.path.positions[i + 1]);
  if (result.certificate.certified)
    result.status = planner::PlanStatus::kSolved;
  else
    result.path = {};
}

Result planWhere(const Problem& problem, const py::object& accept, const py::object& resolution,
                 const py::object& stop) {
  if (PyCallable_Check(accept.ptr()) == 0)
    throw py::type_error(
        "accept is no function; one of states (n, joints) that returns n bools "
        "is expected");
  const double apart = number(resolution, "resolution");
  if (!(apart > 0)) throw py::value_error("resolution is " + text(apart) + "; above 0 is expected");
  if (problem->goals.size() != 1)
    throw py::value_error("one goal is expected; the problem has " +
                          std::to_string(problem->goals.size()));
  const Point start = statePoint(problem, py::str("start")),
              goal = statePoint(problem, py::str("goal"));
  const std::shared_ptr<const planner::Problem> value = problem.value();
  planner::validate(*value);
  if (!value->constraints.empty())
    throw py::value_error("plan_where() does not keep constraints; a problem without is expected");
  Interrupt interrupt(stop);
  const Quiet quiet;
  planner::PlanResult result = interrupt.released([&] {
    const auto scene = std::make_shared<const planner::CompiledScene>(*value, interrupt.callback());
    const ob::SpaceInformationPtr information = planner::makeSpaceInformation(scene, value->seed);
    Condition condition(accept, apart, scene->space(), interrupt);
    information->setMotionValidator(std::make_shared<ConditionalMotions>(
        information, information->getMotionValidator(), condition));
    information->setup();
    const double begin = seconds(), limit = value->limits.time;
    planner::PlanResult found = search(*value, *scene, information, start, goal, [&] {
      return interrupt() || (limit > 0 && seconds() - begin > limit);
    });
    if (!found.path.positions.empty()) certifyPlan(scene, found);
    return found;
  });
  interrupt.rethrow();
  return {value, std::move(result)};
}

}  // namespace

void definePlanWhere(py::module_& module) {
  define(module, "plan_where", "(problem, accept, *, resolution=0.05, stop=None)",
         "Plans with a condition of your own: accept(states) of shape (n, joints) returns n bools. "
         "Every edge is certified to keep its margins; the condition holds at states at most "
         "`resolution` [rad or m] apart on it, and is not proven between them. One goal, its "
         "ranges' middle; RRTConnect; the path is shortened by leaving out waypoints.\n\n"
         "The price: a call of Python for each edge, some 10 us and what `accept` takes.",
         planWhere, py::arg("problem"), py::arg("accept"), py::kw_only(),
         py::arg("resolution") = 0.05, py::arg("stop") = py::none());
}

}  // namespace leeway::python
