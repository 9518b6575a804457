#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <ctime>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <thread>
#include <variant>

#include "collision/base/numbers.h"
#include "leeway/planner/path_io.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/planners.h"
#include "leeway/planner/task.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/groups.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/stopped.h"
#include "planner/base/clock.h"
#include "robots/base/files_read.h"
#include "tools/leeway/batch/batch_list.h"
#include "tools/leeway/batch/batch_output.h"
#include "tools/leeway/batch/file_digests.h"
#include "tools/leeway/batch/ompl_log.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/plan_overrides.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"
#include "tools/leeway/support/warning_log.h"
#include "tools/leeway/view/page_folder.h"
#include "tools/leeway/view/page_options.h"
#include "tools/view/base/figures.h"
#include "tools/view/base/output_file.h"

namespace leeway::tools {
namespace {

using planner::Clock;
using planner::secondsSince;

struct Arguments {
  ProblemSource source;  ///< robot, srdf and packages only
  PlanOverrides overrides;
  std::vector<std::string> inputs;
  std::string shard, output, ompl_log, view;
  bool resume = false, verify = false, pose_goals = false, visual = false;
  int repeat = 1, jobs = 1;
};

/// Counts of the problems by outcome, for the end of stderr and for the exit status.
struct Tally {
  int solved = 0, standing = 0, unsolved = 0, invalid = 0, nothing_checked = 0, not_verified = 0,
      bad_input = 0, faults = 0;
  std::vector<double> plan_s, total_s;

