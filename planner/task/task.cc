#include "leeway/planner/task.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>

#include "collision/base/numbers.h"
#include "leeway/planner/simplify.h"
#include "leeway/robots/input_error.h"
#include "planner/base/clock.h"
#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/base/waypoints.h"
#include "planner/edge/why_undecided.h"
#include "planner/objective/path_cost.h"
#include "planner/search/goal_sampler.h"
#include "planner/search/plan.h"
#include "planner/task/line_motion.h"
#include "planner/task/stages.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

/// One call of planTask(). Searches depth first: a step that succeeds calls the next one.
class TaskPlan {
 public:
  TaskPlan(const Problem& problem, const PlanOptions& options)
      : problem_(problem),
        options_(options),
        kinematics_(problem.robot.model, problem.robot.variables) {}

  PlanResult run() {
    if (problem_.steps.empty()) refuse("there are no steps; at least one is expected");
    result_.seed = problem_.seed;
    result_.planner = problem_.planner.name;
    result_.warnings = problemWarnings(problem_);
    for (const int v : problem_.robot.variables) {
      start_.push_back(problem_.start.at(at(v)));
      result_.path.names.push_back(problem_.robot.model->variables[at(v)].name);
    }
    if (std::none_of(problem_.steps.begin(), problem_.steps.end(), movesRobot)) {
      result_.status = PlanStatus::kNothingChecked;
      result_.reason = kNoMove;
      return std::move(result_);
    }
    stretches_.resize(problem_.steps.size());
    const bool is_whole = solveFrom(0, firstWorld(problem_), start_);
    if (ended_ && at(ended_->end.step) != fault_step_)
      ended_.reset();  // something else failed later
    if (!is_whole && ended_ && !ended_->is_reached && !isDecided() && !isOver()) {
      // No move has yet gone to the beginning of that line.
      takes_part_ = true;
      tries_ = 0;
      solveFrom(0, firstWorld(problem_), start_);
    }
    const bool is_part = !is_whole && ended_ && ended_->is_reached && ended_->place > 0;
    if (is_part) stretches_ = std::move(ended_->stretches);
    result_.plan_s = secondsSince(begin_);
    if (is_whole || is_part) finish(is_whole ? PlanStatus::kSolved : PlanStatus::kPartial);
    if (is_whole) return std::move(result_);
    addTo(result_.warnings, failed_warnings_);
    if (ended_) result_.line_end = std::move(ended_->end);
    if (result_.status != PlanStatus::kInvalidStart && result_.reason.empty())
      result_.reason = fault_;
    return std::move(result_);
  }

 private:
  [[noreturn]] void refuse(const std::string& message) const {
    throw robots::InputError(problem_.name, 0, message);
  }

  /// The result of a step that has succeeded.
  struct Stretch {
    Problem stage;  ///< with names and the configuration at its beginning
    Waypoints points;
    LineDeparture departure;
    std::vector<double> places;              ///< of the points of a line
    std::vector<std::string> warnings = {};  ///< of its move
  };

  /// A line that ends early: of all lines of the farthest step, the longest one.
  struct Ended {
    LineEnd end;
    double place;                         ///< where it ends on its way
    bool is_reached;                      ///< the steps before it have succeeded
    std::vector<Stretch> stretches = {};  ///< if so, these steps and the part of the line
  };

  double timeLimit() const { return problem_.limits.time > 0 ? problem_.limits.time : kInfinity; }
  bool isOver() const {
    return secondsSince(begin_) > timeLimit() || (options_.stop && options_.stop());
  }

  /// Whether planning a step in another way cannot change the outcome.
  bool isDecided() const {
    return result_.status == PlanStatus::kInvalidStart ||
           result_.status == PlanStatus::kNothingChecked;
  }

  /// Adds the warnings that `all` does not contain.
  static void addTo(std::vector<std::string>& all, const std::vector<std::string>& warnings) {
    for (const std::string& warning : warnings)
      if (std::find(all.begin(), all.end(), warning) == all.end()) all.push_back(warning);
  }

  /// The warnings of a step's own search. Those of loaders and scenes are added elsewhere.
  std::vector<std::string> ownWarnings(std::size_t step, const CompiledScene& scene,
                                       const std::vector<std::string>& warnings) const {
    std::vector<std::string> others = problemWarnings(problem_), own;
    const std::vector<std::string> of_scene = scene.warnings();
    others.insert(others.end(), of_scene.begin(), of_scene.end());
    for (const std::string& warning : warnings)
      if (std::find(others.begin(), others.end(), warning) == others.end())
        own.push_back(stepText(problem_, step) + ": " + warning);
    return own;
  }

