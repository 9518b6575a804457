#include "planner/search/plan.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/planner/planners.h"
#include "leeway/planner/simplify.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/stopped.h"
#include "planner/base/clock.h"
#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/constraint/constrained_way.h"
#include "planner/edge/why_undecided.h"
#include "planner/improve/lower_cost.h"
#include "planner/improve/push.h"
#include "planner/objective/path_cost.h"
#include "planner/search/clearance_search.h"
#include "planner/search/cost_search.h"
#include "planner/search/goal_sampler.h"
#include "planner/search/half_turns.h"
#include "planner/search/run_seed.h"
#include "planner/space/ompl_lock.h"
#include "planner/space/ompl_planners.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

/// One call of plan(). The stages are in their order.
class Plan {
 public:
  Plan(std::shared_ptr<const CompiledScene> scene, const Problem& problem,
       const PlanOptions& options)
      : scene_(std::move(scene)),
        problem_(problem),
        options_(options),
        limits_(problem.limits.time, problem.limits.iterations, options.stop, options.progress) {}

  PlanResult run() {
    begin();
    result_.reason = scene_->nothingChecked();
    if (!result_.reason.empty()) {
      result_.status = PlanStatus::kNothingChecked;
      return std::move(result_);
    }
    cost_ = PathCost::of(*scene_, problem_);
    if (isConstrained()) constraints_.emplace(*scene_, problem_);
    pool_ = std::make_shared<CertifierPool>(scene_);
    limits_.enter("plan");
    if (checkEnds()) {
      Waypoints path = search();
      result_.plan_s = limits_.elapsed();
      if (!path.empty()) finish(std::move(path));
    } else {
      result_.plan_s = limits_.elapsed();
    }
    result_.iterations = limits_.iterations();
    work_ += pool_->statistics();
    if (cost_) work_ += cost_->statistics();
    result_.states = work_.states;
    result_.edges = work_.edges;
    result_.distance_queries = work_.distance_queries;
    result_.undecided_edges = work_.undecided_edges;
    return std::move(result_);
  }

 private:
  bool isConstrained() const { return planner::isConstrained(problem_); }
  bool wantsCost() const { return cost_ != nullptr; }
  bool wantsLength() const {
    return !wantsCost() && std::holds_alternative<MinimumLength>(problem_.objective);
  }
  bool wantsClearance() const {
    return std::holds_alternative<MaximumClearance>(problem_.objective);
  }
  Pairs clearanceOf() const {
    const auto* wanted = std::get_if<MaximumClearance>(&problem_.objective);
    return wanted != nullptr ? wanted->of : Pairs::kAll;
  }
  EdgeCertifier& certifier() { return pool_->local().certifier; }

  void begin() {
    traits_ = findPlanner(problem_.planner.name);
    result_.planner = traits_->name;
    result_.deterministic = traits_->deterministic;
    result_.seed = problem_.seed;
    result_.warnings = problemWarnings(problem_);
    const std::vector<std::string> warnings = scene_->warnings();
    result_.warnings.insert(result_.warnings.end(), warnings.begin(), warnings.end());
    const ConfigurationSpace& space = scene_->space();
    for (const ConfigurationSpace::Part& part : space.parts())
      if (part.kind == ConfigurationSpace::Kind::kLine &&
          !std::isfinite(space.upper(part.first) - space.lower(part.first)))
        throw robots::InputError(
            problem_.name, 0,
            "variable '" + variableName(part.first) +
                "' has no limits; a range to plan in is expected, under 'bounds' or with --bounds");
    start_ = startPoint(problem_);
  }

  std::string variableName(int i) const {
    return scene_->model()
        .variables[static_cast<std::size_t>(
            scene_->space().variables()[static_cast<std::size_t>(i)])]
        .name;
  }

