// Reads group, start and goals of MoveIt's motion plan request (moveit_msgs/MotionPlanRequest).

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/robots/placed_model.h"
#include "planner/base/did_you_mean.h"
#include "planner/base/tolerances.h"
#include "planner/problem/moveit/fields.h"
#include "planner/problem/moveit/header_frames.h"
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

/// The variable that a message names, -1: none. MoveIt calls those of a floating joint
/// JOINT/trans_x and JOINT/rot_w.
int namedVariable(const Model& model, const std::string& name) {
  if (const int v = model.findVariable(name); v >= 0) return v;
  const std::size_t slash = name.rfind('/');
  if (slash == std::string::npos) return -1;
  const std::string joint = name.substr(0, slash + 1), axis = name.substr(slash + 1);
  if (axis.starts_with("trans_")) return model.findVariable(joint + axis.substr(6));
  if (axis.starts_with("rot_")) return model.findVariable(joint + 'q' + axis.substr(4));
  return -1;
}

/// One value of a moveit_msgs/RobotState.
struct StateValue {
  std::string name;
  int variable;  // -1: it names a joint without a variable, or no joint
  double value;
  YamlReader place;
};

/// The values of one moveit_msgs/RobotState.
class StateValues {
 public:
  explicit StateValues(Problem& problem) : problem_(problem), model_(*problem.robot.model) {}

  void read(const YamlReader& state, HeaderFrames& frames) {
    if (const auto joints = state.find("joint_state"); hasContent(joints)) {
      readJoints(*joints);
      warnOfVelocity(joints->find("velocity"));
    }
    if (const auto multi = state.find("multi_dof_joint_state"); hasContent(multi)) {
      frames.expectPlanningFrame(*multi);
      readMultiDof(*multi);
      warnOfVelocity(multi->find("twist"));
    }
  }
  const std::vector<StateValue>& values() const { return values_; }
  /// Null: the state does not have it.
  const StateValue* find(const StateValue& other) const {
    const auto found = places_.find(keyOf(other.name, other.variable));
    return found == places_.end() ? nullptr : &values_[found->second];
  }

 private:
  /// Whether all numbers in lists and maps are 0.
  static bool isZero(const YamlReader& value) {
    if (value.isEmpty()) return true;
    if (value.isScalar()) return value.number() == 0;
    if (!value.isMap()) {
      const auto items = value.items();
      return std::all_of(items.begin(), items.end(), isZero);
    }
    const auto fields = value.entries();
    return std::all_of(fields.begin(), fields.end(),
                       [](const auto& field) { return isZero(field.second); });
  }
  void warnOfVelocity(const std::optional<YamlReader>& rates) {
    if (rates && !isZero(*rates))
      problem_.warnings.push_back(fmt::format("{}:{}: {} is left out: paths start at rest",
                                              rates->file(), rates->line(), rates->where()));
  }

  std::string keyOf(const std::string& name, int variable) const {
    return variable < 0 ? name : model_.variables[at(variable)].name;
  }

  [[noreturn]] static void failTwice(const YamlReader& place, const std::string& name) {
    place.fail(fmt::format("joint '{}' stands twice in {}; once is expected", name, place.where()));
  }

  /// Files may give a planar or floating joint in both messages, with the same values.
  void add(const YamlReader& place, const std::string& name, int variable, double value) {
    const auto [entry, is_new] = places_.emplace(keyOf(name, variable), values_.size());
    if (is_new) return values_.push_back({name, variable, value, place});
    if (values_[entry->second].value != value) failTwice(place, name);
  }

  void readJoints(const YamlReader& joints) {
    const YamlReader names = joints.at("name", "a list of joint names"),
                     positions = joints.at("position", "a list of positions");
    const std::vector<YamlReader> name_items = names.items(), items = positions.items();
    if (name_items.size() != items.size())
      positions.fail(fmt::format("{} positions for {} names; equally many are expected",
                                 items.size(), name_items.size()));
    for (std::size_t i = 0; i < items.size(); ++i) {
      const std::string name = name_items[i].text();
      const int joint = model_.findJoint(name), v = namedVariable(model_, name);
      if (places_.count(keyOf(name, v)) != 0) failTwice(items[i], name);
      if (v < 0 && joint >= 0 && model_.joints[at(joint)].variable_count > 1)
        items[i].fail(
            fmt::format("joint '{}' has {} variables; its pose in multi_dof_joint_state is "
                        "expected",
                        name, model_.joints[at(joint)].variable_count));
      add(items[i], name, v, items[i].number());
    }
  }

