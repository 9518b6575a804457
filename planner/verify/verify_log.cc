// The log of an execution, proven from what it states and the problem. First the steps are compared
// with each other and with the problem: order, joints between them, limits, what was seen when.
// Then their motions are proven as one timed path, and their stops as another.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "planner/base/tolerances.h"
#include "planner/validate/checks.h"
#include "planner/verify/log_read.h"
#include "planner/verify/pairs.h"
#include "planner/verify/path_check.h"
#include "planner/verify/timed_check.h"

namespace leeway::planner {
namespace verification {
namespace {

class LogVerifier {
 public:
  LogVerifier(const Problem& problem, const Log& log)
      : problem_(problem), log_(log), space_(problem.robot.model, problem.robot.variables) {
    for (const int v : problem.robot.variables) {
      const robots::Variable& variable = problem.robot.model->variables[at(v)];
      motion_.path.names.push_back(variable.name);
      limits_.push_back(statedLimits(problem, variable));
      double& acceleration = limits_.back().acceleration;
      if (!(acceleration < kInfinity))
        acceleration =
            problem.execution.acceleration_scale * limits_.back().velocity / kTimeToVelocityLimit;
    }
    stops_.path.names = motion_.path.names;
    for (TimedPath* motion : {&motion_, &stops_}) {
      for (const DeformingObstacle& obstacle : problem.world.deforming)
        motion->bodies.emplace_back(obstacle, problem.execution);
      for (const Object& object : problem.world.objects)
        if (object.motion) motion->bodies.emplace_back(object, problem.execution);
    }
    own_.resize(motion_.bodies.size());
    held_.resize(motion_.bodies.size());
  }

  VerifyResult run(const PlanOptions& options, const ClearanceWish& wish) {
    for (const LoggedStep& step : log_.steps)
      if (!take(step)) return result_;
    if (!checkEnd()) return result_;
    if (log_.steps.empty()) {
      const Pairs pairs = collectPairs(problem_, collectBodies(problem_));
      result_.unchecked = countUnchecked(pairs.unchecked);
      if (pairs.nothing_checked.empty())
        refuse(VerifyStatus::kUndecided, log_.end->line, "the log has no step: nothing is proven");
      else
        refuse(VerifyStatus::kNothingChecked, 0, pairs.nothing_checked);
      return result_;
    }
    result_ = proven(motion_, options, wish);
    if (result_.status == VerifyStatus::kCertified && !stops_.times.empty()) {
      stops_.known = std::move(motion_.known);
      VerifyResult stops = proven(stops_, options, {});
      if (stops.status != VerifyStatus::kCertified) {
        stops.reason = "in its stop: " + stops.reason;
        stops.unchecked = result_.unchecked;
        result_ = std::move(stops);
      }
    }
    if (result_.status == VerifyStatus::kCertified && exposed_ != nullptr) {
      refuse(VerifyStatus::kExposed, exposed_->line,
             "the robot stands where an obstacle that moves may reach it, or comes to rest there; "
             "all else is proven");
      result_.t0 = exposed_->times.front();
      result_.t1 = exposed_->times.back();
      result_.clearance_lower = 0;  // pairs were left out
    }
    if (isProven() && !log_.end) {
      const int line = log_.steps.back().line;
      refuse(
          VerifyStatus::kUndecided, line,
          "the log was cut behind this line: no line with a status follows; the steps up to here "
          "are proven");
    }
    return result_;
  }

 private:
  bool isProven() const {
    return result_.status == VerifyStatus::kCertified || result_.status == VerifyStatus::kExposed;
  }

  VerifyResult proven(TimedPath& motion, const PlanOptions& options, const ClearanceWish& wish) {
    VerifyResult result;
    if (const auto fault = findFault(problem_, space_, motion.path, false)) {
      result.status = VerifyStatus::kRefuted;
      result.line = lineOfRow(motion, fault->waypoint);
      result.reason = fault->reason;
      return result;
    }
    result = verifyTimed(problem_, motion, options, wish);
    if (const int segment = std::exchange(result.segment, -1); segment >= 0) {
      const double begin = motion.times[at(segment)], end = motion.times[at(segment) + 1];
      result.line = lineOfRow(motion, at(segment) + 1);
      result.t0 = begin + result.t0 * (end - begin);
      result.t1 = begin + result.t1 * (end - begin);
    }
    return result;
  }

