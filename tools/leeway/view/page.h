#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/plan.h"
#include "leeway/planner/replanner.h"
#include "tools/leeway/view/ends.h"
#include "tools/leeway/view/timeline.h"

namespace leeway::tools::view {

/// Edges of a search, as points of the space.
using SearchEdges = std::vector<std::pair<std::vector<double>, std::vector<double>>>;

/// Records the edges of a plan's search. `edges` must outlive the plan.
void recordSearch(planner::PlanOptions& options, SearchEdges& edges);

/// The contents of a page or a picture.
struct Subject {
  const planner::Problem& problem;
  std::string source;  ///< the problem's file, as the user wrote it
  std::shared_ptr<const planner::CompiledScene> scene;  ///< shown; see shownProblem()
  /// The scene before the first step, whose pairs the page lists; `scene` without steps.
  std::shared_ptr<const planner::CompiledScene> first_scene;
  std::vector<Stage> stages;
  std::vector<End> ends;
  Timeline timeline;
  LeastClearance least;            ///< of a path
  std::string shown;               ///< if nothing moves: "start", or the goal that is not valid
  std::string verdict;             ///< one word: "certified", "unsolved", ...
  bool good = false;               ///< whether this is the wanted result
  std::vector<std::string> notes;  ///< sentences for people
  SearchEdges searched;
  std::vector<std::pair<double, std::string>> decisions;  ///< of an execution, by time [s]
  std::string path_file = {};  ///< where the path comes from: its file, or "plan"
};

/// The subject of a plan, of a path from a file, of an execution. Each function compiles the
/// problem and measures, which takes about a second. `certificate`: of the path, if known.
Subject subjectOfPlan(const planner::Problem& problem, const std::string& source,
                      const planner::PlanResult& result, SearchEdges searched);
Subject subjectOfPath(const planner::Problem& problem, const std::string& source,
                      const planner::Path& path, const planner::Certificate* certificate = nullptr);
Subject subjectOfExecution(const planner::Problem& problem, const std::string& source,
                           const std::vector<planner::ReplanStep>& steps,
                           planner::ReplanStatus status);

/// Returns an HTML document that needs no other files. `compared`: another path of the same
/// problem, shown beside the first; null: none. Throws robots::InputError if the command was built
/// without the page (see expectPage()).
std::string page(const Subject& subject, const Subject* compared = nullptr);

/// The options --view and --open of a verb.
struct PageChoice {
  std::string file;  ///< empty: no page
  bool open = false;
};
void addPageOptions(CLI::App& app, PageChoice& choice);

/// Throws robots::InputError if the page cannot be written: another ending than .html, a missing
/// folder, or a command that was built without node. Verbs call it before their work.
void expectPage(const std::string& file);
void expectPicture(const std::string& file);  ///< the same for .svg, which needs no node
inline void expectPage(const PageChoice& choice) {
  if (!choice.file.empty()) expectPage(choice.file);
}
/// Writes the page as a whole. If `open`, also shows it in the user's browser.
void writePage(const PageChoice& choice, const Subject& subject, const Subject* compared = nullptr);

/// Returns three views of start, goal and the motion between them as an SVG document, for papers
/// and logs. `only_picture`: without title and texts, for an index.
std::string pictureSvg(const Subject& subject, bool only_picture = false);

/// Escapes a user's text for an XML or HTML document.
std::string escaped(const std::string& text);

}  // namespace leeway::tools::view
