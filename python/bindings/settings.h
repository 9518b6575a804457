#pragma once

// What may be said of a problem by keyword, and read or set as its attribute: one table for both.

#include "python/bindings/problem.h"

namespace leeway::python {

/// Planned joints' values: a group state's name, numbers in group order, or a dict by joint, which
/// may name others, too. None: nothing changes.
void setStart(planner::Problem& problem, const py::object& start);
/// `goal`: as setStart(), with pairs (from, to) or 'any' in place of numbers; `several`: a list of
/// goals. None: no goal.
void setGoals(planner::Problem& problem, const py::object& goal, bool several);
/// Properties of class Problem, one a setting.
void defineSettings(py::class_<Problem>& problem);
/// Throws TypeError for a keyword that is left.
void noMore(const char* call, const py::dict& keywords);

}  // namespace leeway::python
