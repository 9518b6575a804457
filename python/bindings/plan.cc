#include "python/bindings/plan.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "leeway/planner/cloud_notes.h"
#include "leeway/planner/path_io.h"
#include "leeway/planner/task.h"
#include "leeway/planner/verify.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/base/warn.h"
#include "python/bindings/scene.h"
#include "python/bindings/settings.h"

namespace leeway::python {
namespace {

py::object take(py::dict& keywords, const char* name) {
  if (!keywords.contains(name)) return py::none();
  return keywords.attr("pop")(name);
}

/// What plan() takes besides the problem.
struct CallOptions {
  planner::PlanOptions plan;
  py::object stop, progress, on_path;

  explicit CallOptions(py::dict& keywords)
      : stop(take(keywords, "stop")),
        progress(take(keywords, "progress")),
        on_path(take(keywords, "on_path")) {
    const py::object certificate = take(keywords, "certificate");
    if (!certificate.is_none()) {
      const std::string word = py::str(certificate);
      if (word != "path" && word != "full") unknownWord("certificate", word, "'path' or 'full'");
      if (word == "full") plan.detail = planner::CertificateDetail::kEveryEdge;
    }
    const py::object tolerance = take(keywords, "tolerance");
    if (!tolerance.is_none()) plan.clearance_tolerance = number(tolerance, "tolerance");
    if (!(plan.clearance_tolerance > 0)) throw py::value_error("tolerance is not positive");
    if (!progress.is_none() && PyCallable_Check(progress.ptr()) == 0)
      throw py::type_error("progress is no function; one of (phase, seconds) is expected");
    if (!on_path.is_none() && PyCallable_Check(on_path.ptr()) == 0)
      throw py::type_error("on_path is no function; one of (path, length) is expected");
  }
  /// Stops where `interrupt` does, and tells the caller's function how far it is.
  planner::PlanOptions with(Interrupt& interrupt) const {
    planner::PlanOptions options = plan;
    options.stop = interrupt.callback();
    if (!progress.is_none())
      options.progress = [this, &interrupt](const std::string& phase, double seconds) {
        const py::gil_scoped_acquire locked;
        try {
          progress(phase, seconds);
        } catch (...) {
          interrupt.fail();
        }
      };
    if (!on_path.is_none())
      options.on_path = [this, &interrupt](const std::vector<std::vector<double>>& path,
                                           double length) {
        const py::gil_scoped_acquire locked;
        try {
          on_path(array(path, path.empty() ? 0 : path.front().size()), length);
        } catch (...) {
          interrupt.fail();
        }
      };
    return options;
  }
};

Result planOne(const py::args& args, const py::kwargs& kwargs) {
  py::dict keywords = kwargs.attr("copy")();
  const CallOptions options(keywords);
  const Problem problem = problemOf("plan", args, keywords, true);
  noMore("plan", keywords);
  requireGoal(problem);
  Interrupt interrupt(options.stop);
  const planner::PlanOptions run = options.with(interrupt);
  const std::shared_ptr<const planner::Problem> value = problem.value();
  Result result{value, released([&] { return planner::solve(*value, run); })};
  interrupt.rethrow();
  return result;
}

/// Problems planned by several threads, each by one: the same results whatever their number.
class Crew {
 public:
  using Problems = std::vector<std::shared_ptr<const planner::Problem>>;
  Crew(const Problems& problems, const planner::PlanOptions& options, int threads)
      : problems_(problems), options_(options), results_(problems.size()) {
    options_.stop = [this] { return stop_.load(); };
    for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
  }
  ~Crew() { join(); }
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  /// Waits for all; asks `interrupt` meanwhile.
  void wait(Interrupt& interrupt) {
    std::unique_lock lock(mutex_);
    while (idle_ < threads_.size()) {
      done_.wait_for(lock, std::chrono::milliseconds(20));
      if (stop_) continue;
      lock.unlock();
      if (interrupt()) stop_ = true;
      lock.lock();
    }
  }
  /// After wait(): throws what the first failing problem threw.
  std::vector<planner::PlanResult> take() {
    join();
    if (error_) std::rethrow_exception(error_);
    return std::move(results_);
  }