  int status() const {
    if (faults > 0) {
      return kInternal;
    }
    if (bad_input > 0) {
      return kBadInput;
    }
    return unsolved + invalid + nothing_checked + not_verified > 0 ? kNo : kYes;
  }
};

/// The outcome of one problem. Any thread may solve it; it is kept until its turn.
struct Outcome {
  Json line;
  std::vector<std::string> warnings;
  std::string error;      ///< for stderr; empty without one
  bool cut = false;       ///< cut short by an interrupt: not part of the answer
  double time_limit = 0;  ///< of the plan [s]; 0 without one
  view::FolderPage page;
};

/// The least value that this share of all values does not exceed.
double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  return values[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

double median(std::vector<double> values) {
  if (values.empty()) {
    return 0;
  }
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

/// The last links that the planned joints move: together they are moved by all of these.
std::vector<int> lastLinks(const planner::Problem& problem) {
  const robots::Model& model = *problem.robot.model;
  const std::vector<int>& planned = problem.robot.variables;
  std::vector<int> links;
  for (auto v = planned.rbegin(); v != planned.rend(); ++v)
    if (std::none_of(links.begin(), links.end(), [&](int link) {
          return robots::movesLink(model, {&*v, 1}, link);
        }))
      links.push_back(model.joints[at(model.variables[at(*v)].joint)].child_link);
  return links;
}

/// Replaces goals that are single configurations by the poses that the last moved links have there.
/// This turns them into the same tasks for inverse kinematics.
void posesForGoals(planner::Problem& problem, const std::string& file) {
  if (!problem.steps.empty())
    throw robots::InputError(file, 0, "it has steps; --pose-goals is for problems with goals");
  const robots::Model& model = *problem.robot.model;
  const std::vector<int> links = lastLinks(problem);
  std::vector<robots::Pose> X_WL(model.links.size());
  for (planner::Goal& goal : problem.goals) {
    std::vector<double> q = problem.start;
    bool single = !goal.ranges.empty();
    for (std::size_t i = 0; i < goal.ranges.size(); ++i) {
      single = single && goal.ranges[i].first == goal.ranges[i].second;
      q[at(problem.robot.variables[i])] = goal.ranges[i].first;
    }
    if (!single) continue;
    robots::forwardKinematics(model, q, X_WL);
    goal = {goal.name, {}, {}};
    for (const int link : links)
      goal.poses.push_back(robots::PoseRegion::exact(link, {}, {}, X_WL[at(link)]));
  }
}

/// Data that all problems of a run share.
struct Shared {
  std::shared_ptr<const robots::Model> robot;  ///< of --robot; without it, each names its own
  Json robot_files = Json::object();           ///< FileDigests::of() what it was read from
  Json robot_found = Json::array();            ///< foundJson() of it
  FileDigests digests;
};

/// Loads a problem, and adds the digests of the files that it was read from to its line.
planner::Problem load(const Arguments& arguments, Shared& shared, const BatchItem& item,
                      Outcome& outcome) {
  std::vector<std::string>& warnings = outcome.warnings;
  const auto add = [&warnings](const std::vector<std::string>& more) {
    warnings.insert(warnings.end(), more.begin(), more.end());
  };
  if (!item.error.empty()) {
    throw robots::InputError(item.problem, 0, item.error);
  }
  const robots::FilesRead files;
  robots::LoadOptions load = loadOptions(arguments.source);
  load.stop = interrupted;
  planner::Problem problem;
  if (shared.robot) {
    problem = planner::loadMoveit(shared.robot, item.problem, item.request, {.load = load});
  } else {
    problem = planner::loadProblem(item.problem, {.load = load});
    add(problem.robot.model->warnings);
  }
  add(problem.warnings);
  outcome.line["files"] = shared.robot_files;
  outcome.line["files"].update(shared.digests.of(files));
  outcome.line["found"] = shared.robot_found;
  for (Json& found : foundJson(files)) outcome.line["found"].push_back(std::move(found));
  if (arguments.pose_goals) posesForGoals(problem, item.problem);
  apply(arguments.overrides, problem);
  return planner::placeStart(problem);
}

/// Whether the clock affects the result: the planner improves its path until its time is over, or
/// the plan took most of its time.
bool isTimed(const planner::Problem& problem, const planner::PlanResult& result) {
  const planner::PlannerTraits* traits = planner::findPlanner(problem.planner.name);
  return !result.deterministic || traits == nullptr || traits->optimizing ||
         !std::holds_alternative<planner::MinimumLength>(problem.objective) ||
         problem.planner.parameters.count("improve") != 0 ||
         result.plan_s + result.simplify_s + result.improve_s + result.push_s + result.certify_s >
             0.5 * problem.limits.time;
}

/// Plans a problem `repeat` times and reports median times. Results that the clock does not affect
/// must be the same each time.
planner::PlanResult planRepeatedly(const planner::Problem& problem,
                                   const planner::PlanOptions& options, int repeat) {
  planner::PlanResult result = planner::solve(problem, options);
  std::vector<double> compile_s{result.compile_s}, plan_s{result.plan_s},
      simplify_s{result.simplify_s}, improve_s{result.improve_s}, push_s{result.push_s},
      certify_s{result.certify_s};
  for (int i = 1; i < repeat && !interrupted(); ++i) {
    const planner::PlanResult again = planner::solve(problem, options);
    if (!isTimed(problem, result) && !isTimed(problem, again) &&
        again.path.positions != result.path.positions) {
      throw std::logic_error(problem.name + ": planned twice, with two paths");
    }
    compile_s.push_back(again.compile_s);
    plan_s.push_back(again.plan_s);
    simplify_s.push_back(again.simplify_s);
    improve_s.push_back(again.improve_s);
    push_s.push_back(again.push_s);
    certify_s.push_back(again.certify_s);
  }
  result.compile_s = median(compile_s);
  result.plan_s = median(plan_s);
  result.simplify_s = median(simplify_s);
  result.improve_s = median(improve_s);
  result.push_s = median(push_s);
  result.certify_s = median(certify_s);
  return result;
}

Json solve(const Arguments& arguments, Shared& shared, const BatchItem& item, Outcome& outcome) {
  const auto start = Clock::now();
  planner::Problem problem = load(arguments, shared, item, outcome);
  const double load_s = secondsSince(start);
  outcome.time_limit = problem.limits.time;
  planner::PlanOptions options = planOptions(arguments.overrides, problem);
  // The progress line shows how many problems are done, not the progress of each.
  options.progress = nullptr;
  const planner::PlanResult result = planRepeatedly(problem, options, arguments.repeat);
  for (const std::string& warning : result.warnings)
    if (std::find(outcome.warnings.begin(), outcome.warnings.end(), warning) ==
        outcome.warnings.end())
      outcome.warnings.push_back(warning);
  std::optional<planner::Trajectory> trajectory;
  if (result.status == planner::PlanStatus::kSolved) {
    trajectory = planner::trajectoryOf(problem, result.path);
  }
  Json document = toJson(problem, result, trajectory, load_s);
  Json verification;
  if (arguments.verify && result.status == planner::PlanStatus::kSolved) {
    const auto verify_start = Clock::now();
    const planner::VerifyResult verified = planner::verify(problem, result.path, options);
    verification = toJson(verified);
    verification["time_s"] = secondsSince(verify_start);
  }
  if (arguments.verify) {
    document["verify"] = verification;
  }
  if (!arguments.view.empty()) {
    outcome.page =
        view::folderPage(view::subjectOfPlan(problem, item.problem, result, {}, interrupted),
                         arguments.visual, outcome.warnings);
  }
  return document;
}

/// Counts a line by its contents, so that lines of an earlier run count too.
void countLine(const Json& document, Tally& tally) {
  const std::string status = document["status"];
  const auto flag = [](const Json& object, const char* key) {
    return object.is_object() && object.value(key, false);
  };
  if (status == "error") {
    ++tally.bad_input;
  } else if (status == "internal_error") {
    ++tally.faults;
  } else if (status == "solved" && document.contains("certificate") &&
             flag(document["certificate"], "certified")) {
    // A path without its proof is not an answer.
    ++tally.solved;
    if (document.contains("obstacles_at") && document["obstacles_at"].is_number()) ++tally.standing;
  } else if (status == "nothing_checked") {
    ++tally.nothing_checked;
  } else {
    status == "solved" || status == "unsolved" ? ++tally.unsolved : ++tally.invalid;
  }
  if (status == "solved" && document.contains("time_s") && document["time_s"].is_object()) {
    const Json& time = document["time_s"];
    tally.plan_s.push_back(time.value("plan", 0.0));
    double total_s = 0;
    for (const char* stage : {"compile", "plan", "simplify", "improve", "push", "certify"})
      total_s += time.value(stage, 0.0);
    tally.total_s.push_back(total_s);
  }
  if (document.contains("verify") && document["verify"].is_object() &&
      document["verify"]["status"] != "certified") {
    ++tally.not_verified;
  }
}

/// Counts of all problems and of each folder, with folders in the order of their first problems.
class Tallies {
 public:
  using Folder = std::pair<std::string, Tally>;

  void add(const std::string& problem, const Json& line) {
    const std::string folder = std::filesystem::path(problem).parent_path().string();
    auto entry = std::find_if(folders_.begin(), folders_.end(),
                              [&](const Folder& other) { return other.first == folder; });
    if (entry == folders_.end()) entry = folders_.insert(entry, {folder, {}});
    countLine(line, all_);
    countLine(line, entry->second);
  }

  const Tally& all() const { return all_; }
  const std::vector<Folder>& folders() const { return folders_; }

 private:
  Tally all_;
  std::vector<Folder> folders_;
};

/// Always returns one line. Bad input and internal faults are reported in it and on stderr, and the
/// batch goes on.
Outcome solveOrReport(const Arguments& arguments, Shared& shared, const BatchItem& item) {
  Outcome outcome;
  Json answer;
  try {
    answer = solve(arguments, shared, item, outcome);
  } catch (const robots::Stopped& stopped) {  // by an interrupt, which cuts the outcome
    answer = {{"status", "error"}, {"error", stopped.what()}};
  } catch (const robots::InputError& error) {
    answer = {{"status", "error"}, {"error", error.what()}};
  } catch (const std::exception& error) {
    answer = {{"status", "internal_error"}, {"error", error.what()}};
  }
  if (answer.contains("error")) {
    outcome.error = answer["error"];
    outcome.line.clear();
  }
  outcome.line.update(answer);
  outcome.cut = interrupted();
  return outcome;
}

/// Solves problems in one thread per job, and returns them in their order.
class Jobs {
 public:
  Jobs(const Arguments& arguments, Shared& shared, std::vector<const BatchItem*> items)
      : arguments_(arguments), shared_(shared), items_(std::move(items)), outcomes_(items_.size()) {
    if (arguments_.jobs == 1) return;
    const std::size_t threads = std::min(static_cast<std::size_t>(arguments_.jobs), items_.size());
    for (std::size_t i = 0; i < threads; ++i) threads_.emplace_back([this] { run(); });
  }
  ~Jobs() {
    next_ = items_.size();
    for (std::thread& thread : threads_) thread.join();
  }
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;

  /// Waits for the outcome of the next problem and returns it. A single job solves it in this
  /// thread.
  Outcome take() {
    const std::size_t i = taken_++;
    if (threads_.empty()) return solveOrReport(arguments_, shared_, *items_[i]);
    std::unique_lock<std::mutex> lock(mutex_);
    solved_.wait(lock, [&] { return outcomes_[i].has_value(); });
    Outcome outcome = std::move(*outcomes_[i]);
    outcomes_[i].reset();
    return outcome;
  }

 private:
  void run() {
    for (std::size_t i = next_++; i < items_.size(); i = next_++) {
      Outcome outcome;
      outcome.cut = true;
      if (!interrupted()) outcome = solveOrReport(arguments_, shared_, *items_[i]);
      const std::lock_guard<std::mutex> lock(mutex_);
      outcomes_[i] = std::move(outcome);
      solved_.notify_one();
    }
  }

  const Arguments& arguments_;
  Shared& shared_;
  std::vector<const BatchItem*> items_;
  std::vector<std::optional<Outcome>> outcomes_;
  std::size_t taken_ = 0;
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
  std::condition_variable solved_;
  std::vector<std::thread> threads_;
};

void printSummary(const Tally& tally, std::size_t count, std::size_t kept, bool verified) {
  const std::string solved = fmt::format("{} solved", tally.solved);
  const bool colours = isatty(STDERR_FILENO) == 1;  // the text goes there
  std::string text = fmt::format(
      "{}: {}, {} unsolved, {} with an invalid start or goal, {} with bad input",
      counted(count, "problem"), colours ? verdictText(solved, tally.status() == kYes) : solved,
      tally.unsolved, tally.invalid, tally.bad_input);
  if (tally.standing > 0) {
    text += fmt::format(
        ", {} with moving obstacles as they stand at the start (`leeway replan` follows them)",
        tally.standing);
  }
  if (tally.nothing_checked > 0) {
    text += fmt::format(", {} with nothing to check", tally.nothing_checked);
  }
  if (verified) {
    text += fmt::format(", {} not verified", tally.not_verified);
  }
  if (tally.faults > 0) {
    text += fmt::format(", {} of this program",
                        counted(static_cast<std::size_t>(tally.faults), "fault"));
  }
  if (kept > 0) {
    text += fmt::format("; {} kept from the run before", kept);
  }
  if (!tally.plan_s.empty()) {
    text += fmt::format(
        "; median {:.2f} ms of planning, {:.2f} ms with compiling, simplifying, improving, pushing "
        "and certifying",
        median(tally.plan_s) * 1e3, median(tally.total_s) * 1e3);
  }
  fmt::print(stderr, "{}", wrapped(text + "\n"));
}

void printInterrupted(std::size_t done, std::size_t count, const BatchOutput& output,
                      const Arguments& arguments) {
  printMessage(fmt::format("interrupted after {} of {} problems{}", done, count,
                           arguments.output.empty() ? ""
                                                    : fmt::format("; {} holds them for --resume",
                                                                  output.partialPath())));
}

void printTable(const std::vector<Tallies::Folder>& folders) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& [folder, tally] : folders) {
    const int other = tally.invalid + tally.nothing_checked + tally.bad_input + tally.faults;
    const auto ms = [](double seconds) { return fmt::format("{:.2f}", seconds * 1e3); };
    rows.push_back({folder, fmt::format("{}", tally.solved + tally.unsolved + other),
                    fmt::format("{}", tally.solved), fmt::format("{}", tally.unsolved),
                    fmt::format("{}", other), ms(median(tally.plan_s)), ms(median(tally.total_s)),
                    ms(quantile(tally.total_s, 0.95))});
  }
  fmt::print(
      stderr, "{}",
      formatTable({"folder", "all", "solved", "unsolved", "invalid", "plan [ms]", "in all", "95 %"},
                  rows));
}

/// A line of a terminal, in place of JSON.
std::string lineForPeople(const Json& line) {
  std::string status = line["status"];
  const Json certificate = line.value("certificate", Json());
  const Json verified = line.value("verify", Json());
  bool certified =
      status == "solved" && certificate.is_object() && certificate.value("certified", false);
  if (certified && verified.is_object() && verified["status"] != "certified") {
    certified = false;
    status = verified["status"];
  }
  std::string text = fmt::format("{}: {}", line["problem"].get<std::string>(),
                                 verdictText(certified ? "certified" : status, certified));
  if (line.contains("obstacles_at") && line["obstacles_at"].is_number())
    text += fmt::format("; the obstacles stand as at {:g} s", line["obstacles_at"].get<double>());
  if (certified && line.contains("time_s") && line["time_s"].is_object())
    text += fmt::format(", {:.2f} ms of planning", line["time_s"].value("plan", 0.0) * 1e3);
  return text + "\n";
}

/// The options of the command line that affect answers. Each line keeps them, so that lines with
/// different options are not mixed.
Json optionsJson(const Arguments& arguments) {
  Json options = Json::object();
  if (!arguments.source.robot.empty()) options["robot"] = arguments.source.robot;
  if (!arguments.source.srdf.empty()) options["srdf"] = arguments.source.srdf;
  if (!arguments.source.joint_limits.empty())
    options["joint_limits"] = arguments.source.joint_limits;
  for (const auto& [name, given] :
       {std::pair("bounds", &arguments.source.bounds), std::pair("widen", &arguments.source.widen),
        std::pair("xacro", &arguments.source.xacro)})
    if (!given->empty()) options[name] = *given;
  if (arguments.source.visual_as_collision) options["visual_as_collision"] = true;
  options.update(arguments.overrides.json());
  if (arguments.repeat != 1) options["repeat"] = arguments.repeat;
  if (arguments.verify) options["verify"] = true;
  if (arguments.pose_goals) options["pose_goals"] = true;
  if (!arguments.source.packages.empty()) options["package"] = arguments.source.packages;
  return options;
}

std::vector<BatchItem> listItems(const Arguments& arguments) {
  std::vector<BatchItem> items = arguments.source.robot.empty()
                                     ? listProblems(arguments.inputs)
                                     : listMoveitProblems(arguments.inputs);
  std::set<std::string> seen;
  std::vector<BatchItem> unique;
  for (const BatchItem& item : items) {
    if (seen.insert(item.problem).second) {
      unique.push_back(item);
    }
  }
  return arguments.shard.empty() ? unique : selectShard(unique, arguments.shard);
}

constexpr std::array<std::string_view, 1> kLogEndings = {".log"};

std::string oneWord(std::string text) {
  std::replace(text.begin(), text.end(), ' ', '_');
  return text;
}

/// The problems of the command line. No output may overwrite one of them.
std::vector<BatchItem> checkedItems(const Arguments& arguments) {
  if (arguments.resume && arguments.output.empty()) {
    throw robots::InputError("command line", 0, "--resume continues a file: name it with --output");
  }
  const ProblemSource& source = arguments.source;
  if (source.robot.empty() && (!(source.srdf + source.joint_limits).empty() ||
                               !source.bounds.empty() || !source.widen.empty()))
    badUsage(
        "--srdf, --joint-limits, --bounds and --widen go with --robot; problem files name these "
        "themselves");
  if (!arguments.ompl_log.empty()) checkOutputFile(arguments.ompl_log, kLogEndings);
  std::vector<BatchItem> items = listItems(arguments);
  std::vector<std::string> inputs = filesOf(arguments.source);
  for (const BatchItem& item : items) inputs.push_back(item.problem);
  expectApart(std::array{arguments.output, arguments.ompl_log}, inputs);
  return items;
}

void loadRobot(const Arguments& arguments, WarningLog& warnings, Shared& shared) {
  const ProblemSource& source = arguments.source;
  if (source.robot.empty()) return;
  const robots::FilesRead files;
  shared.robot = loadRobotModel(source.robot, source.srdf, source);
  shared.robot_files = shared.digests.of(files);
  shared.robot_found = foundJson(files);
  warnings.print(shared.robot->warnings);
}

/// The log of --ompl-log. Without it, nothing is kept.
class OmplLogFile {
 public:
  explicit OmplLogFile(std::string file) : file_(std::move(file)), begin_(Clock::now()) {
    head_.experiment = oneWord(std::filesystem::path(file_).stem().string());
    head_.started = fmt::format("{:%Y-%m-%dT%H:%M:%S}", fmt::localtime(std::time(nullptr)));
  }

