#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/planner/guard.h"
#include "leeway/robots/input_error.h"
#include "planner/base/tolerances.h"
#include "planner/execute/tracking.h"
#include "planner/guard/brake.h"
#include "planner/guard/setpoint_motion.h"
#include "planner/guard/setpoint_proof.h"
#include "planner/timing/leg.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

/// Checks the members that a Guard does not read.
const Problem& guardable(const Problem& problem) {
  validate(problem);
  const auto refuse = [&](const char* what) {
    throw robots::InputError(problem.name, 0, fmt::format("Guard: there are {}", what));
  };
  if (!problem.steps.empty()) refuse("steps, which a Guard does not follow; none are expected");
  if (isConstrained(problem))
    refuse("constraints or a condition, which a Guard does not keep; none are expected");
  return problem;
}

/// Returns the options with the limits that hold; throws where they make no sense.
GuardOptions checked(GuardOptions options, const Problem& problem) {
  const auto expect = [&](bool holds, const std::string& what) {
    if (!holds) throw robots::InputError(problem.name, 0, "Guard: " + what);
  };
  const std::size_t size = problem.robot.variables.size();
  expect(options.period >= GuardOptions::kLeastPeriod && options.period <= 10,
         fmt::format("the period is {} s; {} to 10 s is expected", options.period,
                     GuardOptions::kLeastPeriod));
  expect(options.most_setpoints >= 1 && options.most_setpoints <= GuardOptions::kMostSetpoints,
         fmt::format("most_setpoints is {}; 1 to {} is expected", options.most_setpoints,
                     GuardOptions::kMostSetpoints));
  expect(options.work > 0, fmt::format("work is {}; more than 0 is expected", options.work));
  expect(options.horizon > 0 && options.horizon <= 1e6,
         fmt::format("horizon is {} s; above 0, and at most 1e6 s is expected", options.horizon));
  expect(options.point_error >= 0 && options.point_error < kInfinity,
         fmt::format("point_error is {} m; 0 or more is expected", options.point_error));
  const auto rows = [&](const std::vector<double>& numbers, const char* name, auto accepted,
                        const char* expected) {
    expect(numbers.size() == size, fmt::format("{} has {} numbers; {} are expected, one a planned "
                                               "variable",
                                               name, numbers.size(), size));
    for (std::size_t i = 0; i < size; ++i)
      expect(accepted(numbers[i]),
             fmt::format("{}[{}] is {}; {} is expected", name, i, numbers[i], expected));
  };
  if (options.limits.velocity.empty()) options.limits = motionLimits(problem);
  const auto positive = [](double x) { return x > 0 && x < kInfinity; };
  rows(options.limits.velocity, "limits.velocity", positive, "above 0");
  rows(options.limits.acceleration, "limits.acceleration", positive, "above 0");
  if (options.limits.jerk.empty()) options.limits.jerk.assign(size, kInfinity);
  rows(
      options.limits.jerk, "limits.jerk", [](double j) { return j > 0; }, "above 0");
  return options;
}

/// The problem whose margins hold for the robot's motion as it is commanded, and its scene.
using Commanded = std::pair<Problem, std::shared_ptr<const CompiledScene>>;

Commanded commandedProblem(const Problem& problem, GuardOptions& options) {
  Problem margins = withErrors(problem, options.joint_errors, options.point_error, "Guard");
  auto scene = std::make_shared<const CompiledScene>(margins);
  const auto refuse = [&](const std::string& message) {
    throw robots::InputError(problem.name, 0, "Guard: " + message);
  };
  if (hasRotation(scene->space()))
    refuse("a planned joint is floating; joints with a position each are expected");
  if (const std::string why = scene->nothingChecked(); !why.empty())
    refuse("no pair is checked: " + why);
  return {std::move(margins), std::move(scene)};
}

bool isFinite(std::span<const double> numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

}  // namespace

const char* toString(GuardReason reason) {
  switch (reason) {
    case GuardReason::kPassed:
      return "passed";
    case GuardReason::kLimit:
      return "limit";
    case GuardReason::kNotFree:
      return "not_free";
    case GuardReason::kNotCertified:
      return "not_certified";
    case GuardReason::kWork:
      return "work";
    case GuardReason::kStale:
      return "stale";
    case GuardReason::kJumped:
      return "jumped";
    case GuardReason::kInvalid:
      break;
  }
  return "invalid";
}