  /// Reads {joint_names, transforms}: poses of planar and floating joints, mainly of the virtual
  /// joint.
  void readMultiDof(const YamlReader& multi) {
    const auto names = multi.find("joint_names");
    if (!hasContent(names)) return;
    const YamlReader transforms = multi.at("transforms", "a transform for each joint name");
    const std::vector<YamlReader> name_items = names->items(), items = transforms.items();
    if (name_items.size() != items.size())
      transforms.fail(fmt::format("{} transforms for {} joint_names; equally many are expected",
                                  items.size(), name_items.size()));
    for (std::size_t i = 0; i < items.size(); ++i) {
      const std::string name = name_items[i].text();
      const int index = model_.findJoint(name);
      const JointType type = index >= 0 ? model_.joints[at(index)].type : JointType::kFixed;
      if (type == JointType::kFloating)
        addFloating(items[i], name, model_.joints[at(index)]);
      else if (type == JointType::kPlanar)
        addPlanar(items[i], name, model_.joints[at(index)]);
      else if (!isIdentity(readMoveitPose(items[i], "translation", "rotation", problem_.warnings)))
        items[i].fail(
            fmt::format("joint '{}' is neither planar nor floating, but placed elsewhere; the "
                        "identity is expected",
                        name));
    }
  }

  void addFloating(const YamlReader& transform, const std::string& name,
                   const robots::Joint& joint) {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    Eigen::Vector4d q = Eigen::Vector4d::UnitW();
    if (const auto translation = transform.find("translation")) p = readMoveitVector(*translation);
    if (const auto rotation = transform.find("rotation"))
      q = readMoveitQuaternion(*rotation, problem_.warnings);
    for (int k = 0; k < 7; ++k)
      add(transform, name, joint.first_variable + k, k < 3 ? p[k] : q[k - 3]);
  }

  /// As in MoveIt, a planar joint takes x and y, and the turn about z.
  void addPlanar(const YamlReader& transform, const std::string& name, const robots::Joint& joint) {
    const Pose pose = readMoveitPose(transform, "translation", "rotation", problem_.warnings);
    if (pose.translation.z() != 0)
      problem_.warnings.push_back(
          fmt::format("{}:{}: planar joint '{}' is at z = {}; it has no z, and 0 is taken",
                      transform.file(), transform.line(), name, pose.translation.z()));
    if (joint.axis != Eigen::Vector3d::UnitZ() || !(pose.rotation(2, 2) >= 1 - kPlanarTilt))
      transform.fail(fmt::format(
          "planar joint '{}' is tilted; a turn about z, its normal, is expected", name));
    const double values[] = {pose.translation.x(), pose.translation.y(),
                             std::atan2(pose.rotation(1, 0), pose.rotation(0, 0))};
    for (int k = 0; k < 3; ++k) add(transform, name, joint.first_variable + k, values[k]);
  }

  /// The tilt that quaternions of six digits may have: 1 minus its cosine.
  static constexpr double kPlanarTilt = 1e-10;

  Problem& problem_;
  const Model& model_;
  std::vector<StateValue> values_;
  std::map<std::string, std::size_t> places_;  // in values_
};

/// Takes a value for the start. Fails for one outside the limits.
void takeStartValue(const StateValue& stated, VariableRanges& given, Problem& problem) {
  const Model& model = *problem.robot.model;
  const auto& [name, v, number, place] = stated;
  if (v < 0) {
    // Fixed and mimic joints may be named. A name without a joint belongs to another version of the
    // robot.
    if (model.findJoint(name) < 0)
      problem.warnings.push_back(
          fmt::format("{}:{}: the robot has no joint '{}', its position {} is not used",
                      place.file(), place.line(), name, number));
    return;
  }
  double value = number;
  const bool is_planned = isPlanned(problem, v);
  if (is_planned || boundsFault(model, v, value))
    takeOntoLimit(place, model.variables[at(v)], value, problem);
  // takeStart() would name the request's file, and the value may be the scene's.
  if (const auto fault =
          is_planned ? rangeFault(model, v, value, value) : boundsFault(model, v, value))
    place.fail("start has " + *fault);
  given[at(v)] = {true, value, value, place.line()};
}