  void add(const Json& line) {
    if (!file_.empty()) lines_.push_back(line);
  }
  /// The log contains the longest time limit of its runs [s].
  void limit(double time) { head_.time_limit = std::max(head_.time_limit, time); }

  void write(const Json& options, const std::vector<BatchItem>& items) {
    if (file_.empty()) return;
    head_.setup = "options: " + jsonText(options) + "\nproblems, in the order of the runs:\n";
    for (const BatchItem& item : items) head_.setup += item.problem + "\n";
    head_.total_s = secondsSince(begin_);
    planner::writeFileWhole(file_, omplLog(head_, lines_));
  }

 private:
  std::string file_;
  Clock::time_point begin_;
  OmplLogHead head_;
  std::vector<Json> lines_;
};

int run(const Arguments& arguments) {
  const std::vector<BatchItem> items = checkedItems(arguments);
  OmplLogFile log(arguments.ompl_log);
  view::PageFolder pages(arguments.view);
  WarningLog warnings;
  Shared shared;
  loadRobot(arguments, warnings, shared);
  const Json options = optionsJson(arguments);
  BatchOutput output(arguments.output, items, arguments.resume, options, shared.digests);
  std::vector<const BatchItem*> open;
  for (const BatchItem& item : items) {
    if (!output.has(item.problem)) open.push_back(&item);
  }
  UnitProgress progress(items.size(), items.size() - open.size());
  Jobs jobs(arguments, shared, std::move(open));
  Tallies tallies;
  const auto count = [&](const std::string& problem, const Json& line) {
    tallies.add(problem, line);
    log.add(line);
  };
  const bool for_people = arguments.output.empty() && isatty(STDOUT_FILENO) == 1;
  std::size_t done = 0;
  for (const BatchItem& item : items) {
    if (output.has(item.problem)) {
      const Json kept = Json::parse(output.line(item.problem));
      count(item.problem, kept);
      pages.add(item.problem, kept, {});
      ++done;
      continue;
    }
    progress.next(item.problem);
    const Outcome outcome = jobs.take();
    warnings.print(outcome.warnings);
    if (!outcome.error.empty()) printMessage(outcome.error);
    if (outcome.cut) {  // not part of the answer
      warnings.printCounts();
      printInterrupted(done, items.size(), output, arguments);
      return kNo;
    }
    Json line = {{"problem", item.problem}, {"version", kJsonVersion}, {"options", options}};
    line.update(outcome.line);
    if (for_people) {
      endProgress();
      fmt::print("{}", wrapped(lineForPeople(line)));
    } else {
      output.add(item.problem, jsonText(line));
    }
    pages.add(item.problem, line, outcome.page);
    count(item.problem, line);
    log.limit(outcome.time_limit);
    ++done;
  }
  endProgress();
  output.finish();
  log.write(options, items);
  pages.finish();
  warnings.printCounts();
  if (!isQuiet()) {
    if (items.size() > 1) printTable(tallies.folders());
    printSummary(tallies.all(), items.size(), output.keptCount(), arguments.verify);
  }
  return tallies.all().status();
}

}  // namespace

Verb addBatch(CLI::App& command) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app =
      command.add_subcommand("batch", "plan many problems in one process, one JSON line each");
  app->add_option(
         "inputs", arguments->inputs,
         "problem files or folders of them; with --robot folders of MoveIt scenes and requests")
      ->type_name("FILE|FOLDER")
      ->required();
  app->add_option("--repeat", arguments->repeat,
                  "plan each problem N times: times are medians, answers must be the same")
      ->type_name("N")
      ->check(countFrom(1, 1000000));
  app->add_option("--jobs", arguments->jobs,
                  "solve N problems at a time; except for times, the output is that of one job")
      ->type_name("N")
      ->check(countFrom(1, 1024));
  addRobotArguments(*app, arguments->source);
  addPlanOverrides(*app, arguments->overrides);
  app->add_option("--shard", arguments->shard, "only every N-th problem from the i-th")
      ->type_name("i/N");
  app->add_option("--output", arguments->output,
                  "write the lines to FILE; FILE.partial grows until all are done")
      ->type_name("FILE");
  app->add_option("--ompl-log", arguments->ompl_log,
                  "also write OMPL's benchmark log, for ompl_benchmark_statistics.py and Planner "
                  "Arena: a run for each problem")
      ->type_name("FILE.log");
  CLI::Option* pages =
      app->add_option("--view", arguments->view,
                      "a page of each problem, and DIR/index.html with their pictures")
          ->type_name("DIR");
  view::addVisual(*app, arguments->visual)->needs(pages);
  app->add_flag("--resume", arguments->resume, "continue an interrupted --output FILE");
  app->add_flag("--pose-goals", arguments->pose_goals,
                "in place of goals that are single configurations, the pose that the last moved "
                "link has there");
  app->add_flag("--verify", arguments->verify,
                "add the independent verifier's answer to each line");
  app->footer(
      "A line is what `plan --json` prints, with `problem`, the file's path, before it; on a "
      "terminal, the verdict. Bad input "
      "also gives a line, and the run continues.\n\nExamples:\n  leeway batch problems/shelf "
      "--time 1 --verify --output lines.json\n  leeway batch problems/shelf --time 1 --shard 1/2\n "
      " leeway batch problems/shelf --jobs 2");
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace leeway::tools
