#include "planner/search/goals.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "leeway/robots/kinematics.h"

namespace leeway::planner {
namespace {

using Kind = ConfigurationSpace::Kind;
using Part = ConfigurationSpace::Part;
using Range = std::pair<double, double>;

using collision::kTwoPi;

bool orientationIsFree(const Goal& goal, const Part& part) {
  for (std::size_t k = 0; k < 4; ++k)
    if (goal.ranges[at(part.first) + k].first > -1 || goal.ranges[at(part.first) + k].second < 1)
      return false;
  return true;
}

/// The angle in `range`, modulo whole turns, that is nearest to x; x itself if it is in the range.
double nearestOnCircle(const Range& range, double x) {
  if (range.second - range.first >= kTwoPi) return x;
  const double below = std::remainder(x - range.first, kTwoPi);
  const double above = std::remainder(x - range.second, kTwoPi);
  // Whole turns are rounded where they are added.
  const double rounding = 2 * std::numeric_limits<double>::epsilon() * std::abs(x);
  if (std::abs(below) <= rounding || std::abs(above) <= rounding) return x;
  // x is in the range if a turn upwards from the lower end reaches it before the upper end.
  const double from_lower = below < 0 ? below + kTwoPi : below;
  if (from_lower < range.second - range.first) return x;
  return std::abs(below) < std::abs(above) ? range.first : range.second;
}

bool posesHold(const CompiledScene& scene, const Goal& goal, std::span<const double> q) {
  const robots::Model& model = scene.model();
  std::vector<double> configuration(model.variables.size());
  std::vector<robots::Pose> X_WL(model.links.size());
  scene.expand(q, configuration);
  robots::forwardKinematics(model, configuration, X_WL);
  return std::all_of(goal.poses.begin(), goal.poses.end(), [&](const robots::PoseRegion& region) {
    const robots::Pose& X_link = X_WL[at(region.link)];
    const robots::PoseError error = robots::poseError(
        region, region.base < 0 ? X_link : X_WL[at(region.base)].inverse() * X_link);
    return error.position <= region.position_tolerance && error.angle <= region.angle_tolerance;
  });
}

}  // namespace

bool isPoint(const Goal& goal) {
  return goal.poses.empty() && std::all_of(goal.ranges.begin(), goal.ranges.end(),
                                           [](const Range& r) { return r.first == r.second; });
}

void drawPoint(const ConfigurationSpace& space, const Goal& goal, Random& random,
               std::span<double> q) {
  for (const Part& part : space.parts()) {
    const std::size_t i = at(part.first);
    if (part.kind == Kind::kRotation) {
      if (orientationIsFree(goal, part))
        random.quaternion(&q[i]);
      else
        for (std::size_t k = 0; k < 4; ++k) q[i + k] = goal.ranges[i + k].first;
      continue;
    }
    Range range = goal.ranges[i];
    if (part.kind == Kind::kLine)
      range = {std::max(range.first, space.lower(part.first)),
               std::min(range.second, space.upper(part.first))};
    q[i] = random.uniform(range.first, range.second);
  }
}

void nearestInGoal(const ConfigurationSpace& space, const Goal& goal, std::span<const double> q,
                   std::span<double> nearest) {
  for (const Part& part : space.parts()) {
    const std::size_t i = at(part.first);
    if (part.kind == Kind::kLine)
      nearest[i] = std::clamp(q[i], goal.ranges[i].first, goal.ranges[i].second);
    if (part.kind == Kind::kCircle) nearest[i] = nearestOnCircle(goal.ranges[i], q[i]);
    if (part.kind != Kind::kRotation) continue;
    const bool free = orientationIsFree(goal, part);
    for (std::size_t k = 0; k < 4; ++k) nearest[i + k] = free ? q[i + k] : goal.ranges[i + k].first;
  }
}

bool goalHolds(const CompiledScene& scene, const Goal& goal, std::span<const double> q) {
  const ConfigurationSpace& space = scene.space();
  if (!goal.poses.empty()) return posesHold(scene, goal, q);
  std::vector<double> nearest(q.size());
  nearestInGoal(space, goal, q, nearest);
  return space.distance(q, nearest) == 0;
}

void writeAsInGoal(const ConfigurationSpace& space, const Goal& goal, std::span<double> q) {
  if (!goal.poses.empty()) return;
  for (const Part& part : space.parts()) {
    const std::size_t i = at(part.first);
    const Range& range = goal.ranges[i];
    if (part.kind == Kind::kRotation && !orientationIsFree(goal, part))
      for (std::size_t k = 0; k < 4; ++k) q[i + k] = goal.ranges[i + k].first;
    if (part.kind != Kind::kCircle || (q[i] >= range.first && q[i] <= range.second)) continue;
    double above = std::remainder(q[i] - range.first, kTwoPi);
    if (above < 0) above += kTwoPi;
    q[i] = std::clamp(range.first + above, range.first, range.second);
  }
}

GoalRegions::GoalRegions(const ompl::base::SpaceInformationPtr& space_information,
                         const ConfigurationSpace& space, const Problem& problem,
                         const GoalPoints& points)
    : GoalStates(space_information), space_(space), problem_(problem) {
  // OMPL requires a distance below the threshold, and only zero is below this one.
  setThreshold(std::numeric_limits<double>::denorm_min());
  for (const std::vector<double>& point : points.points) {
    ompl::base::State* state = si_->allocState();
    std::copy(point.begin(), point.end(), state->as<OmplStateSpace::StateType>()->values);
    states_.push_back(state);
  }
  for (const planner::Goal& goal : problem.goals)
    has_ranges_ = has_ranges_ || (goal.poses.empty() && !isPoint(goal));
}

double GoalRegions::distanceGoal(const ompl::base::State* state) const {
  if (!has_ranges_) return GoalStates::distanceGoal(state);
  const std::span<const double> q(state->as<OmplStateSpace::StateType>()->values,
                                  at(space_.size()));
  thread_local std::vector<double> nearest;  // all of a planner's threads check goals
  nearest.resize(q.size());
  double distance = GoalStates::distanceGoal(state);
  for (const planner::Goal& goal : problem_.goals) {
    if (!goal.poses.empty()) continue;  // for poses, only the points count
    nearestInGoal(space_, goal, q, nearest);
    distance = std::min(distance, space_.distance(q, nearest));
  }
  return distance;
}

}  // namespace leeway::planner
