#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/planner/replanner.h"
#include "leeway/robots/input_error.h"
#include "planner/base/clock.h"
#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/base/waypoints.h"
#include "planner/execute/step_certifier.h"
#include "planner/execute/timed_path.h"
#include "planner/search/goals.h"
#include "planner/search/plan.h"
#include "planner/timing/motion_limits.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

/// Adds a step that took `seconds` of computing to the sums of an execution.
void add(const ReplanStep& step, double seconds, ReplanResult& result) {
  ++result.steps;
  result.compute_s += seconds;
  result.longest_step_s = std::max(result.longest_step_s, seconds);
  (step.decision == Decision::kPlan     ? result.plans
   : step.decision == Decision::kFollow ? result.follows
   : step.decision == Decision::kEvade  ? result.evasions
                                        : result.waits) += 1;
  result.certified = result.certified && step.certified;
  result.clearance.lower = std::min(result.clearance.lower, step.clearance.lower);
  result.clearance.upper = std::min(result.clearance.upper, step.clearance.upper);
}

/// The sums of an execution before its first step.
ReplanResult sumsOf(const Problem& problem, bool proves) {
  ReplanResult result;
  result.seed = problem.seed;
  result.clearance = {kInfinity, kInfinity};
  result.certified = proves;
  if (!proves) result.status = ReplanStatus::kNothingChecked;
  for (const int v : problem.robot.variables)
    result.names.push_back(problem.robot.model->variables[at(v)].name);
  return result;
}

std::uint64_t stream(std::uint64_t first, int number) {
  return first + static_cast<std::uint64_t>(number);
}

/// Checks the members that only execution reads.
const Problem& executable(const Problem& problem) {
  const Execution& e = problem.execution;
  const auto refuse = [&](const std::string& message) {
    throw robots::InputError(problem.name, 0, message);
  };
  validate(problem);
  requireGoals(problem, "a Replanner");
  if (isConstrained(problem))
    throw robots::InputError(problem.name, 0,
                             "there are constraints or a condition, which a Replanner does not "
                             "keep; none are expected");
  if (!(e.look_ahead <= kLongestLookAhead * e.step))
    refuse(fmt::format("execution.look_ahead is {}; at most {} steps of {} s is expected",
                       e.look_ahead, kLongestLookAhead, e.step));
  return problem;
}

}  // namespace

const char* toString(Decision decision) {
  switch (decision) {
    case Decision::kPlan:
      return "plan";
    case Decision::kFollow:
      return "follow";
    case Decision::kWait:
      return "wait";
    case Decision::kEvade:
      return "evade";
    case Decision::kUnsafe:
      break;
  }
  return "unsafe";
}

struct Replanner::Impl {
  Impl(const Problem& given, const ReplanOptions& given_options)
      : problem(executable(given)),
        options((requireTolerance(given_options.clearance_tolerance, "Replanner"), given_options)),
        scene(std::make_shared<const CompiledScene>(problem)),
        obstacles(problem, scene),
        certifier(scene, obstacles),
        proves(scene->nothingChecked().empty()),
        limits(velocityLimits(problem)),
        seen(scene),
        now(problem.execution.start),
        state(startPoint(problem)),
        trail{state},
        sums(sumsOf(problem, proves)) {}

  /// A possible motion, and how far it is proven.
  struct Candidate {
    Decision decision = Decision::kUnsafe;
    std::vector<TimedPoint> motion;  // over the step and the look-ahead
    Waypoints rest;                  // the path after the step
    Waypoints trail;                 // what is left of it after a retreat; else empty
    bool first_edge_known = true;    // the rest's first edge is certified against static bodies
    double until = -kInfinity;       // proven up to [s]
  };

  const ConfigurationSpace& space() const { return scene->space(); }
  const Execution& execution() const { return problem.execution; }
  double stepEnd() const { return execution().start + (index + 1) * execution().step; }
  bool isProven(const Candidate& c) const { return c.until >= stepEnd(); }
  bool isFullyProven(const Candidate& c) const { return c.until >= marks.back(); }
  bool looksAhead() const { return marks.size() > 1; }

  /// Sets the times up to which candidates are proven: the step's end and, where the obstacles'
  /// future is known, the ends of the steps of the look-ahead.
  void setMarks() {
    const double step_end = stepEnd(), end = step_end + execution().look_ahead;
    marks = {step_end};
    if (!obstacles.arePredicted()) return;
    for (int k = 1; step_end + k * execution().step < end - execution().step / 2; ++k)
      marks.push_back(step_end + k * execution().step);
    if (end > step_end) marks.push_back(end);
  }

  bool inGoal(const std::vector<double>& point) const {
    return std::any_of(problem.goals.begin(), problem.goals.end(),
                       [&](const Goal& goal) { return goalHolds(*scene, goal, point); });
  }

