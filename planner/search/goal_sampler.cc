#include "planner/search/goal_sampler.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "collision/base/numbers.h"
#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/edge/why_undecided.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

/// Keeps the check with the greatest clearance: among invalid configurations, the least deep one.
void keepBetter(StateCheck& best, const StateCheck& check) {
  if (best.pair < 0 || check.clearance.upper > best.clearance.upper) best = check;
}

/// The reason why a configuration is not valid: its closest pair.
std::string contactText(const EdgeCertifier& certifier, const StateCheck& check) {
  if (check.pair < 0) return "its clearance could not be decided";
  const collision::Scene& scene = certifier.scene().scene();
  const collision::ScenePair& pair = scene.pairs()[at(check.pair)];
  const auto [lower, upper] = check.clearance;
  const std::string names = fmt::format("{} and {}", scene.bodies()[at(pair.body_a)].name,
                                        scene.bodies()[at(pair.body_b)].name);
  if (upper > 0)
    return fmt::format("{} are too near there, {:.3f} mm apart, and more than {:g} mm is required",
                       names, upper * 1e3, pair.margin * 1e3);
  if (pair.margin >= 0) return fmt::format("{} collide there, {:.3f} mm deep", names, -upper * 1e3);
  // The depth of meshes may have wide bounds.
  return fmt::format(
      "{} are {:.3f} to {:.3f} mm deep in each other there, and less than {:g} mm is required",
      names, -upper * 1e3, -lower * 1e3, -pair.margin * 1e3);
}

/// Whether points drawn uniformly from each region can be reached. They cannot if a position is
/// `any`, if two regions are of one link, or if a region moves.
bool canDrawEvenly(const std::vector<robots::PoseRegion>& poses) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i].base >= 0) return false;
    for (const auto& [from, to] : poses[i].position)
      if (to - from > kWidestDraw) return false;
    for (std::size_t k = 0; k < i; ++k)
      if (poses[k].link == poses[i].link) return false;
  }
  return true;
}

}  // namespace

GoalSampler::GoalSampler(EdgeCertifier& certifier, const Problem& problem, std::uint64_t seed)
    : certifier_(&certifier), problem_(problem), seed_(seed) {
  const ConfigurationSpace& space = certifier.scene().space();
  for (std::size_t g = 0; g < problem.goals.size(); ++g) {
    if (problem.goals[g].poses.empty()) continue;
    std::vector<robots::PoseRegion> poses = problem.goals[g].poses;
    for (const Constraint& constraint : problem.constraints)
      for (const robots::PoseRegion& region : regionsOf(problem, constraint))
        poses.push_back(region);
    const bool evenly = canDrawEvenly(poses);
    pose_goals_.push_back({g, std::move(poses), evenly});
  }
  if (isConstrained(problem)) constraints_.emplace(certifier.scene(), problem);
  difference_.resize(at(space.size()));
  if (!pose_goals_.empty())
    kinematics_ =
        std::make_unique<robots::InverseKinematics>(problem.robot.model, problem.robot.variables);
}

GoalPoints GoalSampler::first(const std::function<bool()>& stop) {
  GoalPoints result;
  auto drawn = pose_goals_.begin();
  for (std::size_t g = 0; g < problem_.goals.size(); ++g) {
    if (problem_.goals[g].poses.empty())
      drawJoints(g, result, stop);
    else
      drawPoses(*drawn++, result, stop);
  }
  return result;
}

