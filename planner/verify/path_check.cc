#include "planner/verify/path_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <utility>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"
#include "planner/verify/kinematics.h"
#include "planner/verify/pose_check.h"

namespace leeway::planner::verification {
namespace {

class PathCheck {
 public:
  PathCheck(const Problem& problem, const ConfigurationSpace& space, const Path& path,
            bool ends_in_goal)
      : problem_(problem), space_(space), path_(path), ends_in_goal_(ends_in_goal) {}

  std::optional<PathFault> run() const {
    std::size_t waypoint = 0;
    std::string reason = fault(waypoint);
    if (reason.empty()) return std::nullopt;
    return PathFault{waypoint, std::move(reason)};
  }

  bool isInGoal(const std::vector<double>& q) const {
    return std::any_of(problem_.goals.begin(), problem_.goals.end(),
                       [&](const Goal& goal) { return meets(goal, q); });
  }

 private:
  /// Returns the first fault, or an empty text. Sets `waypoint`.
  std::string fault(std::size_t& waypoint) const {
    if (path_.positions.empty()) return "the path has no waypoints";
    if (path_.names.size() != problem_.robot.variables.size()) return columns();
    for (std::size_t i = 0; i < path_.names.size(); ++i)
      if (path_.names[i] != variable(i).name) return columns();
    for (; waypoint < path_.positions.size(); ++waypoint)
      if (const std::string reason = outside(path_.positions[waypoint]); !reason.empty())
        return reason;
    if (const std::string reason = notCubic(waypoint); !reason.empty()) return reason;
    waypoint = 0;
    if (const std::string reason = notStart(path_.positions.front()); !reason.empty())
      return reason;
    waypoint = path_.positions.size() - 1;
    if (!ends_in_goal_ || isInGoal(path_.positions.back())) return {};
    return "the last waypoint is in none of the problem's goals";
  }

  const robots::Variable& variable(std::size_t i) const {
    return problem_.robot.model->variables[at(problem_.robot.variables[i])];
  }

  std::string columns() const {
    return "the path's columns are not the problem's planned variables";
  }

  std::string outside(const std::vector<double>& q) const {
    if (q.size() != path_.names.size())
      return "the waypoint has " + std::to_string(q.size()) + " values, " +
             std::to_string(path_.names.size()) + " are planned";
    for (std::size_t i = 0; i < q.size(); ++i) {
      const robots::Variable& v = variable(i);
      if (!std::isfinite(q[i])) return v.name + " is not finite";
      if (q[i] < v.lower - kVerifyWaypoint || q[i] > v.upper + kVerifyWaypoint)
        return v.name + " is " + numberText(q[i]) + ", outside its limits " + numberText(v.lower) +
               " to " + numberText(v.upper);
    }
    for (const ConfigurationSpace::Part& part : space_.parts()) {
      const double* x = &q[at(part.first)];
      if (part.kind == ConfigurationSpace::Kind::kRotation) {
        const double norm = std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3]);
        if (!(std::abs(norm - 1) <= kUnitQuaternion))
          return "the quaternion at " + variable(at(part.first)).name + " has length " +
                 numberText(norm) + ", not 1";
      }
    }
    return {};
  }

  /// Returns the fault of times and velocities, or of cubics between rows. Sets `waypoint`.
  std::string notCubic(std::size_t& waypoint) const {
    const std::size_t rows = path_.positions.size();
    waypoint = 0;
    if (path_.times.empty() && path_.velocities.empty()) return {};
    if (path_.times.size() != rows || path_.velocities.size() != rows)
      return "the path has " + std::to_string(path_.times.size()) + " times and " +
             std::to_string(path_.velocities.size()) + " velocities for its " +
             std::to_string(rows) + " rows";
    for (; waypoint < rows; ++waypoint) {
      const std::vector<double>& velocity = path_.velocities[waypoint];
      if (velocity.size() != path_.names.size() || !std::isfinite(path_.times[waypoint]) ||
          !std::all_of(velocity.begin(), velocity.end(), [](double v) { return std::isfinite(v); }))
        return "the row's time or velocity is not finite, or a velocity is missing";
      if (waypoint > 0 && !(path_.times[waypoint] > path_.times[waypoint - 1]))
        return "the row's time is not after that of the row before";
    }
    for (waypoint = 0; waypoint + 1 < rows; ++waypoint) {
      const std::vector<Cubic> cubics = cubicsOf(path_, waypoint);
      for (std::size_t i = 0; i < cubics.size(); ++i) {
        const robots::Variable& v = variable(i);
        const double beyond =
            cubics[i].most() > v.upper + kVerifyWaypoint ? cubics[i].most() : cubics[i].least();
        if (beyond > v.upper + kVerifyWaypoint || beyond < v.lower - kVerifyWaypoint)
          return v.name + " reaches " + numberText(beyond) + " after the row, outside its limits " +
                 numberText(v.lower) + " to " + numberText(v.upper);
      }
    }
    for (std::size_t i = 0; i < path_.names.size(); ++i)
      if (const std::string reason = tooFast(i, waypoint); !reason.empty()) return reason;
    return {};
  }

