#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <thread>
#include <variant>

#include "leeway/planner/plan.h"
#include "leeway/planner/planners.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "tools/leeway/batch/batch_list.h"
#include "tools/leeway/batch/batch_output.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"
#include "tools/leeway/support/warning_log.h"

namespace leeway::tools {
namespace {

using Clock = std::chrono::steady_clock;

struct Arguments {
  ProblemSource source;  ///< robot, srdf and packages only
  PlanOverrides overrides;
  std::vector<std::string> inputs;
  std::string shard, output;
  bool resume = false, verify = false;
  int repeat = 1, jobs = 1;
};

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What became of the problems, for the last line on stderr and for the exit status.
struct Tally {
  int solved = 0, unsolved = 0, invalid = 0, not_verified = 0, bad_input = 0, faults = 0;
  std::vector<double> plan_s, total_s;

  int status() const {
    if (faults > 0) {
      return kInternal;
    }
    if (bad_input > 0) {
      return kBadInput;
    }
    return unsolved + invalid + not_verified > 0 ? kNo : kYes;
  }

  void add(const Tally& more) {
    solved += more.solved;
    unsolved += more.unsolved;
    invalid += more.invalid;
    not_verified += more.not_verified;
    bad_input += more.bad_input;
    faults += more.faults;
    plan_s.insert(plan_s.end(), more.plan_s.begin(), more.plan_s.end());
    total_s.insert(total_s.end(), more.total_s.begin(), more.total_s.end());
  }
};

/// What became of one problem: kept apart until its turn, whoever solved it.
struct Outcome {
  Json line;
  std::vector<std::string> warnings;
  std::string error;  ///< for stderr; empty: none
  Tally tally;
  bool cut = false;  ///< short, by an interrupt: no part of the answer
};

double median(std::vector<double> values) {
  if (values.empty()) {
    return 0;
  }
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

planner::Problem load(const Arguments& arguments, const std::shared_ptr<const robots::Model>& model,
                      const BatchItem& item, std::vector<std::string>& warnings) {
  const auto add = [&warnings](const std::vector<std::string>& more) {
    warnings.insert(warnings.end(), more.begin(), more.end());
  };
  if (!item.error.empty()) {
    throw robots::InputError(item.problem, 0, item.error);
  }
  planner::Problem problem;
  if (model) {
    problem = planner::loadMoveit(model, item.problem, item.request);
  } else {
    problem = planner::loadProblem(item.problem, {.load = loadOptions(arguments.source)});
    add(problem.robot.model->warnings);
  }
  add(problem.warnings);
  return problem;
}

void count(const planner::PlanResult& result, Tally& tally) {
  switch (result.status) {
    case planner::PlanStatus::kSolved:
      // A path without its proof is not an answer.
      result.certificate.certified ? ++tally.solved : ++tally.unsolved;
      tally.plan_s.push_back(result.plan_s);
      tally.total_s.push_back(result.compile_s + result.plan_s + result.simplify_s + result.push_s +
                              result.certify_s);
      break;
    case planner::PlanStatus::kUnsolved:
      ++tally.unsolved;
      break;
    case planner::PlanStatus::kInvalidStart:
    case planner::PlanStatus::kInvalidGoal:
      ++tally.invalid;
      break;
  }
}

/// Whether the clock decides what comes out: a planner improves its path as long as it may, or a
/// plan took most of its time.
bool isTimed(const planner::Problem& problem, const planner::PlanResult& result) {
  const planner::PlannerTraits* traits = planner::findPlanner(problem.planner.name);
  return !result.deterministic || traits == nullptr || traits->optimizing ||
         !std::holds_alternative<planner::MinimumLength>(problem.objective) ||
         result.plan_s + result.simplify_s + result.push_s + result.certify_s >
             0.5 * problem.limits.time;
}

/// Plans a problem some times: its times are the medians. What the clock does not decide must come
/// out the same each time.
planner::PlanResult planRepeatedly(const planner::Problem& problem,
                                   const planner::PlanOptions& options, int repeat) {
  planner::PlanResult result = planner::plan(problem, options);
  std::vector<double> compile_s{result.compile_s}, plan_s{result.plan_s},
      simplify_s{result.simplify_s}, push_s{result.push_s}, certify_s{result.certify_s};
  for (int i = 1; i < repeat && !interrupted(); ++i) {
    const planner::PlanResult again = planner::plan(problem, options);
    if (!isTimed(problem, result) && !isTimed(problem, again) &&
        again.path.positions != result.path.positions) {
      throw std::logic_error(problem.name + ": planned twice, with two paths");
    }
    compile_s.push_back(again.compile_s);
    plan_s.push_back(again.plan_s);
    simplify_s.push_back(again.simplify_s);
    push_s.push_back(again.push_s);
    certify_s.push_back(again.certify_s);
  }
  result.compile_s = median(compile_s);
  result.plan_s = median(plan_s);
  result.simplify_s = median(simplify_s);
  result.push_s = median(push_s);
  result.certify_s = median(certify_s);
  return result;
}

Json solve(const Arguments& arguments, const std::shared_ptr<const robots::Model>& model,
           const BatchItem& item, Outcome& outcome) {
  const auto start = Clock::now();
  planner::Problem problem = load(arguments, model, item, outcome.warnings);
  apply(arguments.overrides, problem);
  const double load_s = secondsSince(start);
  planner::PlanOptions options = planOptions(arguments.overrides);
  // Of several problems at once only how many are done is shown.
  if (arguments.jobs > 1) options.progress = nullptr;
  const planner::PlanResult result = planRepeatedly(problem, options, arguments.repeat);
  outcome.warnings.insert(outcome.warnings.end(), result.warnings.begin(), result.warnings.end());
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
    if (verified.status != planner::VerifyStatus::kCertified) {
      ++outcome.tally.not_verified;
    }
  }
  if (arguments.verify) {
    document["verify"] = verification;
  }
  count(result, outcome.tally);
  return document;
}

/// A line of the run before counts as it counted then.
void countKept(const std::string& line, Tally& tally) {
  const auto document = nlohmann::json::parse(line);
  const std::string status = document["status"];
  const auto flag = [](const nlohmann::json& object, const char* key) {
    return object.is_object() && object.value(key, false);
  };
  if (status == "solved" && document.contains("certificate") &&
      flag(document["certificate"], "certified")) {
    ++tally.solved;
  } else {
    status == "solved" || status == "unsolved" ? ++tally.unsolved : ++tally.invalid;
  }
  if (document.contains("verify") && document["verify"].is_object() &&
      document["verify"]["status"] != "certified") {
    ++tally.not_verified;
  }
}

/// One line, whatever happens: bad input and faults of our own are told in it and on stderr, and
/// the batch goes on.
Outcome solveOrReport(const Arguments& arguments, const std::shared_ptr<const robots::Model>& model,
                      const BatchItem& item) {
  Outcome outcome;
  outcome.line = {{"problem", item.problem}};
  Json answer;
  try {
    answer = solve(arguments, model, item, outcome);
  } catch (const robots::InputError& error) {
    ++outcome.tally.bad_input;
    answer = {{"status", "error"}, {"error", error.what()}};
  } catch (const std::exception& error) {
    ++outcome.tally.faults;
    answer = {{"status", "internal_error"}, {"error", error.what()}};
  }
  if (answer.contains("error")) outcome.error = answer["error"];
  outcome.line.update(answer);
  outcome.cut = interrupted();
  return outcome;
}

/// Solves problems in as many threads as there are jobs, and hands them out in their order.
class Jobs {
 public:
  Jobs(const Arguments& arguments, std::shared_ptr<const robots::Model> model,
       std::vector<const BatchItem*> items)
      : arguments_(arguments),
        model_(std::move(model)),
        items_(std::move(items)),
        outcomes_(items_.size()) {
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

  /// The next problem's outcome. Waits for it; one job solves it here.
  Outcome take() {
    const std::size_t i = taken_++;
    if (threads_.empty()) return solveOrReport(arguments_, model_, *items_[i]);
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
      if (!interrupted()) outcome = solveOrReport(arguments_, model_, *items_[i]);
      const std::lock_guard<std::mutex> lock(mutex_);
      outcomes_[i] = std::move(outcome);
      solved_.notify_one();
    }
  }