 private:
  void join() {
    for (std::thread& thread : threads_)
      if (thread.joinable()) thread.join();
  }
  void work() {
    for (std::size_t i = next_++; i < problems_.size() && !stop_; i = next_++) {
      try {
        results_[i] = planner::solve(*problems_[i], options_);
      } catch (...) {
        const std::lock_guard lock(mutex_);
        if (!error_ || i < first_error_) {
          error_ = std::current_exception();
          first_error_ = i;
        }
      }
    }
    const std::lock_guard lock(mutex_);
    ++idle_;
    done_.notify_all();
  }

  const Problems& problems_;
  planner::PlanOptions options_;
  std::vector<planner::PlanResult> results_;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> stop_ = false;
  std::mutex mutex_;
  std::condition_variable done_;
  std::size_t idle_ = 0, first_error_ = 0;
  std::exception_ptr error_;
  std::vector<std::thread> threads_;
};

py::list planMany(const py::object& given, const py::kwargs& kwargs) {
  py::dict keywords = kwargs.attr("copy")();
  const py::object wanted = take(keywords, "threads");
  const CallOptions options(keywords);
  if (!options.progress.is_none() || !options.on_path.is_none())
    throw py::type_error("plan_many(): progress and on_path are of plan() alone");
  std::vector<Problem> problems;
  for (const py::handle item : given) {
    if (!py::isinstance<Problem>(item))
      throw py::type_error(std::string("plan_many(): problems hold a ") +
                           Py_TYPE(item.ptr())->tp_name + "; a Problem is expected");
    problems.push_back(item.cast<const Problem&>());
    requireGoal(problems.back());
  }
  py::dict settings;
  for (const auto& [key, value] : keywords)
    if (isSetting(py::str(key))) settings[key] = value;
  for (const auto& [key, value] : settings) keywords.attr("pop")(key);
  noMore("plan_many", keywords);
  Crew::Problems values;
  for (Problem& problem : problems) {
    if (!settings.empty()) problem.apply(settings);
    values.push_back(problem.value());
  }
  int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  if (!wanted.is_none()) {
    threads = whole<int>(wanted, "threads");
    if (threads < 1) throw py::value_error("threads are below 1; at least one is expected");
  }
  threads = std::min(threads, static_cast<int>(std::max<std::size_t>(1, problems.size())));
  Interrupt interrupt(options.stop);
  std::vector<planner::PlanResult> results = released([&] {
    Crew crew(values, options.plan, threads);
    crew.wait(interrupt);
    return crew.take();
  });
  interrupt.rethrow();
  py::list list;
  for (std::size_t i = 0; i < values.size(); ++i)
    list.append(Result{values[i], std::move(results[i])});
  return list;
}

/// An outcome, with what is odd about its problem.
struct Verification : planner::VerifyResult {
  std::vector<std::string> warnings, notes;
};

Verification verify(const Problem& problem, const py::object& path, bool shortest,
                    const py::object& stop) {
  const planner::Path given = pathOf(problem, path, shortest, true);
  requireGoal(problem);
  Interrupt interrupt(stop);
  const std::shared_ptr<const planner::Problem> value = problem.value();
  planner::PlanOptions options;
  options.stop = interrupt.callback();
  Verification result{released([&] { return planner::verify(*value, given, options); }),
                      planner::problemWarnings(*value), planner::cloudNotes(*value)};
  interrupt.rethrow();
  return result;
}

Verification verifyLog(const Problem& problem, const py::object& file, const py::object& stop) {
  const std::string name = fileName(file, "file");
  requireGoal(problem);
  Interrupt interrupt(stop);
  const std::shared_ptr<const planner::Problem> value = problem.value();
  planner::PlanOptions options;
  options.stop = interrupt.callback();
  Verification result{released([&] { return planner::verifyLog(*value, name, options); }),
                      planner::problemWarnings(*value), planner::cloudNotes(*value)};
  interrupt.rethrow();
  return result;
}

/// The path with `parts` edges in place of each.
planner::Path parted(const planner::ConfigurationSpace& space, const planner::Path& path,
                     int parts) {
  planner::Path result;
  result.names = path.names;
  for (std::size_t i = 0; i + 1 < path.positions.size(); ++i)
    for (int k = 0; k < parts; ++k) {
      std::vector<double> point(path.positions[i].size());
      space.alongLine(path.positions[i], path.positions[i + 1], static_cast<double>(k) / parts,
                      point);
      result.positions.push_back(std::move(point));
    }
  result.positions.push_back(path.positions.back());
  return result;
}

planner::Certificate clearance(const Problem& problem, const py::object& path, double tolerance,
                               int parts, bool shortest) {
  const planner::Path given = pathOf(problem, path, shortest);
  if (given.positions.size() < 2)
    throw py::value_error("path has fewer than two waypoints: there is no edge to measure");
  if (!(tolerance > 0) || parts < 1 || parts > 100000)
    throw py::value_error("tolerance must be positive and parts between 1 and 100000");
  const std::shared_ptr<const planner::Problem> value = problem.value();
  if (!value->steps.empty())
    throw py::value_error(
        "clearance: the problem has steps, between which its world changes; a problem without "
        "steps is expected (verify() and the command `leeway clearance` take one with steps)");
  Interrupt interrupt;
  return interrupt.released([&] {
    const auto scene = std::make_shared<const planner::CompiledScene>(*value, interrupt.callback());
    planner::EdgeCertifier certifier(scene);
    const planner::Path in_parts = parts == 1 ? given : parted(scene->space(), given, parts);
    planner::Certificate certificate = planner::certify(certifier, in_parts, tolerance);
    auto proven = planner::proveConstraints(*scene, *value, in_parts);
    certificate.certified = certificate.certified && proven;
    if (proven) certificate.constraints = std::move(*proven);
    return certificate;
  });
}

const char* statusName(planner::VerifyStatus status) {
  return status == planner::VerifyStatus::kCertified        ? "certified"
         : status == planner::VerifyStatus::kRefuted        ? "refuted"
         : status == planner::VerifyStatus::kNothingChecked ? "nothing_checked"
         : status == planner::VerifyStatus::kExposed        ? "exposed"
                                                            : "undecided";
}

void defineVerification(py::module_& module) {
  py::class_<Verification> result(module, "Verification",
                                  "The outcome of an independent proof. True if certified.");
  defineConstant(
      result, "status", [](const Verification& self) { return statusName(self.status); },
      "'certified', 'refuted', 'undecided', 'nothing_checked': no pair of shapes is checked; of a "
      "log also 'exposed': obstacles may reach the robot where it stands, and all else is proven.");
  result.def_readonly("lower", &Verification::clearance_lower,
                      "Every point of a certified path keeps at least this [m]; inf where nothing "
                      "is near.");
  result.def_readonly("edge", &Verification::segment,
                      "The edge that fails or is undecided; -1: none.");
  result.def_readonly("line", &Verification::line,
                      "The line of a log that fails or is not proven; 0: none.");
  defineConstant(
      result, "t", [](const Verification& self) { return py::make_tuple(self.t0, self.t1); },
      "The part of that edge, in [0, 1]; of a log: times [s].");
  defineConstant(
      result, "pair", [](const Verification& self) { return pairObject(self.a, self.b); },
      "What is too near there, or None.");
  result.def_readonly("reason", &Verification::reason, "In words.");
  defineConstant(
      result, "unchecked", [](const Verification& self) { return uncheckedList(self.unchecked); },
      "Pairs that were not looked at, as Certificate.unchecked.");
  defineConstant(result, "warnings", &Verification::warnings, "Those of the problem.");
  defineConstant(
      result, "notes", [](const Verification& self) { return listOf(self.notes); },
      "Those of the problem.");
  result.def("__bool__", [](const Verification& self) {
    return self.status == planner::VerifyStatus::kCertified;
  });
  result.def("__repr__", [](const Verification& self) {
    std::string what = std::string("<leeway.Verification: ") + statusName(self.status);
    if (self.status == planner::VerifyStatus::kCertified)
      return what + (std::isinf(self.clearance_lower)
                         ? ", nothing near>"
                         : ", at least " + text(self.clearance_lower) + " m>");
    return what + (self.reason.empty() ? "" : ": " + self.reason) + ">";
  });
}

}  // namespace

namespace {

/// `cubics`: the motion of a Trajectory or of a file with blended corners is taken as it is.
planner::Path givenPath(const Problem& problem, const py::object& path, bool cubics) {
  if (cubics)
    if (auto motion = motionOfTrajectory(path)) return *std::move(motion);
  if (py::isinstance<Result>(path)) {
    const Result& result = path.cast<const Result&>();
    const Robot robot = problem.robot();
    const std::vector<std::string>& names = result.value.path.names;
    std::vector<std::string> planned;
    for (std::size_t i = 0; i < robot.size(); ++i) planned.push_back(robot.variableName(i));
    if (names != planned) {
      throw py::value_error("path is a result of the joints " + listed(names) + "; " +
                            listed(planned) + " are expected, in this order");
    }
    return result.value.path;
  }
  if (py::isinstance<py::str>(path) || py::hasattr(path, "__fspath__")) {
    const std::string file = fileName(path, "path");
    const std::shared_ptr<const planner::Problem> value = problem.value();
    std::vector<std::string> warnings;
    planner::Path read = released(
        [&] { return planner::readPath(file, *value, {.cubics = cubics, .warnings = &warnings}); });
    for (const std::string& warning : warnings) warn(warning);
    return read;
  }
  const Rows given = rows(path, "path", problem.size(), 2);
  if (given.shape.size() != 1)
    throw py::value_error("path is a single state; (n, joints) is expected");
  planner::Path result;
  const Robot robot = problem.robot();
  for (std::size_t i = 0; i < robot.size(); ++i) result.names.push_back(robot.variableName(i));
  for (std::size_t i = 0; i < given.count(); ++i)
    result.positions.emplace_back(given.row(i).begin(), given.row(i).end());
  return result;
}

}  // namespace

planner::Path pathOf(const Problem& problem, const py::object& path, bool shortest, bool cubics) {
  planner::Path given = givenPath(problem, path, cubics);
  if (shortest) {
    const planner::Problem& of = *problem.value();
    given.positions = planner::unwrapped(
        planner::ConfigurationSpace(of.robot.model, of.robot.variables), given.positions);
  }
  return given;
}

py::list uncheckedList(std::span<const planner::UncheckedPairs> unchecked) {
  py::list list;
  for (const planner::UncheckedPairs& group : unchecked) {
    py::list names;
    for (const auto& [a, b] : group.names) names.append(py::make_tuple(a, b));
    list.append(py::make_tuple(toString(group.why), group.count, names));
  }
  return list;
}

void definePlan(py::module_& module) {
  define(module, "plan",
         "(robot, world=None, start=None, goal=None, *, stop=None, progress=None, on_path=None, "
         "certificate='path', tolerance=0.0001, **settings)",
         "Plans a path, or a task's steps, and proves the clearance of every edge. Also "
         "plan(problem, **settings).\n\n"
         "Settings are those of Problem: margin=0.01, time=1, seed=2, planner='RRTstar', ... "
         "`stop()` is asked some fifty times a second and ends the run with True; "
         "progress(phase, seconds) is told how far it is; on_path(path, length) each better path "
         "while parameters={'improve': seconds} has Connect look for shorter ones; a signal "
         "(Ctrl-C) ends it in the main "
         "thread. certificate='full' bounds every edge's clearance to within `tolerance` [m]. Runs "
         "without the interpreter's lock.\n"
         "Raises InputError for what a problem can get wrong.",
         planOne);
  define(module, "plan_many", "(problems, *, threads=None, stop=None, **settings)",
         "Plans a list of problems on several threads (default: all cores). The results, in the "
         "same order, have the same bytes for any number of threads.",
         planMany, py::arg("problems"));
  define(module, "verify", "(problem, path, *, shortest=False, stop=None)",
         "Proves or refutes that a path keeps all margins, independently of what planned it. "
         "`path`: a Result, an array (n, joints), a Trajectory or a file of one; the blends of a "
         "Trajectory are proven as they are executed. Rows mean straight lines: a continuous "
         "joint goes from 3 to -3 by 6 rad; with `shortest` it goes the shorter way.",
         verify);
  define(module, "verify_log", "(problem, file, *, stop=None)",
         "Proves or refutes the log of an execution, a file with the lines that Step.log and "
         "Executed.log have, or that `leeway replan` prints: each step kept all margins and limits "
         "among what was observed. Raises InputError for a line that was cut or changed.",
         verifyLog);
  define(module, "clearance", "(problem, path, *, tolerance=0.0001, parts=1, shortest=False)",
         "The clearance along a path, each edge cut into `parts`, to within `tolerance` [m]: a "
         "Certificate. `path` and `shortest` as for verify().",
         clearance);
  defineVerification(module);
}

}  // namespace leeway::python
