#include "leeway/planner/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>

#include "leeway/planner/path_io.h"
#include "leeway/planner/planners.h"
#include "leeway/planner/task.h"
#include "leeway/planner/trajectory.h"
#include "leeway/robots/input_error.h"
#include "leeway/view/page.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/pair_samples.h"
#include "tools/leeway/support/plan_overrides.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"
#include "tools/leeway/view/page_options.h"
#include "tools/view/base/figures.h"
#include "tools/view/base/output_file.h"
#include "tools/view/base/scene_names.h"
#include "tools/view/least_clearance.h"

namespace leeway::tools {
namespace {

struct PlanArguments {
  ProblemSource source;
  PlanOverrides overrides;
  std::string output;
  std::string trajectory;
  double period = 0;
  view::PageChoice view;
  bool json = false;
  bool list_planners = false;
};

constexpr std::string_view kPathEndings[] = {".yaml", ".json", ".csv", ".path"};
constexpr std::string_view kTrajectoryEndings[] = {".yaml", ".json", ".csv"};

double millimetres(double metres) { return metres * 1e3; }

/// The proven clearance of an edge or a step: its lower bound, or the path's least clearance if
/// that is higher. `has_least`: the path's least clearance is there.
std::string keptText(double lower, const planner::Interval& least, bool has_least) {
  if (const auto figure = figureOf(least); figure && has_least) return *figure;
  lower = std::max(lower, least.lower);
  return std::isfinite(lower) ? ">= " + formatLower(millimetres(lower), 2)
         : lower > 0          ? "nothing near"
                              : "not known";
}

/// The waypoints as a table. Columns have the names of joints if they then fit side by side, else
/// q1, q2, ... with a key above the table.
std::string pathTable(const planner::PlanResult& result, const planner::PathClearance& least) {
  const auto& names = result.path.names;
  std::size_t width = 0;
  for (const std::string& name : names) width += std::max<std::size_t>(name.size(), 7) + 2;
  std::string text;
  std::vector<std::string> heading = {""};
  for (std::size_t j = 0; j < names.size(); ++j) {
    heading.push_back(width <= 66 ? names[j] : fmt::format("q{}", j + 1));
    if (width > 66) text += fmt::format("q{} = {}\n", j + 1, names[j]);
  }
  heading.emplace_back("keeps [mm]");
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < result.path.positions.size(); ++i) {
    std::vector<std::string> row = {fmt::format("{}", i)};
    for (const double position : result.path.positions[i]) row.push_back(formatNear(position, 4));
    row.push_back(i < result.certificate.segments.size()
                      ? keptText(result.certificate.segments[i].lower, least.clearance,
                                 static_cast<int>(i) == least.closest_segment)
                      : "");
    rows.push_back(row);
  }
  return text + formatTable(heading, rows);
}

/// The steps of a task, with what each one does and what is proven for it.
std::string stepTable(const planner::Problem& problem, const planner::PlanResult& result,
                      const planner::PathClearance& whole) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < result.path.steps.size(); ++i) {
    const planner::PathStep& step = result.path.steps[i];
    std::string clearance, departure;
    double least = std::numeric_limits<double>::infinity();
    for (int edge = step.first; edge < step.last; ++edge)
      least = std::min(least, result.certificate.segments[static_cast<std::size_t>(edge)].lower);
    if (step.first < step.last)
      clearance =
          keptText(least, whole.clearance,
                   step.first <= whole.closest_segment && whole.closest_segment < step.last);
    if (std::holds_alternative<planner::LineStep>(problem.steps[i].action))
      departure = fmt::format("<= {} mm, {} mrad", formatUpper(millimetres(step.deviation), 2),
                              formatUpper(step.turn * 1e3, 2));
    rows.push_back({fmt::format("{}", i + 1), step.name,
                    step.first < step.last ? fmt::format("{} to {}", step.first, step.last)
                                           : fmt::format("{}", step.first),
                    clearance, departure});
  }
  return formatTable({"step", "name", "waypoints", "keeps [mm]", "off its line"}, rows,
                     {1, 2, 3, 4});
}