  /// Remembers why the farthest step failed.
  void fail(std::size_t step, const std::string& why) {
    if (!fault_.empty() && step < fault_step_) return;
    fault_step_ = step;
    fault_ = stepText(problem_, step) + ": " + why;
  }

  bool solveFrom(std::size_t step, const Problem& world, const std::vector<double>& point) {
    if (step == problem_.steps.size()) return true;
    const Step& now = problem_.steps[step];
    Stretch& stretch = stretches_[step];
    try {
      stretch.stage = stageOf(world, now);
    } catch (const std::invalid_argument& error) {
      refuse(stepText(problem_, step) + ": " + error.what());
    }
    if (std::holds_alternative<AttachStep>(now.action) ||
        std::holds_alternative<DetachStep>(now.action)) {
      stretch.points = {point};
      return after(step, world);
    }
    const auto scene = std::make_shared<const CompiledScene>(stretch.stage);
    if (const std::string nothing = scene->nothingChecked(); !nothing.empty()) {
      result_.status = PlanStatus::kNothingChecked;
      return fail(step, nothing), false;
    }
    if (const auto* line = std::get_if<LineStep>(&now.action)) {
      if (step == 0 && !startIsFree(scene, point)) return false;
      LineMotion motion = follow(step, world, scene, *line, point, kLineTries);
      stretch.points = std::move(motion.points);
      stretch.places = std::move(motion.places);
      stretch.departure = motion.departure;
      if (!motion.end) return after(step, world);
      remember(*motion.end, stretch.places.back(), true);
      return takes_part_ && ended_->is_reached;
    }
    return move(step, world, scene, point);
  }

  /// Whether the start keeps its margins. If not, the result names the pair that does not.
  bool startIsFree(const std::shared_ptr<const CompiledScene>& scene,
                   const std::vector<double>& start) {
    EdgeCertifier certifier(scene);
    if (certifier.decide(start) == Verdict::kFree) return true;
    result_.status = PlanStatus::kInvalidStart;
    result_.offending = certifier.tooNear(start, kReportTolerance);
    if (const int pair = result_.offending.pair; pair >= 0) {
      const collision::ScenePair& bodies = scene->scene().pairs()[at(pair)];
      result_.offending_a = scene->scene().bodies()[at(bodies.body_a)].name;
      result_.offending_b = scene->scene().bodies()[at(bodies.body_b)].name;
    }
    result_.reason = whyUndecided(*scene, start);
    fail(0, "its start is not valid");
    count(certifier);
    return false;
  }

  /// Continues with the next step from the end of this one.
  bool after(std::size_t step, const Problem& world) {
    const std::vector<double> end = stretches_[step].points.back();
    std::vector<double> configuration = world.start;
    for (std::size_t i = 0; i < end.size(); ++i)
      configuration[at(world.robot.variables[i])] = end[i];
    std::optional<Problem> next;
    try {
      next = worldAfter(world, problem_.steps[step], configuration);
    } catch (const std::invalid_argument& error) {
      refuse(stepText(problem_, step) + ": " + error.what());
    }
    return solveFrom(step + 1, *next, end);
  }

  /// Follows the line of a step.
  LineMotion follow(std::size_t step, const Problem& world,
                    const std::shared_ptr<const CompiledScene>& scene, const LineStep& line,
                    const std::vector<double>& point, int tries) {
    EdgeCertifier certifier(scene);
    std::optional<LineMotion> motion;
    try {
      motion = followLine(certifier, kinematics_, world, line, point,
                          {tries, problem_.seed, [this] { return isOver(); }});
    } catch (const std::invalid_argument& error) {
      refuse(stepText(problem_, step) + ": " + error.what());
    }
    count(certifier);
    if (motion->end) motion->end->step = static_cast<int>(step);
    return std::move(*motion);
  }

  /// Remembers a line that ends early, unless a line that is remembered is as long.
  void remember(const LineEnd& end, double place, bool is_reached) {
    if (ended_) {
      if (end.step < ended_->end.step) return;
      const bool is_same = end.step == ended_->end.step;
      if (is_same && place < ended_->place) return;
      if (is_same && place == ended_->place && (ended_->is_reached || !is_reached)) return;
    }
    const std::size_t step = at(end.step);
    ended_ = {end, place, is_reached, {}};
    if (is_reached)
      ended_->stretches.assign(stretches_.begin(),
                               stretches_.begin() + static_cast<std::ptrdiff_t>(step) + 1);
    fail(step, end.text);
  }

