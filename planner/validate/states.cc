// Checks the states, goals and poses of a problem.

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "collision/base/greatest.h"
#include "collision/base/numbers.h"
#include "collision/base/pose_check.h"
#include "planner/base/largest_value.h"
#include "planner/base/tolerances.h"
#include "planner/validate/checks.h"
#include "robots/inverse/region.h"

namespace leeway::planner {
namespace {

using robots::Model;

/// Whether a variable is one of the four numbers of an orientation.
bool isOfOrientation(const Model& model, int variable) {
  const robots::Joint& joint = model.joints[at(model.variables[at(variable)].joint)];
  return joint.type == robots::JointType::kFloating && variable - joint.first_variable >= 3;
}

/// Returns the fault of four ranges of a goal that must be one orientation or any orientation.
std::optional<std::string> orientationFault(const Model& model, const Goal& goal, std::size_t first,
                                            int variable) {
  bool is_free = true, is_given = true;
  double squared = 0;
  for (std::size_t k = first; k < first + 4; ++k) {
    const auto& [low, high] = goal.ranges[k];
    is_free = is_free && low <= -1 && high >= 1;
    is_given = is_given && low == high;
    squared += low * low;
  }
  if (is_free || (is_given && std::abs(std::sqrt(squared) - 1) <= kUnitQuaternion))
    return std::nullopt;
  return fmt::format(
      "{} first of an orientation that is not one unit quaternion; unit length within {}, or -1 to "
      "1 four times for any orientation, is expected",
      variableText(model, variable), kUnitQuaternion);
}

}  // namespace

std::string variableText(const Model& model, int variable) {
  return "joint '" + model.variables[at(variable)].name + "'";
}

std::optional<std::string> rangeFault(const Model& model, int v, double lower, double upper) {
  const robots::Variable& variable = model.variables[at(v)];
  const auto fault = [&](const std::string& what) { return variableText(model, v) + " " + what; };
  for (const double x : {lower, upper})
    if (!std::isfinite(x)) return fault(fmt::format("at {}; a finite number is expected", x));
  if (lower > upper)
    return fault(
        fmt::format("from {} to {}; a range with its lower end first is expected", lower, upper));
  if (lower < variable.lower || upper > variable.upper) {
    const bool is_beyond = lower != upper && (lower > variable.upper || upper < variable.lower);
    const std::string& by = variable.narrowed_by;
    return fault(fmt::format("at {}, outside its limits; {} to {} is expected{}",
                             is_beyond ? fmt::format("{} to {}", lower, upper)
                                       : fmt::format("{}", lower < variable.lower ? lower : upper),
                             variable.lower, variable.upper,
                             by.empty() ? "" : ", because of " + by));
  }
  const double most = largestValue(model, v);
  for (const double x : {lower, upper})
    if (std::abs(x) > most)
      return fault(fmt::format(
          "at {}{}; at most {} {} is expected, because numbers round too much farther out", x,
          x == variable.lower || x == variable.upper ? ", which is its limit" : "",
          std::max(0.0, most), isAngle(model, v) ? "rad" : "m"));
  return std::nullopt;
}

std::optional<std::string> boundsFault(const Model& model, int v, double value) {
  if (!model.variables[at(v)].file_limits) return std::nullopt;
  return rangeFault(model, v, value, value);
}

std::optional<std::string> posesFault(const Problem& problem,
                                      const std::vector<robots::PoseRegion>& poses) {
  for (const robots::PoseRegion& region : poses)
    if (auto fault = robots::regionFault(*problem.robot.model, region)) return fault;
  return std::nullopt;
}

std::optional<std::string> goalFault(const Problem& problem, const Goal& goal) {
  const Model& model = *problem.robot.model;
  const std::vector<int>& variables = problem.robot.variables;
  const auto fault = [&](const std::string& what) {
    return fmt::format("goal '{}' {}", goal.name, what);
  };
  if (!goal.poses.empty()) {
    if (!goal.ranges.empty()) return fault("has both ranges and poses; one is expected");
    if (const auto wrong = posesFault(problem, goal.poses)) return fault("has a pose: " + *wrong);
    return std::nullopt;
  }
  if (goal.ranges.size() != variables.size())
    return fault(fmt::format("has {} values; {} are expected, one for each planned variable",
                             goal.ranges.size(), variables.size()));
  for (std::size_t i = 0; i < variables.size();) {
    const bool turns = isOfOrientation(model, variables[i]);
    const auto wrong =
        turns ? orientationFault(model, goal, i, variables[i])
              : rangeFault(model, variables[i], goal.ranges[i].first, goal.ranges[i].second);
    if (wrong) return fault("has " + *wrong);
    i += turns ? 4 : 1;
  }
  return std::nullopt;
}

namespace {

bool hasFollower(const Model& model, int variable) {
  return std::any_of(model.joints.begin(), model.joints.end(), [&](const robots::Joint& joint) {
    return joint.mimic >= 0 && joint.mimic == model.variables[at(variable)].joint;
  });
}

}  // namespace

std::optional<std::string> passiveWarning(const Problem& problem, int v) {
  const robots::Variable& variable = problem.robot.model->variables[at(v)];
  const double value = problem.start[at(v)];
  const std::vector<int>& planned = problem.robot.variables;
  if ((value >= variable.lower && value <= variable.upper) ||
      std::find(planned.begin(), planned.end(), v) != planned.end())
    return std::nullopt;
  return fmt::format("{} at {}, outside its limits of {} to {}; it is not planned and stays there",
                     variableText(*problem.robot.model, v), value, variable.lower, variable.upper);
}

std::optional<std::string> startFault(const Problem& problem) {
  const Model& model = *problem.robot.model;
  if (problem.start.size() != model.variables.size())
    return fmt::format("start has {} values; {} are expected, one for each variable of the model",
                       problem.start.size(), model.variables.size());
  for (std::size_t v = 0; v < problem.start.size(); ++v) {
    if (!std::isfinite(problem.start[v]))
      return fmt::format("start has {} at {}; a finite number is expected",
                         variableText(model, static_cast<int>(v)), problem.start[v]);
    if (const auto fault = boundsFault(model, static_cast<int>(v), problem.start[v]))
      return "start has " + *fault;
    // (A joint that does not move is placed exactly, but those that mimic it are not.)
    if (const double most = largestValue(model, static_cast<int>(v));
        std::abs(problem.start[v]) > most && hasFollower(model, static_cast<int>(v)))
      return fmt::format(
          "start has {} at {}; {} is expected, because a joint that mimics it would be too far out",
          variableText(model, static_cast<int>(v)), problem.start[v],
          most < 0 ? "another robot" : fmt::format("at most {}", most));
  }
  for (const int v : problem.robot.variables) {
    if (!isOfOrientation(model, v)) {
      if (const auto fault = rangeFault(model, v, problem.start[at(v)], problem.start[at(v)]))
        return "start has " + *fault;
      continue;
    }
    const int first = model.joints[at(model.variables[at(v)].joint)].first_variable + 3;
    if (v != first) continue;
    double squared = 0;
    for (int k = 0; k < 4; ++k) squared += problem.start[at(v + k)] * problem.start[at(v + k)];
    if (!(std::abs(squared - 1) <= 2 * kUnitQuaternion))
      return fmt::format(
          "start has {} first of a quaternion of length {}; unit length within {} is expected",
          variableText(model, v), std::sqrt(squared), kUnitQuaternion);
  }
  return std::nullopt;
}

namespace {

bool isOrthogonal(const Eigen::Matrix3d& R) { return collision::checkRotations(R, R).rotations; }

bool isPlacement(const robots::Pose& X) {
  return isOrthogonal(X.rotation) && X.rotation.determinant() > 0 &&
         (X.translation.array().abs() <= collision::kLargestSize).all();
}

}  // namespace

std::string poseFault(const robots::Pose& X) {
  if (isPlacement(X)) return {};
  const Eigen::Vector3d& p = X.translation;
  const Eigen::Matrix3d& R = X.rotation;
  return fmt::format(
      "is at ({}, {}, {}), its rotation {:.3g} from orthogonal{}; coordinates up to {} m and a "
      "right-handed rotation within {} are expected",
      p.x(), p.y(), p.z(), (R.transpose() * R - Eigen::Matrix3d::Identity()).norm(),
      isOrthogonal(R) && R.determinant() < 0 ? ", and mirrored" : "", collision::kLargestSize,
      collision::kRotationTolerance);
}

std::string objectFault(const Object& object) {
  if (!isPlacement(object.X_WO))
    return fmt::format("the pose of '{}' {}", object.name, poseFault(object.X_WO));
  for (const robots::Geometry& geometry : object.geometries)
    if (!isPlacement(geometry.X_BG))
      return fmt::format("the pose of a shape of '{}' {}", object.name, poseFault(geometry.X_BG));
  if (object.color)
    for (const double share : *object.color)
      if (!(share >= 0 && share <= 1))
        return fmt::format("the color of '{}' holds {}; numbers from 0 to 1 are expected",
                           object.name, share);
  if (!object.cloud) return {};
  if (const std::string fault = cloudFault(*object.cloud); !fault.empty())
    return fmt::format("cloud '{}': {}", object.name, fault);
  if (const std::string fault = carveFault(*object.cloud, object.X_WO); !fault.empty())
    return fmt::format("cloud '{}' {}", object.name, fault);
  return {};
}

std::string carveFault(const PointCloud& cloud, const robots::Pose& X_WC) {
  for (const CloudFilter& f : cloud.filters)
    if (f.X_WC && f.removed > 0 &&
        (f.X_WC->translation != X_WC.translation || f.X_WC->rotation != X_WC.rotation))
      return "stands at another pose than the one at which it was carved, and what was carved out "
             "may be in the way here; that pose, or a cloud that is not carved, is expected";
  return {};
}

bool isFitted(const Object& object) {
  return object.cloud != nullptr &&
         std::any_of(object.cloud->filters.begin(), object.cloud->filters.end(),
                     [](const CloudFilter& f) { return f.name == "crop" || f.name == "carve"; });
}

double extentOf(const Object& object) {
  double extent = 0;
  const auto add = [&](const Eigen::Vector3d& center, double radius) {
    extent = collision::greatest(extent, center.norm() + radius);
  };
  for (const robots::Geometry& g : object.geometries)
    add(g.X_BG * g.shape.boundingCenter(), g.shape.boundingRadius());
  if (object.cloud)
    for (const PointCloud::Ball& ball : object.cloud->balls) add(ball.center, ball.radius);
  return extent * (1 + kGrowthRounding);
}

double pointSpeed(double speed, double turning, double extent) {
  const double most = speed + (turning == 0 ? 0 : turning * extent);
  return most >= 0 ? most * (1 + kGrowthRounding) : kInfinity;
}

std::string motionFault(const Object& object, double start) {
  if (!object.motion) return {};
  const ObjectMotion& motion = *object.motion;
  if (object.geometries.empty() && !object.cloud)
    return "moves and has no shape; at least one is expected";
  if (!(extentOf(object) < kInfinity))
    return "moves and has a half-space; shapes of bounded size are expected";
  if (object.cloud && !object.cloud->crops.empty())
    return "moves, and its cloud was cropped: what it lacks may come near; a cloud that is not "
           "cropped is expected";
  if (motion.poses && isFitted(object))
    return "moves, and its cloud was carved for one place; a whole cloud is expected";
  if (!(motion.speed_bound >= 0))
    return fmt::format("has the speed bound {}; at least 0 m/s is expected", motion.speed_bound);
  if (!(motion.turn_bound >= 0))
    return fmt::format("has the turning bound {}; at least 0 rad/s is expected", motion.turn_bound);
  if (!(motion.age >= 0 && std::isfinite(motion.age)))
    return fmt::format("was seen {} s before the start; a finite age from 0 s on is expected",
                       motion.age);
  if (!motion.poses && motion.start && *motion.start != start)
    return fmt::format(
        "was seen {} s before {} s, and execution starts at {} s; movingObject() with that time is "
        "expected, in Python set_motion() with start={}",
        motion.age, *motion.start, start, start);
  if (!motion.poses) return {};
  if (motion.age != 0)
    return fmt::format("has an age, {} s, beside its poses at all times; 0 s is expected",
                       motion.age);
  const robots::Pose X_WO = motion.poses->pose(start);
  if (object.X_WO.translation != X_WO.translation || object.X_WO.rotation != X_WO.rotation)
    return fmt::format(
        "does not stand where its motion has it at {} s, when execution starts; movingObject() "
        "with "
        "that time is expected, in Python set_motion() with start={}",
        start, start);
  return {};
}

Object movingObject(Object object, const ObjectMotion& motion, double time) {
  ObjectMotion of_object = motion;
  of_object.start = time;
  // Any motion of a cloud's points is within a bound on their speed, turning included.
  if (object.cloud && object.geometries.empty() && !motion.poses && motion.turn_bound == kInfinity)
    of_object.turn_bound = 0;
  object.motion = std::make_shared<const ObjectMotion>(std::move(of_object));
  if (motion.poses) object.X_WO = motion.poses->pose(time);
  std::string fault = objectFault(object);
  if (fault.empty())
    if (const std::string of_motion = motionFault(object, time); !of_motion.empty())
      fault = fmt::format("object '{}' {}", object.name, of_motion);
  if (!fault.empty()) throw std::invalid_argument(fault);
  return object;
}

std::optional<double> obstaclesAt(const Problem& problem) {
  const bool has_moving = std::any_of(problem.world.objects.begin(), problem.world.objects.end(),
                                      [](const Object& o) { return o.motion != nullptr; });
  const bool has_deforming =
      std::any_of(problem.world.deforming.begin(), problem.world.deforming.end(),
                  [](const DeformingObstacle& o) { return o.motion != nullptr; });
  if (!has_moving && !has_deforming) return std::nullopt;
  return problem.execution.start;
}

bool areSameMargins(const Margins& x, const Margins& y) {
  return x.common == y.common &&
         std::equal(x.pairs.begin(), x.pairs.end(), y.pairs.begin(), y.pairs.end(),
                    [](const PairMargin& m, const PairMargin& n) {
                      return m.a == n.a && m.b == n.b && m.margin == n.margin;
                    });
}

double mostMargin(const Problem& problem) {
  double most = problem.margins.common;
  for (const PairMargin& m : problem.margins.pairs) most = std::max(most, m.margin);
  for (const Wish& wish : problem.margins.wishes) most = std::max(most, wish.clearance);
  most = std::max(most, keptClearance(problem));
  if (const auto* cost = std::get_if<MinimumCost>(&problem.objective))
    for (const CostTerm& term : cost->terms)
      if (term.of != Pairs::kSelf)
        most = std::max(most, term.nearness.kind == Nearness::Kind::kHinge ? term.nearness.distance
                                                                           : kInfinity);
  return most;
}

double keptClearance(const Problem& problem) {
  const auto* length = std::get_if<MinimumLength>(&problem.objective);
  return length != nullptr ? length->clearance : -kInfinity;
}

std::string firstGrasp(const Problem& problem) {
  for (std::size_t s = 0; s < problem.steps.size(); ++s)
    if (std::holds_alternative<AttachStep>(problem.steps[s].action))
      return problem.steps[s].name.empty() ? fmt::format("steps[{}]", s)
                                           : "step '" + problem.steps[s].name + "'";
  return {};
}

CropNeeds cropNeeds(const Problem& problem) {
  return {mostMargin(problem), robotReach(problem), firstGrasp(problem)};
}

std::string cropFault(const Object& object, const CropNeeds& needs) {
  if (!object.cloud || object.cloud->crops.empty()) return {};
  const auto fault = [&](const std::string& what) {
    return fmt::format("cloud '{}' {}", object.name, what);
  };
  if (needs.margin > object.cloud->completeWithin())
    return fault(
        fmt::format("lacks what is farther than {} m from the robot's reach, and a margin, wish "
                    "or cost reaches {} m; a crop of at least that is expected",
                    object.cloud->completeWithin(), needs.margin));
  if (!needs.grasp.empty())
    return fault(
        fmt::format("was cropped, and {} attaches an object, which reaches farther than the robot "
                    "at the start; a cloud that is not cropped is expected",
                    needs.grasp));
  for (const PointCloud::Crop& crop : object.cloud->crops) {
    if (crop.X_WC.translation != object.X_WO.translation ||
        crop.X_WC.rotation != object.X_WO.rotation)
      return fault(
          "stands at another pose than the one at which it was cropped; that pose, or a cloud that "
          "is not cropped, is expected");
    if (!crop.covers(needs.reach_W))
      return fault(
          "was cropped for a robot that reaches less far: the robot, its base, its planned joints, "
          "the values of the others or what it holds were different; a cloud that was cropped for "
          "this problem, or one that is not cropped, is expected");
  }
  return {};
}

std::vector<double> startPoint(const Problem& problem) {
  std::vector<double> point;
  for (const int v : problem.robot.variables) {
    if (v < 0 || at(v) >= problem.start.size())
      throw robots::InputError(
          problem.name, 0,
          fmt::format("start has {} values, without one for planned variable {}; one for each "
                      "variable of the model is expected",
                      problem.start.size(), v));
    point.push_back(problem.start[at(v)]);
  }
  return point;
}

std::vector<double> goalPoint(const Problem& problem, const Goal& goal) {
  std::vector<double> point = startPoint(problem);
  for (std::size_t i = 0; i < goal.ranges.size(); ++i) {
    const auto [lower, upper] = goal.ranges[i];
    if (std::isfinite(lower) && std::isfinite(upper))
      point[i] = lower == upper ? lower : 0.5 * lower + 0.5 * upper;
    else if (std::isfinite(lower) || std::isfinite(upper))
      point[i] = std::isfinite(lower) ? lower : upper;
  }
  return point;
}

}  // namespace leeway::planner