  /// Sets the result. Returns false.
  bool refuse(VerifyStatus status, int line, const std::string& reason) {
    result_.status = status;
    result_.line = line;
    result_.reason = reason;
    return false;
  }
  bool refute(const LoggedStep& step, const std::string& reason) {
    result_.t0 = result_.t1 = step.time;
    return refuse(VerifyStatus::kRefuted, step.line, reason);
  }

  /// The line of the step that ends at a row, or has it within.
  int lineOfRow(const TimedPath& motion, std::size_t row) const {
    const std::size_t edge = row == 0 || motion.steps[row - 1] == kGap ? row : row - 1;
    return log_.steps[motion.steps[edge]].line;
  }

  /// Adds a step to the motion, if it follows the steps before. Returns false if it does not.
  bool take(const LoggedStep& step) {
    const std::size_t index = motion_.known.size();
    if (step.step != static_cast<std::int64_t>(index))
      return refute(step, fmt::format("step {} is where step {} is expected: lines are missing, or "
                                      "not in order",
                                      step.step, index));
    return joins(step) && (!step.exposed || goesOnAsKept(step)) && keepsLimits(step) &&
           observes(step) && (step.keeps_stop ? keepsStop(step) : stops(step)) && saysWhatIs(step);
  }

  /// The motion of a step begins where and when that of the step before ended.
  bool joins(const LoggedStep& step) {
    const bool is_first = motion_.times.empty();
    const double before = is_first ? problem_.execution.start : motion_.times.back();
    if (step.times.front() != before)
      return refute(
          step, fmt::format("its motion begins at {} s; {} at {} s", step.times.front(),
                            is_first ? "the execution begins" : "the step before ends", before));
    if (is_first) {
      Path start;
      start.names = motion_.path.names;
      start.positions = {step.rows.front()};
      if (const auto fault = findFault(problem_, space_, start, false))
        return refute(step, fault->reason);
    }
    if (step.time != before)
      return refute(step,
                    fmt::format("its time is {} s; its motion begins at {} s", step.time, before));
    if (step.measured && is_first && *step.measured != step.rows.front())
      return refute(step, fmt::format("the robot was measured elsewhere than its motion begins{}",
                                      offText(*step.measured, step.rows.front())));
    if (step.measured && !is_first && *step.measured != motion_.path.positions.back())
      return refuse(VerifyStatus::kUndecided, step.line,
                    fmt::format("the robot was measured off its motion{}: where it was before is "
                                "not known",
                                offText(*step.measured, motion_.path.positions.back())));
    if (!is_first && step.rows.front() != motion_.path.positions.back())
      return refute(step, fmt::format("its motion does not begin where the step before ends{}",
                                      offText(step.rows.front(), motion_.path.positions.back())));
    if (step.position != step.rows.back())
      return refute(step, fmt::format("position is not where its motion ends{}",
                                      offText(step.position, step.rows.back())));
    return true;
  }

  /// An exposed step does what was left to do: it goes through the stop of the step before, and
  /// stands behind it.
  bool goesOnAsKept(const LoggedStep& step) {
    for (std::size_t i = 1; i < step.rows.size(); ++i) {
      const bool stands = kept_.size() < i;
      const std::vector<double>& expected = stands ? step.rows[i - 1] : kept_.row(i - 1);
      if (step.rows[i] != expected)
        return refute(step,
                      fmt::format("exposed is true, and its motion is not what the stop of the "
                                  "step before leaves{}",
                                  offText(step.rows[i], expected)));
      if (!stands && step.times[i] != kept_.time(i - 1))
        return refute(step,
                      fmt::format("exposed is true, and its motion is at {} s where the stop of "
                                  "the step before is at {} s",
                                  numberText(step.times[i]), numberText(kept_.time(i - 1))));
    }
    if (exposed_ == nullptr) exposed_ = &step;
    return true;
  }

