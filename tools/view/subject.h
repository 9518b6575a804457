#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/plan.h"
#include "leeway/planner/replanner.h"
#include "tools/view/ends.h"
#include "tools/view/timeline.h"

namespace leeway::tools::view {

/// Edges of a search, as points of the space.
using SearchEdges = std::vector<std::pair<std::vector<double>, std::vector<double>>>;

/// The contents of a page or a picture.
struct Subject {
  const planner::Problem& problem;
  std::string source;  ///< the problem's file, as the user wrote it
  std::shared_ptr<const planner::CompiledScene> scene;  ///< shown; see shownProblem()
  /// The scene before the first step; `scene` without steps.
  std::shared_ptr<const planner::CompiledScene> first_scene;
  std::vector<Stage> stages;  ///< of a path
  std::vector<End> ends;
  Timeline timeline;
  LeastClearance least;            ///< of a path or of an execution
  std::string shown;               ///< if nothing moves: "start", or the goal that is not valid
  std::string verdict;             ///< one word: "certified", "unsolved", ...
  bool good = false;               ///< whether this is the wanted result
  std::vector<std::string> notes;  ///< sentences for people
  SearchEdges searched;
  std::vector<std::pair<double, std::string>> decisions;  ///< of an execution, by time [s]
  std::vector<std::string> warnings = {};  ///< of loaders and scene, without this machine's folders
  std::vector<planner::BlockedPair> blocked = {};  ///< of a plan without a path
  std::string path_file = {};  ///< where the path comes from: its file, or "plan"
  /// The least clearance of an execution is known, not only that of its moments.
  bool measured_throughout = false;
};

/// The subject of a plan, of a path, of an execution, of the start alone. Each function compiles
/// the problem and measures, which takes about a second. `certificate`: of the path, if known.
/// `stop` may return true to accept wider intervals of the least clearances.
Subject subjectOfPlan(const planner::Problem& problem, const std::string& source,
                      const planner::PlanResult& result, SearchEdges searched,
                      const std::function<bool()>& stop = {});
Subject subjectOfPath(const planner::Problem& problem, const std::string& source,
                      const planner::Path& path, const planner::Certificate* certificate = nullptr,
                      const std::function<bool()>& stop = {});
Subject subjectOfExecution(const planner::Problem& problem, const std::string& source,
                           const std::vector<planner::ReplanStep>& steps,
                           planner::ReplanStatus status, const std::function<bool()>& stop = {});
Subject subjectOfStart(const planner::Problem& problem, const std::string& source);

}  // namespace leeway::tools::view
