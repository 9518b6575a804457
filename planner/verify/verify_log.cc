// The log of an execution, proven from what it states and the problem. First the steps are compared
// with each other and with the problem: order, joints between them, limits, what was seen when.
// Then their motions are proven as one timed path.

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
      limits_.push_back(statedLimits(problem, variable).velocity);
    }
    for (const DeformingObstacle& obstacle : problem.world.deforming)
      motion_.bodies.emplace_back(obstacle, problem.execution);
    for (const Object& object : problem.world.objects)
      if (object.motion) motion_.bodies.emplace_back(object, problem.execution);
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
    if (const auto fault = findFault(problem_, space_, motion_.path, false)) {
      refuse(VerifyStatus::kRefuted, lineOfRow(fault->waypoint), fault->reason);
      return result_;
    }
    result_ = verifyTimed(problem_, motion_, options, wish);
    if (const int segment = std::exchange(result_.segment, -1); segment >= 0) {
      const double begin = motion_.times[at(segment)], end = motion_.times[at(segment) + 1];
      result_.line = lineOfRow(at(segment) + 1);
      result_.t0 = begin + result_.t0 * (end - begin);
      result_.t1 = begin + result_.t1 * (end - begin);
    }
    if (result_.status == VerifyStatus::kCertified && !log_.end) {
      const int line = log_.steps.back().line;
      refuse(
          VerifyStatus::kUndecided, line,
          "the log was cut behind this line: no line with a status follows; the steps up to here "
          "are proven");
    }
    return result_;
  }

 private:
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
  int lineOfRow(std::size_t row) const {
    return log_.steps[motion_.steps[row == 0 ? 0 : row - 1]].line;
  }

  /// Adds a step to the motion, if it follows the steps before. Returns false if it does not.
  bool take(const LoggedStep& step) {
    const std::size_t index = motion_.known.size();
    if (step.step != static_cast<std::int64_t>(index))
      return refute(step, fmt::format("step {} is where step {} is expected: lines are missing, or "
                                      "not in order",
                                      step.step, index));
    return joins(step) && keepsLimits(step) && observes(step) && saysWhatIs(step);
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

  /// ": NAME is VALUE, not OTHER" for the first joint that differs.
  std::string offText(const std::vector<double>& found, const std::vector<double>& expected) const {
    for (std::size_t i = 0; i < found.size(); ++i)
      if (found[i] != expected[i])
        return fmt::format(": {} is {}, not {}", motion_.path.names[i], numberText(found[i]),
                           numberText(expected[i]));
    return {};
  }

  /// Times do not decrease, and no joint is faster than its limit. Adds the rows.
  bool keepsLimits(const LoggedStep& step) {
    const std::size_t index = motion_.known.size();
    if (motion_.times.empty()) add(step.times.front(), step.rows.front());
    std::vector<double> dq(at(space_.size()));
    for (std::size_t i = 1; i < step.rows.size(); ++i) {
      const double duration = step.times[i] - step.times[i - 1];
      if (!(duration >= 0))
        return refute(step, fmt::format("its motion is at {} s after {} s; times that do not "
                                        "decrease are expected",
                                        step.times[i], step.times[i - 1]));
      space_.difference(step.rows[i - 1], step.rows[i], dq);
      for (const ConfigurationSpace::Part& part : space_.parts()) {
        const std::size_t k = at(part.first);
        const bool turns = part.kind == ConfigurationSpace::Kind::kRotation;
        const double change =
            turns ? std::sqrt(dq[k] * dq[k] + dq[k + 1] * dq[k + 1] + dq[k + 2] * dq[k + 2])
                  : std::abs(dq[k]);
        // Rounding of times and values.
        const double slack =
            kVerifyRounding * (1 + std::abs(step.rows[i][k])) +
            limits_[k] * 8 * std::numeric_limits<double>::epsilon() * std::abs(step.times[i]);
        if (!(change <= limits_[k] * duration * (1 + kVerifyWaypoint) + slack))
          return refute(step,
                        fmt::format("{} moves by {} in {} s; at most {} a second is its limit",
                                    motion_.path.names[k], change, duration, limits_[k]));
      }
      add(step.times[i], step.rows[i]);
      motion_.steps.push_back(index);
    }
    return true;
  }

  void add(double time, const std::vector<double>& row) {
    motion_.times.push_back(time);
    motion_.path.positions.push_back(row);
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
    return differs("certified", end.certified, count("unsafe") == 0) &&
           differs("duration", end.duration, last.times.back() - problem_.execution.start) &&
           differs("status: reached", end.status == "reached", last.reached) &&
           differs("status: unsafe", end.status == "unsafe", last.decision == "unsafe");
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
  std::vector<double> limits_;  ///< on velocity [rad/s or m/s]
  TimedPath motion_;
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