  bool move(std::size_t step, const Problem& world,
            const std::shared_ptr<const CompiledScene>& scene, const std::vector<double>& point) {
    const Problem stage = stretches_[step].stage;  // the recursion overwrites stretches
    if (stage.goals[0].poses.empty()) return moveTo(step, world, stage, scene, point);
    EdgeCertifier certifier(scene);
    GoalSampler sampler(certifier, stage, stage.seed);
    GoalPoints points = sampler.first([this] { return isOver(); });
    if (points.points.empty()) {
      std::string why = points.reason;
      if (why.empty() && points.closest.pair >= 0)
        why = "its goal is in collision: " + pairText(*scene, points.closest.pair);
      fail(step, why.empty() ? "no valid joint values were found for its goal" : why);
      addTo(failed_warnings_, ownWarnings(step, *scene, points.warnings));
      count(certifier);
      return false;
    }
    // If the lines that follow end early from every goal, those that go farthest are tried again
    // with other motions of the joints that the lines leave free.
    std::vector<Tried> ended;
    const auto goesOn = [&](std::size_t i, int tries) {
      ++tries_;
      const std::vector<double>& goal = points.points[i];
      Tried tried{i};
      if (!linesWork(step, world, goal, tries, tried)) {
        if (tries == 0) ended.push_back(tried);
        return false;
      }
      Problem to = stage;
      to.goals = {{problem_.steps[step].name, {}, {}}};
      for (const double x : goal) to.goals[0].ranges.emplace_back(x, x);
      return moveTo(step, world, to, scene, point);
    };
    bool is_solved = false;
    for (std::size_t i = 0; i < kStepSolutions && !is_solved && !isDecided(); ++i) {
      while (i >= points.points.size() && sampler.more(points) && !isOver()) {
      }
      if (i >= points.points.size() || tries_ >= kTaskTries || isOver()) break;
      is_solved = goesOn(i, 0);
    }
    std::stable_sort(ended.begin(), ended.end(), [](const Tried& a, const Tried& b) {
      return std::pair(a.step, a.place) > std::pair(b.step, b.place);
    });
    ended.resize(std::min(ended.size(), kLongestLines));
    for (const Tried& tried : ended) {
      if (is_solved || isDecided() || tries_ >= kTaskTries || isOver()) break;
      is_solved = goesOn(tried.goal, kLineTries);
    }
    if (is_solved) return count(certifier), true;
    count(certifier);
    if (isOver()) fail(step, "the time limit was reached");
    return false;
  }

  static std::string pairText(const CompiledScene& scene, int pair_index) {
    const collision::ScenePair& pair = scene.scene().pairs()[at(pair_index)];
    return scene.scene().bodies()[at(pair.body_a)].name + " and " +
           scene.scene().bodies()[at(pair.body_b)].name;
  }

  /// One goal of a move, and where the lines that follow it end early.
  struct Tried {
    std::size_t goal;
    std::size_t step = 0;
    double place = 0;
  };

  /// Whether the lines up to the next move succeed from `point`, which takes much less time than a
  /// path. If a part is enough, whether they go as far as the longest remembered line.
  bool linesWork(std::size_t step, const Problem& world, std::vector<double> point, int tries,
                 Tried& tried) {
    Problem now = world;
    for (std::size_t next = step + 1;; ++next) {
      std::vector<double> configuration = now.start;
      for (std::size_t i = 0; i < point.size(); ++i)
        configuration[at(now.robot.variables[i])] = point[i];
      try {
        now = worldAfter(now, problem_.steps[next - 1], configuration);
        if (next == problem_.steps.size() ||
            std::holds_alternative<MoveStep>(problem_.steps[next].action))
          return true;
        const auto* line = std::get_if<LineStep>(&problem_.steps[next].action);
        if (line == nullptr) continue;
        const auto scene =
            std::make_shared<const CompiledScene>(stageOf(now, problem_.steps[next]));
        LineMotion motion = follow(next, now, scene, *line, point, tries);
        if (motion.end) {
          tried.step = next;
          tried.place = motion.places.back();
          remember(*motion.end, tried.place, false);
          return takes_part_ && motion.end->step == ended_->end.step &&
                 tried.place >= ended_->place;
        }
        point = std::move(motion.points.back());
      } catch (const std::invalid_argument& error) {
        refuse(stepText(problem_, next) + ": " + error.what());
      }
    }
  }

