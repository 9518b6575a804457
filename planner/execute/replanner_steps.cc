#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/planner/replanner.h"
#include "leeway/robots/input_error.h"
#include "planner/base/clock.h"
#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/base/waypoints.h"
#include "planner/execute/drive.h"
#include "planner/execute/step_certifier.h"
#include "planner/execute/timed_path.h"
#include "planner/execute/tracking.h"
#include "planner/search/goals.h"
#include "planner/search/plan.h"
#include "planner/timing/leg.h"
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
ReplanResult sumsOf(const Problem& problem, const CompiledScene& scene) {
  ReplanResult result;
  const bool proves = scene.nothingChecked().empty();
  result.seed = problem.seed;
  result.clearance = {kInfinity, kInfinity};
  result.certified = proves;
  result.unchecked = countUnchecked(scene.dropped());
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

/// The longest time in which a variable comes to rest from its velocity limit [s].
double longestStop(const MotionLimits& limits) {
  double longest = 0;
  for (std::size_t i = 0; i < limits.velocity.size(); ++i) {
    const LineLimits line{limits.velocity[i], limits.acceleration[i], limits.jerk[i]};
    longest = std::max(longest, SpeedChange(0, line.speed, line).time);
  }
  return longest;
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
  using Tick = StepCertifier::Tick;
  Impl(const Problem& given, const ReplanOptions& given_options)
      : options((requireTolerance(given_options.clearance_tolerance, "Replanner"), given_options)),
        problem(withErrors(executable(given), options.joint_errors, 0, "Replanner")),
        scene(std::make_shared<const CompiledScene>(problem)),
        obstacles(problem, scene),
        certifier(scene, obstacles, problem.execution),
        proves(scene->nothingChecked().empty()),
        limits(motionLimits(problem)),
        space_of_drives(std::make_shared<const ConfigurationSpace>(problem.robot.model,
                                                                   problem.robot.variables)),
        periods(static_cast<int>(std::ceil(execution().step / kLongestPeriod))),
        reaction(longestStop(limits)),
        seen(scene),
        now(problem.execution.start),
        state(startPoint(problem)),
        trail{state},
        sums(sumsOf(problem, *scene)) {}

  /// A possible motion, and how far it is proven.
  struct Candidate {
    Decision decision = Decision::kUnsafe;
    std::shared_ptr<const Drive> drive = nullptr;  // null: it stands
    /// Times of the drive after each period: of the step, and of the stop after it.
    std::vector<double> times = {};
    int pace = 0;                         // of these, the first that are at the drive's own pace
    Waypoints trail = {};                 // what is left of it after a retreat; else empty
    std::vector<TimedPoint> motion = {};  // over the step and the stop, and at rest after it
    double stop_end = 0;                  // when it comes to rest [s]
    Tick stop_tick = 0;                   // not before that
    double until = -kInfinity;            // proven up to [s]
  };

  const ConfigurationSpace& space() const { return scene->space(); }
  const Execution& execution() const { return problem.execution; }
  double stepEnd() const { return execution().start + (index + 1) * execution().step; }
  double period() const { return execution().step / periods; }
  /// The time of a row, counted from the present one. A row has the same time in each step, so that
  /// what is left of a motion is the motion that was proven.
  double rowTime(int row) const {
    const int whole_step = index + row / periods;
    return execution().start + whole_step * execution().step + (row % periods) * period();
  }
  /// Proven, with the stop at its end.
  bool isProven(const Candidate& c) const { return c.until >= std::max(c.stop_end, stepEnd()); }
  bool isFullyProven(const Candidate& c) const { return isProven(c) && c.until >= lastMark(); }
  bool looksAhead() const { return marks.size() > 1; }
  bool moves() const { return !ahead.empty(); }
  double lastMark() const { return certifier.timeOf(marks.back()); }
  /// The tick of the present plus a whole number of steps.
  Tick tickOf(int steps) const { return (index + Tick{steps}) * StepCertifier::kStepTicks; }
  /// The first tick that is a multiple of `every` and not before a time, which is `periods_ahead`
  /// from now.
  Tick tickAfter(double periods_ahead, double time, Tick every) const {
    const double ticks = periods_ahead / periods * StepCertifier::kStepTicks;
    Tick tick = tickOf(0) + static_cast<Tick>(ticks) / every * every;
    while (certifier.timeOf(tick) < time) tick += every;
    return tick;
  }

  /// Sets the times up to which candidates are proven: the step's end and, to look ahead, times
  /// that are farther apart the farther they are. A robot that has to leave a place comes to rest
  /// before, and evades from rest to rest. With bounds on obstacles alone, the time of an evasion
  /// is left out: any obstacle may come nearer, and the robot would evade distant ones.
  void setMarks(bool ahead_of_step) {
    const double evasion = obstacles.arePredicted() ? reaction + kEvasionTime : 0;
    const double time =
        std::min(execution().look_ahead + reaction + evasion, kLongestLookAhead * execution().step);
    marks = {tickOf(1)};
    if (!ahead_of_step) return;
    const Tick end = tickAfter(periods + time / period(), stepEnd() + time, StepCertifier::kCoarse);
    for (Tick t = tickOf(1); t < end;) {
      Tick length = StepCertifier::kStepTicks;
      while (t % (2 * length) == 0 && 4 * length <= t - tickOf(0)) length *= 2;
      t = std::min(t + length, end);
      marks.push_back(t);
    }
  }

  bool inGoal(const std::vector<double>& point) const {
    return std::any_of(problem.goals.begin(), problem.goals.end(),
                       [&](const Goal& goal) { return goalHolds(*scene, goal, point); });
  }

  // ---------------------------------------------------------------------------------------------
  // candidates

  /// The robot's place at a time of a drive. On the present drive, the offset at which the robot
  /// was measured is added. The limits are never left: `is_cut` becomes true if that changes the
  /// motion.
  std::vector<double> placeOn(const std::shared_ptr<const Drive>& on, double time,
                              bool& is_cut) const {
    std::vector<double> place = on->at(time);
    if (offset.empty() || on != drive) return place;
    space().advance(place, offset, 1, place);
    for (const ConfigurationSpace::Part& part : space().parts())
      if (part.kind == ConfigurationSpace::Kind::kLine) {
        double& q = place[at(part.first)];
        const double inside = std::clamp(q, space().lower(part.first), space().upper(part.first));
        is_cut = is_cut || std::abs(q - inside) > kGuardDifference * (std::abs(q) + 1);
        q = inside;
      }
    return place;
  }

  /// Sets the motion of a candidate, a row a period, which continues straight from the state.
  /// Returns false if it would leave the joints' limits, where it would have to stop at once.
  bool setMotion(Candidate& c) const {
    bool is_cut = false;
    c.motion = {{now, state}};
    const int rows = std::max(periods, static_cast<int>(c.times.size()));
    for (int k = 1; k <= rows; ++k) {
      if (k <= static_cast<int>(c.times.size()))
        c.motion.push_back({rowTime(k), placeOn(c.drive, c.times[at(k) - 1], is_cut)});
      else
        c.motion.push_back({rowTime(k), c.motion.back().position});
      space().unwrap(c.motion[at(k) - 1].position, c.motion.back().position);
    }
    c.stop_end = c.motion[c.times.size()].time;
    c.stop_tick = tickAfter(static_cast<double>(c.times.size()), c.stop_end,
                            c.stop_end <= stepEnd() ? 1 : StepCertifier::kCoarse);
    const double last = certifier.timeOf(std::max(marks.back(), c.stop_tick));
    if (c.motion.back().time < last) c.motion.push_back({last, c.motion.back().position});
    return !is_cut;
  }

  /// Keeps the candidate that is proven farthest; of equals, the first. `known`: it is proven up to
  /// there already [s].
  void consider(Candidate candidate, ReplanStep& step, double known = -kInfinity) {
    if (candidate.drive != nullptr && candidate.times.empty()) return;  // it leads nowhere
    if (!setMotion(candidate)) {
      rest_until = -kInfinity;
      return;
    }
    std::vector<Tick> until = {tickOf(1)};
    if (candidate.stop_tick > tickOf(0) && candidate.stop_tick != tickOf(1))
      until.insert(candidate.stop_tick < tickOf(1) ? until.begin() : until.end(),
                   candidate.stop_tick);
    const std::size_t must = until.size();
    for (const Tick mark : marks)
      if (mark > until.back()) until.push_back(mark);
    blocked = {};
    candidate.until =
        std::max(known, certifier.certify(candidate.motion, until, must, blocked, known));
    if (step.broken_a.empty()) {
      step.broken_a = blocked.a;
      step.broken_b = blocked.b;
    }
    rest_until = candidate.until;
    const auto rank = [&](const Candidate& c) { return std::min(c.until, lastMark()); };
    if (isProven(candidate) && rank(candidate) > rank(best)) best = std::move(candidate);
  }

  /// Drives on from a row: for the step, then with the shortest stop; or further before it; or to
  /// where the drive rests, which is free in a world at rest.
  void considerDrive(Decision decision, const std::shared_ptr<const Drive>& on, int row,
                     ReplanStep& step) {
    const int lead = moves() ? 0 : restBefore();
    const auto goes = [&](int until, const std::vector<double>& stop) {
      Candidate c{decision, on};
      c.pace = lead + until - row;
      c.times.assign(at(lead), row);
      for (int k = row + 1; k <= until; ++k) c.times.push_back(std::min(k, on->rows()));
      c.times.insert(c.times.end(), stop.begin(), stop.end());
      return c;
    };
    const int end = row + periods - lead;
    // Short steps share a stop.
    const int shared =
        periods * std::max(1, static_cast<int>(kStopEvery / execution().step + 1e-6));
    if (lead == 0 && shared > periods && row + shared < on->rows())
      consider(goes(row + shared, on->stop(row + shared)), step);
    if (isFullyProven(best)) return;
    const std::vector<double> stop = on->stop(end);
    consider(goes(end, stop), step);
    if (isFullyProven(best)) return;
    if (looksAhead()) {
      const int later =
          std::min(end + static_cast<int>(std::ceil((lastMark() - stepEnd()) / period())),
                   std::max(end, on->rows()));
      consider(goes(later, on->stop(later)), step);
      if (isFullyProven(best)) return;
    }
    std::vector<double> rest(at(std::max(0, on->restFrom(end) - end)));
    std::iota(rest.begin(), rest.end(), end + 1.0);
    if (rest != stop) consider(goes(end, rest), step);
  }

  /// The rows for which a robot that has just come to rest stands before it moves: from the last
  /// row of one motion to the first of another its speed would change too fast.
  int restBefore() const { return std::max(0, (limits.jerk.empty() ? 1 : 2) - rested); }

  /// Returns the motion that was proven before: the stop, or the rest of an evasion; else standing.
  Candidate goingOn() const {
    if (!moves()) return {Decision::kWait};
    Candidate c{evades ? Decision::kEvade : Decision::kWait, drive};
    c.times = ahead;
    return c;
  }

  /// Up to when goingOn() was proven by a step before, whose knowledge still holds [s].
  double provenBefore() const { return is_contradicted ? -kInfinity : proven_until; }

  /// Retreats along the trail, or goes to the random neighbours with the most clearance: from rest
  /// to rest.
  void considerEvasions(ReplanStep& step) {
    const Clock::time_point begin = Clock::now();
    const auto evasion = [&](const std::shared_ptr<const Drive>& way) {
      Candidate c{Decision::kEvade, way};
      c.times.assign(at(restBefore()), 0);
      for (int k = 1; k <= way->rows(); ++k) c.times.push_back(k);
      return c;
    };
    Waypoints back = {state};
    std::size_t left = trail.size();
    for (; left > 0 && pathDuration(space(), limits.velocity, back) < kEvasionTime; --left)
      if (trail[left - 1] != back.back()) back.push_back(trail[left - 1]);
    if (back.size() > 1) {
      Candidate retreat = evasion(driveAlong(back, seen));
      retreat.trail.assign(trail.begin(), trail.begin() + static_cast<std::ptrdiff_t>(left) + 1);
      consider(std::move(retreat), step);
    }
    std::vector<std::pair<double, std::vector<double>>> places;
    Random random(problem.seed, stream(kEvasionStream, index));
    for (int k = 0; k < kEvasions && !isFullyProven(best); ++k) {
      std::vector<double> place = neighbour(random);
      if (space().withinLimits(place)) {
        const double room = certifier.roomAt(place, marks.back());
        places.emplace_back(room, std::move(place));
      }
    }
    std::stable_sort(places.begin(), places.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    for (std::size_t k = 0; k < places.size() && k < kEvasionsAsked && !isFullyProven(best); ++k)
      consider(evasion(std::make_shared<const Drive>(
                   space_of_drives, Waypoints{state, places[k].second}, limits, period())),
               step);
    step.plan_s += secondsSince(begin);
  }

  /// How the robot drives along a path, whose edges are certified. Cuts corners where the rows are
  /// free in the world as seen; so all of it is.
  std::shared_ptr<const Drive> driveAlong(const Waypoints& along,
                                          const std::shared_ptr<const CompiledScene>& world) {
    if (execution().corners == Corners::kBlend && along.size() > 2) {
      const auto made = std::make_shared<const Drive>(space_of_drives, along, limits, period(),
                                                      certifiedCuts(world, along, limits));
      std::vector<TimedPoint> rows;
      for (int k = 0; k <= made->rows(); ++k) rows.push_back({k * period(), made->at(k)});
      if (certifier.isFree(rows)) return made;
    }
    return std::make_shared<const Drive>(space_of_drives, along, limits, period());
  }

  /// A random configuration nearby.
  std::vector<double> neighbour(Random& random) const {
    std::vector<double> dq(state.size()), place(state.size());
    const double time = random.uniform(0, kEvasionTime);
    for (const ConfigurationSpace::Part& part : space().parts()) {
      const auto i = static_cast<std::size_t>(part.first);
      if (part.kind == ConfigurationSpace::Kind::kRotation) {
        const double most = limits.velocity[i] * time / std::sqrt(3.0);
        for (std::size_t k = 0; k < 3; ++k) dq[i + k] = random.uniform(-most, most);
      } else {
        dq[i] = random.uniform(-1, 1) * limits.velocity[i] * time;
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
  /// obstacles, then without. Returns how to drive; null without a path.
  std::shared_ptr<const Drive> plan(ReplanStep& step) {
    const Clock::time_point begin = Clock::now();
    Problem from_here = problem;
    for (std::size_t i = 0; i < state.size(); ++i)
      from_here.start[static_cast<std::size_t>(problem.robot.variables[i])] = state[i];
    from_here.seed = Random(problem.seed, stream(kReplanStream, searches++)).next();
    from_here.planner.push = false;  // the buffer is for that
    PlanOptions plan_options;
    plan_options.stop = options.stop;
    plan_options.progress = options.progress;
    std::shared_ptr<const Drive> found;
    for (const double buffer : {execution().buffer, 0.0}) {
      const std::shared_ptr<const CompiledScene> world = obstacles.world(buffer);
      const PlanResult result = planIn(world, from_here, plan_options);
      step.iterations += result.iterations;
      step.edges += result.edges;
      step.distance_queries += result.distance_queries;
      if (result.status == PlanStatus::kSolved) {
        found = driveAlong(result.path.positions, world);
        step.path_clearance = result.certificate.clearance.lower;
        break;
      }
      if (buffer == 0 || obstacles.empty()) break;
    }
    step.plan_s += secondsSince(begin);
    return found;
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
    certifier.setWork(options.work);
    if (moves()) {
      // An obstacle that crosses the path farther ahead may be gone by then.
      unheld = step.path_held ? 0 : unheld + execution().step;
      if (follows && unheld <= execution().patience) {
        if (pace >= periods && goesOnAsProven()) return;
        considerDrive(Decision::kFollow, drive, static_cast<int>(time_on_drive), step);
      }
      if (isFullyProven(best)) return;
      if (follows)
        why = unheld <= execution().patience ? "the way ahead with a stop at its end is not proven"
                                             : "the path does not hold";
      certifier.setWork(options.work);  // kept for what there is to fall back on
      return consider(goingOn(), step, provenBefore());
    }
    unheld = 0;
    if (restBefore() >= periods) {
      why = "it has just come to rest";
      return consider(goingOn(), step, provenBefore());
    }
    why = path.empty() ? "there is no path" : "the path does not hold";
    if (step.path_held) {
      why = "the way ahead with a stop at its end is not proven";
      if (drive == nullptr) setDrive(driveAlong(path, seen));
      considerDrive(Decision::kFollow, drive, static_cast<int>(time_on_drive), step);
    }
    if (isFullyProven(best)) return;
    const bool impatient = waited >= execution().patience;
    if ((!step.path_held || impatient) && mayPlan()) {
      if (const std::shared_ptr<const Drive> found = plan(step)) {
        why = "the way ahead with a stop at its end is not proven";
        considerDrive(Decision::kPlan, found, 0, step);
      } else {
        why = "no path was found";
        planFailed();
      }
    }
    if (isFullyProven(best)) return;
    certifier.setWork(options.work);
    setMarks(true);  // also where their future is not known: it may have to leave
    consider(goingOn(), step, provenBefore());
    if (isFullyProven(best)) return;
    why += ", and rest is not proven as far as it looks ahead";
    const double standing_until = rest_until;
    const StepCertifier::Bodies standing_blocked = blocked;
    considerEvasions(step);
    rest_until = standing_until;
    blocked = standing_blocked;
  }

  /// Keeps to the drive and its stop as they were proven, if what was known then still holds.
  bool goesOnAsProven() {
    Candidate c = goingOn();
    c.decision = Decision::kFollow;
    c.pace = pace;
    if (!setMotion(c)) return false;
    c.until = provenBefore();
    if (!isProven(c)) return false;
    best = std::move(c);
    return true;
  }

  void setDrive(std::shared_ptr<const Drive> on) {
    drive = std::move(on);
    time_on_drive = 0;
    evades = false;
    offset.clear();
  }

  void take(ReplanStep& step) {
    if (!isProven(best) || !proves || is_lost) {
      best = goingOn();
      best.decision = Decision::kUnsafe;
      setMotion(best);
      step.exposed = proves && !is_lost && rest_until >= best.stop_end;
      why = !proves        ? "no pair of shapes is checked"
            : is_lost      ? "a body that turns freely was measured beside its motion"
            : step.exposed ? fmt::format("it {}, where an obstacle may reach it{}",
                                         moves() ? "comes to rest" : "stands", blockedText())
                           : "neither a motion nor rest is proven";
      if (step.exposed) best.until = rest_until;
    }
    is_lost = is_contradicted = false;
    proven_until = best.until;
    step.decision = best.decision;
    step.certified = best.decision != Decision::kUnsafe;
    step.look_ahead =
        step.certified ? std::clamp(best.until - stepEnd(), 0.0, execution().look_ahead) : 0.0;
    const auto end = best.motion.begin() + periods + 1;
    step.motion.assign(best.motion.begin(), end);
    step.stop.assign(end, std::find_if(end, best.motion.end(), [&](const TimedPoint& row) {
                       return row.time > best.stop_end;
                     }));
    int still = 0;  // rows at the end of the step in which the robot stands
    while (still < periods && step.motion[at(periods - still - 1)].position ==
                                  step.motion[at(periods - still)].position)
      ++still;
    rested = std::min(still < periods ? still : rested + periods, kMostRested);
    step.keeps_stop = keepsStop(step);
    last_stop = step.stop;
    if (!step.certified) {
      step.clearance = {-kInfinity, kInfinity};
    } else {
      const Clock::time_point begin = Clock::now();
      // clearance() uses the parts of the last proof, which may be another candidate's.
      StepCertifier::Bodies ignored, closest;
      const double step_end = stepEnd();
      const Tick end_tick = tickOf(1);
      certifier.setWork(options.work);
      // The work may end before all parts are proven again; then the margins are known.
      const bool is_again = certifier.certify(step.motion, {&end_tick, 1}, 1, ignored) >= step_end;
      step.clearance = is_again ? certifier.clearance(step.motion, step_end,
                                                      options.clearance_tolerance, closest)
                                : collision::Interval{leastMargin(), kInfinity};
      step.closest_a = closest.a;
      step.closest_b = closest.b;
      step.clearance_s = secondsSince(begin);
    }
    state = step.motion.back().position;
    const bool moved = best.decision == Decision::kFollow || best.decision == Decision::kPlan;
    if (!moved) step.why = why;
    if (best.decision == Decision::kPlan) {
      if (sums.plans > 0) ++sums.replans;
      pause = 1;
    }
    go();
    waited = moved ? 0 : waited + execution().step;
    if (!best.trail.empty()) trail = best.trail;
    if (trail.back() != state && !evades) trail.push_back(state);
    if (trail.size() > kTrail) trail.erase(trail.begin());
    step.reached = isReached();
    step.remaining_s = path.empty()       ? kInfinity
                       : drive && !evades ? (drive->rows() - time_on_drive) * period()
                                          : pathDuration(space(), limits.velocity, path);
    now = stepEnd();
    ++index;
  }

  /// Takes the best candidate: where the robot is on its drive, and what of the path is left.
  void go() {
    if (best.drive != nullptr) {
      if (best.drive != drive) setDrive(best.drive);
      evades = best.decision == Decision::kEvade || (best.decision == Decision::kUnsafe && evades);
      const std::size_t passed = std::min(best.times.size(), at(periods));
      time_on_drive = best.times[passed - 1];
      ahead.assign(best.times.begin() + static_cast<std::ptrdiff_t>(passed), best.times.end());
      follows = best.pace >= periods;
      pace = std::max(0, best.pace - periods);
    }
    first_edge_known = follows;
    if (drive == nullptr || evades) {
      if (!path.empty()) path.front() = state;
    } else {
      path = drive->pathFrom(time_on_drive);
      path.front() = state;
      // It is not quite where the path ends.
      if (path.size() == 1 && !offset.empty()) path.push_back(drive->at(drive->rows()));
    }
    path = unwrapped(space(), std::move(path));
    if (moves()) return;
    // At rest it drives on from a row in which the drive rests; else by another one.
    const bool rests_on_it = drive != nullptr && !evades && offset.empty() &&
                             time_on_drive < drive->rows() &&
                             drive->restFrom(static_cast<int>(time_on_drive)) == time_on_drive;
    if (!rests_on_it) {
      setDrive(nullptr);
      follows = false;
    }
  }

  /// Whether the step's rows, and its stop, are the stop of the step before.
  bool keepsStop(const ReplanStep& step) const {
    return last_stop.size() == at(periods) + step.stop.size() && !step.stop.empty() &&
           std::equal(step.motion.begin() + 1, step.motion.end(), last_stop.begin()) &&
           std::equal(step.stop.begin(), step.stop.end(), last_stop.begin() + periods);
  }

  std::string blockedText() const {
    return blocked.a.empty() ? "" : fmt::format(": {} and {}", blocked.a, blocked.b);
  }

  double leastMargin() const { return scene->scene().pairs().leastMargin(); }

  bool isReached() const { return !moves() && path.size() == 1 && inGoal(state); }

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
    certifier.begin(tickOf(0));
    setMarks(obstacles.arePredicted());
    step.update_s = secondsSince(begin);
    step.obstacles = obstacles.updates();
    seen = obstacles.world();
    begin = Clock::now();
    certifier.setWork(options.work);
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
      sums.status = step.exposed      ? ReplanStatus::kExposed
                    : !step.certified ? ReplanStatus::kUnsafe
                    : step.reached    ? ReplanStatus::kReached
                                      : ReplanStatus::kStopped;
    return step;
  }

  /// Takes the robot's true state. In motion it goes on from there, beside its drive.
  void measure(std::span<const double> point) {
    std::vector<double> off(state.size());
    space().difference(state, point, off);
    if (isWithin(off, options.joint_errors)) return;
    const std::vector<double> before = std::exchange(state, {point.begin(), point.end()});
    space().unwrap(before, state);
    measured = state;
    is_contradicted = true;
    trail.push_back(state);
    first_edge_known = false;
    // One waypoint is the goal, and the robot is no longer there.
    if (path.size() == 1) path.clear();
    if (!path.empty()) path.front() = state;
    if (moves() && !hasRotation(space())) {
      if (offset.empty()) offset.assign(state.size(), 0);
      for (std::size_t i = 0; i < off.size(); ++i) offset[i] += off[i];
      first_edge_known = true;  // no edge of it is taken before the robot rests
    } else {
      // How it comes to rest from there is not known, also where it was measured twice in a step.
      is_lost = is_lost || moves();
      setDrive(nullptr);
      ahead.clear();
      follows = false;
    }
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
    // An older sight takes the place of the one that proofs rely on.
    const bool contradicts = !(obstacles.jump(object, sight, time) <= 0) ||
                             obstacles.widens(object, sight, bound) ||
                             time < obstacles.seenAt(object, sight);
    obstacles.set(object, sight, time, bound);
    is_contradicted = is_contradicted || contradicts;
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

  ReplanOptions options;
  Problem problem;  // with margins that hold for the motion as it is commanded
  std::shared_ptr<const CompiledScene> scene;
  Obstacles obstacles;
  StepCertifier certifier;
  bool proves;  // false: no pair is checked, and so no step is certified
  MotionLimits limits;
  std::shared_ptr<const ConfigurationSpace> space_of_drives;
  int periods;      // of a step
  double reaction;  // the longest time of a stop [s]; an evasion takes it and kEvasionTime
  std::shared_ptr<const CompiledScene> seen;
  double now;
  std::vector<double> state;
  Waypoints trail;
  Waypoints path;
  bool first_edge_known = true;
  // Where the robot is on a drive, and its proven way to rest, a time a period; none at rest.
  std::shared_ptr<const Drive> drive;
  double time_on_drive = 0;
  std::vector<double> ahead;
  bool follows = false;  // it moves at the drive's pace, in its rows
  int pace = 0;          // of `ahead`, the first that do [count]
  static constexpr int kMostRested = 2;
  int rested = kMostRested;    // rows for which it has stood, up to kMostRested
  bool is_lost = false;        // it was measured in a motion that cannot go on beside its drive
  bool evades = false;         // the drive leaves the path
  std::vector<double> offset;  // from the drive, where it was measured; empty: none
  double unheld = 0;           // how long the path has not held in motion [s]
  std::string why;             // it waits
  std::vector<TimedPoint> last_stop;
  Candidate best;
  StepCertifier::Bodies blocked;     // of the last candidate
  double rest_until = -kInfinity;    // up to when goingOn() is proven now [s]
  double proven_until = -kInfinity;  // and was in the step before
  bool is_contradicted = false;      // what was known then does not hold any more
  std::vector<Tick> marks;
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
bool Replanner::reached() const { return impl_->isReached(); }
int Replanner::replans() const { return impl_->sums.replans; }
ReplanResult Replanner::executed() const { return impl_->sums; }
std::shared_ptr<const CompiledScene> Replanner::scene() const { return impl_->seen; }

void Replanner::setState(std::span<const double> point) {
  if (point.size() != impl_->state.size() || !impl_->space().withinLimits(point))
    throw std::invalid_argument(fmt::format(
        "a state of {} finite numbers within the limits is expected", impl_->state.size()));
  if (std::equal(point.begin(), point.end(), impl_->state.begin())) return;
  impl_->measure(point);
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