const char* toString(MotionLimit limit) {
  switch (limit) {
    case MotionLimit::kPosition:
      return "position";
    case MotionLimit::kVelocity:
      return "velocity";
    case MotionLimit::kAcceleration:
      return "acceleration";
    case MotionLimit::kJerk:
      break;
  }
  return "jerk";
}

const char* toString(Observation observation) {
  switch (observation) {
    case Observation::kTaken:
      return "taken";
    case Observation::kJumped:
      return "jumped";
    case Observation::kLate:
      return "late";
    case Observation::kInvalid:
      break;
  }
  return "invalid";
}

struct Guard::Impl {
  Impl(const Problem& given, const GuardOptions& given_options)
      : problem(guardable(given)),
        options(checked(given_options, problem)),
        commanded(commandedProblem(problem, options)),
        scene(commanded.second),
        size(at(scene->space().size())),
        proof(commanded.first, options, scene),
        brake(options.limits, options.period),
        known(size, at(options.most_setpoints + brake.mostRows()), GuardRequest::kMostTerms),
        next(known),
        velocity(size),
        acceleration(size) {
    known.reset(startPoint(problem), problem.execution.start);
    answer.start = known.row(0);
    answer.time = known.time;
    proof.look(problem.execution.start);
  }

  double nextTime() const {
    return has_begun ? known.time + std::max(1, known.passed) * options.period : known.time;
  }

  // ---------------------------------------------------------------------------------------------
  // Where the motion begins

  /// Sets `next` to begin where `known` is at a time.
  void beginOn(double time) {
    next.time = time;
    next.since = 0;
    next.rows = next.passed = next.curved = 0;
    const double periods =
        std::min((time - known.time) / options.period, static_cast<double>(known.rows + 1));
    const double same = sameTime(time, options.period) / options.period;
    const int whole = static_cast<int>(periods + same);
    const double share = periods - whole;  // of the way to the row after that
    const bool between = share > same;
    const bool rests = whole > known.rows || (whole == known.rows && between);
    const int row = std::min(whole, known.rows);
    const int to = between && !rests ? row + 1 : row;
    if (between && !rests && to <= known.curved)
      return beginOnCurve(known.curveTime(periods, options.period));
    for (std::size_t i = 0; i < size; ++i) {
      const double p = known.row(row)[i];
      next.row(0)[i] = to > row ? p + (known.row(to)[i] - p) * share : p;
      next.velocity[i] = rests ? 0 : known.velocityTo(to, i, options.period);
      next.acceleration[i] = rests ? 0 : known.accelerationTo(to, i, options.period);
    }
    // In the middle of a period the velocity may have changed at its begin.
    if (whole == known.rows && between) {
      bool stopped = false;
      for (std::size_t i = 0; i < size; ++i)
        stopped = stopped || known.velocityTo(known.rows, i, options.period) != 0;
      if (stopped) next.since = share * options.period;
    } else if (between && !rests) {
      next.since = share * options.period;
    } else if (!rests && to == 0) {
      next.since = known.since;
    }
  }

  void beginOnCurve(double t) {
    // Where polynomials begin, velocity may have changed.
    if (t < options.period) next.since = t;
    for (std::size_t i = 0; i < size; ++i) {
      next.row(0)[i] = placeOn(known.curve, i, t);
      next.velocity[i] = known.curve.at(i, 1, t);
      next.acceleration[i] = known.curve.at(i, 2, t);
    }
  }

  /// A variable's place on a polynomial that keeps the limits, without what rounding adds.
  double placeOn(const Polynomials& curve, std::size_t i, double t) const {
    const double q = curve.at(i, 0, t);
    const auto variable = static_cast<int>(i);
    return isCircle(variable)
               ? q
               : std::clamp(q, scene->space().lower(variable), scene->space().upper(variable));
  }

  /// Each part of the space is one variable, because no joint is floating.
  bool isCircle(int variable) const {
    return scene->space().parts()[at(variable)].kind == ConfigurationSpace::Kind::kCircle;
  }