/// The cost of the path, and the wishes that it keeps.
std::string costText(const planner::Problem& problem, const planner::PlanResult& result) {
  if (!std::isfinite(result.cost.upper)) return "";
  std::string text = fmt::format("Cost between {} and {}.\n", formatLower(result.cost.lower, 5),
                                 formatUpper(result.cost.upper, 5));
  for (std::size_t i = 0; i < result.wishes.size(); ++i) {
    const planner::WishResult& of = result.wishes[i];
    const planner::Wish& wish = problem.margins.wishes[i];
    text += fmt::format("Wish of {} mm between {}: ", millimetres(wish.clearance), wish.name);
    if (of.kept && *of.kept)
      text += "kept everywhere, proven.\n";
    else if (of.kept)
      text += fmt::format("missed by {} to {} mm, which costs {} to {}.\n",
                          formatLower(millimetres(wish.clearance - of.clearance.upper), 3),
                          formatUpper(millimetres(wish.clearance - of.clearance.lower), 3),
                          formatLower(of.cost.lower, 5), formatUpper(of.cost.upper, 5));
    else
      text += "not decided.\n";
  }
  return text;
}

/// All pairs that are too near at the start, if there are more than the named one, and those that a
/// user might allow.
std::string allPairsText(const planner::Problem& problem, const planner::PlanResult& result) {
  const std::vector<PairNames> pairs = pairsTooNear(problem, result);
  if (pairs.empty()) return {};
  const std::string hint = allowHint(problem, pairs);
  if (pairs.size() < 2) return hint;
  return fmt::format("All {} pairs that are too near there: {}.\n{}", pairs.size(),
                     pairsText(pairs), hint);
}

std::string offendingText(const planner::Problem& problem, const planner::PlanResult& result) {
  const auto& check = result.offending;
  const bool is_start = result.status == planner::PlanStatus::kInvalidStart;
  if (!result.reason.empty()) {
    return fmt::format("{}: {}.\n", is_start ? "The start is not valid" : "No configuration",
                       result.reason);
  }
  const char* state = is_start ? "start" : "goal";
  if (result.offending_a.empty()) {
    return fmt::format(
        "The {} is not valid: its clearance could not be decided, which sizes or places near the "
        "limits of the numbers cause.\n",
        state);
  }
  const Eigen::Vector3d place = 0.5 * (check.closest.point_a + check.closest.point_b);
  const std::string where = fmt::format("at ({}, {}, {}) m", formatNear(place.x(), 4),
                                        formatNear(place.y(), 4), formatNear(place.z(), 4));
  if (check.clearance.upper <= 0) {
    return fmt::format("The {} is in collision: {} and {}, {} deep, {}.\n", state,
                       result.offending_a, result.offending_b,
                       clearanceText({-check.clearance.upper, -check.clearance.lower}), where);
  }
  return fmt::format(
      "The {} is too near: {} and {}, {} apart, {}; more than {:g} mm is required.\n", state,
      result.offending_a, result.offending_b, clearanceText(check.clearance), where,
      millimetres(offendingMargin(problem, result)));
}

std::string timeText(const planner::PlanResult& result, double load_s) {
  const std::string improve =
      result.improve_s < 1e-5 ? "" : fmt::format("improve {:.2f}, ", result.improve_s * 1e3);
  return fmt::format(
      "Time [ms]: load {:.2f}, compile {:.2f}, plan {:.2f}, simplify {:.2f}, {}push {:.2f}, "
      "certify {:.2f}.\n"
      "Counts: {}, {}, {} ({} undecided), {} distance {}.\n",
      load_s * 1e3, result.compile_s * 1e3, result.plan_s * 1e3, result.simplify_s * 1e3, improve,
      result.push_s * 1e3, result.certify_s * 1e3, counted(result.iterations, "iteration"),
      counted(result.states, "state"), counted(result.edges, "edge"), result.undecided_edges,
      result.distance_queries, result.distance_queries == 1 ? "query" : "queries");
}

std::string durationText(const planner::Trajectory& trajectory) {
  const int corners = static_cast<int>(trajectory.waypoints().size()) - 2;
  std::string at_corners;
  if (corners > 0 && trajectory.cutCorners().empty()) {
    at_corners = ", at rest at every corner";
  } else if (corners > 0) {
    at_corners = fmt::format(", {} of {} blended", trajectory.cutCorners().size(),
                             counted(static_cast<std::size_t>(corners), "corner"));
  }
  return fmt::format("Takes {:.3f} s within the joints' limits{}.\n", trajectory.duration(),
                     at_corners);
}

std::string limitsText(const planner::PlanningLimits& limits) {
  return limits.iterations > 0
             ? fmt::format("limits: {} s, {} iterations", limits.time, limits.iterations)
             : fmt::format("limit: {} s", limits.time);
}

