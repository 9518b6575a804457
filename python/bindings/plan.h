#pragma once

#include <optional>

#include "leeway/planner/plan.h"
#include "python/bindings/problem.h"

namespace leeway::python {

/// A plan, and the problem that it answers.
struct Result {
  std::shared_ptr<const planner::Problem> problem;
  planner::PlanResult value;
};

/// A path from a Result, an array (n, joints) or a file. `shortest`: its continuous joints go the
/// shorter way from row to row. `cubics`: also from a Trajectory, and of files with blended corners
/// with its cubics (planner::Path::times).
planner::Path pathOf(const Problem& problem, const py::object& path, bool shortest,
                     bool cubics = false);
/// [(reason, how many, pairs by name where they are assumed), ...]
py::list uncheckedList(std::span<const planner::UncheckedPairs> unchecked);

void defineResult(py::module_& module);
void definePlan(py::module_& module);
void defineTrajectory(py::module_& module);

/// The motion of a Trajectory; nothing for other objects.
std::optional<planner::Path> motionOfTrajectory(const py::object& object);

/// result.trajectory().
py::object trajectoryObject(const Result& result, double period);

}  // namespace leeway::python
