#include "leeway/view/page.h"

#include <fmt/format.h>

#include <optional>
#include <span>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/planner/path_io.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/stopped.h"
#include "robots/base/read_file.h"
#include "robots/load/visual_shapes.h"
#include "tools/view/document.h"
#include "tools/view/picture.h"
#include "tools/view/subject.h"

namespace leeway::view {
namespace {

using tools::view::Subject;

bool isPicture(const std::string& file) { return robots::endingOf(file) == ".svg"; }

/// Checks what would make the work useless.
void expectFile(const std::string& file, const PageOptions& options) {
  const std::string ending = robots::endingOf(file);
  if (ending != ".svg" && ending != ".html")
    throw robots::InputError(
        file, 0, fmt::format("unknown ending '{}'; .html, .svg can be written", ending));
  if (!isPicture(file)) return tools::view::expectPage(file);
  tools::view::expectPicture(file);
  if (options.compared)
    throw std::invalid_argument(
        "two paths are compared in a page; a file that ends in .html is "
        "expected");
  if (options.visual)
    throw std::invalid_argument(
        "visual shapes are drawn in a page; a file that ends in .html is expected");
}

void expectPathOf(const planner::Problem& problem, const planner::Path& path) {
  std::vector<std::string> names;
  for (const int v : problem.robot.variables)
    names.push_back(problem.robot.model->variables[at(v)].name);
  if (!path.names.empty() && path.names != names)
    throw std::invalid_argument("the path is of other variables than the problem plans");
  if (path.positions.empty()) throw std::invalid_argument("the path has no waypoints");
}

/// Stays true once it was true, so that work that ended early is not taken for whole.
class Stop {
 public:
  explicit Stop(const std::function<bool()>& stop) : stop_(stop) {}
  bool operator()() { return stopped_ = stopped_ || (stop_ && stop_()); }
  std::function<bool()> callback() {
    return [this] { return (*this)(); };
  }

 private:
  const std::function<bool()>& stop_;
  bool stopped_ = false;
};

void write(const std::string& file, const Subject& subject, const Subject* compared,
           const PageOptions& options, Stop& stop) {
  std::optional<robots::VisualShapes> visuals;
  if (options.visual) {
    visuals = robots::loadVisualShapes(*subject.problem.robot.model, stop.callback());
    if (options.warnings != nullptr)
      options.warnings->insert(options.warnings->end(), visuals->left_out.begin(),
                               visuals->left_out.end());
  }
  robots::throwIfStopped(stop.callback(), "measuring what the page shows");
  planner::writeFileWhole(
      file, isPicture(file) ? tools::view::pictureSvg(subject)
                            : tools::view::page(subject, compared, visuals ? &*visuals : nullptr));
}

/// Writes a subject, and beside it the path to compare.
void writeBoth(const std::string& file, const planner::Problem& problem, Subject& subject,
               const PageOptions& options, Stop& stop) {
  subject.path_file = options.label;
  if (!options.compared) return write(file, subject, nullptr, options, stop);
  Subject compared = tools::view::subjectOfPath(problem, options.source, *options.compared, nullptr,
                                                stop.callback());
  compared.path_file = options.compared_label;
  write(file, subject, &compared, options, stop);
}

}  // namespace

void recordSearch(planner::PlanOptions& options, SearchEdges& edges) {
  options.on_edge = [&edges](std::span<const double> a, std::span<const double> b) {
    constexpr std::size_t kMost = 200'000;  // enough to show how far the search came
    if (edges.size() < kMost)
      edges.emplace_back(std::vector<double>(a.begin(), a.end()),
                         std::vector<double>(b.begin(), b.end()));
  };
}

void writePage(const std::string& file, const planner::Problem& problem,
               const planner::PlanResult& result, const PageOptions& options) {
  expectFile(file, options);
  if (!result.path.positions.empty()) expectPathOf(problem, result.path);
  if (options.compared) expectPathOf(problem, *options.compared);
  Stop stop(options.stop);
  Subject subject = tools::view::subjectOfPlan(problem, options.source, result, options.searched,
                                               stop.callback());
  writeBoth(file, problem, subject, options, stop);
}

void writePage(const std::string& file, const planner::Problem& problem, const planner::Path& path,
               const PageOptions& options) {
  expectFile(file, options);
  expectPathOf(problem, path);
  if (options.compared) expectPathOf(problem, *options.compared);
  Stop stop(options.stop);
  Subject subject =
      tools::view::subjectOfPath(problem, options.source, path, nullptr, stop.callback());
  subject.searched = options.searched;
  writeBoth(file, problem, subject, options, stop);
}

void writePage(const std::string& file, const planner::Problem& problem,
               const std::vector<planner::ReplanStep>& steps, planner::ReplanStatus status,
               const PageOptions& options) {
  expectFile(file, options);
  if (options.compared || !options.searched.empty())
    throw std::invalid_argument("an execution has no path to compare and no search to show");
  Stop stop(options.stop);
  Subject subject =
      tools::view::subjectOfExecution(problem, options.source, steps, status, stop.callback());
  subject.path_file = options.label;
  write(file, subject, nullptr, options, stop);
}

}  // namespace leeway::view