  bool takesTime(double time) const {
    return std::isfinite(time) && time >= known.time &&
           timeSpacing(time) <= kGuardCoarsestTime * options.period;
  }

  /// How far a variable is from where `next` begins. Whole turns do not move a circle.
  double offMotion(std::size_t i, double place) const {
    const double off = place - next.row(0)[i];
    const bool has_turns = isCircle(static_cast<int>(i)) && std::abs(off) <= kLargestAngle;
    return has_turns ? std::remainder(off, 2 * std::numbers::pi) : off;
  }

  /// Where setpoints or polynomials of a variable begin; they may make no sense.
  std::optional<double> firstOf(const GuardRequest& request, std::size_t i) const {
    if (request.setpoints.size() >= size) return request.setpoints[i];
    const std::size_t terms = request.polynomials.size() / size;
    if (terms > 0) return request.polynomials[i * terms];
    return {};
  }

  /// Takes the request's time and state; false where they make no sense. The robot is at a position
  /// that is readable also where the rest is not.
  bool begin(const GuardRequest& request) {
    const double time = request.time.value_or(nextTime());
    const bool has_time = takesTime(time);
    beginOn(has_time ? time : nextTime());
    const auto fits = [&](std::span<const double> state) {
      return state.empty() || (state.size() == size && isFinite(state));
    };
    const bool has_place = fits(request.position), has_velocity = fits(request.velocity);
    const auto place = has_place ? request.position : std::span<const double>();
    const auto moves = has_velocity ? request.velocity : std::span<const double>();
    bool leaves = !has_begun || (is_lost && !place.empty());
    for (std::size_t i = 0; i < place.size(); ++i)
      leaves = leaves ||
               !(std::abs(offMotion(i, place[i])) <= options.joint_errors[i] + kVerifyWaypoint);
    if (!leaves)
      for (std::size_t i = 0; i < place.size(); ++i) {
        double& now = next.row(0)[i];
        const std::optional<double> first = firstOf(request, i);
        // Setpoints follow in the turn that is commanded, or in the one that was measured.
        if (first && std::abs(place[i] - now) > std::numbers::pi &&
            std::abs(*first - place[i]) < std::abs(*first - now))
          now = place[i] - offMotion(i, place[i]);
      }
    if (leaves) {
      // Without a time, the velocity of the motion before does not say how fast the robot is.
      const bool is_fast = has_begun && !has_time && moves.empty();
      known_holds = false;
      is_lost = !has_place || !has_velocity || is_fast;
      next.since = 0;
      std::copy(place.begin(), place.end(), next.row(0).begin());
      std::copy(moves.begin(), moves.end(), next.velocity.begin());
      std::fill(next.acceleration.begin(), next.acceleration.end(), 0);
    }
    return has_time && has_place && has_velocity;
  }

  // ---------------------------------------------------------------------------------------------
  // Setpoints and stops

  /// Takes the setpoints that are within the limits into `next`; returns how many.
  int takeSetpoints(std::span<const double> setpoints) {
    const int count = static_cast<int>(setpoints.size() / size);
    for (int k = 1; k <= count; ++k) {
      const std::span<const double> row = setpoints.subspan(at(k - 1) * size, size);
      std::copy(row.begin(), row.end(), next.row(k).begin());
      if (!keepsLimits(k)) return k - 1;
    }
    return count;
  }

  /// Whether the request's polynomials make sense where `next` begins.
  bool arePolynomials(const GuardRequest& request) const {
    const std::size_t given = request.polynomials.size(), terms = given / size;
    const double periods = request.duration / options.period;
    if (given % size != 0 || terms > at(GuardRequest::kMostTerms) || !isFinite(request.polynomials))
      return false;
    if (!(periods >= 0.5 && periods <= options.most_setpoints + 0.5) ||
        !(std::abs(periods - std::round(periods)) <= kGuardSameTime))
      return false;
    for (std::size_t i = 0; i < size; ++i)
      if (!(std::abs(request.polynomials[i * terms] - next.row(0)[i]) <= kVerifyWaypoint))
        return false;
    return true;
  }