/// Warns of a position that a fixed or mimic joint does not have at the start.
void warnOfFollower(const StateValue& stated, Problem& problem) {
  const Model& model = *problem.robot.model;
  const int j = stated.variable < 0 ? model.findJoint(stated.name) : -1;
  if (j < 0) return;
  const robots::KinematicStep& step = model.steps[at(j)];
  const bool follows = model.joints[at(j)].mimic >= 0;
  const double position =
      follows ? step.multiplier * problem.start[at(step.variable)] + step.offset : 0;
  if (std::abs(stated.value - position) <= kLimitSlack) return;
  problem.warnings.push_back(fmt::format(
      "{}:{}: joint '{}' {} {}; its position {} is not used", stated.place.file(),
      stated.place.line(), stated.name,
      follows ? "follows another joint and stands at" : "is fixed at", position, stated.value));
}

/// Warns of joints whose position is not in the files.
void warnOfUnstated(const YamlReader& place, const VariableRanges& given, Problem& problem) {
  const Model& model = *problem.robot.model;
  std::string names;
  for (const robots::Joint& joint : model.joints) {
    if (joint.variable_count == 0 || given[at(joint.first_variable)].given) continue;
    names += fmt::format("{}'{}'", names.empty() ? "" : ", ", joint.name);
    if (joint.variable_count == 1)
      names += fmt::format(" at {}", problem.start[at(joint.first_variable)]);
  }
  if (!names.empty())
    problem.warnings.push_back(
        fmt::format("{}:{}: neither the request nor the scene says where these joints are; they "
                    "are taken to be at rest at zero or the nearest limit: {}",
                    place.file(), place.line(), names));
}

std::optional<YamlReader> contentOf(const YamlReader& map, std::string_view key) {
  const auto value = map.find(key);
  return hasContent(value) ? value : std::nullopt;
}

}  // namespace

void readRequestStart(const YamlReader* scene, const YamlReader& request, HeaderFrames& frames,
                      Problem& problem) {
  StateValues requested(problem), of_scene(problem);
  const auto state = contentOf(request, "start_state");
  if (state) requested.read(*state, frames);
  if (scene != nullptr)
    if (const auto known = contentOf(*scene, "robot_state")) of_scene.read(*known, frames);
  if (requested.values().empty() && of_scene.values().empty())
    request.at("start_state", "the robot's start").at("joint_state", "name and position");
  // As in MoveIt, the request's state changes the scene's.
  VariableRanges given(problem.robot.model->variables.size());
  std::vector<StateValue> used = requested.values();
  for (const StateValue& value : of_scene.values())
    if (requested.find(value) == nullptr) used.push_back(value);
  for (const StateValue& value : used) takeStartValue(value, given, problem);
  const auto joints = state ? contentOf(*state, "joint_state") : std::nullopt;
  const YamlReader& place = joints ? *joints : state ? *state : request;
  takeStart(place.file(), place.line(), given, problem);
  for (const StateValue& value : used) warnOfFollower(value, problem);
  warnOfUnstated(place, given, problem);
  std::vector<double> scene_state = problem.start;
  for (const StateValue& value : of_scene.values())
    if (const StateValue* const other = requested.find(value);
        value.variable >= 0 && other != nullptr && other->value != value.value)
      scene_state[at(value.variable)] = value.value;
  frames.setSceneState(std::move(scene_state));
}

