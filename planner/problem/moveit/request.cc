// Reads group, start and goals of MoveIt's motion plan request (moveit_msgs/MotionPlanRequest).

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/robots/placed_model.h"
#include "planner/base/did_you_mean.h"
#include "planner/base/tolerances.h"
#include "planner/problem/moveit/fields.h"
#include "planner/problem/read_shapes.h"
#include "planner/problem/read_states.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

using robots::JointType;
using robots::Model;
using robots::Pose;

bool isIdentity(const Pose& pose) {
  return pose.rotation == Eigen::Matrix3d::Identity() &&
         pose.translation == Eigen::Vector3d::Zero();
}

/// Moves a value that is just outside a joint's limits onto the limit, with a warning.
void takeOntoLimit(const YamlReader& place, const robots::Variable& variable, double& value,
                   Problem& problem) {
  const double nearest = std::clamp(value, variable.lower, variable.upper);
  if (nearest == value || std::abs(nearest - value) > kLimitSlack) return;
  problem.warnings.push_back(fmt::format("{}:{}: joint '{}' at {} is moved onto its limit {}",
                                         place.file(), place.line(), variable.name, value,
                                         nearest));
  value = nearest;
}

bool isPlanned(const Problem& problem, int variable) {
  return std::find(problem.robot.variables.begin(), problem.robot.variables.end(), variable) !=
         problem.robot.variables.end();
}

void takeStartJoint(const YamlReader& place, const std::string& name, double value,
                    VariableRanges& given, Problem& problem) {
  const Model& model = *problem.robot.model;
  const int v = model.findVariable(name);
  if (v >= 0) {
    if (given[at(v)].given)
      place.fail(
          fmt::format("joint '{}' stands twice in {}; once is expected", name, place.where()));
    if (isPlanned(problem, v) || boundsFault(model, v, value))
      takeOntoLimit(place, model.variables[at(v)], value, problem);
    given[at(v)] = {true, value, value, place.line()};
    return;
  }
  // Fixed and mimic joints may be named. A name without a joint belongs to another version of the
  // robot.
  if (model.findJoint(name) < 0)
    problem.warnings.push_back(
        fmt::format("{}:{}: the robot has no joint '{}', its position {} is not used", place.file(),
                    place.line(), name, value));
}

/// Reads {joint_names, transforms}: poses of planar and floating joints, mainly of the virtual
/// joint.
void readMultiDof(const YamlReader& state, VariableRanges& given, Problem& problem) {
  const auto names = state.find("joint_names");
  if (!hasContent(names)) return;
  const YamlReader transforms = state.at("transforms", "a transform for each joint name");
  const std::vector<YamlReader> name_items = names->items(), items = transforms.items();
  if (name_items.size() != items.size())
    transforms.fail(fmt::format("{} transforms for {} joint_names; equally many are expected",
                                items.size(), name_items.size()));
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Model& model = *problem.robot.model;
    const int index = model.findJoint(name_items[i].text());
    const JointType type = index >= 0 ? model.joints[at(index)].type : JointType::kFixed;
    if (type == JointType::kFloating) {
      const int first = model.joints[at(index)].first_variable;
      Eigen::Vector3d p = Eigen::Vector3d::Zero();
      Eigen::Vector4d q = Eigen::Vector4d::UnitW();
      if (const auto translation = items[i].find("translation")) p = readMoveitVector(*translation);
      if (const auto rotation = items[i].find("rotation"))
        q = readMoveitQuaternion(*rotation, problem.warnings);
      for (int k = 0; k < 7; ++k) {
        const double value = k < 3 ? p[k] : q[k - 3];
        given[at(first + k)] = {true, value, value, items[i].line()};
      }
    } else if (!isIdentity(readMoveitPose(items[i], "translation", "rotation", problem.warnings))) {
      items[i].fail(
          fmt::format("joint '{}' is not floating, but placed elsewhere; the identity is expected",
                      name_items[i].text()));
    }
  }
}

}  // namespace

void readRequestStart(const YamlReader& request, Problem& problem) {
  const YamlReader state = request.at("start_state", "the robot's start");
  const YamlReader joints = state.at("joint_state", "name and position");
  const YamlReader names = joints.at("name", "a list of joint names"),
                   positions = joints.at("position", "a list of positions");
  const std::vector<YamlReader> name_items = names.items(), items = positions.items();
  if (name_items.size() != items.size())
    positions.fail(fmt::format("{} positions for {} names; equally many are expected", items.size(),
                               name_items.size()));
  VariableRanges given(problem.robot.model->variables.size());
  for (std::size_t i = 0; i < items.size(); ++i)
    takeStartJoint(items[i], name_items[i].text(), items[i].number(), given, problem);
  if (const auto multi = state.find("multi_dof_joint_state"); multi && multi->isMap())
    readMultiDof(*multi, given, problem);
  takeStart(joints.file(), joints.line(), given, problem);
}