  /// Whether the start and some goal are valid. If not, the result names the bodies in collision.
  bool checkEnds() {
    if (certifier().decide(start_) != Verdict::kFree) {
      offend(PlanStatus::kInvalidStart, certifier().tooNear(start_, kReportTolerance));
      result_.reason = whyUndecided(*scene_, start_);
      return false;
    }
    if (constraints_)
      if (result_.reason = constraints_->fault(start_); !result_.reason.empty()) {
        result_.status = PlanStatus::kInvalidStart;
        return false;
      }
    sampler_ = std::make_unique<GoalSampler>(certifier(), problem_, problem_.seed);
    goals_ = sampler_->first([this] { return limits_.over(); });
    result_.warnings.insert(result_.warnings.end(), goals_.warnings.begin(), goals_.warnings.end());
    if (cost_)
      result_.warnings.insert(result_.warnings.end(), cost_->warnings().begin(),
                              cost_->warnings().end());
    if (!goals_.points.empty()) return true;
    result_.reason = goals_.reason;
    result_.unreachable = goals_.unreachable;
    // A goal range that was not fully explored within the limits may still be valid.
    if (!goals_.stopped) offend(PlanStatus::kInvalidGoal, goals_.closest);
    return false;
  }

  void offend(PlanStatus status, const StateCheck& check) {
    result_.status = status;
    result_.offending = check;
    if (check.pair < 0) return;
    const collision::Scene& scene = scene_->scene();
    const collision::ScenePair& pair = scene.pairs()[static_cast<std::size_t>(check.pair)];
    result_.offending_a = scene.bodies()[static_cast<std::size_t>(pair.body_a)].name;
    result_.offending_b = scene.bodies()[static_cast<std::size_t>(pair.body_b)].name;
  }

  /// Stores why a search found no path: the pairs in the way, and the remaining gap.
  void explain(const Hindrance& hindrance) {
    const collision::Scene& scene = scene_->scene();
    // Bodies have several shapes, each with pairs of its own.
    std::map<std::pair<int, int>, std::uint64_t> of_bodies;
    for (const auto& [index, edges] : hindrance.blocked) {
      const collision::ScenePair& pair = scene.pairs()[at(index)];
      of_bodies[{pair.body_a, pair.body_b}] += edges;
    }
    std::vector<std::pair<std::pair<int, int>, std::uint64_t>> most(of_bodies.begin(),
                                                                    of_bodies.end());
    std::stable_sort(most.begin(), most.end(),
                     [](const auto& x, const auto& y) { return x.second > y.second; });
    if (most.size() > PlanResult::kMostBlocked) most.resize(PlanResult::kMostBlocked);
    for (const auto& [bodies, edges] : most)
      result_.blocked.push_back(
          {scene.bodies()[at(bodies.first)].name, scene.bodies()[at(bodies.second)].name, edges});
    result_.gap = {hindrance.gap.distance, hindrance.gap.of_start, hindrance.gap.of_goals};
    for (int i = 0; i < scene_->space().size(); ++i)
      if (turnsLong(i)) result_.long_turns.push_back(variableName(i));
  }

  /// Whether the limits of a revolute joint block the shorter turn to every goal.
  bool turnsLong(int i) const {
    const robots::Variable& variable =
        scene_->model().variables[at(scene_->space().variables()[at(i)])];
    if (scene_->model().joints[at(variable.joint)].type != robots::JointType::kRevolute)
      return false;
    const double from = start_[at(i)];
    return std::all_of(problem_.goals.begin(), problem_.goals.end(), [&](const Goal& goal) {
      if (goal.ranges.empty()) return false;
      const auto [lower, upper] = goal.ranges[at(i)];
      const double to = std::clamp(from, lower, upper);
      const double other = to > from ? to - 2 * std::numbers::pi : to + 2 * std::numbers::pi;
      return std::abs(to - from) > std::numbers::pi &&
             (other < variable.lower || other > variable.upper);
    });
  }

  SearchTask searchTask() {
    return {problem_, start_, goals_, limits_, options_.on_edge, nullptr, scene_.get()};
  }