void GoalSampler::drawJoints(std::size_t g, GoalPoints& result, const std::function<bool()>& stop) {
  const ConfigurationSpace& space = certifier_->scene().space();
  const Goal& goal = problem_.goals[g];
  std::vector<double> q(at(space.size()));
  Random random(seed_, kGoalStream + g);
  const bool point = isPoint(goal);
  const std::size_t wanted = result.points.size() + (point ? 1 : kGoalSamples);
  bool found = false, stopped = false, kept = false;
  for (int i = 0; i < (point ? 1 : kGoalAttempts) && result.points.size() < wanted; ++i) {
    if (i > 0 && stop()) {
      stopped = true;
      break;
    }
    drawPoint(space, goal, random, q);
    // Few points of a narrow range keep the constraints; its middle often does.
    for (const ConfigurationSpace::Part& part : space.parts()) {
      if (i > 0 || !constraints_ || part.kind == ConfigurationSpace::Kind::kRotation) continue;
      const auto& [low, high] = goal.ranges[at(part.first)];
      if (const double middle = std::midpoint(low, high); std::isfinite(middle))
        q[at(part.first)] = middle;
    }
    if (!keepsConstraints(q)) continue;
    kept = true;
    if (certifier_->decide(q) == Verdict::kFree) {
      result.points.push_back(q);
      found = true;
    } else if (result.points.empty() && i < kGoalReports) {
      keepBetter(result.closest, certifier_->tooNear(q, kReportTolerance));
    }
  }
  result.stopped = result.stopped || stopped;
  if (!found && point && !keepsConstraints(q) && result.reason.empty())
    result.reason = "goal '" + goal.name + "': " + constraints_->fault(q);
  const std::string why = point ? whyUndecided(certifier_->scene(), q) : std::string();
  if (!found && !point && !kept && !stopped && result.reason.empty())
    result.reason = fmt::format("goal '{}': none of {} points of it keeps the constraints",
                                goal.name, kGoalAttempts);
  if (!found && !why.empty() && result.reason.empty())
    result.reason = "goal '" + goal.name + "': " + why;
  if (!found)
    result.warnings.push_back(
        "goal '" + goal.name + "' is left out: " +
        (point && !keepsConstraints(q) ? constraints_->fault(q)
         : !why.empty()                ? why
         : point   ? contactText(*certifier_, certifier_->tooNear(q, kReportTolerance))
         : stopped ? "no valid point of it was found within the limits"
                   : "none of " + std::to_string(kGoalAttempts) + " points of it was valid"));
}

void GoalSampler::drawPoses(PoseGoal& drawn, GoalPoints& result,
                            const std::function<bool()>& stop) {
  const Goal& goal = problem_.goals[drawn.goal];
  const std::size_t before = result.points.size();
  const auto found = [&] { return result.points.size() > before; };
  robots::IkOptions options;
  options.seed = seed_;
  options.stop = stop;
  options.prove = false;
  // One start is enough for most goals, a few more for most others. The remaining goals are worth
  // many starts, and a proof. Each of these searches starts like the previous one.
  struct Effort {
    int starts, solutions;
  };
  constexpr Effort kEfforts[] = {{1, kFirstPoseSolutions},
                                 {kFirstPoseStarts, kFirstPoseSolutions},
                                 {kPoseStarts, kPoseSolutions}};
  robots::IkResult solved;
  int starts = 0;
  bool is_alone = false;  // without the constraints
  for (const Effort& effort : kEfforts) {
    if (drawn.complete || (starts > 0 && stop())) break;
    options.starts = effort.starts;
    options.max_solutions = effort.solutions;
    // The regions omit a rim of what constraints allow, so they prove nothing. Finally the goal
    // alone is solved; its solutions may satisfy the constraints.
    const bool is_last = effort.starts == kPoseStarts && drawn.found.empty();
    options.prove = is_last;
    is_alone = is_last && constraints_;
    if (is_alone) drawn.poses = goal.poses;
    drawn.broken.clear();
    drawn.breaking = 0;
    solved = kinematics_->solve(drawn.poses, problem_.start, options);
    starts = solved.starts;
    drawn.complete = solved.complete;
    drawn.pending = std::move(solved.solutions);
    if (takePending(drawn, result)) break;
  }
  const bool unreachable = solved.status == robots::IkStatus::kUnreachable;
  while (!found() && !unreachable && !drawn.found.empty() && !isExhausted(drawn) && !stop())
    drawBatch(drawn, result);
  if (found()) return;
  const bool stopped = !unreachable && stop();
  result.stopped = result.stopped || stopped;
  std::string reason;
  if (unreachable)
    reason = "out of reach: proven";
  else if (drawn.found.empty() && drawn.breaking > 0)
    reason = fmt::format(
        "none of {} sets of joint values that were found for it keeps the constraints; of the "
        "first, {}",
        drawn.breaking, drawn.broken);
  else if (drawn.found.empty())
    reason = fmt::format(
        "no joint values were found for it from {} starts{}; the nearest are {:.3g} mm and {:.3g} "
        "degrees off",
        starts, is_alone ? ", even without the constraints" : "",
        solved.nearest.error.position * 1e3, solved.nearest.error.angle * 180 / std::numbers::pi);
  if (!reason.empty() && result.reason.empty() && !stopped) {
    result.reason = "goal '" + goal.name + "': " + reason;
    result.unreachable = unreachable;
  }
  if (reason.empty())
    reason = fmt::format("none of {} sets of joint values that were found for it is valid",
                         drawn.found.size());
  result.warnings.push_back("goal '" + goal.name + "' is left out: " + reason);
}