/// The word for a plan without a path.
std::string verdictOf(planner::PlanStatus status) {
  switch (status) {
    case planner::PlanStatus::kSolved:
    case planner::PlanStatus::kPartial:
      break;
    case planner::PlanStatus::kUnsolved:
      return "no path found";
    case planner::PlanStatus::kInvalidStart:
      return "start not valid";
    case planner::PlanStatus::kInvalidGoal:
      return "goal not valid";
    case planner::PlanStatus::kNothingChecked:
      return "nothing checked";
    case planner::PlanStatus::kNotCompiled:
      return "not compiled";
  }
  return "solved";
}

/// The planner and its seed.
std::string methodText(const planner::PlanResult& result) {
  return fmt::format("{}, seed {}{}{}", result.planner, result.seed,
                     interrupted() ? ", interrupted" : "",
                     result.deterministic
                         ? ""
                         : " (this planner keeps clocks or threads of its own: not deterministic)");
}

std::string solvedText(const planner::Problem& problem, const planner::PlanResult& result,
                       const planner::Trajectory& trajectory) {
  view::LeastClearance least = view::leastClearance(problem, result.path, interrupted);
  const planner::Certificate& certificate = result.certificate;
  view::narrow(least, certificate, certificate.world, certificate.self);
  const bool is_part = result.status == planner::PlanStatus::kPartial;
  const std::string verdict = verdictText(is_part                 ? "only a part of the line"
                                          : certificate.certified ? "certified"
                                                                  : "solved, but not certified",
                                          certificate.certified && !is_part);
  std::string text = wrapped(fmt::format("{}: {}, {}{}\n", problem.name, verdict,
                                         view::leastText(least), obstaclesText(problem))) +
                     "\n" + pathTable(result, least.all) + "\n";
  if (!result.path.steps.empty()) text += stepTable(problem, result, least.all) + "\n";
  const std::string part =
      is_part ? fmt::format("{}: {}.\n",
                            certificate.certified ? "Only a part of it, which is certified"
                                                  : "Only a part of it, which is not certified",
                            result.reason)
              : "";
  return text + wrapped(part + view::nearestText(least) + planner::toString(certificate.unchecked) +
                        ".\n" + constraintsText(problem, result.certificate.constraints) +
                        (is_part ? "Planned with " : "Solved with ") + methodText(result) + ": " +
                        view::lengthText(result) + ".\n" + costText(problem, result) +
                        durationText(trajectory));
}

/// The reason for a plan without a path.
std::string failureText(const planner::Problem& problem, const planner::PlanResult& result) {
  std::string text =
      fmt::format("{}: {}\n", problem.name, verdictText(verdictOf(result.status), false));
  switch (result.status) {
    case planner::PlanStatus::kUnsolved:
      if (!result.reason.empty()) {
        text += fmt::format("No further than {}.\n{}{}", result.reason, blockedText(result.blocked),
                            hindranceText(problem, result));
        break;
      }
      text += fmt::format("No path after {:.2f} s of planning and {} ({}).\n", result.plan_s,
                          counted(result.iterations, "iteration"),
                          interrupted() ? "interrupted" : limitsText(problem.limits));
      if (result.undecided_edges > 0)
        text += fmt::format("{} of {} {} left undecided; the search did not use {}.\n",
                            result.undecided_edges, counted(result.edges, "edge"),
                            result.undecided_edges == 1 ? "was" : "were",
                            result.undecided_edges == 1 ? "it" : "them");
      text += blockedText(result.blocked) + hindranceText(problem, result);
      break;
    case planner::PlanStatus::kInvalidStart:
    case planner::PlanStatus::kInvalidGoal:
      text += offendingText(problem, result) + allPairsText(problem, result);
      break;
    case planner::PlanStatus::kNothingChecked:
      text += fmt::format("Nothing was checked, and nothing planned: {}.\n", result.reason);
      break;
    case planner::PlanStatus::kNotCompiled:
      text += fmt::format("Nothing was planned: {}.\n", result.reason);
      break;
    case planner::PlanStatus::kSolved:
    case planner::PlanStatus::kPartial:
      break;
  }
  return wrapped(text + "Planner: " + methodText(result) + ".\n");
}

void printText(const planner::Problem& problem, const planner::PlanResult& result,
               const std::optional<planner::Trajectory>& trajectory, double load_s) {
  const std::string text =
      trajectory ? solvedText(problem, result, *trajectory) : failureText(problem, result);
  fmt::print("{}{}", text, wrapped(timeText(result, load_s)));
}