  /// Returns a path with every edge certified; empty if none is found within the limits.
  Waypoints search() {
    if (Waypoints path = direct(); !path.empty()) return path;
    const bool lazy = wantsLength() && traits_->name == kOwnPlanner;
    while (!lazy && goals_.points.size() < static_cast<std::size_t>(kGoalSamples) &&
           !limits_.searchOver() && sampler_->more(goals_)) {
    }
    const QuietOmpl quiet;
    SearchTask task = searchTask();
    if (traits_->optimizing) limits_.reserve(kSimplifyShare);
    if (wantsLength()) {
      GoalSupply supply(scene_, *sampler_, goals_);
      if (lazy && sampler_->hasPoses()) task.supply = &supply;
      Search search(scene_, pool_, task);
      auto path = search.shortest(problem_.seed);
      work_ += search.work();
      work_ += supply.work();
      if (!path) explain(search.hindrance());
      return std::move(path).value_or(Waypoints{});
    }
    limits_.reserve(kSimplifyShare);
    if (wantsCost()) return searchCheapest(task);
    const double bound = clearanceBound();
    // A range or a pose has more goals than the search has drawn.
    result_.clearance_bound = haveGoalsOnePlace() ? bound : mostClearance(start_);
    Search search(scene_, pool_, task);
    const bool is_limited =
        std::isfinite(std::get<MaximumClearance>(problem_.objective).at_most_longer);
    if (traits_->optimizing && traits_->any_cost && !is_limited) {
      auto path = search.widest(problem_.seed, bound - kClearanceTolerance);
      if (!path) explain(search.hindrance());
      return std::move(path).value_or(Waypoints{});
    }
    auto widest = searchClearance(scene_, search, task, bound);
    work_ += search.work();
    if (!widest) explain(search.hindrance());
    if (!widest) return {};
    work_ += widest->work;
    result_.shortest_length = widest->shortest;
    longest_ = widest->longest;
    kept_ = widest->clearance;
    simplified_ = widest->simplified;
    return std::move(widest->path);
  }

  Waypoints searchCheapest(const SearchTask& task) {
    Search search(scene_, pool_, task);
    double bound = kInfinity;
    for (const std::vector<double>& goal : goals_.points)
      bound = std::min(bound, cost_->leastBetween(start_, goal));
    enough_ = (1 + kCostTolerance) * bound;
    if (traits_->optimizing) {
      auto path = search.cheapest(problem_.seed, cost_, enough_);
      if (!path) explain(search.hindrance());
      return std::move(path).value_or(Waypoints{});
    }
    auto cheapest = searchCost(search, *cost_, task, enough_);
    work_ += search.work();
    if (!cheapest) explain(search.hindrance());
    if (!cheapest) return {};
    simplified_ = cheapest->simplified;
    return std::move(cheapest->path);
  }

  /// The straight edge to the nearest goal, if length is the objective and the edge is free,
  /// because no path is shorter. If the start is a goal, a path that stays there.
  Waypoints direct() {
    const ConfigurationSpace& space = scene_->space();
    for (const Goal& goal : problem_.goals)
      if (goalHolds(*scene_, goal, start_)) return {start_, start_};
    if (!wantsLength() || limits_.searchOver()) return {};
    const auto nearest = std::min_element(
        goals_.points.begin(), goals_.points.end(), [&](const auto& a, const auto& b) {
          return space.distance(start_, a) < space.distance(start_, b);
        });
    if (constraints_ && !constraints_->holds(start_, *nearest)) return {};
    if (certifier().certify(start_, *nearest, EdgeRequest::persistent()).verdict != Verdict::kFree)
      return {};
    return {start_, *nearest};
  }

  double mostClearance(const std::vector<double>& point) {
    return certifier()
        .edgeClearance(point, point, {.tolerance = kEndTolerance, .pairs = clearanceOf()})
        .clearance.upper;
  }

  bool haveGoalsOnePlace() const {
    return std::all_of(problem_.goals.begin(), problem_.goals.end(), [](const Goal& goal) {
      return goal.poses.empty() && std::all_of(goal.ranges.begin(), goal.ranges.end(),
                                               [](const auto& r) { return r.first == r.second; });
    });
  }