  /// ": NAME is VALUE, not OTHER" for the first joint that differs.
  std::string offText(const std::vector<double>& found, const std::vector<double>& expected) const {
    for (std::size_t i = 0; i < found.size(); ++i)
      if (found[i] != expected[i])
        return fmt::format(": {} is {}, not {}", motion_.path.names[i], numberText(found[i]),
                           numberText(expected[i]));
    return {};
  }

  /// How the joints move when they come to a row.
  struct Moving {
    double time = 0, span = kInfinity;  ///< [s] of the row, and of the edge before it
    std::vector<double> row, velocity, acceleration;
  };

  /// Goes on to the next row, if times do not decrease and the limits are kept: velocity is that of
  /// the edge, acceleration its change over the shorter one of two edges, jerk that of
  /// acceleration.
  bool goOn(const LoggedStep& step, Moving& at_row, double time, const std::vector<double>& row,
            const char* where = "") {
    const double duration = time - at_row.time;
    if (!(duration >= 0))
      return refute(step, fmt::format("{}its motion is at {} s after {} s; times that do not "
                                      "decrease are expected",
                                      where, time, at_row.time));
    Moving next{time, duration, row, std::vector<double>(at(space_.size())), {}};
    space_.difference(at_row.row, row, next.velocity);
    const double span = std::min(duration, at_row.span);
    next.acceleration.resize(next.velocity.size());
    const auto size = [&](const std::vector<double>& v, const ConfigurationSpace::Part& part) {
      const std::size_t i = at(part.first);
      return part.kind == ConfigurationSpace::Kind::kRotation
                 ? std::sqrt(v[i] * v[i] + v[i + 1] * v[i + 1] + v[i + 2] * v[i + 2])
                 : std::abs(v[i]);
    };
    // Bounds the rounding of a value, and of a time at the greatest speed.
    const double of_time =
        kLogTimeDigits * std::max(std::abs(time), std::abs(problem_.execution.start));
    const auto roundingOf = [&](std::size_t k) {
      return kLogPlaceDigits * (1 + std::abs(row[k])) + limits_[k].velocity * of_time;
    };
    for (const ConfigurationSpace::Part& part : space_.parts()) {
      const std::size_t k = at(part.first);
      const double change = size(next.velocity, part), limit = limits_[k].velocity;
      if (!(change <= limit * duration * (1 + kVerifyWaypoint) + 2 * roundingOf(k)))
        return refute(
            step, fmt::format("{}{} moves by {} in {} s; at most {} a second is its limit", where,
                              motion_.path.names[k], change, duration, limit));
    }
    if (duration == 0) return true;  // nothing moved
    for (std::size_t i = 0; i < next.velocity.size(); ++i) {
      next.velocity[i] /= duration;
      next.acceleration[i] = (next.velocity[i] - at_row.velocity[i]) / span;
    }
    for (const ConfigurationSpace::Part& part : space_.parts()) {
      const std::size_t k = at(part.first);
      std::vector<double> jerk = next.acceleration;
      for (std::size_t i = 0; i < jerk.size(); ++i)
        jerk[i] = (jerk[i] - at_row.acceleration[i]) / span;
      const auto exceeds = [&](const char* what, double value, double limit, double rounding) {
        const double most = limit * (1 + kVerifyRowLimit);
        if (value + rounding <= most) return false;
        if (value - rounding <= most) {
          if (rounding <= limit * kLogLimitShare) return false;
          refuse(VerifyStatus::kUndecided, step.line,
                 fmt::format("{}{}'s {} cannot be told: rows are {:.3g} s apart at {:.6g} s, and "
                             "numbers are rounded",
                             where, motion_.path.names[k], what, span, time));
          return true;
        }
        refute(step, fmt::format("{}{}'s {} is {:.6g} at {:.6g} s; its limit is {:.6g}", where,
                                 motion_.path.names[k], what, value, time, limit));
        return true;
      };
      const double rounding = 4 * roundingOf(k) / (span * span);
      if (exceeds("acceleration", size(next.acceleration, part), limits_[k].acceleration,
                  rounding) ||
          (limits_[k].jerk < kInfinity &&
           exceeds("jerk", size(jerk, part), limits_[k].jerk, 2 * rounding / span)))
        return false;
    }
    at_row = std::move(next);
    return true;
  }