  /// Plans to the goal of `stage` and continues with the next step.
  bool moveTo(std::size_t step, const Problem& world, Problem stage,
              const std::shared_ptr<const CompiledScene>& scene, const std::vector<double>& point) {
    // The remaining time is shared among the moves, because some objectives use all of it.
    const auto moves = std::count_if(
        problem_.steps.begin() + static_cast<std::ptrdiff_t>(step), problem_.steps.end(),
        [](const Step& s) { return std::holds_alternative<MoveStep>(s.action); });
    stage.limits.time = (timeLimit() - secondsSince(begin_)) / static_cast<double>(moves);
    if (!(stage.limits.time > 0)) return fail(step, "the time limit was reached"), false;
    if (stage.limits.iterations == 0) stage.limits.iterations = kStepIterations;
    stage.seed = Random(problem_.seed, kTaskStream + step).next() + at(static_cast<int>(tries_));
    for (std::size_t i = 0; i < point.size(); ++i)
      stage.start[at(stage.robot.variables[i])] = point[i];
    PlanOptions options;
    options.stop = options_.stop;
    options.progress = options_.progress;
    options.detail = CertificateDetail::kPath;
    PlanResult planned = planIn(scene, stage, options);
    result_.iterations += planned.iterations;
    result_.states += planned.states;
    result_.edges += planned.edges;
    result_.distance_queries += planned.distance_queries;
    result_.undecided_edges += planned.undecided_edges;
    result_.deterministic = planned.deterministic;
    std::vector<std::string> warnings = ownWarnings(step, *scene, planned.warnings);
    if (planned.status != PlanStatus::kSolved) {
      if (planned.status == PlanStatus::kInvalidStart && step == 0) {
        result_.status = planned.status;
        result_.offending = planned.offending;
        result_.offending_a = planned.offending_a;
        result_.offending_b = planned.offending_b;
        result_.reason = planned.reason;
      }
      result_.blocked = std::move(planned.blocked);
      result_.gap = std::move(planned.gap);
      result_.long_turns = std::move(planned.long_turns);
      std::string why = planned.reason;
      if (why.empty()) {
        why = planned.status == PlanStatus::kInvalidStart  ? "its start is not valid"
              : planned.status == PlanStatus::kInvalidGoal ? "its goal is not valid"
                                                           : "no path was found to its goal";
        if (!planned.offending_a.empty())
          why += ": " + planned.offending_a + " and " + planned.offending_b;
      }
      fail(step, why);
      addTo(failed_warnings_, warnings);
      return false;
    }
    stretches_[step].warnings = std::move(warnings);
    stretches_[step].stage = std::move(stage);
    stretches_[step].points = std::move(planned.path.positions);
    stretches_[step].departure = {};
    return after(step, world);
  }

  void count(EdgeCertifier& certifier) {
    const EdgeCertifier::Statistics work = certifier.statistics;
    result_.states += work.states;
    result_.edges += work.edges;
    result_.distance_queries += work.distance_queries;
    result_.undecided_edges += work.undecided_edges;
  }

  /// Takes the lesser clearance of a path and of a part of it that begins with edge `first`.
  static void takeLeast(PathClearance& whole, const PathClearance& part, int first) {
    const double lower = std::min(whole.clearance.lower, part.clearance.lower);
    if (part.clearance.upper < whole.clearance.upper) {
      whole = part;
      whole.closest_segment += first;
    }
    whole.clearance.lower = lower;
  }

  /// Adds the cost of a stretch, if the problem has costs.
  void addCost(const Stretch& stretch) {
    const auto cost = PathCost::of(CompiledScene(stretch.stage), stretch.stage);
    if (cost == nullptr) return;
    const Interval of_part = cost->reported(stretch.points);
    if (std::isinf(result_.cost.lower)) result_.cost = {0, 0};
    result_.cost = {result_.cost.lower + of_part.lower, result_.cost.upper + of_part.upper};
    const std::vector<WishResult> wishes =
        cost->wishes(stretch.points, options_.clearance_tolerance);
    if (result_.wishes.empty())
      result_.wishes = wishes;
    else
      for (std::size_t i = 0; i < wishes.size(); ++i) takeWish(result_.wishes[i], wishes[i]);
  }