  /// Takes polynomials into `next` as far as they keep the limits; returns for how many periods.
  int takePolynomials(const GuardRequest& request) {
    const double T = options.period;
    const int count = static_cast<int>(std::round(request.duration / T));
    next.curve.set(request.polynomials);
    next.curve_begin = 0;
    next.curved = 0;
    double until = count * T;
    for (std::size_t i = 0; i < size && until > 0; ++i) until = keepsLimitsUntil(i, until);
    next.curved = until < count * T ? static_cast<int>(until / T) : count;
    for (int k = 1; k <= next.curved; ++k)
      for (std::size_t i = 0; i < size; ++i) next.row(k)[i] = placeOn(next.curve, i, k * T);
    for (std::size_t i = 0; i < size; ++i) {
      double most = 0;
      for (int part = 0; part < kGuardPolynomialParts; ++part)
        most = std::max(most, next.curve.most(i, 2, until * part / kGuardPolynomialParts,
                                              until * (part + 1) / kGuardPolynomialParts));
      next.bend[i] = (most * T * T / 8 + std::abs(next.curve.at(i, 0, 0) - next.row(0)[i]) +
                      next.curve.rounding(i, 0, until)) *
                     (1 + kGuardChordShare);
    }
    proof.charge(static_cast<std::int64_t>(size) * kGuardPolynomialParts * kGuardPolynomialWork);
    return next.curved;
  }

  /// The time in [0, `until`] up to which the polynomial of a variable keeps its limits.
  double keepsLimitsUntil(std::size_t i, double until) {
    const auto variable = static_cast<int>(i);
    const double T = options.period, dt = next.timeTo(1, T);
    const double rounding = kGuardDifference * (std::abs(next.row(0)[i]) + 1) / T;
    const double first = next.curve.at(i, 1, 0), bends = next.curve.at(i, 2, 0);
    if (!keeps(MotionLimit::kAcceleration, variable, (first - next.velocity[i]) / dt,
               options.limits.acceleration[i], rounding * 4 / dt))
      return 0;
    for (const double jerk :
         {(first - next.velocity[i]) / (dt * dt), (bends - next.acceleration[i]) / dt})
      if (!keeps(MotionLimit::kJerk, variable, jerk, options.limits.jerk[i],
                 rounding * 16 / (dt * dt)))
        return 0;
    const bool is_circle = isCircle(variable);
    // A circle that turns farther in a period would go the other way.
    const double fastest = is_circle ? kLongestLineTurn / T : kInfinity;
    const double most[] = {kInfinity, std::min(options.limits.velocity[i], fastest),
                           options.limits.acceleration[i], options.limits.jerk[i]};
    constexpr MotionLimit kLimits[] = {MotionLimit::kPosition, MotionLimit::kVelocity,
                                       MotionLimit::kAcceleration, MotionLimit::kJerk};
    for (int order = 0; order < 4; ++order) {
      if (order == 0 ? is_circle : !(most[order] < kInfinity)) continue;
      const double high = order == 0 ? scene->space().upper(variable) : most[order];
      const double low = order == 0 ? scene->space().lower(variable) : -most[order];
      const double slack =
          (order == 0 ? 0 : kGuardLimitSlack * high) + next.curve.rounding(i, order, until);
      int steps = kGuardPolynomialSteps;
      const double kept =
          next.curve.keepsUntil({i, order, low - slack, high + slack}, 0, until, steps);
      proof.charge((kGuardPolynomialSteps - steps + 1) * kGuardPolynomialWork);
      if (!(kept < until)) continue;
      const double here = next.curve.at(i, order, kept);
      const double there = next.curve.at(i, order, std::min(until, kept + T));
      const double value =
          std::max(here - high, low - here) > std::max(there - high, low - there) ? here : there;
      setLimit(kLimits[order], variable, value, value > high - (high - low) / 2 ? high : low);
      until = kept;
    }
    return until;
  }

