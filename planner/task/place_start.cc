#include <algorithm>
#include <functional>
#include <numbers>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/planner/placed_at.h"
#include "leeway/planner/plan.h"
#include "leeway/robots/input_error.h"
#include "planner/base/clock.h"
#include "planner/base/tolerances.h"
#include "planner/search/goal_sampler.h"
#include "planner/task/line_motion.h"
#include "planner/task/stages.h"

namespace leeway::planner {
namespace {

/// A start, and how far the line can be followed from there.
struct Candidate {
  std::vector<double> point;
  double place = -1;
  bool is_whole = false;
};

/// Searches for the start from which the first line of a task can be followed farthest.
class LongestLine {
 public:
  LongestLine(EdgeCertifier& certifier, const Problem& world, const LineStep& line,
              std::uint64_t seed, std::function<bool()> stop)
      : certifier_(certifier),
        world_(world),
        line_(line),
        seed_(seed),
        stop_(std::move(stop)),
        kinematics_(world.robot.model, world.robot.variables) {}

  std::vector<double> choose(GoalSampler& sampler, GoalPoints& points) {
    std::vector<Candidate> tried;
    for (std::size_t i = 0; i < kLineStarts; ++i) {
      while (i >= points.points.size() && sampler.more(points)) {
      }
      if (i >= points.points.size() || (i > 0 && stop_())) break;
      tried.push_back(withTurns(follow(points.points[i], 0)));
      if (tried.back().is_whole) return tried.back().point;
    }
    std::stable_sort(tried.begin(), tried.end(),
                     [](const Candidate& a, const Candidate& b) { return a.place > b.place; });
    tried.resize(std::min(tried.size(), kLongestLines));
    for (Candidate& candidate : tried) {
      if (stop_()) break;
      candidate = follow(candidate.point, kLineTries);
      if (candidate.is_whole) return candidate.point;
    }
    return std::max_element(
               tried.begin(), tried.end(),
               [](const Candidate& a, const Candidate& b) { return a.place < b.place; })
        ->point;
  }

 private:
  Candidate follow(const std::vector<double>& point, int tries) {
    const LineMotion motion =
        followLine(certifier_, kinematics_, world_, line_, point, {tries, seed_, stop_});
    return {point, motion.places.back(), !motion.end};
  }

  /// Tries the candidate with joints a whole turn away, and returns the one with the longest line.
  Candidate withTurns(Candidate best) {
    const ConfigurationSpace& space = certifier_.scene().space();
    for (bool gains = true; gains && !best.is_whole && !stop_();) {
      gains = false;
      for (const ConfigurationSpace::Part& part : space.parts()) {
        if (part.kind == ConfigurationSpace::Kind::kRotation ||
            !isAngle(space.variables()[at(part.first)]))
          continue;
        for (const double turn : {-kTurn, kTurn}) {
          std::vector<double> point = best.point;
          point[at(part.first)] += turn;
          if (!space.withinLimits(point)) continue;
          Candidate other = follow(point, 0);
          if (!(other.place > best.place)) continue;
          best = std::move(other);
          gains = true;
        }
      }
    }
    return best;
  }

  static constexpr double kTurn = 2 * std::numbers::pi;

  /// Whether a variable is the angle of a joint with limits.
  bool isAngle(int variable) const {
    const auto& joints = world_.robot.model->joints;
    return std::any_of(joints.begin(), joints.end(), [variable](const robots::Joint& joint) {
      return joint.first_variable == variable && joint.type == robots::JointType::kRevolute &&
             joint.mimic < 0;
    });
  }

  EdgeCertifier& certifier_;
  const Problem& world_;
  const LineStep& line_;
  std::uint64_t seed_;
  std::function<bool()> stop_;
  robots::InverseKinematics kinematics_;
};

}  // namespace

Problem placeStart(const Problem& problem, const std::function<bool()>& stop) {
  validate(problem);
  return problem.start_poses.empty() ? problem
                                     : placedAt(problem, problem.start_poses, "start", stop);
}

Problem placedAt(const Problem& problem, const std::vector<robots::PoseRegion>& poses,
                 const std::string& what, const std::function<bool()>& stop) {
  const Clock::time_point begin = Clock::now();
  const double limit = problem.limits.time > 0 ? problem.limits.time / 2 : kInfinity;
  const auto isOver = [&] { return secondsSince(begin) > limit || (stop && stop()); };
  Problem placed = problem;
  placed.start_poses = poses;
  validate(placed);
  placed.start_poses.clear();
  const LineStep* line =
      problem.steps.empty() ? nullptr : std::get_if<LineStep>(&problem.steps[0].action);
  const Problem world = firstWorld(placed);
  Problem task = line == nullptr ? world : stageOf(world, problem.steps[0]);
  task.goals = {{what, {}, poses}};
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(task));
  GoalSampler sampler(certifier, task, problem.seed);
  GoalPoints points = sampler.first([] { return false; });
  if (!points.reason.empty()) {
    const std::string as_goal = "goal '" + what + "': ";  // it was searched as one
    throw robots::InputError(
        problem.name, 0,
        what + ": " +
            points.reason.substr(points.reason.starts_with(as_goal) ? as_goal.size() : 0));
  }
  std::vector<double> start;
  if (points.points.empty())
    // Planning from the nearest configuration reports the obstacle.
    start = sampler.found(0).front();
  else if (line != nullptr)
    start = LongestLine(certifier, world, *line, problem.seed, isOver).choose(sampler, points);
  else
    start = points.points.front();
  for (std::size_t i = 0; i < start.size(); ++i)
    placed.start[at(placed.robot.variables[i])] = start[i];
  return placed;
}

}  // namespace leeway::planner