  /// The motion keeps the limits. Adds its rows.
  bool keepsLimits(const LoggedStep& step) {
    const std::size_t index = motion_.known.size();
    if (motion_.times.empty()) {
      const std::vector<double> rest(at(space_.size()));
      moving_ = {step.times.front(), kInfinity, step.rows.front(), rest, rest};
      add(motion_, step.times.front(), step.rows.front());
    }
    for (std::size_t i = 1; i < step.rows.size(); ++i) {
      if (!goOn(step, moving_, step.times[i], step.rows[i])) return false;
      if (step.exposed && step.rows[i] == step.rows[i - 1])
        motion_.exposed.push_back(motion_.steps.size());
      add(motion_, step.times[i], step.rows[i]);
      motion_.steps.push_back(index);
    }
    return true;
  }

  /// The step's motion and stop are the stop of the step before, which keeps the limits. The stop
  /// is proven again unless the step knows the same of all obstacles.
  bool keepsStop(const LoggedStep& step) {
    bool is_kept = kept_.size() >= step.rows.size();
    for (std::size_t i = 1; is_kept && i < step.rows.size(); ++i)
      is_kept = kept_.row(i - 1) == step.rows[i] && kept_.time(i - 1) == step.times[i];
    if (!is_kept)
      return refute(step,
                    "its stop is null: it is what the motion leaves of the stop before; the "
                    "motion is not the beginning of that");
    kept_.begin += step.rows.size() - 1;
    const std::vector<Sighting>& known = motion_.known.back();
    if (!step.observed.empty() || std::any_of(known.begin(), known.end(), [](const Sighting& s) {
          return s.kind == Sighting::Kind::kLooked;
        }))
      addStop();
    return true;
  }

  /// Adds the rest of the present stop to what is proven, with the knowledge of the present step.
  void addStop() {
    if (kept_.size() == 0) return;
    if (stops_.times.empty()) add(stops_, motion_.times.front(), motion_.path.positions.front());
    stops_.steps.push_back(kGap);
    add(stops_, moving_.time, moving_.row);
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      add(stops_, kept_.time(i), kept_.row(i));
      stops_.steps.push_back(motion_.known.size() - 1);
    }
  }

  /// The stop brings the robot to rest within the limits; without one it rests. Adds its rows.
  bool stops(const LoggedStep& step) {
    constexpr const char* kWhere = "in its stop: ";
    Moving moving = moving_;
    for (std::size_t i = 0; i < step.stop_rows.size(); ++i)
      if (!goOn(step, moving, step.stop_times[i], step.stop_rows[i], kWhere)) return false;
    kept_ = {&step, 0};
    addStop();
    const double span = moving.span;
    for (int k = 0; k < 2 && span < kInfinity; ++k)
      if (!goOn(step, moving, moving.time + span, std::vector<double>(moving.row), kWhere))
        return false;
    return true;
  }

  static void add(TimedPath& motion, double time, const std::vector<double>& row) {
    motion.times.push_back(time);
    motion.path.positions.push_back(row);
  }