  /// The greatest clearance of a path to the goal points: that of its start, or of the best of them
  /// [m].
  double clearanceBound() {
    double goal = -kInfinity;
    for (const std::vector<double>& point : goals_.points)
      goal = std::max(goal, mostClearance(point));
    return std::min(goal, mostClearance(start_));
  }

  void finish(Waypoints path) {
    const Waypoints unsimplified = path;
    if (problem_.planner.simplify && !simplified_)
      timed("simplify", result_.simplify_s, [&] { simplifyPath(path, 0); });
    if (wantsLength()) timed("improve", result_.improve_s, [&] { improve(path); });
    if (problem_.planner.simplify && problem_.planner.push && !wantsCost() && !isConstrained())
      timed("push", result_.push_s, [&] { wantsLength() ? pushPath(path) : pushElsewhere(path); });
    for (int i = 0; i < scene_->space().size(); ++i) result_.path.names.push_back(variableName(i));
    timed("certify", result_.certify_s, [&] {
      // Every edge was certified before, but the report contains only what is certified now.
      if (certifyPath(std::move(path)) || certifyPath(unsimplified)) return report();
      result_.warnings.emplace_back("a path was found whose certificate could not be repeated");
      result_.path = {};
      result_.certificate = {};
    });
  }

  template <typename Stage>
  void timed(const char* name, double& seconds, const Stage& stage) {
    limits_.enter(name);
    const double begin = limits_.elapsed();
    stage();
    seconds = limits_.elapsed() - begin;
  }

  bool certifyPath(Waypoints path) {
    splitHalfTurns(scene_->space(), path);
    result_.path.positions = unwrapped(scene_->space(), std::move(path));
    // With clearance as objective, the certificate reports it for every edge.
    const CertificateDetail detail =
        wantsClearance() ? CertificateDetail::kEveryEdge : options_.detail;
    result_.certificate =
        planner::certify(certifier(), result_.path, options_.clearance_tolerance, detail, pushed_);
    if (constraints_) {
      auto proven = proveConstraints(*scene_, problem_, result_.path);
      result_.certificate.certified = result_.certificate.certified && proven;
      if (proven) result_.certificate.constraints = std::move(*proven);
      if (proven && problem_.condition.accept) result_.certificate.conditions = kSampled;
    }
    return result_.certificate.certified;
  }

  void report() {
    result_.length = pathLength(scene_->space(), result_.path.positions);
    for (std::size_t g = 0; g < problem_.goals.size() && result_.goal < 0; ++g)
      if (goalHolds(*scene_, problem_.goals[g], result_.path.positions.back()))
        result_.goal = static_cast<int>(g);
    result_.status = PlanStatus::kSolved;
    if (!wantsCost()) return;
    result_.cost = cost_->reported(result_.path.positions);
    result_.wishes = cost_->wishes(result_.path.positions, options_.clearance_tolerance);
  }

  double timeLimit() const { return problem_.limits.time > 0 ? problem_.limits.time : kInfinity; }

  /// Searches for shorter paths for the time that the parameter `improve` gives. Each search is
  /// bounded by a multiple of the best length. After a search without success, the best path is
  /// simplified again with other random numbers.
  void improve(Waypoints& path) {
    // Only Connect has this parameter. Without it, no work is done.
    if (problem_.planner.parameters.count("improve") == 0) return;
    const SearchTask task = searchTask();
    Search search(scene_, pool_, task);
    const double seconds = search.improves();
    if (!(seconds > 0)) return;
    const double begin = limits_.elapsed();
    double straight = kInfinity, length = pathLength(scene_->space(), path);
    for (const std::vector<double>& goal : goals_.points)
      straight = std::min(straight, scene_->space().distance(start_, goal));
    if (options_.on_path) options_.on_path(unwrapped(scene_->space(), path), length);
    limits_.describe([&] { return search.describeLength(length); });
    for (std::uint64_t round = 1;; ++round) {
      const double aim = (1 - kImprovement) * length;
      const double bound = aim * kImproveSlack[round % std::size(kImproveSlack)];
      const std::uint64_t before = limits_.iterations();
      if (!(straight < aim) || limits_.searchOver() || limits_.elapsed() - begin > seconds) break;
      Waypoints next =
          search.shorter(runSeed(problem_.seed, kImproveRuns * round), bound).value_or(path);
      if (limits_.iterations() == before) break;  // it would never stop
      if (problem_.planner.simplify) simplifyPath(next, round);
      const double now = pathLength(scene_->space(), next);
      if (!(now < length)) continue;
      path = std::move(next);
      length = now;
      if (options_.on_path) options_.on_path(unwrapped(scene_->space(), path), length);
    }
    limits_.describe(nullptr);
    work_ += search.work();
  }