int listPlanners(bool json) {
  std::vector<std::vector<std::string>> rows;
  Json list = Json::array();
  for (const planner::PlannerTraits& planner : planner::plannerNames()) {
    list.push_back({{"name", planner.name},
                    {"deterministic", planner.deterministic},
                    {"optimizing", planner.optimizing},
                    {"projection", planner.projection},
                    {"summary", planner.summary}});
    rows.push_back({planner.name, planner.optimizing ? "yes" : "no",
                    planner.deterministic ? "yes" : "no", planner.summary});
  }
  if (json) {
    printJson({{"planners", list}});
  } else {
    fmt::print("{}",
               formatTable({"planner", "optimises", "deterministic", "how"}, rows, {1, 2, 3}));
  }
  return kYes;
}

int runPlan(const PlanArguments& arguments) {
  if (arguments.list_planners) {
    return listPlanners(arguments.json);
  }
  if (!arguments.output.empty()) {
    checkOutputFile(arguments.output, kPathEndings);
  }
  if (!arguments.trajectory.empty()) {
    checkOutputFile(arguments.trajectory, kTrajectoryEndings);
  }
  view::expectPage(arguments.view);
  expectApart(std::array{arguments.output, arguments.trajectory, arguments.view.file},
              filesOf(arguments.source));
  const auto start = std::chrono::steady_clock::now();
  planner::Problem problem = loadProblem(arguments.source, arguments.overrides);
  const double load_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  planner::PlanOptions options = planOptions(arguments.overrides, problem);
  view::SearchEdges searched;
  if (!arguments.view.file.empty()) leeway::view::recordSearch(options, searched);
  const planner::PlanResult result = planner::solve(problem, options);
  endProgress();
  printWarnings(result.warnings);
  const bool solved = result.status == planner::PlanStatus::kSolved;
  const bool has_path = solved || result.status == planner::PlanStatus::kPartial;
  if (has_path && !arguments.output.empty()) {
    planner::writePath(arguments.output, problem, result);
  }
  std::optional<planner::Trajectory> trajectory;
  if (has_path) {
    trajectory = planner::trajectoryOf(problem, result.path);
    if (!arguments.trajectory.empty()) {
      planner::writeTrajectory(arguments.trajectory, problem, result, *trajectory,
                               arguments.period);
    }
  }
  if (!arguments.view.file.empty()) {
    view::writePage(arguments.view, view::subjectOfPlan(problem, arguments.source.problem, result,
                                                        std::move(searched), interrupted));
  }
  if (arguments.json) {
    printJson(toJson(problem, result, trajectory, load_s));
  } else {
    printText(problem, result, trajectory, load_s);
  }
  return solved && result.certificate.certified ? kYes : kNo;
}

}  // namespace

Verb addPlan(CLI::App& command) {
  auto arguments = std::make_shared<PlanArguments>();
  CLI::App* app =
      command.add_subcommand("plan", "find a path and prove the clearance of every edge");
  addProblemArguments(*app, arguments->source);
  addPlanOverrides(*app, arguments->overrides);
  app->add_option("--output", arguments->output,
                  "write the path; the ending chooses the format: .yaml .json .csv .path")
      ->type_name("FILE");
  app->add_option("--trajectory", arguments->trajectory,
                  "write the path with times, velocities and accelerations within the limits of "
                  "`execution:`; the ending chooses the format: .yaml .json .csv")
      ->type_name("FILE");
  app->add_option(
         "--period", arguments->period,
         "add a row of the trajectory every S seconds to those where the acceleration changes")
      ->type_name("S")
      ->check(numberFrom(2e-5, 1e6))
      ->needs("--trajectory");
  view::addPageOptions(*app, arguments->view);
  app->add_flag("--json", arguments->json, "print one JSON document");
  app->add_flag("--planners", arguments->list_planners, "list the planners and end");
  app->footer(
      "Examples:\n"
      "  leeway plan problems/shelf/reach.yaml\n"
      "  leeway plan problems/shelf/reach.yaml --planner BITstar --objective clearance --time 1 "
      "--json\n"
      "  leeway plan problems/pick_place/can.yaml --output path.json\n"
      "  leeway plan problems/constrained/wipe.yaml");
  return {app, [arguments] { return runPlan(*arguments); }};
}

}  // namespace leeway::tools
