#pragma once

#include "leeway/planner/plan.h"
#include "python/bindings/problem.h"

namespace leeway::python {

/// A plan, and the problem that it answers.
struct Result {
  std::shared_ptr<const planner::Problem> problem;
  planner::PlanResult value;
};

/// A path from a Result, an array (n, joints) or a file.
planner::Path pathOf(const Problem& problem, const py::object& path);

void defineResult(py::module_& module);
void definePlan(py::module_& module);
void defineTrajectory(py::module_& module);

/// result.trajectory().
py::object trajectoryObject(const Result& result, double period);

}  // namespace leeway::python