  static void takeWish(WishResult& whole, const WishResult& part) {
    whole.clearance = {std::min(whole.clearance.lower, part.clearance.lower),
                       std::min(whole.clearance.upper, part.clearance.upper)};
    whole.cost = {whole.cost.lower + part.cost.lower, whole.cost.upper + part.cost.upper};
    const auto is = [](const WishResult& wish, bool kept) { return wish.kept == kept; };
    if (is(whole, false) || is(part, false))
      whole.kept = false;
    else if (!is(whole, true) || !is(part, true))
      whole.kept = std::nullopt;
  }

  /// Joins the stretches to one path with one certificate.
  void finish(PlanStatus status) {
    const Clock::time_point begin = Clock::now();
    Certificate& whole = result_.certificate;
    whole.clearance = whole.world.clearance = whole.self.clearance = {kInfinity, kInfinity};
    whole.certified = true;
    whole.margins = problem_.margins;
    std::set<CompiledScene::Dropped> dropped;  // in some step
    result_.warnings.clear();
    Path& path = result_.path;
    path.positions = {start_};
    for (std::size_t s = 0; s < stretches_.size(); ++s) {
      const Stretch& stretch = stretches_[s];
      const int first = static_cast<int>(path.positions.size()) - 1;
      path.positions.insert(path.positions.end(), stretch.points.begin() + 1, stretch.points.end());
      path.steps.push_back({problem_.steps[s].name, first,
                            static_cast<int>(path.positions.size()) - 1,
                            stretch.departure.deviation, stretch.departure.turn, stretch.places});
      if (stretch.points.size() < 2) continue;
      const auto scene = std::make_shared<const CompiledScene>(stretch.stage);
      // Keep the warnings that hold in every step.
      const std::vector<std::string> warnings = scene->warnings();
      if (whole.segments.empty()) result_.warnings = warnings;  // the loaders' are added below
      std::erase_if(result_.warnings, [&](const std::string& warning) {
        return std::find(warnings.begin(), warnings.end(), warning) == warnings.end();
      });
      EdgeCertifier certifier(scene);
      const Certificate part =
          certify(certifier, {path.names, unwrapped(scene->space(), stretch.points), {}},
                  options_.clearance_tolerance, options_.detail);
      whole.certified = whole.certified && part.certified;
      dropped.insert(certifier.scene().dropped().begin(), certifier.scene().dropped().end());
      whole.segments.insert(whole.segments.end(), part.segments.begin(), part.segments.end());
      takeLeast(whole, part, first);
      takeLeast(whole.world, part.world, first);
      takeLeast(whole.self, part.self, first);
      if (whole.certified) addCost(stretch);
    }
    const std::vector<std::string> loaded = problemWarnings(problem_);
    result_.warnings.insert(result_.warnings.begin(), loaded.begin(), loaded.end());
    for (const Stretch& stretch : stretches_) addTo(result_.warnings, stretch.warnings);
    whole.unchecked = countUnchecked(std::vector(dropped.begin(), dropped.end()));
    result_.certify_s = secondsSince(begin);
    if (!whole.certified) {
      result_.reason = "a path was found whose certificate could not be repeated";
      path.positions.clear();
      path.steps.clear();
      whole = {};
      return;
    }
    const ConfigurationSpace space(problem_.robot.model, problem_.robot.variables);
    path.positions = unwrapped(space, std::move(path.positions));
    result_.length = pathLength(space, path.positions);
    result_.status = status;
  }

  const Problem& problem_;
  const PlanOptions& options_;
  robots::InverseKinematics kinematics_;
  Clock::time_point begin_ = Clock::now();
  std::vector<double> start_;
  std::vector<Stretch> stretches_;
  int tries_ = 0;
  std::size_t fault_step_ = 0;
  std::string fault_;
  std::vector<std::string> failed_warnings_;  ///< of searches; reported if the task fails
  std::optional<Ended> ended_;
  bool takes_part_ = false;  ///< accept the part of a line that ended_ remembers
  PlanResult result_;
};

}  // namespace

PlanResult planTask(const Problem& problem, const PlanOptions& options) {
  requireTolerance(options.clearance_tolerance, "planTask()");
  validate(problem);
  requirePlaced(problem);
  return TaskPlan(problem, options).run();
}

PlanResult solve(const Problem& problem, const PlanOptions& options) {
  return problem.steps.empty() ? plan(problem, options) : planTask(problem, options);
}

}  // namespace leeway::planner