namespace {

/// The variable that an entry of joint_constraints names.
int constrainedVariable(const YamlReader& constraint, const Problem& problem) {
  const Model& model = *problem.robot.model;
  const YamlReader name = constraint.at("joint_name", "the name of a joint");
  const int v = namedVariable(model, name.text());
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
  const robots::Joint& joint = model.joints[at(v.joint)];
  return joint.type == JointType::kContinuous ||
         (joint.type == JointType::kPlanar && variable == joint.first_variable + 2) ||
         (joint.type == JointType::kRevolute && v.file_limits && std::isinf(v.file_limits->first));
}

constexpr double kTurn = 2 * std::numbers::pi;

/// The angle that equals `value` up to whole turns and is nearest to `near`.
double turnedNear(double value, double near) {
  return value + kTurn * std::round((near - value) / kTurn);
}

/// How far a joint may be from the position of its constraint.
struct Tolerance {
  double below, above;
};

/// The tolerances of an entry of joint_constraints. A tolerance of zero, which MotionBenchMaker
/// writes, means the exact position. MoveIt measures a free joint by the shorter way round, which
/// is half a turn at most.
Tolerance toleranceOf(const YamlReader& constraint, bool turns_freely) {
  const auto tolerance = [&](const char* key) {
    const auto found = constraint.find(key);
    const double value = found ? found->sizeNumber() : 0;
    return turns_freely ? std::min(value, std::numbers::pi) : value;
  };
  return {tolerance("tolerance_below"), tolerance("tolerance_above")};
}

/// The angle that equals `value` up to whole turns, is in the limits of the variable, and of these
/// is the nearest to `near`. If none is, the same for angles whose tolerance meets the limits;
/// else the nearest of all.
double turnedWithin(const robots::Variable& variable, double value, const Tolerance& tolerance,
                    double near) {
  const double turns = std::round((near - value) / kTurn);
  for (const auto& [below, above] : {Tolerance{0, 0}, tolerance}) {
    const double least = std::ceil((variable.lower - kLimitSlack - above - value) / kTurn);
    const double most = std::floor((variable.upper + kLimitSlack + below - value) / kTurn);
    if (least <= most) return value + kTurn * std::clamp(turns, least, most);
  }
  return value + kTurn * turns;
}

void readJointConstraint(const YamlReader& constraint, VariableRanges& given, Problem& problem) {
  const Model& model = *problem.robot.model;
  const YamlReader position = constraint.at("position", "a number");
  const int v = constrainedVariable(constraint, problem);
  const robots::Variable& variable = model.variables[at(v)];
  if (given[at(v)].given)
    constraint.fail(fmt::format("joint '{}' has two constraints; one is expected", variable.name));
  double value = position.number();
  const bool is_free = turnsFreely(model, v);
  const Tolerance tolerance = toleranceOf(constraint, is_free);
  // A path constraint or `bounds` limit a free joint to some of its turns.
  if (is_free && std::isfinite(variable.lower))
    value = turnedWithin(variable, value, tolerance, problem.start[at(v)]);
  if (isPlanned(problem, v)) takeOntoLimit(position, variable, value, problem);
  double lower = value - tolerance.below, upper = value + tolerance.above;
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
  const Tolerance tolerance = toleranceOf(constraint, is_free);
  if (is_free && tolerance.below + tolerance.above >= kTurn) return;
  const double middle = is_free ? turnedNear(position.number(), start) : position.number();
  const double lower = middle - tolerance.below, upper = middle + tolerance.above;
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

Goal readConstraints(const YamlReader& map, const std::string& name, HeaderFrames& frames,
                     Problem& problem) {
  refuseContent(map, "visibility_constraints", "a goal of joints or poses");
  Goal goal{name, {}, {}};
  if (const auto positions = map.find("position_constraints"); hasContent(positions))
    for (const YamlReader& constraint : positions->items())
      goal.poses.push_back(readPositionConstraint(constraint, frames, problem));
  if (const auto orientations = map.find("orientation_constraints"); hasContent(orientations))
    for (const YamlReader& constraint : orientations->items())
      goal.poses.push_back(readOrientationConstraint(constraint, frames, problem));
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

void readGoalConstraints(const YamlReader& request, HeaderFrames& frames, Problem& problem) {
  const YamlReader goals = request.at("goal_constraints", "a list of goals");
  const std::vector<YamlReader> items = goals.items();
  if (items.empty()) goals.fail("goal_constraints is empty; at least one goal is expected");
  for (const YamlReader& item : items)
    problem.goals.push_back(readConstraints(
        item, items.size() == 1 ? "goal" : fmt::format("goal {}", problem.goals.size() + 1), frames,
        problem));
}

void readPathConstraints(const YamlReader& request, HeaderFrames& frames, Problem& problem) {
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
      readPathPosition(constraint, frames, problem);
  if (const auto orientations = constraints->find("orientation_constraints");
      hasContent(orientations))
    for (const YamlReader& constraint : orientations->items())
      readPathOrientation(constraint, frames, problem);
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

void readRequestGoals(const YamlReader& request, HeaderFrames& frames, Problem& problem) {
  // Limits that the path narrows hold for goals, too.
  readPathConstraints(request, frames, problem);
  readGoalConstraints(request, frames, problem);
}

}  // namespace leeway::planner