  // ---------------------------------------------------------------------------------------------
  // candidates

  /// Keeps the candidate that is proven farthest; of equals, the first.
  void consider(Candidate candidate, ReplanStep& step) {
    StepCertifier::Bodies broken;
    candidate.until = certifier.certify(candidate.motion, marks, broken);
    if (step.broken_a.empty()) {
      step.broken_a = broken.a;
      step.broken_b = broken.b;
    }
    if (isProven(candidate) && candidate.until > best.until) best = std::move(candidate);
  }

  /// Follows the path for the step, then further or, where that is not certified, stands.
  void considerPath(Decision decision, const Waypoints& along, bool edge_known, ReplanStep& step) {
    Candidate go{decision, {}, {}, {}, true, -kInfinity};
    go.motion = travel(space(), limits, along, now, stepEnd(), &go.rest);
    // Only the path's first edge may be uncertified: once it is left, the rest is certified.
    go.first_edge_known = edge_known || go.rest.size() < along.size();
    Candidate stop = go;
    if (looksAhead()) {
      const std::vector<TimedPoint> ahead =
          travel(space(), limits, go.rest, stepEnd(), marks.back());
      go.motion.insert(go.motion.end(), ahead.begin() + 1, ahead.end());
    }
    consider(std::move(go), step);
    if (isFullyProven(best) || !looksAhead()) return;
    stop.motion.push_back({marks.back(), stop.motion.back().position});
    consider(std::move(stop), step);
  }

  Candidate standing(const std::vector<double>& place) const {
    Candidate stand{Decision::kWait, {}, path, {}, first_edge_known, -kInfinity};
    stand.motion = {{now, state}, {stepEnd(), place}};
    if (looksAhead()) stand.motion.push_back({marks.back(), place});
    return stand;
  }