  /// Returns how the cubics of one variable exceed its limits, or do not begin and end at rest.
  /// Sets `waypoint`.
  std::string tooFast(std::size_t i, std::size_t& waypoint) const {
    const StatedLimits limits = statedLimits(problem_, variable(i));
    const std::string& name = path_.names[i];
    const auto exceeds = [&](const char* what, double value, double limit) {
      return fmt::format("{}'s {} after the row reaches {:.6g}, over its limit of {:.6g}", name,
                         what, value, limit);
    };
    const auto jumps = [&](double from, double to) {
      return fmt::format(
          "{}'s acceleration jumps at the row, from {:.6g} to {:.6g}, although its "
          "jerk is limited",
          name, from, to);
    };
    double before = 0;  // the acceleration at the end of the cubic before; at first, at rest
    double slack_before = 0, farthest = 0;
    for (const std::vector<double>& row : path_.positions)
      farthest = std::max(farthest, std::abs(row[i]));
    for (waypoint = 0; waypoint + 1 < path_.positions.size(); ++waypoint) {
      const double duration = path_.times[waypoint + 1] - path_.times[waypoint];
      const auto hidden = [&](const char* what) {
        return fmt::format(
            "{}'s {} after the row cannot be told: the next row is {:.3g} s later, at "
            "{:.6g} s, and numbers are rounded; rows at least {:g} s apart are expected",
            name, what, duration, path_.times[waypoint + 1], kLeastRow);
      };
      if (duration < kLeastRow / 2) return hidden("acceleration");
      const Cubic cubic = cubicsOf(path_, waypoint)[i];
      // Rounding of positions and times, which derivatives enlarge.
      const double rounding =
          kVerifyDigits *
          (farthest + cubic.speed() * (1 + std::abs(path_.times[waypoint + 1]) / duration));
      const auto within = [&](double value, double limit, double off) {
        return std::abs(value) <= limit * (1 + kVerifyLimit) + off;
      };
      const double square = duration * duration;
      const double slack = rounding / square;
      const double slack_of_jerk = kVerifyJerkDigits * slack / duration;
      if (rounding / duration > limits.velocity / 2) return hidden("velocity");
      if (slack > std::max(limits.acceleration / 2, kVerifyLeastAcceleration))
        return hidden("acceleration");
      if (slack_of_jerk > std::max(limits.jerk / 2, kVerifyLeastJerk)) return hidden("jerk");
      // No more than what times in whole nanoseconds make of a limited jerk.
      const auto within_jump = [&](double change, double off) {
        return std::abs(change) <=
               kVerifyLimit * std::min(limits.acceleration, limits.jerk * duration) + 2 * off;
      };
      if (const double v = cubic.speed() / duration;
          !within(v, limits.velocity, rounding / duration))
        return exceeds("velocity", v, limits.velocity);
      const double first = cubic.acceleration(0) / square, last = cubic.acceleration(1) / square;
      for (const double a : {first, last})
        if (!within(a, limits.acceleration, slack))
          return exceeds("acceleration", a, limits.acceleration);
      if (limits.jerk < kInfinity) {
        const double j = cubic.jerk() / (square * duration);
        if (!within(j, limits.jerk, slack_of_jerk)) return exceeds("jerk", j, limits.jerk);
        if (!within_jump(first - before, slack_before + slack)) return jumps(before, first);
        if (waypoint + 2 == path_.positions.size() && !within_jump(last, slack)) {
          ++waypoint;
          return jumps(last, 0);
        }
      }
      before = last;
      slack_before = slack;
    }
    for (waypoint = 0;; waypoint = path_.positions.size() - 1) {
      const double velocity = path_.velocities[waypoint][i];
      if (!(std::abs(velocity) <= kVerifyLimit * kVerifyLimit * limits.velocity))
        return fmt::format("{} moves at {:.6g} in the {} row; rest is expected", name, velocity,
                           waypoint == 0 ? "first" : "last");
      if (waypoint + 1 == path_.positions.size()) return {};
    }
  }

