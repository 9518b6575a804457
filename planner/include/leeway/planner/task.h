#pragma once

#include "leeway/planner/plan.h"

namespace leeway::planner {

/// Plans a problem's steps one after the other, from its start, each in the world as the steps
/// before have left it. The result's path is that of all steps, its certificate that of all edges,
/// each in the world of its step; the limit on time is that of the whole task, a limit on
/// iterations that of each search.
///
/// A step whose goal is poses tries several configurations for them, and the lines behind it come
/// before the search for a path to it. Where a later step fails, earlier ones try their other
/// configurations, kTaskTries in all. An edge of a line is proven to keep the frame within the
/// step's tolerances of its place on the line, which moves at a constant rate, and to keep all
/// margins. Joints that a line leaves free are moved where that makes it longer.
///
/// A line that ends early gives kPartial: the path of the task as far as it is had, certified, with
/// `line_end`; nothing behind that line is tried. kUnsolved says in `reason` which step got no
/// further, and why. Throws robots::InputError as plan(), and for steps that name what does not
/// exist or contradict each other. Deterministic as plan().
PlanResult planTask(const Problem& problem, const PlanOptions& options = {});

/// plan(), or planTask() for a problem with steps.
PlanResult solve(const Problem& problem, const PlanOptions& options = {});

}  // namespace leeway::planner
