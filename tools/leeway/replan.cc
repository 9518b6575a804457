#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/path_io.h"
#include "leeway/planner/replanner.h"
#include "leeway/robots/input_error.h"
#include "robots/base/read_file.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/plan_overrides.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"
#include "tools/leeway/view/page_options.h"
#include "tools/view/base/figures.h"
#include "tools/view/base/output_file.h"
#include "tools/view/executed_clearance.h"

namespace leeway::tools {
namespace {

constexpr std::string_view kLogEnding = ".jsonl";
constexpr std::string_view kOutputEndings[] = {".csv", kLogEnding};

// The keys of the JSON documents, for --help. A test checks that none is missing.
constexpr const char* kReplanKeys =
    R"(JSON, a document a step (metres, radians, seconds; null: nothing, or nothing known):
  version                 of these documents, 2 (docs/json.md)
  step                    from 0
  time                    of the look at the obstacles
  decision                plan: sets out on a new path; follow: the path holds; wait: comes to rest,
                          or stands; evade: leaves the path, because it cannot stay; unsafe: nothing
                          can be certified
  why                     it waits, evades or is unsafe; else empty
  certified               the step and its stop keep all margins, whatever the obstacles do until then
  exposed                 not certified, because an obstacle may reach the robot where it stands
  clearance_lower, clearance_upper
                          least separation over the whole step, measured: the lower bound may be
                          below a pair's margin, which certified proves
  closest.a, closest.b    the pair that is kept apart least, with the obstacles where they are in the
                          middle of each proven part of the step
  look_ahead              time after the step for which going on, or standing, is certified
  path_held               what was left of the path held in the world as it was seen
  broken.a, broken.b      else these were in the way
  remaining_s             that the rest of the path takes
  reached                 the step ends in a goal
  joint_names             the planned joints, in the order of the values below
  position                at the end of the step
  motion[]                what is executed: time, position; between rows at constant speed, continuous
                          joints the shorter way. Limits on acceleration and jerk hold for differences
                          of that speed
  stop[]                  the rows after it, time and position, in which the robot comes to rest if no
                          other step is taken; none where it rests; null: the motion is the beginning
                          of the stop of the step before, and the rest of that is this stop
  measured                the robot's true state, where a program has set it since the step before
  observed[]              what a program has seen since then: object, time; position, rotation (rows of
                          the matrix), with balls (x y z radius) of a cloud, or vertices; speed_bound
                          and turn_bound from then on (null: none)
  obstacles[]             name; seen: when, at last; predicted: proven against its motion, else against
                          a bound; strategy that its hierarchy was updated by; reason: why auto chose
                          it, else "asked for"; update_s: what the update took
  time_s                  of computing: update of all obstacles, certify, plan, clearance
  counts                  looks: instants at which obstacles were placed; edges and distance_queries
                          asked for; iterations of planners
  sum                     of the line's text before this key (FNV-1a, 64 bits): shows changes
and at the end, with version:
  status                  reached, exposed (an obstacle may reach the robot, which stands), unsafe,
                          timeout (execution: duration), stopped (--steps), nothing_checked (no pair
                          of shapes is: no step is taken)
  problem, seed           what was executed
  certified               every step was
  not_checked             the pairs that it does not cover: pairs, their number; reasons[]: reason, pairs,
                          and names of those that are only assumed to touch
  clearance_lower, clearance_upper
                          the least of all steps
  duration                of what was executed
  steps, plans, follows, waits, evasions
                          how many, and how many by decision
  replans                 plans besides the first
  clouds[]                of the problem: name, balls, largest_radius, unseen (free, occupied),
                          complete_within, filters that removed balls, bytes
  warnings[]              of the problem
  time_s                  of computing: load, compute (all steps), longest_step
  sum                     as above
The lines are a log: `leeway verify PROBLEM.yaml --log FILE` proves what they state.
)";

struct ReplanArguments {
  ProblemSource source;
  PlanOverrides overrides;
  std::string output;
  int steps = 0;
  view::PageChoice view;
  bool json = false, text = false;
};

/// The table for people: one row for every run of steps with the same decision.
class Rows {
 public:
  void add(const planner::ReplanStep& step) {
    const std::string decision = planner::toString(step.decision);
    if (runs_.empty() || runs_.back().decision != decision ||
        step.decision == planner::Decision::kPlan) {
      runs_.push_back({decision, step.time, step.time, 0, step.clearance.lower, {}, 0});
    }
    Run& run = runs_.back();
    ++run.steps;
    run.end = step.motion.back().time;
    run.clearance = std::min(run.clearance, step.clearance.lower);
    run.compute =
        std::max(run.compute, step.update_s + step.certify_s + step.plan_s + step.clearance_s);
    if (run.because.empty() && !step.broken_a.empty()) {
      run.because = step.broken_a + " and " + step.broken_b;
    }
  }