  static double angleBetween(double a, double b) {
    return std::remainder(a - b, 2 * std::numbers::pi);
  }

  /// The angle between two orientations [rad]. Accurate for small angles only.
  static double turnBetween(const double* a, const double* b) {
    double minus = 0, plus = 0;
    for (int k = 0; k < 4; ++k) {
      minus += (a[k] - b[k]) * (a[k] - b[k]);
      plus += (a[k] + b[k]) * (a[k] + b[k]);
    }
    return 2 * std::sqrt(std::min(minus, plus));
  }

  std::string notStart(const std::vector<double>& q) const {
    std::vector<double> start;
    for (const int v : problem_.robot.variables) start.push_back(problem_.start[at(v)]);
    for (const ConfigurationSpace::Part& part : space_.parts()) {
      const std::size_t i = at(part.first);
      const bool angle = part.kind == ConfigurationSpace::Kind::kCircle;
      const double apart = part.kind == ConfigurationSpace::Kind::kRotation
                               ? turnBetween(&q[i], &start[i])
                           : angle ? std::abs(angleBetween(q[i], start[i]))
                                   : std::abs(q[i] - start[i]);
      if (!(apart <= kVerifyWaypoint))
        return "the first waypoint is not the start: " + variable(i).name + " is " +
               numberText(q[i]) + ", the start's " + numberText(start[i]);
    }
    return {};
  }

  bool meets(const Goal& goal, const std::vector<double>& q) const {
    if (!goal.poses.empty()) {
      std::vector<double> configuration = problem_.start;
      for (std::size_t i = 0; i < q.size(); ++i)
        configuration[at(problem_.robot.variables[i])] = q[i];
      const std::vector<robots::Pose> X_WL = placeLinks(*problem_.robot.model, configuration);
      return std::all_of(
          goal.poses.begin(), goal.poses.end(),
          [&](const robots::PoseRegion& region) { return isInRegion(region, X_WL); });
    }
    if (goal.ranges.size() != q.size()) return false;
    for (const ConfigurationSpace::Part& part : space_.parts()) {
      const std::size_t i = at(part.first);
      if (part.kind == ConfigurationSpace::Kind::kRotation) {
        if (!orientationMeets(goal, q, i)) return false;
        continue;
      }
      const auto& [low, high] = goal.ranges[i];
      if (part.kind != ConfigurationSpace::Kind::kCircle) {
        if (!(q[i] >= low - kVerifyWaypoint && q[i] <= high + kVerifyWaypoint)) return false;
        continue;
      }
      // An angle may differ from the written range by whole turns.
      const double middle = low / 2 + high / 2, half = high / 2 - low / 2;
      if (half < std::numbers::pi &&
          !(std::abs(angleBetween(q[i], middle)) <= half + kVerifyWaypoint))
        return false;
    }
    return true;
  }

  /// The orientation of a goal is one quaternion, or it is free, which is four times [-1, 1].
  static bool orientationMeets(const Goal& goal, const std::vector<double>& q, std::size_t i) {
    double given[4];
    bool free = true;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto& [low, high] = goal.ranges[i + k];
      free = free && low <= -1 && high >= 1;
      given[k] = low;
    }
    return free || turnBetween(&q[i], given) <= kVerifyWaypoint;
  }

  const Problem& problem_;
  const ConfigurationSpace& space_;
  const Path& path_;
  bool ends_in_goal_;
};

}  // namespace