bool GoalSampler::more(GoalPoints& points) {
  for (std::size_t i = 0; i < pose_goals_.size(); ++i) {
    PoseGoal& drawn = pose_goals_[turn_++ % pose_goals_.size()];
    if (drawn.found.empty()) continue;
    if (!drawn.pending.empty()) {
      takePending(drawn, points);
      return true;
    }
    if (isExhausted(drawn)) continue;
    drawBatch(drawn, points);
    return true;
  }
  return false;
}

bool GoalSampler::isExhausted(const PoseGoal& drawn) {
  return drawn.complete || drawn.idle >= kIdleDraws || drawn.found.size() >= kMostPoseSolutions;
}

void GoalSampler::drawBatch(PoseGoal& drawn, GoalPoints& points) {
  const std::vector<robots::PoseRegion>& poses = drawn.poses;
  for (int i = 0; i < kPoseDraws; ++i) {
    ++drawn.idle;
    if (drawn.evenly) {
      const auto solution = kinematics_->sample(poses, problem_.start, drawn.draws++, seed_);
      if (solution) take(drawn, {&*solution, 1}, points);
      continue;
    }
    robots::IkOptions options;
    options.starts = 1;
    options.prove = false;
    take(drawn, kinematics_->solve(poses, anyConfiguration(drawn), options).solutions, points);
  }
}

std::vector<double> GoalSampler::anyConfiguration(PoseGoal& drawn) const {
  const ConfigurationSpace& space = certifier_->scene().space();
  Goal all;
  for (int i = 0; i < space.size(); ++i) all.ranges.emplace_back(space.lower(i), space.upper(i));
  for (const ConfigurationSpace::Part& part : space.parts()) {
    if (part.kind == ConfigurationSpace::Kind::kCircle)
      all.ranges[at(part.first)] = {-std::numbers::pi, std::numbers::pi};
    if (part.kind == ConfigurationSpace::Kind::kRotation)
      for (int k = 0; k < 4; ++k) all.ranges[at(part.first + k)] = {-1, 1};
  }
  std::vector<double> point(at(space.size())), configuration(problem_.start.size());
  Random random(Random(seed_, kGoalStream + drawn.goal).next(), drawn.draws++);
  drawPoint(space, all, random, point);
  certifier_->scene().expand(point, configuration);
  return configuration;
}

bool GoalSampler::takePending(PoseGoal& drawn, GoalPoints& points) {
  const std::size_t before = points.points.size();
  std::size_t taken = 0;
  while (taken < drawn.pending.size() && points.points.size() == before)
    take(drawn, {&drawn.pending[taken++], 1}, points);
  drawn.pending.erase(drawn.pending.begin(),
                      drawn.pending.begin() + static_cast<std::ptrdiff_t>(taken));
  return points.points.size() > before;
}

void GoalSampler::take(PoseGoal& drawn, std::span<const robots::IkSolution> solutions,
                       GoalPoints& points) {
  for (const robots::IkSolution& solution : solutions) {
    const std::vector<double>& q = solution.values;
    if (isKnown(drawn, q) || !certifier_->scene().space().withinLimits(q) ||
        !goalHolds(certifier_->scene(), problem_.goals[drawn.goal], q))
      continue;
    if (!keepsConstraints(q)) {
      if (drawn.breaking++ == 0) drawn.broken = constraints_->fault(q);
      continue;
    }
    drawn.idle = 0;
    drawn.found.push_back(q);
    if (certifier_->decide(q) == Verdict::kFree)
      points.points.push_back(q);
    else if (points.points.empty() && drawn.found.size() <= at(kGoalReports))
      keepBetter(points.closest, certifier_->tooNear(q, kReportTolerance));
  }
}

bool GoalSampler::isKnown(const PoseGoal& drawn, const std::vector<double>& point) const {
  const ConfigurationSpace& space = certifier_->scene().space();
  return std::any_of(drawn.found.begin(), drawn.found.end(), [&](const std::vector<double>& q) {
    space.difference(q, point, difference_);
    return std::all_of(difference_.begin(), difference_.end(),
                       [](double x) { return std::abs(x) < kSameSolution; });
  });
}

}  // namespace leeway::planner