  std::string text(const view::ExecutedClearance& executed) const {
    const planner::Interval& least = executed.least.all.clearance;
    const double time = executed.all().time;
    std::vector<std::vector<std::string>> rows;
    for (const Run& run : runs_) {
      const double clearance =
          std::isfinite(run.clearance) ? std::max(run.clearance, least.lower) : run.clearance;
      const auto figure = run.begin <= time && time <= run.end ? figureOf(least) : std::nullopt;
      rows.push_back({fmt::format("{:.2f}", run.begin), fmt::format("{:.2f}", run.end),
                      run.decision, fmt::format("{}", run.steps),
                      figure                     ? *figure
                      : std::isfinite(clearance) ? ">= " + formatLower(clearance * 1e3, 2)
                                                 : "-",
                      fmt::format("{:.1f}", run.compute * 1e3), run.because});
    }
    return formatTable(
        {"from [s]", "to [s]", "decision", "steps", "keeps [mm]", "longest [ms]", "in the way"},
        rows, {2, 6});
  }

 private:
  struct Run {
    std::string decision;
    double begin, end;
    int steps;
    double clearance;
    std::string because;
    double compute;
  };
  std::vector<Run> runs_;
};

/// The first line: the verdict, and the proven bounds.
std::string verdictLine(const planner::Problem& problem, const planner::ReplanResult& result,
                        const view::ExecutedClearance& executed) {
  const bool nothing_checked = result.status == planner::ReplanStatus::kNothingChecked;
  const bool good = result.status == planner::ReplanStatus::kReached && result.certified;
  std::string words = nothing_checked ? "nothing checked" : planner::toString(result.status);
  if (!nothing_checked) words += result.certified ? ", certified" : ", not certified";
  std::string proven = "no pair of shapes is checked; `leeway info` lists them";
  if (result.status == planner::ReplanStatus::kExposed)
    proven = "the robot stands, and an obstacle may reach it";
  else if (!nothing_checked && !result.certified)
    proven = "the last step could not be certified";
  else if (!nothing_checked)
    proven = view::keptText(executed);
  return wrapped(fmt::format("{}: {}; {}\n", problem.name, verdictText(words, good), proven));
}

std::string summaryText(const planner::ReplanResult& result,
                        const view::ExecutedClearance& executed) {
  const double lasted = result.trajectory.empty()
                            ? 0
                            : result.trajectory.back().time - result.trajectory.front().time;
  const auto some = [](int count, const char* what) {
    return counted(static_cast<std::size_t>(count), what);
  };
  const std::string nearest = view::nearestText(executed, result.certified);
  return wrapped(nearest + (nearest.empty() ? "" : "\n") +
                 fmt::format("{}.\n{:.2f} s, {}: {} ({} of them on the way), {}, {}; seed {}.\n"
                             "Computing: {:.2f} s in all, {:.1f} ms for the longest step.\n",
                             planner::toString(result.unchecked), lasted,
                             some(result.steps, "step"), some(result.plans, "plan"), result.replans,
                             some(result.waits, "wait"), some(result.evasions, "evasion"),
                             result.seed, result.compute_s, result.longest_step_s * 1e3));
}

/// Warns of pairs that are checked although they touch at zero, and of parts of the problem that an
/// execution does not use.
void warnOfProblem(const planner::Problem& problem, const std::string& file) {
  printWarnings(planner::CompiledScene(problem).warnings());
  for (const planner::DeformingObstacle& obstacle : problem.world.deforming) {
    if (!obstacle.motion) {
      printWarnings({fmt::format("{}: obstacle '{}' has no motion: it stands still here", file,
                                 obstacle.object.name)});
    }
  }
  for (const planner::Object& object : problem.world.objects) {
    if (object.motion && !object.motion->poses) {
      printWarnings({fmt::format(
          "{}: object '{}' is seen only once, at the start: it may be anywhere that its bounds "
          "allow",
          file, object.name)});
    }
  }
}

bool isLog(const std::string& output) { return robots::endingOf(output) == kLogEnding; }

/// Handles each step when it is done. Prints JSON lines, or collects rows of a table for the end;
/// shows progress; and keeps the steps for a page, and their lines for a file.
class StepLog {
 public:
  StepLog(const planner::Problem& problem, const ReplanArguments& arguments, bool json)
      : problem_(problem),
        most_steps_(arguments.steps),
        json_(json),
        keep_(!json || !arguments.view.file.empty()),
        keep_lines_(isLog(arguments.output)) {}