Cubic::Cubic(double q0, double q1, double v0, double v1)
    : q0_(q0),
      q1_(q1),
      c1_(v0),
      c2_(3 * (q1 - q0) - 2 * v0 - v1),
      c3_(v0 + v1 - 2 * (q1 - q0)),
      least_(std::min(q0, q1)),
      most_(std::max(q0, q1)),
      speed_(std::max(std::abs(v0), std::abs(v1))) {
  // The derivative is extreme where the second one vanishes.
  const double middle = c3_ != 0 ? -c2_ / (3 * c3_) : 0;
  if (middle > 0 && middle < 1) speed_ = std::max(speed_, std::abs(velocity(middle)));
  // Rounding of the slopes, of which sums of three terms may cancel.
  speed_ += kVerifyRounding * (std::abs(c1_) + std::abs(c2_) + std::abs(c3_));
  // The cubic is extreme where the derivative vanishes: twice at most.
  const double root = c2_ * c2_ - 3 * c3_ * c1_;
  if (!(root >= 0)) return;
  const double sum = -c2_ - std::copysign(std::sqrt(root), c2_);
  for (const double t : {sum / (3 * c3_), c1_ / sum}) {
    if (!(t > 0 && t < 1)) continue;
    least_ = std::min(least_, at(t));
    most_ = std::max(most_, at(t));
  }
}

double Cubic::at(double t) const {
  if (t == 1) return q1_;
  return q0_ + t * (c1_ + t * (c2_ + t * c3_));
}

bool Cubic::isShort() const {
  return std::abs(c1_) <= kVerifyCubic && std::abs(c2_) <= kVerifyCubic &&
         std::abs(c3_) <= kVerifyCubic;
}

StatedLimits statedLimits(const Problem& problem, const robots::Variable& variable) {
  const Execution& execution = problem.execution;
  const auto stated = [&](const std::map<std::string, double>& given, double own,
                          double otherwise) {
    const auto found = given.find(variable.name);
    if (found != given.end()) return found->second;
    return own > 0 && own <= kMostLimit ? own : otherwise;
  };
  return {execution.speed * stated(execution.velocities, variable.velocity, kDefaultVelocity),
          execution.acceleration_scale *
              stated(execution.accelerations, variable.acceleration, kInfinity),
          execution.jerk_scale * stated(execution.jerks, variable.jerk, kInfinity)};
}

std::vector<Cubic> cubicsOf(const Path& path, std::size_t segment) {
  const double duration = path.times[segment + 1] - path.times[segment];
  std::vector<Cubic> cubics;
  for (std::size_t i = 0; i < path.names.size(); ++i)
    cubics.emplace_back(path.positions[segment][i], path.positions[segment + 1][i],
                        path.velocities[segment][i] * duration,
                        path.velocities[segment + 1][i] * duration);
  return cubics;
}

std::optional<PathFault> findFault(const Problem& problem, const ConfigurationSpace& space,
                                   const Path& path, bool ends_in_goal) {
  return PathCheck(problem, space, path, ends_in_goal).run();
}

bool isInGoal(const Problem& problem, const ConfigurationSpace& space,
              const std::vector<double>& q) {
  return PathCheck(problem, space, {}, false).isInGoal(q);
}

std::optional<VerifyResult> findUnaccepted(const Problem& problem, const ConfigurationSpace& space,
                                           const Path& path) {
  const Condition& condition = problem.condition;
  if (!condition.accept) return std::nullopt;
  const std::size_t edges = std::max<std::size_t>(1, path.positions.size() - 1);
  std::vector<double> state(at(space.size()));
  for (std::size_t i = 0; i < edges; ++i) {
    const std::vector<double>& a = path.positions[i];
    const std::vector<double>& b = path.positions[std::min(i + 1, path.positions.size() - 1)];
    // A line of more than half a turn is several edges of one length.
    const int lines = space.edgesAlongLine(a, b);
    space.alongLine(a, b, 1.0 / lines, state);
    const double parts = std::ceil(lines * space.greatestChange(a, state) / condition.resolution);
    for (double k = 0; k <= parts; ++k) {
      const double t = parts > 0 ? k / parts : 0;
      space.alongLine(a, b, t, state);
      for (const ConfigurationSpace::Part& part : space.parts())
        if (part.kind == ConfigurationSpace::Kind::kCircle)
          state[at(part.first)] = std::remainder(state[at(part.first)], 2 * std::numbers::pi);
      if (condition.accept(state)) continue;
      VerifyResult result;
      result.status = VerifyStatus::kRefuted;
      result.segment = static_cast<int>(i);
      result.t0 = result.t1 = t;
      result.reason = "the condition does not accept a state";
      return result;
    }
  }
  return std::nullopt;
}

std::string numberText(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.17g", x);
  return buffer;
}

}  // namespace leeway::planner::verification
