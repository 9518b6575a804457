#pragma once

#include <memory>

#include "leeway/planner/problem.h"
#include "python/bindings/robot.h"
#include "python/bindings/world.h"

namespace leeway::python {

/// A problem. Whoever plans holds `value`, which is never changed while someone else holds it.
struct Problem {
  std::shared_ptr<const planner::Problem> value;

  Robot robot() const { return {value->robot.model, value->robot.variables}; }
  std::size_t size() const { return value->robot.variables.size(); }
  /// With the interpreter's lock held: the problem, to be changed; a copy of it where it is held.
  planner::Problem& change();
};

/// What may be said of a problem by keyword: margin=0.01. Throws TypeError for other keywords.
void applySettings(planner::Problem& problem, const py::dict& settings);
bool isSetting(const std::string& name);

/// The problem that a call means: (problem) or (robot, world, start, goal), with settings. `call`
/// is for messages. Takes what it knows from `keywords`.
Problem problemOf(const char* call, const py::args& args, py::dict& keywords);

/// Throws ValueError where there is nothing to plan to.
void requireGoal(const Problem& problem);

/// Points of the planned joints: the problem's start, and the middle of its goals.
std::vector<double> startPoint(const planner::Problem& problem);
/// "start", "goal", a group state, numbers, or a map by joint.
std::vector<double> statePoint(const Problem& problem, const py::object& state);

void defineProblem(py::module_& module);

}  // namespace leeway::python