  void add(const planner::ReplanStep& step) {
    if (keep_) kept_.push_back(step);
    std::string line;
    if (json_ || keep_lines_) line = planner::logLine(problem_, step) + "\n";
    if (keep_lines_) lines_ += line;
    if (json_) {
      endProgress();
      fmt::print("{}", line);
      std::fflush(stdout);
    } else {
      rows_.add(step);
    }
    ++begun_;
    state_ = fmt::format(", {:.2f} s", step.time);
    if (std::isfinite(step.remaining_s))
      state_ += fmt::format(", {:.2f} s of path left", step.remaining_s);
  }

  void show(const std::string& phase) const {
    const std::string of = most_steps_ > 0 ? fmt::format(" of {}", most_steps_) : "";
    showProgress(fmt::format("step {}{}{}: {}", begun_, of, state_, phase));
  }

  const std::vector<planner::ReplanStep>& kept() const { return kept_; }
  std::string table(const view::ExecutedClearance& executed) const { return rows_.text(executed); }
  /// Those of all steps, if they are written to a file.
  const std::string& lines() const { return lines_; }

 private:
  const planner::Problem& problem_;
  int most_steps_;
  bool json_, keep_, keep_lines_;
  int begun_ = 1;
  std::string state_;
  Rows rows_;
  std::vector<planner::ReplanStep> kept_;
  std::string lines_;
};

int runReplan(const ReplanArguments& arguments) {
  if (arguments.json && arguments.text) {
    throw robots::InputError("command line", 0, "--json and --text exclude each other");
  }
  if (!arguments.output.empty()) {
    checkOutputFile(arguments.output, kOutputEndings);
  }
  view::expectPage(arguments.view);
  expectApart(std::array{arguments.output, arguments.view.file}, filesOf(arguments.source));
  const auto start = std::chrono::steady_clock::now();
  planner::Problem problem = loadProblem(arguments.source, arguments.overrides);
  refuseSteps(problem, "replan");
  const double load_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  warnOfProblem(problem, arguments.source.problem);
  const bool json = arguments.json || (!arguments.text && isatty(STDOUT_FILENO) != 1);
  StepLog log(problem, arguments, json);
  planner::ReplanOptions options;
  options.stop = interactivePlanOptions().stop;
  options.progress = [&](const std::string& phase, double) { log.show(phase); };
  const planner::ReplanResult result = planner::replan(
      problem, options, [&](const planner::ReplanStep& step) { log.add(step); }, arguments.steps);
  endProgress();
  const std::string end = planner::logLine(problem, result, load_s) + "\n";
  if (isLog(arguments.output)) {
    planner::writeFileWhole(arguments.output, log.lines() + end);
  } else if (!arguments.output.empty()) {
    planner::writeTrajectory(arguments.output, problem, result.trajectory);
  }
  if (!arguments.view.file.empty()) {
    view::writePage(arguments.view, view::subjectOfExecution(problem, arguments.source.problem,
                                                             log.kept(), result.status));
  }
  if (json) {
    fmt::print("{}", end);
  } else {
    const view::ExecutedClearance executed = view::executedClearance(
        problem, std::make_shared<const planner::CompiledScene>(problem), log.kept(), interrupted);
    fmt::print("{}\n{}\n{}", verdictLine(problem, result, executed), log.table(executed),
               summaryText(result, executed));
  }
  return result.status == planner::ReplanStatus::kReached && result.certified ? kYes : kNo;
}

}  // namespace

Verb addReplan(CLI::App& command) {
  auto arguments = std::make_shared<ReplanArguments>();
  CLI::App* app =
      command.add_subcommand("replan", "execute a problem step by step while its obstacles move");
  addProblemArguments(*app, arguments->source);
  addPlanOverrides(*app, arguments->overrides);
  app->remove_option(app->get_option("--upright"));  // executions keep no constraint
  app->add_option("--steps", arguments->steps, "most steps; 0: until the execution ends")
      ->type_name("N")
      ->check(countFrom(0, 1'000'000'000));
  app->add_option("--output", arguments->output,
                  "write what was executed: time and joints (.csv), or the log (.jsonl): the lines "
                  "of --json, which `verify --log` proves")
      ->type_name("FILE");
  view::addPageOptions(*app, arguments->view);
  app->add_flag("--json", arguments->json,
                "print one JSON document a step and one at the end; so it is where stdout is no "
                "terminal");
  app->add_flag("--text", arguments->text, "print a table");
  app->footer(
      std::string(kReplanKeys) +
      "\nThe limits (--time, --iterations) apply to each planning. Exit status 0: in a goal, every "
      "step certified.\nExample:\n  leeway replan problems/deforming/curtain.yaml --text");
  return {app, [arguments] { return runReplan(*arguments); }};
}

}  // namespace leeway::tools