  /// Retreats along the trail, or goes to the random neighbours with the most clearance.
  void considerEvasions(ReplanStep& step) {
    const Clock::time_point begin = Clock::now();
    const auto evasion = [&](const std::vector<TimedPoint>& motion) {
      Candidate c = standing(motion.back().position);
      c.decision = Decision::kEvade;
      c.motion = motion;
      if (looksAhead()) c.motion.push_back({marks.back(), motion.back().position});
      if (!c.rest.empty()) c.rest.front() = motion.back().position;
      c.first_edge_known = false;
      return c;
    };
    if (trail.size() > 1) {
      const Waypoints back(trail.rbegin(), trail.rend());
      Waypoints left;
      Candidate retreat = evasion(travel(space(), limits, back, now, stepEnd(), &left));
      retreat.trail.assign(left.rbegin(), left.rend());
      consider(std::move(retreat), step);
    }
    std::vector<std::pair<double, std::vector<double>>> places;
    Random random(problem.seed, stream(kEvasionStream, index));
    for (int k = 0; k < kEvasions && !isFullyProven(best); ++k) {
      std::vector<double> place = neighbour(random);
      if (space().withinLimits(place)) {
        const double room = certifier.roomAt(place, stepEnd());
        places.emplace_back(room, std::move(place));
      }
    }
    std::stable_sort(places.begin(), places.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    for (std::size_t k = 0; k < places.size() && k < kEvasionsAsked && !isFullyProven(best); ++k)
      consider(evasion({{now, state}, {stepEnd(), places[k].second}}), step);
    step.plan_s += secondsSince(begin);
  }

  /// A random configuration that the joints reach within the step.
  std::vector<double> neighbour(Random& random) const {
    std::vector<double> dq(state.size()), place(state.size());
    const double time = stepEnd() - now;
    for (const ConfigurationSpace::Part& part : space().parts()) {
      const auto i = static_cast<std::size_t>(part.first);
      if (part.kind == ConfigurationSpace::Kind::kRotation) {
        const double most = limits[i] * time / std::sqrt(3.0);
        for (std::size_t k = 0; k < 3; ++k) dq[i + k] = random.uniform(-most, most);
      } else {
        dq[i] = random.uniform(-1, 1) * limits[i] * time;
      }
    }
    space().advance(state, dq, 1, place);
    for (const ConfigurationSpace::Part& part : space().parts())
      if (part.kind == ConfigurationSpace::Kind::kLine) {
        const auto i = static_cast<std::size_t>(part.first);
        place[i] = std::clamp(place[i], space().lower(part.first), space().upper(part.first));
      }
    return place;
  }

  // ---------------------------------------------------------------------------------------------
  // planning

  /// Plans from the present state in the world as last seen: first with the buffer to deforming
  /// obstacles, then without.
  bool plan(ReplanStep& step, Waypoints& found) {
    const Clock::time_point begin = Clock::now();
    Problem from_here = problem;
    for (std::size_t i = 0; i < state.size(); ++i)
      from_here.start[static_cast<std::size_t>(problem.robot.variables[i])] = state[i];
    from_here.seed = Random(problem.seed, stream(kReplanStream, searches++)).next();
    from_here.planner.push = false;  // the buffer is for that
    PlanOptions plan_options;
    plan_options.stop = options.stop;
    plan_options.progress = options.progress;
    bool solved = false;
    for (const double buffer : {execution().buffer, 0.0}) {
      const PlanResult result = planIn(obstacles.world(buffer), from_here, plan_options);
      step.iterations += result.iterations;
      step.edges += result.edges;
      step.distance_queries += result.distance_queries;
      if (result.status == PlanStatus::kSolved) {
        found = result.path.positions;
        step.path_clearance = result.certificate.clearance.lower;
        solved = true;
        break;
      }
      if (buffer == 0 || obstacles.empty()) break;
    }
    step.plan_s += secondsSince(begin);
    return solved;
  }

  bool mayPlan() const { return index >= next_plan; }

  /// Doubles the number of steps until the next attempt.
  void planFailed() {
    next_plan = index + pause;
    pause = std::min(2 * pause, kLongestPause);
  }

  // ---------------------------------------------------------------------------------------------
  // the step

  void decide(ReplanStep& step) {
    best = Candidate{};
    if (step.path_held) considerPath(Decision::kFollow, path, first_edge_known, step);
    if (isFullyProven(best)) return;
    const bool impatient = waited >= execution().patience;
    if ((!step.path_held || impatient) && mayPlan()) {
      Waypoints found;
      if (plan(step, found))
        considerPath(Decision::kPlan, found, true, step);
      else
        planFailed();
    }
    if (isFullyProven(best)) return;
    consider(standing(state), step);
    if (isFullyProven(best)) return;
    considerEvasions(step);
  }

  void take(ReplanStep& step) {
    if (!isProven(best) || !proves) {
      best = standing(state);
      best.decision = Decision::kUnsafe;
    }
    step.decision = best.decision;
    step.certified = best.decision != Decision::kUnsafe;
    step.look_ahead = step.certified ? best.until - stepEnd() : 0.0;
    step.motion = partOf(space(), best.motion, now, stepEnd());
    if (!step.certified) {
      step.clearance = {-kInfinity, kInfinity};
    } else {
      const Clock::time_point begin = Clock::now();
      // clearance() uses the parts of the last proof, which may be another candidate's.
      StepCertifier::Bodies ignored, closest;
      certifier.certify(step.motion, {&marks[0], 1}, ignored);
      step.clearance =
          certifier.clearance(step.motion, stepEnd(), options.clearance_tolerance, closest);
      step.closest_a = closest.a;
      step.closest_b = closest.b;
      step.clearance_s = secondsSince(begin);
    }
    state = step.motion.back().position;
    path = best.rest;
    first_edge_known = best.first_edge_known;
    if (best.decision == Decision::kPlan) {
      if (sums.plans > 0) ++sums.replans;
      pause = 1;
    }
    const bool moved = best.decision == Decision::kFollow || best.decision == Decision::kPlan;
    waited = moved ? 0 : waited + execution().step;
    if (!best.trail.empty()) trail = best.trail;
    if (trail.back() != state) trail.push_back(state);
    if (trail.size() > kTrail) trail.erase(trail.begin());
    step.reached = path.size() == 1 && inGoal(state);
    step.remaining_s = path.empty() ? kInfinity : pathDuration(space(), limits, path);
    now = stepEnd();
    ++index;
  }

  ReplanStep run() {
    const Clock::time_point start = Clock::now();
    ReplanStep step;
    step.index = index;
    step.time = now;
    step.path_clearance = kInfinity;
    const EdgeCertifier::Statistics before = certifier.statistics();
    const std::uint64_t looks = certifier.looks;
    if (options.progress) options.progress("update", 0);
    Clock::time_point begin = Clock::now();
    obstacles.look(now);
    certifier.begin();
    setMarks();
    step.update_s = secondsSince(begin);
    step.obstacles = obstacles.updates();
    seen = obstacles.world();
    begin = Clock::now();
    StepCertifier::Bodies broken;
    step.path_held = !path.empty() && certifier.holds(path, first_edge_known, broken);
    step.broken_a = broken.a;
    step.broken_b = broken.b;
    if (options.progress) options.progress("certify", 0);
    decide(step);
    step.certify_s = secondsSince(begin) - step.plan_s;
    take(step);
    const EdgeCertifier::Statistics after = certifier.statistics();
    step.edges += after.edges - before.edges;
    step.distance_queries += after.distance_queries - before.distance_queries;
    step.looks = 1 + certifier.looks - looks;
    step.observed = std::exchange(observed, {});
    step.measured = std::exchange(measured, {});
    add(step, secondsSince(start), sums);
    sums.duration = now - execution().start;
    if (proves)
      sums.status = !step.certified ? ReplanStatus::kUnsafe
                    : step.reached  ? ReplanStatus::kReached
                                    : ReplanStatus::kStopped;
    return step;
  }

  void set(const std::string& object, const Obstacles::Sight& sight, double time,
           const Obstacles::Bound& bound) {
    if (!(time <= now))
      throw std::invalid_argument(
          fmt::format("{} of '{}' seen at {} s, later than the present {} s",
                      sight.index() == 0   ? "vertices"
                      : sight.index() == 1 ? "a pose"
                                           : "a cloud",
                      object, time, now));
    obstacles.requireNewer(object, sight, time);
    obstacles.set(object, sight, time, bound);
    ObstacleSight seen_now{object, time, {}, bound.speed, bound.turning};
    if (const auto* pose = std::get_if<robots::Pose>(&sight)) {
      seen_now.seen = *pose;
    } else if (const auto* cloud = std::get_if<Obstacles::CloudSight>(&sight)) {
      seen_now.seen = SeenCloud{cloud->cloud, obstacles.poseOf(object)};
    } else {
      const auto& vertices = std::get<0>(sight);
      seen_now.seen = std::vector<Eigen::Vector3d>(vertices.begin(), vertices.end());
    }
    observed.push_back(std::move(seen_now));
  }

  Problem problem;
  ReplanOptions options;
  std::shared_ptr<const CompiledScene> scene;
  Obstacles obstacles;
  StepCertifier certifier;
  bool proves;  // false: no pair is checked, and so no step is certified
  std::vector<double> limits;
  std::shared_ptr<const CompiledScene> seen;
  double now;
  std::vector<double> state;
  Waypoints trail;
  Waypoints path;
  bool first_edge_known = true;
  Candidate best;
  std::vector<double> marks;
  double waited = 0;
  std::vector<ObstacleSight> observed;          // since the last step
  std::optional<std::vector<double>> measured;  // likewise
  ReplanResult sums;
  int index = 0, searches = 0;
  int next_plan = 0, pause = 1;
};

Replanner::Replanner(const Problem& problem, const ReplanOptions& options)
    : impl_(std::make_unique<Impl>(problem, options)) {}
Replanner::~Replanner() = default;
Replanner::Replanner(Replanner&&) noexcept = default;
Replanner& Replanner::operator=(Replanner&&) noexcept = default;

ReplanStep Replanner::step() { return impl_->run(); }
double Replanner::time() const { return impl_->now; }
std::span<const double> Replanner::state() const { return impl_->state; }
const Waypoints& Replanner::path() const { return impl_->path; }
bool Replanner::reached() const { return impl_->path.size() == 1 && impl_->inGoal(impl_->state); }
int Replanner::replans() const { return impl_->sums.replans; }
ReplanResult Replanner::executed() const { return impl_->sums; }
std::shared_ptr<const CompiledScene> Replanner::scene() const { return impl_->seen; }

void Replanner::setState(std::span<const double> point) {
  if (point.size() != impl_->state.size() || !impl_->space().withinLimits(point))
    throw std::invalid_argument(fmt::format(
        "a state of {} finite numbers within the limits is expected", impl_->state.size()));
  if (std::equal(point.begin(), point.end(), impl_->state.begin())) return;
  impl_->state.assign(point.begin(), point.end());
  impl_->measured = impl_->state;
  impl_->trail.push_back(impl_->state);
  impl_->first_edge_known = false;
  // One waypoint is the goal, and the robot is no longer there.
  if (impl_->path.size() == 1) impl_->path.clear();
  if (!impl_->path.empty()) impl_->path.front() = impl_->state;
}

void Replanner::setVertices(const std::string& object, std::span<const Eigen::Vector3d> vertices,
                            double time, double speed_bound) {
  impl_->set(object, vertices, time, {speed_bound});
}

void Replanner::setPose(const std::string& object, const robots::Pose& X_WO, double time,
                        double speed_bound, double turn_bound) {
  impl_->set(object, X_WO, time, {speed_bound, turn_bound});
}

void Replanner::setCloud(const std::string& object, std::shared_ptr<const PointCloud> cloud,
                         double time, double speed_bound, const std::optional<robots::Pose>& X_WO) {
  impl_->set(object, Obstacles::CloudSight{std::move(cloud), X_WO}, time, {speed_bound});
}

}  // namespace leeway::planner