  bool keepsLimits(int k) {
    const double T = options.period;
    for (const ConfigurationSpace::Part& part : scene->space().parts()) {
      const std::size_t i = at(part.first);
      const double q = next.row(k)[i];
      const bool is_circle = part.kind == ConfigurationSpace::Kind::kCircle;
      if (!is_circle && !keepsRange(part.first, q)) return false;
      const double dt = next.timeTo(k, T);
      const double before = next.velocityTo(k - 1, i, T), now = next.velocityTo(k, i, T);
      const double earlier = next.accelerationTo(k - 1, i, T), a = (now - before) / dt;
      const double rounding = kGuardDifference * (std::abs(q) + 1) / T;
      // A circle that turns farther would go the other way.
      const double fastest = is_circle ? kLongestLineTurn / T : kInfinity;
      if (!keeps(MotionLimit::kVelocity, part.first, now,
                 std::min(options.limits.velocity[i], fastest), rounding) ||
          !keeps(MotionLimit::kAcceleration, part.first, a, options.limits.acceleration[i],
                 rounding * 4 / dt) ||
          !keeps(MotionLimit::kJerk, part.first, (a - earlier) / dt, options.limits.jerk[i],
                 rounding * 16 / (dt * dt)))
        return false;
    }
    return true;
  }

  /// Names a limit that the robot breaks where the motion begins: setpoints may lead back inside.
  void checkBeginning() {
    for (int i = 0; i < static_cast<int>(size); ++i)
      if (!(isCircle(i) || keepsRange(i, next.row(0)[at(i)])) ||
          !keeps(MotionLimit::kVelocity, i, next.velocity[at(i)], options.limits.velocity[at(i)],
                 0))
        return;
  }

  bool keepsRange(int variable, double q) {
    const double low = scene->space().lower(variable), high = scene->space().upper(variable);
    if (q >= low && q <= high) return true;
    setLimit(MotionLimit::kPosition, variable, q, q < low ? low : high);
    return false;
  }

  bool keeps(MotionLimit limit, int variable, double value, double most, double rounding) {
    if (std::abs(value) <= most * (1 + kGuardLimitSlack) + rounding) return true;
    setLimit(limit, variable, value, value < 0 ? -most : most);
    return false;
  }

  void setLimit(MotionLimit limit, int variable, double value, double allowed) {
    fail(GuardReason::kLimit);
    answer.limit = limit;
    answer.variable = variable;
    answer.value = value;
    answer.allowed = allowed;
  }

  void fail(GuardReason reason, bool in_stop = false, std::string_view a = {},
            std::string_view b = {}) {
    answer.reason = reason;
    answer.in_stop = in_stop;
    answer.a = a;
    answer.b = b;
    answer.variable = -1;
    answer.value = answer.allowed = 0;
  }
  void failAsProof(bool in_stop) {
    fail(proof.failure().reason, in_stop, proof.failure().a, proof.failure().b);
  }

  /// Appends a stop to the first k setpoints. Returns false, and leaves next.rows at k, where there
  /// is too little room for it.
  bool appendStop(int k) {
    for (std::size_t i = 0; i < size; ++i) {
      velocity[i] = next.velocityTo(k, i, options.period);
      acceleration[i] = next.accelerationTo(k, i, options.period);
    }
    const int stop = brake.stop(next.row(k), velocity, acceleration, next.from(k + 1),
                                next.timeTo(k + 1, options.period));
    next.passed = k;
    next.curved = std::min(next.curved, k);
    next.rows = k + std::max(0, stop);
    return stop >= 0;
  }

  /// Returns whether a row of the stop after k setpoints keeps the limits that a stop may break.
  /// With k = 0 the robot may already be faster than its limits; the stop is not faster than that.
  bool stopKeepsLimits(int k, int row) {
    const double T = options.period;
    for (const ConfigurationSpace::Part& part : scene->space().parts()) {
      const std::size_t i = at(part.first);
      const double q = next.row(row)[i];
      const bool is_circle = part.kind == ConfigurationSpace::Kind::kCircle;
      if (!is_circle && !keepsRange(part.first, q)) return false;
      const double now = next.velocityTo(row, i, T);
      const double rounding = kGuardDifference * (std::abs(q) + 1) / T;
      // A circle that turns farther would go the other way.
      const double fastest = is_circle ? kLongestLineTurn / T : kInfinity;
      const double most =
          std::max(options.limits.velocity[i], k > 0 ? 0 : std::abs(next.velocity[i]));
      if (!keeps(MotionLimit::kVelocity, part.first, now, std::min(most, fastest), rounding))
        return false;
      // The robot may be in no state to brake within its limits from within a period.
      if (row > 2 || !(next.since > 0)) continue;
      const double since = next.timeTo(row, T), a = next.accelerationTo(row, i, T);
      const double before = row == 1 ? next.acceleration[i] : next.accelerationTo(row - 1, i, T);
      if (!keeps(MotionLimit::kAcceleration, part.first, a, options.limits.acceleration[i],
                 rounding * 4 / since) ||
          !keeps(MotionLimit::kJerk, part.first, (a - before) / since, options.limits.jerk[i],
                 rounding * 16 / (next.since * since)))
        return false;
    }
    return true;
  }

