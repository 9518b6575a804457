#pragma once

#include "leeway/planner/plan.h"
#include "python/bindings/problem.h"

namespace leeway::python {

/// A plan, and the problem that it answers.
struct Result {
  std::shared_ptr<const planner::Problem> problem;
  planner::PlanResult value;
};

/// A path from a Result, an array (n, joints) or a file. `shortest`: its continuous joints go the
/// shorter way from row to row.
planner::Path pathOf(const Problem& problem, const py::object& path, bool shortest);
/// [(reason, how many, pairs by name where they are assumed), ...]
py::list uncheckedList(std::span<const planner::UncheckedPairs> unchecked);

void defineResult(py::module_& module);
void definePlan(py::module_& module);
void defineTrajectory(py::module_& module);

/// result.trajectory().
py::object trajectoryObject(const Result& result, double period);

}  // namespace leeway::python
