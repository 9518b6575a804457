#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/plan.h"
#include "leeway/planner/replanner.h"

namespace leeway::view {

/// Edges of a search, as points of the space.
using SearchEdges = std::vector<std::pair<std::vector<double>, std::vector<double>>>;

/// Sets PlanOptions::on_edge to record the edges of a plan's search, at most 200,000. `edges` must
/// outlive the plan.
void recordSearch(planner::PlanOptions& options, SearchEdges& edges);

struct PageOptions {
  /// The problem's file, for the page's heading. Its folder and name are shown, not its place on
  /// the machine. Empty: only Problem::name is shown.
  std::string source;
  /// The name of the path beside that of `compared`.
  std::string label = "plan";
  /// A second path of the same problem, shown beside the first. Only for a page.
  std::optional<planner::Path> compared;
  std::string compared_label = "compared";
  /// The edges of the plan's search, a layer of the page.
  SearchEdges searched;
  /// Also draws the visual shapes of the robot's file: <visual> of a URDF, the geoms that MuJoCo
  /// shows. The page says that they are not what is proven. They are read again, and take at most
  /// about 60,000 triangles of the page. Only for a page.
  bool visual = false;
  /// Receives why visual shapes are left out, each with file and line. Null: only their number is
  /// in the page.
  std::vector<std::string>* warnings = nullptr;
  /// Called now and then; true ends the work.
  std::function<bool()> stop;
};

/// Writes what `leeway view` shows of a plan, whole or not at all (planner::writeFileWhole()). The
/// ending chooses: .html, one page that needs no network and no server; .svg, a picture with three
/// views. For a plan without a path it shows the start or the goal that is not valid, and how far
/// the search came. The clearances shown are computed here, as docs/view.md says, and are narrower
/// than the certificate's.
///
/// Compiles the problem, and takes about a second more. Throws robots::InputError as
/// planner::validate(), for another ending, a file that cannot be written, and for .html if the
/// library was built without node; this is checked before the work. Throws std::invalid_argument
/// for a path of other variables than the problem plans, a path without waypoints, and for
/// `compared` or `visual` with .svg; robots::Stopped if `stop` ended it, and then writes nothing.
void writePage(const std::string& file, const planner::Problem& problem,
               const planner::PlanResult& result, const PageOptions& options = {});

/// The same for any path. For a task, the path must have its steps (Path::steps), which plan() and
/// readPath() give.
void writePage(const std::string& file, const planner::Problem& problem, const planner::Path& path,
               const PageOptions& options = {});

/// The same for an execution among obstacles that move: the steps that planner::replan() handed to
/// its callback, and its status. PageOptions::compared and `searched` must be empty.
void writePage(const std::string& file, const planner::Problem& problem,
               const std::vector<planner::ReplanStep>& steps, planner::ReplanStatus status,
               const PageOptions& options = {});

}  // namespace leeway::view