  /// Whether k setpoints, which are proven, have a stop that is proven. Where k is 0, the reason
  /// why the first setpoint does not pass stays.
  bool hasStop(int k) {
    if (!appendStop(k)) {
      if (k > 0 || answer.reason == GuardReason::kPassed) fail(GuardReason::kNotCertified, true);
      return false;
    }
    const GuardAnswer before = answer;
    bool keeps = true;
    proof.charge(static_cast<std::int64_t>(next.rows - k) * static_cast<std::int64_t>(size));
    for (int row = k + 1; row <= next.rows && keeps; ++row) keeps = stopKeepsLimits(k, row);
    if (!keeps) {
      answer.in_stop = true;
    } else {
      keeps = proof.isFree(next, k, next.rows);
      if (!keeps) failAsProof(true);
    }
    if (k == 0 && before.reason != GuardReason::kPassed) answer = before;
    return keeps;
  }

  /// Sets `next` to the setpoints that pass and their stop, proven. Returns false where not even a
  /// stop is proven.
  bool prove(const GuardRequest& request) {
    const std::size_t given = request.setpoints.size();
    const bool curves = !request.polynomials.empty();
    int count = 0;
    if (!begin(request) || given % size != 0 || given / size > at(options.most_setpoints) ||
        !isFinite(request.setpoints) ||
        (curves ? given > 0 || !arePolynomials(request) : request.duration != 0)) {
      fail(GuardReason::kInvalid);
      if (is_lost) return false;
    } else if (is_lost) {  // where the robot is, and whether it is at rest, is not known
      fail(GuardReason::kNotCertified, true);
      return false;
    } else if (!jumped.empty()) {
      fail(GuardReason::kJumped, false, jumped.front());
    } else {
      count = curves ? takePolynomials(request) : takeSetpoints(request.setpoints);
      if (count > 0) {
        const int free = std::max(0, proof.freeUntil(next, 0, count));
        if (free < count) failAsProof(false);
        count = free;
      }
    }
    for (int k = count; k >= 0; --k) {
      if (hasStop(k)) {
        if (k == 0 && answer.reason == GuardReason::kPassed) checkBeginning();
        return true;
      }
      if (proof.isSpent()) break;
    }
    // There is too little room for a stop: perhaps the robot is too fast, or elsewhere.
    if (answer.reason == GuardReason::kNotCertified && answer.a.empty()) checkBeginning();
    return false;
  }

  /// Takes what is left of the last motion into `next`.
  void goOn(double time) {
    const double periods = std::max(0.0, (time - known.time) / options.period);
    const double same = sameTime(time, options.period) / options.period;
    const int row = periods >= known.rows ? known.rows : static_cast<int>(periods + same);
    for (std::size_t i = 0; i < size; ++i) {
      next.velocity[i] = known.velocityTo(row, i, options.period);
      next.acceleration[i] = known.accelerationTo(row, i, options.period);
    }
    for (int k = row; k <= known.rows; ++k)
      std::copy(known.row(k).begin(), known.row(k).end(), next.row(k - row).begin());
    next.since = row == 0 ? known.since : 0;
    next.curve = known.curve;
    next.curve_begin = known.curveTime(row, options.period);
    next.curved = std::max(0, known.curved - row);
    next.time = periods >= known.rows ? time : known.time + row * options.period;
    next.rows = known.rows - row;
    next.passed = 0;
  }

