#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "leeway/planner/problem.h"
#include "leeway/robots/input_error.h"
#include "tools/lab/motion/edge_report.h"
#include "tools/lab/motion/motion_cases.h"
#include "tools/lab/motion/own_motion_engine.h"
#include "tools/lab/report/report.h"
#include "tools/lab/report/rival_report.h"

namespace leeway::tools {
namespace {

using report::MotionRow;

std::vector<report::NamedProblem> readProblems(const MotionProblems& asked, std::uint64_t seed) {
  std::shared_ptr<const robots::Model> model;
  if (!asked.robot.empty()) model = robots::loadModel(asked.robot, asked.srdf);
  std::vector<report::NamedProblem> problems;
  for (const std::string& file : asked.files) {
    std::string request = std::filesystem::path(file).filename();
    if (model && request.rfind("scene", 0) != 0)
      throw robots::InputError(file, 0, "a file named sceneNNNN.yaml is expected");
    if (model) request.replace(0, 5, "request");
    report::NamedProblem named{
        std::filesystem::path(file).parent_path().filename().string() + "/" +
            std::filesystem::path(file).stem().string(),
        model ? planner::loadMoveit(model, file,
                                    std::filesystem::path(file).replace_filename(request))
              : planner::loadProblem(file)};
    named.problem.seed = seed;
    problems.push_back(std::move(named));
  }
  return problems;
}

/// Wrong, unsafe or open answers of ours, and failures: what the exit status is about.
int ownErrors(const std::vector<MotionRow>& rows, const std::vector<report::EdgeRow>& edges) {
  int errors = 0;
  for (const report::EdgeRow& r : edges) errors += r.method == "certified" ? r.missed : 0;
  for (const MotionRow& r : rows)
    if (r.claims_bounds) errors += r.wrong() + r.undecided + r.failures();
  return errors;
}

}  // namespace

int runReportMotion(report::MotionReportOptions options, const MotionProblems& asked) {
  RivalReport out(options);
  const std::vector<report::NamedProblem> problems = readProblems(asked, options.seed);
  const auto own = report::makeOwnMotionEngines();
  const auto engines = out.engines(own, &report::Rivals::motions);
  if (options.families.empty()) options.families = report::contactFamilies();
  options.progress = out.begin(options.families.size() + problems.size());
  options.on_rows = out.keep("motion", report::motionRows);
  const std::vector<MotionRow> rows = report::measureMotion(engines, options);
  report::EdgeReportOptions edge_options;
  edge_options.edges = asked.edges;
  edge_options.progress = options.progress;
  edge_options.on_rows = out.keep("edges", report::edgeRows);
  const std::vector<report::EdgeRow> edges = report::measureEdges(problems, edge_options);
  out.note(fmt::format("{} cases a family; one pinned core, of each case the median of {} passes",
                       options.cases, options.passes));
  RivalReport::End end{{report::motionTable(rows)}};
  std::vector<std::string> pictures = {"motion.svg"};
  out.write("motion", report::motionRows(rows));
  if (!problems.empty()) {
    out.write("edges", report::edgeRows(edges));
    pictures.emplace_back("edges.svg");
    end.tables.push_back(report::edgesTable(edges));
  }
  out.draw(pictures);
  end.count = rows.size();
  end.own_errors = ownErrors(rows, edges);
  return out.end(end);
}

}  // namespace leeway::tools
