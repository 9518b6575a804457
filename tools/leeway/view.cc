#include <fmt/format.h>

#include <array>
#include <memory>
#include <optional>

#include "leeway/planner/path_io.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/replanner.h"
#include "leeway/planner/task.h"
#include "leeway/robots/input_error.h"
#include "leeway/view/page.h"
#include "robots/base/read_file.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/path_ends.h"
#include "tools/leeway/support/plan_overrides.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"
#include "tools/leeway/view/page_options.h"
#include "tools/view/base/output_file.h"
#include "tools/view/base/scene_names.h"
#include "tools/view/picture.h"

namespace leeway::tools {
namespace {

struct ViewArguments {
  ProblemSource source;
  PlanOverrides overrides;
  std::vector<std::string> files;
  view::PageChoice page{.file = "view.html"};
  std::string svg, compare;
  bool shortest = false;
};

/// The subject if no path is given: a plan, or an execution if obstacles move, or the start if
/// there is no goal.
view::Subject solve(const planner::Problem& problem, const ViewArguments& arguments) {
  const std::string& name = arguments.source.problem;
  if (problem.goals.empty() && problem.steps.empty()) return view::subjectOfStart(problem, name);
  if (movesAsKnown(problem)) {
    std::vector<planner::ReplanStep> steps;
    planner::ReplanOptions options;
    options.stop = interactivePlanOptions().stop;
    const planner::ReplanResult result = planner::replan(
        problem, options, [&](const planner::ReplanStep& step) { steps.push_back(step); });
    return view::subjectOfExecution(problem, name, steps, result.status);
  }
  view::SearchEdges searched;
  planner::PlanOptions options = planOptions(arguments.overrides, problem);
  leeway::view::recordSearch(options, searched);
  const planner::PlanResult result = planner::solve(problem, options);
  printWarnings(result.warnings);
  return view::subjectOfPlan(problem, name, result, std::move(searched), interrupted);
}

int runView(ViewArguments& arguments) {
  arguments.source.notes_clouds = false;
  arguments.source.needs_goal = false;
  std::string path_file;
  if (arguments.files.size() == 2 ||
      (arguments.files.size() == 1 && !arguments.source.robot.empty()))
    path_file = takePathFile(arguments.source, arguments.files);
  else if (!arguments.files.empty())
    arguments.source.problem = arguments.files.front();
  const bool only_picture = !arguments.svg.empty() && arguments.page.file.empty();
  if (!arguments.svg.empty()) view::expectPicture(arguments.svg);
  if (!only_picture && robots::endingOf(arguments.page.file) == ".svg")
    badUsage(fmt::format("--output {0} is a page, .html; --svg {0} writes a picture",
                         arguments.page.file));
  if (!only_picture) view::expectPage(arguments.page);
  if (!arguments.compare.empty() && only_picture)
    badUsage("--compare shows two paths in a page; --output FILE.html is expected beside --svg");
  std::vector<std::string> inputs = filesOf(arguments.source);
  if (arguments.page.visual && only_picture)
    badUsage("--visual draws shapes in a page; --output FILE.html is expected beside --svg");
  inputs.push_back(path_file);
  inputs.push_back(arguments.compare);
  expectApart(std::array{arguments.svg, only_picture ? std::string() : arguments.page.file},
              inputs);
  planner::Problem problem = loadProblem(arguments.source, arguments.overrides);
  std::vector<std::string> warnings;
  const planner::PathReading reading{.shortest = arguments.shortest, .warnings = &warnings};
  view::Subject subject = path_file.empty()
                              ? solve(problem, arguments)
                              : view::subjectOfPath(problem, arguments.source.problem,
                                                    planner::readPath(path_file, problem, reading),
                                                    nullptr, interrupted);
  subject.path_file = path_file.empty() ? "plan" : path_file;
  std::optional<view::Subject> compared;
  if (!arguments.compare.empty()) {
    if (!subject.decisions.empty())
      badUsage("--compare shows two paths, and an execution has none; a path file is expected");
    compared.emplace(view::subjectOfPath(problem, arguments.source.problem,
                                         planner::readPath(arguments.compare, problem, reading),
                                         nullptr, interrupted));
    compared->path_file = arguments.compare;
  }
  printWarnings(warnings);
  endProgress();
  if (!arguments.svg.empty()) planner::writeFileWhole(arguments.svg, view::pictureSvg(subject));
  if (!only_picture) view::writePage(arguments.page, subject, compared ? &*compared : nullptr);
  std::string text =
      fmt::format("{}: {}{}\n", problem.name, verdictText(subject.verdict, subject.good),
                  interrupted() ? ", interrupted" : "");
  text += view::nearestText(subject.least) + blockedText(subject.blocked);
  for (const std::string& note : subject.notes) text += note + "\n";
  if (compared)
    text += fmt::format("\n{}: {}\n", arguments.compare,
                        verdictText(compared->verdict, compared->good)) +
            view::nearestText(compared->least);
  fmt::print("{}", wrapped(text));
  if (!arguments.svg.empty()) fmt::print("{}\n", arguments.svg);
  if (!only_picture) fmt::print("{}\n", arguments.page.file);
  return subject.good && (!compared || compared->good) ? kYes : kNo;
}

}  // namespace

Verb addView(CLI::App& command) {
  auto arguments = std::make_shared<ViewArguments>();
  CLI::App* app = command.add_subcommand(
      "view", "write an HTML page that shows the plan and its clearance, or why there is no plan");
  addProblemAndPathArguments(*app, arguments->source, arguments->files);
  app->get_option("files")->expected(0, 2)->description(
      "problem file (not with --robot) and path file; without a path the problem is planned, or "
      "executed where its obstacles move; without a goal the start is shown");
  addPlanOverrides(*app, arguments->overrides);
  addShortest(*app, arguments->shortest);
  CLI::Option* output = app->add_option("--output", arguments->page.file, "the page")
                            ->type_name("FILE.html")
                            ->capture_default_str();
  app->add_option("--compare", arguments->compare,
                  "a second path of the same problem, shown beside the first in the page")
      ->type_name("FILE");
  app->add_option(
         "--svg", arguments->svg,
         "a picture instead of the page (both with --output): three views with start, goal "
         "and what lies between")
      ->type_name("FILE.svg");
  app->add_flag("--open", arguments->page.open, "show the page in the browser");
  view::addVisual(*app, arguments->page.visual);
  app->footer(
      "The page needs no network and no server. docs/view.md explains it.\n"
      "Examples:\n"
      "  leeway view problems/shelf/reach.yaml --output shelf.html\n"
      "  leeway view problems/shelf/reach.yaml --svg shelf.svg\n"
      "  leeway plan problems/shelf/reach.yaml --output short.json\n"
      "  leeway plan problems/shelf/reach.yaml --objective clearance --output wide.json\n"
      "  leeway view problems/shelf/reach.yaml short.json --compare wide.json");
  return {app, [arguments, output] {
            if (!arguments->svg.empty() && output->count() == 0) arguments->page.file.clear();
            return runView(*arguments);
          }};
}

}  // namespace leeway::tools