  const GuardAnswer& check(const GuardRequest& request) {
    answer = {};
    answer.reason = GuardReason::kPassed;
    proof.begin(options.work);
    if (prove(request)) {
      known_holds = answer.certified = true;
    } else if (known_holds) {
      goOn(next.time);
      answer.goes_on = true;
      // At rest it is proven that nothing touches as long as nothing else moves.
      answer.certified = next.rows > 0 || !proof.hasObstacles();
    } else if (!appendStop(0)) {
      is_lost = true;  // it is faster than any stop that there is room for
    }
    std::swap(known, next);
    has_begun = true;
    answer.passed = known.passed;
    answer.motion = known.setpoints();
    answer.on_polynomials = known.curved;
    answer.start = known.row(0);
    answer.time = known.time;
    const EdgeCertifier::Statistics spent = proof.statistics();
    answer.edges = spent.edges;
    answer.distance_queries = spent.distance_queries;
    answer.work = spent.work;
    return answer;
  }

  // ---------------------------------------------------------------------------------------------
  // Observations

  Observation observe(const std::string& object, const Obstacles::Sight& seen, double time,
                      const Obstacles::Bound& bound) {
    Obstacles& obstacles = proof.obstacles();
    Obstacles::requireBound(object, bound);
    const double last = obstacles.seenAt(object, seen);
    // A sight whose time was ahead of every answer's does not shut out those that follow.
    const bool replaces = time < last && has_begun && last > nextTime() + options.horizon;
    if (!std::isfinite(time) || !(time >= last || replaces)) return Observation::kLate;
    const double jump = obstacles.jump(object, seen, time);
    if (std::isnan(jump)) return Observation::kInvalid;
    const bool widens = replaces || obstacles.widens(object, seen, bound);
    try {
      obstacles.set(object, seen, time, bound);
    } catch (const std::invalid_argument&) {  // a coordinate that is too large
      return Observation::kInvalid;
    }
    std::erase(jumped, object);
    if (widens || jump > kGuardJump) {  // what has been proven was proven from what does not hold
      known_holds = false;
      proof.forget();
    }
    if (!(jump > kGuardJump)) return Observation::kTaken;
    jumped.push_back(object);
    return Observation::kJumped;
  }

  Problem problem;
  GuardOptions options;
  Commanded commanded;
  std::shared_ptr<const CompiledScene> scene;
  std::size_t size;
  SetpointProof proof;
  Brake brake;
  SetpointMotion known, next;  ///< of the last answer; of the one that is made
  bool has_begun = false;      ///< there was a call
  bool known_holds = false;    ///< `known` is proven, and the robot is on it
  /// No stop was found, or where the robot is, or how fast, was not readable; holds until a
  /// position is given.
  bool is_lost = false;
  std::vector<double> velocity, acceleration;
  std::vector<std::string> jumped;  ///< obstacles
  GuardAnswer answer;
};

Guard::Guard(const Problem& problem, const GuardOptions& options)
    : impl_(std::make_unique<Impl>(problem, options)) {}
Guard::~Guard() = default;
Guard::Guard(Guard&&) noexcept = default;
Guard& Guard::operator=(Guard&&) noexcept = default;

const GuardAnswer& Guard::check(const GuardRequest& request) noexcept {
  return impl_->check(request);
}

Observation Guard::setVertices(const std::string& object, std::span<const Eigen::Vector3d> vertices,
                               double time, double speed_bound) {
  return impl_->observe(object, vertices, time, {speed_bound});
}

Observation Guard::setPose(const std::string& object, const robots::Pose& X_WO, double time,
                           double speed_bound, double turn_bound) {
  return impl_->observe(object, X_WO, time, {speed_bound, turn_bound});
}

Observation Guard::setCloud(const std::string& object, std::shared_ptr<const PointCloud> cloud,
                            double time, double speed_bound,
                            const std::optional<robots::Pose>& X_WO) {
  return impl_->observe(object, Obstacles::CloudSight{std::move(cloud), X_WO}, time, {speed_bound});
}

void Guard::look(double time) {
  if (!std::isfinite(time))
    throw std::invalid_argument(
        fmt::format("Guard::look() at {} s; a finite time is expected", time));
  impl_->proof.look(time);
}

double Guard::nextTime() const { return impl_->nextTime(); }
bool Guard::takesTime(double time) const { return impl_->takesTime(time); }
const GuardOptions& Guard::options() const { return impl_->options; }
const std::shared_ptr<const CompiledScene>& Guard::scene() const { return impl_->scene; }
const GuardAnswer& Guard::answer() const { return impl_->answer; }

}  // namespace leeway::planner