  SimplifyOptions simplifyOptions(std::uint64_t round) {
    SimplifyOptions options;
    options.seed = Random(problem_.seed, kSimplifyStream + round).next();
    options.stop = [this] { return limits_.over(); };
    if (options_.stop && options_.stop()) {
      // After a stop, the path is still simplified for a short time.
      const double end = limits_.elapsed() + kLastSimplification;
      options.stop = [this, end] { return limits_.elapsed() > std::min(end, timeLimit()); };
    }
    return options;
  }

  void simplifyPath(Waypoints& path, std::uint64_t round) {
    const SimplifyOptions options = simplifyOptions(round);
    if (isConstrained()) {
      const ConstrainedWay::IsFree is_free = [this](std::span<const double> a,
                                                    std::span<const double> b) {
        return certifier().certify(a, b).verdict == Verdict::kFree;
      };
      ConstrainedWay way(*scene_, problem_, is_free, defaultRange(scene_->space()));
      shorten(way, scene_->space(), path, options.seed, options.stop);
      return;
    }
    if (wantsLength()) {
      const std::int64_t before = certifier().statistics.work;
      simplify(certifier(), path, options);
      simplify_work_ = certifier().statistics.work - before;
      return;
    }
    if (wantsCost()) {
      lowerCost(certifier(), *cost_, path, {options.seed, enough_, options.stop});
      return;
    }
    // From here on, the clearance reached so far is a margin.
    const Pairs of = clearanceOf();
    if (!kept_)
      kept_ = pathClearance(certifier(), path, kBoundTolerance, -kInfinity, of) - kBoundTolerance;
    EdgeCertifier wide(raised(*scene_, of, *kept_));
    simplify(wide, path, options);
    work_ += wide.statistics;
  }

  void pushPath(Waypoints& path) {
    PushOptions options;
    options.target = kPushClearance;
    options.least = kPushLeast;
    options.longest = (1 + kPushLonger) * pathLength(scene_->space(), path);
    options.work = std::max(kPushWork, kPushSimplifications * simplify_work_);
    options.stop = [this] { return limits_.over(); };
    pushed_ = push(certifier(), path, options);
    if (pushed_ < kPushEnough && searchRoomier(path, options.longest))
      pushed_ = std::max(kPushEnough, push(certifier(), path, options));
  }

  /// Searches for a path elsewhere that keeps the clearance which a push should have reached.
  bool searchRoomier(Waypoints& path, double longest) {
    if (traits_->name != kOwnPlanner || limits_.searchOver()) return false;
    const auto wider = scene_->withWorldMarginAtLeast(kPushEnough);
    const auto pool = std::make_shared<CertifierPool>(wider);
    const SearchTask task = searchTask();
    Search search(wider, pool, task);
    auto found =
        search.any(problem_.seed, std::max(kRoomierShare * limits_.iterations(), kRoomierBudget));
    if (found) simplify(search.certifier(), *found, simplifyOptions(0));
    work_ += pool->statistics();
    work_ += search.work();
    if (!found || !(pathLength(scene_->space(), *found) <= longest)) return false;
    path = std::move(*found);
    return true;
  }

  /// Pushes also the parts of the path that do not limit the least clearance.
  void pushElsewhere(Waypoints& path) {
    if (!kept_ || !std::isfinite(*kept_) || limits_.over()) return;
    PushOptions options;
    options.target = *kept_;
    options.longest =
        std::min(longest_, (1 + kElsewhereLonger) * pathLength(scene_->space(), path));
    options.pairs = clearanceOf();
    options.stop = [this] { return limits_.over(); };
    work_ += planner::pushElsewhere(scene_, certifier(), path, options);
  }

