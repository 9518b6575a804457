#pragma once

// The table of settings (leeway/planner/settings.h) in Python: keywords of calls, and attributes of
// problems.

#include <optional>

#include "python/bindings/problem.h"

namespace leeway::python {

/// Where a frame may be: by names, as a program gives it; or as a problem holds it, `found`.
struct FramePose {
  planner::FramePose given;
  struct Found {
    collision::Pose X_LF, X_WR;
  };
  std::optional<Found> found = std::nullopt;  ///< then `given.frame` is a link's name
};

int variableOf(const planner::Problem& problem, const std::string& name);

/// A FramePose or a list of them, and nothing else: the poses.
std::vector<FramePose> framePoses(const py::object& value);
/// Where they are in `problem`. Throws std::invalid_argument for unknown names.
std::vector<robots::PoseRegion> regionsOf(const planner::Problem& problem,
                                          const std::vector<FramePose>& poses);
py::list framePoseList(const planner::Problem& problem,
                       const std::vector<robots::PoseRegion>& regions);

/// Planned joints' values: a group state's name, numbers in group order, a dict by joint, which may
/// name others, too, or poses. None: nothing changes.
void setStart(planner::Problem& problem, const py::object& start);
/// A group state's name; numbers, pairs (from, to) or 'any', or ranges (joints, 2); or poses.
/// `of_group`: of a group within a goal by groups. Those within it must be smaller, because a dict
/// may hold itself.
planner::Goal goalOf(const planner::Problem& problem, const py::object& goal,
                     bool of_group = false);
/// `several`: a list of goals. None: no goal.
void setGoals(planner::Problem& problem, const py::object& goal, bool several);
/// Ranges (joints, 2), or poses.
py::object goalObject(const planner::Problem& problem, const planner::Goal& goal);

/// A list of Constraints. None: none.
void setConstraints(planner::Problem& problem, const py::object& constraints);
py::object constraintList(const planner::Problem& problem);

/// A list of TaskSteps. None: no steps.
void setSteps(planner::Problem& problem, const py::object& steps);
py::object stepList(const planner::Problem& problem);

/// Pairs of names, each of a link, an object, "robot" for all of its links and what it holds, or a
/// tuple of such: all pairs that they stand for.
std::vector<std::pair<std::string, std::string>> namePairs(const planner::Problem& problem,
                                                           py::handle item, const char* name);

void defineGoals(py::module_& module);
void defineTasks(py::module_& module);

/// Properties of class Problem, one a setting, and settings().
void defineSettings(py::module_& module, py::class_<Problem>& problem);
/// "NAME: what it does", one a line.
std::string settingsDoc();
/// Throws TypeError for a keyword that is left.
void noMore(const char* call, const py::dict& keywords);

}  // namespace leeway::python