namespace {

/// The variable that an entry of joint_constraints names.
int constrainedVariable(const YamlReader& constraint, const Problem& problem) {
  const Model& model = *problem.robot.model;
  const YamlReader name = constraint.at("joint_name", "the name of a joint");
  const int v = model.findVariable(name.text());
  if (v >= 0) return v;
  std::vector<std::string> known;
  for (const int variable : problem.robot.variables)
    known.push_back(model.variables[at(variable)].name);
  name.fail(fmt::format("unknown joint '{}' in {}{}", name.text(), constraint.where(),
                        didYouMean(model, "virtual joint", name.text(), known)));
}

/// Whether the robot's own joint turns without limits: MoveIt does not tell whole turns of it
/// apart.
bool turnsFreely(const Model& model, int variable) {
  const robots::Variable& v = model.variables[at(variable)];
  return model.joints[at(v.joint)].type == JointType::kContinuous ||
         (model.joints[at(v.joint)].type == JointType::kRevolute && v.file_limits &&
          std::isinf(v.file_limits->first));
}

/// The angle that equals `value` up to whole turns and is nearest to `near`.
double turnedNear(double value, double near) {
  constexpr double kTurn = 2 * std::numbers::pi;
  return value + kTurn * std::round((near - value) / kTurn);
}

/// Returns the range that an entry of joint_constraints allows around `position`.
std::pair<double, double> allowedRange(const YamlReader& constraint, double position) {
  const auto tolerance = [&](const char* key) {
    const auto found = constraint.find(key);
    return found ? found->sizeNumber() : 0;
  };
  // A tolerance of zero, which MotionBenchMaker writes, means the exact position.
  return {position - tolerance("tolerance_below"), position + tolerance("tolerance_above")};
}

void readJointConstraint(const YamlReader& constraint, VariableRanges& given, Problem& problem) {
  const Model& model = *problem.robot.model;
  const YamlReader position = constraint.at("position", "a number");
  const int v = constrainedVariable(constraint, problem);
  const robots::Variable& variable = model.variables[at(v)];
  if (given[at(v)].given)
    constraint.fail(fmt::format("joint '{}' has two constraints; one is expected", variable.name));
  double value = position.number();
  // Bounds of a path constraint are about the start.
  if (turnsFreely(model, v) && std::isfinite(variable.lower))
    value = turnedNear(value, problem.start[at(v)]);
  if (isPlanned(problem, v)) takeOntoLimit(position, variable, value, problem);
  auto [lower, upper] = allowedRange(constraint, value);
  if (lower <= variable.upper && upper >= variable.lower) {
    lower = std::max(lower, variable.lower);
    upper = std::min(upper, variable.upper);
  }
  given[at(v)] = {true, lower, upper, position.line()};
}

/// A joint constraint of the path: narrower limits of a planned joint. Other joints stay, and are
/// looked at where they are.
void readPathJoint(const YamlReader& constraint, std::vector<char>& seen, Problem& problem) {
  const Model& model = *problem.robot.model;
  const YamlReader position = constraint.at("position", "a number");
  const int v = constrainedVariable(constraint, problem);
  const robots::Variable& variable = model.variables[at(v)];
  if (seen[at(v)]++ != 0)
    constraint.fail(fmt::format("joint '{}' has two constraints; one is expected", variable.name));
  double& start = problem.start[at(v)];
  const bool is_free = turnsFreely(model, v);
  const double middle = position.number();
  auto [lower, upper] = allowedRange(constraint, is_free ? turnedNear(middle, start) : middle);
  if (is_free && upper - lower >= 2 * std::numbers::pi) return;
  if (!isPlanned(problem, v)) {
    if (start >= lower - kLimitSlack && start <= upper + kLimitSlack) return;
    position.fail(fmt::format(
        "joint '{}' is not planned and stands at {}; {} allows {} to {}; a start there is expected",
        variable.name, start, constraint.where(), lower, upper));
  }
  if (!(lower <= variable.upper && upper >= variable.lower))
    position.fail(fmt::format(
        "{} allows joint '{}' from {} to {}, outside its limits; a range that "
        "meets {} to {} is expected",
        constraint.where(), variable.name, lower, upper, variable.lower, variable.upper));
  const std::size_t axis = variable.name.find('/');
  const robots::Joint& joint = model.joints[at(variable.joint)];
  const robots::JointBound bound{
      std::max(lower, variable.lower), std::min(upper, variable.upper), false,
      fmt::format("{} at {}:{}", constraint.where(), position.file(), position.line())};
  const bool has_axes = joint.type == JointType::kPlanar || joint.type == JointType::kFloating;
  try {
    problem.robot.model = robots::withBounds(
        model, {{joint.name, {{has_axes ? variable.name.substr(axis + 1) : "", bound}}}});
  } catch (const std::invalid_argument& error) {
    position.fail(fmt::format("{}: {}", constraint.where(), error.what()));
  }
  takeOntoLimit(position, problem.robot.model->variables[at(v)], start, problem);
}

Goal readConstraints(const YamlReader& map, const std::string& name, Problem& problem) {
  refuseContent(map, "visibility_constraints", "a goal of joints or poses");
  Goal goal{name, {}, {}};
  if (const auto positions = map.find("position_constraints"); hasContent(positions))
    for (const YamlReader& constraint : positions->items())
      goal.poses.push_back(readPositionConstraint(constraint, problem));
  if (const auto orientations = map.find("orientation_constraints"); hasContent(orientations))
    for (const YamlReader& constraint : orientations->items())
      goal.poses.push_back(readOrientationConstraint(constraint, problem));
  if (!goal.poses.empty()) {
    refuseContent(map, "joint_constraints", "a goal of either joints or poses");
    return goal;
  }
  const YamlReader joints = map.at("joint_constraints", "a list of joint_name and position");
  VariableRanges given(problem.robot.model->variables.size());
  for (const YamlReader& constraint : joints.items())
    readJointConstraint(constraint, given, problem);
  return takeGoal(joints.file(), joints.line(), name, given, problem);
}

void readGoalConstraints(const YamlReader& request, Problem& problem) {
  const YamlReader goals = request.at("goal_constraints", "a list of goals");
  const std::vector<YamlReader> items = goals.items();
  if (items.empty()) goals.fail("goal_constraints is empty; at least one goal is expected");
  for (const YamlReader& item : items)
    problem.goals.push_back(readConstraints(
        item, items.size() == 1 ? "goal" : fmt::format("goal {}", problem.goals.size() + 1),
        problem));
}

void readPathConstraints(const YamlReader& request, Problem& problem) {
  const auto constraints = request.find("path_constraints");
  refuseContent(request, "trajectory_constraints", "a path without these");
  if (!hasContent(constraints)) return;
  refuseContent(*constraints, "visibility_constraints", "a path without these");
  if (const auto joints = constraints->find("joint_constraints"); hasContent(joints)) {
    std::vector<char> seen(problem.robot.model->variables.size(), 0);
    for (const YamlReader& constraint : joints->items()) readPathJoint(constraint, seen, problem);
  }
  if (const auto positions = constraints->find("position_constraints"); hasContent(positions))
    for (const YamlReader& constraint : positions->items())
      problem.constraints.push_back(readPathPosition(constraint, problem));
  if (const auto orientations = constraints->find("orientation_constraints");
      hasContent(orientations))
    for (const YamlReader& constraint : orientations->items())
      if (auto path = readPathOrientation(constraint, problem))
        problem.constraints.push_back(std::move(*path));
}

}  // namespace

void readRequestGroup(const YamlReader& request, Problem& problem) {
  const YamlReader name = request.at("group_name", "the group that moves");
  const Model& model = *problem.robot.model;
  const int group = model.findGroup(name.text());
  if (group < 0) {
    std::vector<std::string> known;
    for (const robots::Group& candidate : model.groups) known.push_back(candidate.name);
    name.fail(fmt::format("robot '{}' has no group '{}'{}", model.name, name.text(),
                          didYouMean(model, "group", name.text(), known)));
  }
  problem.robot.variables = model.groups[at(group)].variables;
  if (problem.robot.variables.empty())
    name.fail(fmt::format("group '{}' has no joint that can move; another group is expected",
                          name.text()));
}

void readRequestGoals(const YamlReader& request, Problem& problem) {
  // Limits that the path narrows hold for goals, too.
  readPathConstraints(request, problem);
  readGoalConstraints(request, problem);
}

}  // namespace leeway::planner