  std::shared_ptr<const CompiledScene> scene_;
  const Problem& problem_;
  const PlanOptions& options_;
  Limits limits_;
  const PlannerTraits* traits_ = nullptr;
  std::shared_ptr<CertifierPool> pool_;
  std::vector<double> start_;
  std::optional<ConstraintProof> constraints_;
  std::unique_ptr<GoalSampler> sampler_;
  GoalPoints goals_;
  EdgeCertifier::Statistics work_;
  std::int64_t simplify_work_ = 0;  ///< work of the last simplification [units of Work]
  double pushed_ = 0;               ///< clearance from the world that the path was pushed to [m]
  std::optional<double> kept_;      ///< the clearance that a search for clearance has reached [m]
  double longest_ = kInfinity;      ///< bound on the length of its path
  std::shared_ptr<PathCost> cost_;  ///< null: the problem has no cost
  double enough_ = 0;               ///< lower bound on the cost of any path, up to the tolerance
  bool simplified_ = false;         ///< the path of a search is already simplified
  PlanResult result_;
};

}  // namespace

const char* toString(PlanStatus status) {
  switch (status) {
    case PlanStatus::kSolved:
      return "solved";
    case PlanStatus::kUnsolved:
      return "unsolved";
    case PlanStatus::kPartial:
      return "partial";
    case PlanStatus::kInvalidStart:
      return "invalid_start";
    case PlanStatus::kInvalidGoal:
      return "invalid_goal";
    case PlanStatus::kNothingChecked:
      return "nothing_checked";
    case PlanStatus::kNotCompiled:
      return "not_compiled";
  }
  return "unsolved";
}

PlanResult plan(const Problem& problem, const PlanOptions& options) {
  const Clock::time_point begin = Clock::now();
  requireTolerance(options.clearance_tolerance, "plan()");
  requireGoals(problem, "plan()");
  if (options.progress) options.progress("compile", 0);
  const auto elapsed = [begin] { return secondsSince(begin); };
  bool is_late = false;
  const auto stop = [&] {
    const double limit = problem.limits.time;
    is_late = limit > 0 && elapsed() > std::max(limit, kLeastReading);
    return is_late || (options.stop && options.stop());
  };
  std::shared_ptr<const CompiledScene> scene;
  try {
    scene = std::make_shared<const CompiledScene>(problem, stop);
    scene->lanes();  // what certifiers share: seconds for a new robot with large hulls
  } catch (const robots::Stopped&) {
    PlanResult result;
    result.status = PlanStatus::kNotCompiled;
    result.planner = problem.planner.name;
    result.seed = problem.seed;
    result.compile_s = elapsed();
    result.reason = is_late ? "the problem was not compiled within its time limit; a longer one "
                              "(limits.time, --time) is expected"
                            : "the problem was not compiled before it was stopped";
    return result;
  }
  const double compile_s = elapsed();
  PlanResult result = planIn(std::move(scene), problem, options);
  result.compile_s = compile_s;
  return result;
}

PlanResult plan(std::shared_ptr<const CompiledScene> scene, const Problem& problem,
                const PlanOptions& options) {
  if (!scene) throw std::invalid_argument("plan(): a compiled scene is expected");
  requireTolerance(options.clearance_tolerance, "plan()");
  scene->requireProblem(problem);
  requireGoals(problem, "plan()");
  return planIn(std::move(scene), problem, options);
}

PlanResult planIn(std::shared_ptr<const CompiledScene> scene, const Problem& problem,
                  const PlanOptions& options) {
  const auto* length = std::get_if<MinimumLength>(&problem.objective);
  if (length != nullptr && std::isfinite(length->clearance))
    scene = scene->withWorldMarginAtLeast(length->clearance);
  return Plan(std::move(scene), problem, options).run();
}

}  // namespace leeway::planner