  /// Takes what was observed before the step. Refuses sights that contradict others, or the
  /// knowledge on which steps relied.
  bool observes(const LoggedStep& step) {
    std::vector<Sighting> known;
    for (std::size_t m = 0; m < own_.size(); ++m) {
      known.push_back(own_[m] ? *own_[m] : motion_.bodies[m].lookedAt(step.time));
      if (!held_[m].empty()) held_[m].back().until = step.time;
    }
    for (const LoggedSight& sight : step.observed) {
      std::size_t m = 0;
      while (motion_.bodies[m].name() != sight.object) ++m;
      if (!(sight.time <= step.time))
        return refute(step, fmt::format("'{}' was seen at {} s, later than the step's {} s",
                                        sight.object, sight.time, step.time));
      if (sight.cloud && known[m].kind == Sighting::Kind::kSeen && sight.time < known[m].time)
        return refute(step, fmt::format("a cloud of '{}' was seen at {} s, before the one of {} s",
                                        sight.object, sight.time, known[m].time));
      Sighting now;
      now.kind = Sighting::Kind::kSeen;
      now.time = sight.time;
      now.X_WO = sight.X_WO;
      now.cloud = sight.cloud ? sight.cloud : known[m].cloud;
      if (!sight.is_rigid)
        now.vertices = std::make_shared<const std::vector<Eigen::Vector3d>>(sight.vertices);
      now.speed = sight.speed_bound;
      now.turning = sight.turn_bound;
      if (const std::string fault = motion_.bodies[m].carvedElsewhere(now); !fault.empty())
        return refute(step, fmt::format("'{}' {}", sight.object, fault));
      if (!agrees(step, m, now)) return false;
      held_[m].push_back({step.line, step.time, step.time, now});
      own_[m] = known[m] = std::move(now);
    }
    for (std::size_t m = 0; m < known.size(); ++m) {
      const bool is_same = !held_[m].empty() && known[m].kind == held_[m].back().known.kind &&
                           known[m].kind != Sighting::Kind::kLooked;
      if (!is_same) held_[m].push_back({step.line, step.time, step.time, known[m]});
    }
    motion_.known.push_back(std::move(known));
    return saysWhatWasSeen(step);
  }

  /// Whether a sight agrees with all that was held of its obstacle at its time and later.
  bool agrees(const LoggedStep& step, std::size_t m, const Sighting& now) {
    MovingBody& body = motion_.bodies[m];
    for (auto held = held_[m].rbegin(); held != held_[m].rend() && held->until >= now.time;
         ++held) {
      std::string off = body.departure(held->known, now);
      if (held->known.kind == Sighting::Kind::kFollows)
        for (const double time : {std::max(held->from, now.time), held->until})
          if (off.empty()) off = body.departureOfMotion(now, time);
      if (!off.empty())
        return refute(step,
                      fmt::format("'{}' {}{}", body.name(), off,
                                  held->line == step.line
                                      ? ", in the same line"
                                      : fmt::format(", on which line {} relied", held->line)));
    }
    return true;
  }

  /// The step lists each obstacle, with the time at which it was seen.
  bool saysWhatWasSeen(const LoggedStep& step) {
    const std::vector<Sighting>& known = motion_.known.back();
    if (step.obstacles.size() != known.size())
      return refute(step, fmt::format("it lists {} obstacles; the problem has {} that move",
                                      step.obstacles.size(), known.size()));
    for (std::size_t m = 0; m < known.size(); ++m) {
      const LoggedObstacle& said = step.obstacles[m];
      const bool follows = known[m].kind == Sighting::Kind::kFollows;
      const double seen = known[m].kind == Sighting::Kind::kSeen ? known[m].time : step.time;
      if (said.name != motion_.bodies[m].name())
        return refute(step, fmt::format("obstacles[{}] is '{}'; the problem's is '{}'", m,
                                        said.name, motion_.bodies[m].name()));
      if (said.seen != seen)
        return refute(step,
                      fmt::format("'{}' was seen at {} s by the step, and at {} s by what the "
                                  "log observes",
                                  said.name, numberText(said.seen), numberText(seen)));
      if (said.predicted != follows)
        return refute(
            step, fmt::format("'{}' is {}predicted by the step; by what is known it {}", said.name,
                              said.predicted ? "" : "not ", follows ? "is" : "is not"));
    }
    return true;
  }