  const Arguments& arguments_;
  std::shared_ptr<const robots::Model> model_;
  std::vector<const BatchItem*> items_;
  std::vector<std::optional<Outcome>> outcomes_;
  std::size_t taken_ = 0;
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
  std::condition_variable solved_;
  std::vector<std::thread> threads_;
};

void printSummary(const Tally& tally, std::size_t count, std::size_t kept, bool verified) {
  std::string text = fmt::format(
      "{} problems: {} solved, {} unsolved, {} with an invalid start or goal, {} with bad input",
      count, tally.solved, tally.unsolved, tally.invalid, tally.bad_input);
  if (verified) {
    text += fmt::format(", {} not verified", tally.not_verified);
  }
  if (tally.faults > 0) {
    text += fmt::format(", {} faults of this program", tally.faults);
  }
  if (kept > 0) {
    text += fmt::format("; {} kept from the run before", kept);
  }
  if (!tally.plan_s.empty()) {
    text += fmt::format(
        "; median {:.2f} ms of planning, {:.2f} ms with compiling, simplifying and certifying",
        median(tally.plan_s) * 1e3, median(tally.total_s) * 1e3);
  }
  fmt::print(stderr, "{}\n", text);
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

int run(const Arguments& arguments) {
  if (arguments.resume && arguments.output.empty()) {
    throw robots::InputError("command line", 0, "--resume continues a file: name it with --output");
  }
  const std::vector<BatchItem> items = listItems(arguments);
  WarningLog warnings;
  std::shared_ptr<const robots::Model> model;
  if (!arguments.source.robot.empty()) {
    model = robots::loadModel(arguments.source.robot, arguments.source.srdf,
                              loadOptions(arguments.source));
    warnings.print(model->warnings);
  }
  BatchOutput output(arguments.output, items, arguments.resume, arguments.overrides.seed);
  std::vector<const BatchItem*> open;
  for (const BatchItem& item : items) {
    if (!output.has(item.problem)) open.push_back(&item);
  }
  Jobs jobs(arguments, model, std::move(open));
  Tally tally;
  std::size_t done = 0;
  for (const BatchItem& item : items) {
    ++done;
    if (output.has(item.problem)) {
      countKept(output.line(item.problem), tally);
      continue;
    }
    showProgress(fmt::format("{} of {}: {}", done, items.size(), item.problem));
    const Outcome outcome = jobs.take();
    warnings.print(outcome.warnings);
    if (!outcome.error.empty()) {
      endProgress();
      fmt::print(stderr, "{}\n", outcome.error);
    }
    if (outcome.cut) {
      // This problem was cut short: it is not part of the answer.
      endProgress();
      warnings.printCounts();
      fmt::print(stderr, "interrupted after {} of {} problems{}\n", done - 1, items.size(),
                 arguments.output.empty()
                     ? ""
                     : fmt::format("; {} holds them for --resume", output.partialPath()));
      return kNo;
    }
    tally.add(outcome.tally);
    output.add(item.problem, jsonText(outcome.line));
  }
  endProgress();
  output.finish();
  warnings.printCounts();
  printSummary(tally, items.size(), output.keptCount(), arguments.verify);
  return tally.status();
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
      ->check(CLI::Range(1, 1000000));
  app->add_option("--jobs", arguments->jobs,
                  "solve N problems at a time; the output is that of one job, but for times")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  addRobotArguments(*app, arguments->source);
  addPlanOverrides(*app, arguments->overrides);
  app->add_option("--shard", arguments->shard, "only every N-th problem from the i-th")
      ->type_name("i/N");
  app->add_option("--output", arguments->output,
                  "write the lines to FILE; FILE.partial grows until all are done")
      ->type_name("FILE");
  app->add_flag("--resume", arguments->resume, "continue an interrupted --output FILE");
  app->add_flag("--verify", arguments->verify,
                "add the independent verifier's answer to each line");
  app->footer(
      "A line is what `plan --json` prints, with `problem`, the file's path, before it; bad input "
      "is a line too, and the rest goes on.\n\n"
      "Examples:\n"
      "  leeway batch problems/shelf --time 1 --verify --output lines.json\n"
      "  leeway batch problems/shelf --time 1 --shard 1/2\n"
      "  leeway batch problems/shelf --jobs 2");
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace leeway::tools