  /// Compares the decision of a step with its certificate, and its end with the goals.
  bool saysWhatIs(const LoggedStep& step) {
    if (step.certified == (step.decision == "unsafe"))
      return refute(step, fmt::format("certified is {} with the decision '{}'", step.certified,
                                      step.decision));
    if (step.exposed && step.certified) return refute(step, "exposed is true, and so is certified");
    if (step.exposed && own_.empty()) return refute(step, "exposed is true, and no obstacle moves");
    if (step.reached && !isInGoal(problem_, space_, step.rows.back()))
      return refute(step, "reached is true, and its motion ends in none of the problem's goals");
    return true;
  }

  /// Compares the last line with the steps.
  bool checkEnd() {
    if (!log_.end) return true;
    const LoggedEnd& end = *log_.end;
    const auto differs = [&](const char* key, const auto& said, const auto& found) {
      if (said == found) return true;
      return refuse(VerifyStatus::kRefuted, end.line,
                    fmt::format("{} is {}; by the lines before it is {}", key, said, found));
    };
    const auto count = [&](const char* decision) {
      return static_cast<std::int64_t>(
          std::count_if(log_.steps.begin(), log_.steps.end(),
                        [&](const LoggedStep& step) { return step.decision == decision; }));
    };
    if (!differs("steps", end.steps, static_cast<std::int64_t>(log_.steps.size())) ||
        !differs("plans", end.plans, count("plan")) ||
        !differs("follows", end.follows, count("follow")) ||
        !differs("evasions", end.evasions, count("evade")) ||
        !differs("waits", end.waits, count("wait") + count("unsafe")))
      return false;
    if (log_.steps.empty()) return true;
    const LoggedStep& last = log_.steps.back();
    return differs("status: exposed", end.status == "exposed", last.exposed) &&
           differs("certified", end.certified, count("unsafe") == 0) &&
           differs("duration", end.duration, last.times.back() - problem_.execution.start) &&
           differs("status: reached", end.status == "reached", last.reached && last.certified) &&
           differs("status: unsafe", end.status == "unsafe",
                   last.decision == "unsafe" && !last.exposed);
  }

  /// Knowledge of an obstacle, and when it was held: while steps relied on it, or at the time of a
  /// line in which another sight follows.
  struct Held {
    int line;            ///< of the first step
    double from, until;  ///< [s]
    Sighting known;
  };

  const Problem& problem_;
  const Log& log_;
  ConfigurationSpace space_;
  std::vector<StatedLimits> limits_;  ///< with the default acceleration
  TimedPath motion_, stops_;
  /// The present stop: the rows of a step from one on.
  struct Kept {
    const LoggedStep* step = nullptr;
    std::size_t begin = 0;
    std::size_t size() const { return step == nullptr ? 0 : step->stop_rows.size() - begin; }
    const std::vector<double>& row(std::size_t i) const { return step->stop_rows[begin + i]; }
    double time(std::size_t i) const { return step->stop_times[begin + i]; }
  };
  Kept kept_;
  const LoggedStep* exposed_ = nullptr;       ///< the first such step
  Moving moving_;                             ///< at the end of motion_
  std::vector<std::optional<Sighting>> own_;  ///< what the program has seen of each body
  std::vector<std::vector<Held>> held_;       ///< by obstacle, in the order of the steps
  VerifyResult result_;
};

}  // namespace
}  // namespace verification

VerifyResult verifyLog(const Problem& problem, const std::string& file, const PlanOptions& options,
                       const std::function<bool(const Interval&)>& is_enough) {
  validate(problem);
  requireGoals(problem, "verifyLog()");
  if (isConstrained(problem))
    throw robots::InputError(problem.name, 0,
                             "there are constraints or a condition, which no log has; none are "
                             "expected");
  const verification::Log log = verification::readLog(file, problem);
  return verification::LogVerifier(problem, log).run(options, {is_enough});
}

}  // namespace leeway::planner
