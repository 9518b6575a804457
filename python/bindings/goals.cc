#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

#include "leeway/robots/groups.h"
#include "leeway/robots/text.h"
#include "python/base/at.h"
#include "python/base/define.h"
#include "python/bindings/settings.h"

namespace leeway::python {
namespace {

using Range = std::pair<double, double>;

/// What 'any' means of a position [m], as in problem files: no robot reaches as far.
constexpr double kAnyPosition = 1e6;
constexpr double kLargestAngle = 1e3;  ///< as in problem files [rad]

std::size_t count(const planner::Problem& problem) { return problem.robot.variables.size(); }

// ---- Ranges.

bool isRange(const py::handle& value) {
  return py::isinstance<py::tuple>(value) || py::isinstance<py::list>(value) ||
         (py::isinstance<py::array>(value) && py::reinterpret_borrow<py::array>(value).ndim() == 1);
}

Range rangeOf(const py::handle& value, const std::string& name) {
  const std::vector<double> range = numbers(value, name.c_str(), 2);
  if (range[0] > range[1])
    throw py::value_error(name + " is from " + text(range[0]) + " to " + text(range[1]) +
                          "; from <= to is expected");
  return {range[0], range[1]};
}

Range rangeOf(const planner::Problem& problem, int variable, const py::handle& value) {
  const robots::Variable& v = problem.robot.model->variables[at(variable)];
  if (py::isinstance<py::str>(value)) {
    if (const std::string given = word(value, "goal"); given != "any")
      unknownWord("goal", given, "a number, (from, to) or 'any'");
    if (std::isfinite(v.lower) && std::isfinite(v.upper)) {
      return {v.lower, v.upper};
    }
    const robots::Joint& joint = problem.robot.model->joints[at(v.joint)];
    const bool turns =
        joint.type == robots::JointType::kContinuous ||
        (joint.type == robots::JointType::kPlanar && variable == joint.first_variable + 2);
    if (turns) return {-std::numbers::pi, std::numbers::pi};
    throw py::value_error("goal: joint '" + v.name + "' is 'any', but has no limits");
  }
  if (isRange(value)) return rangeOf(value, "goal of " + v.name);
  const double given = number(value, ("goal of " + v.name).c_str());
  return {given, given};
}

// ---- Poses.

/// Three numbers, pairs (from, to) or 'any'.
std::array<Range, 3> rangesOf(const py::object& value, const char* name, double any, double most) {
  std::array<Range, 3> ranges;
  const auto three = py::list(value);
  if (three.size() != 3)
    throw py::value_error(std::string(name) + " holds " + std::to_string(three.size()) +
                          " values; 3 are expected");
  for (std::size_t i = 0; i < 3; ++i) {
    const py::handle item = three[i];
    if (py::isinstance<py::str>(item)) {
      const std::string word = py::str(item);
      if (word != "any") unknownWord(name, word, "a number, (from, to) or 'any'");
      ranges[i] = {-any, any};
    } else if (isRange(item)) {
      ranges[i] = rangeOf(item, name);
    } else {
      ranges[i].first = ranges[i].second = number(item, name);
    }
    const double farthest = std::max(std::abs(ranges[i].first), std::abs(ranges[i].second));
    if (farthest > most)
      throw py::value_error(std::string(name) + " holds " + text(farthest) + "; at most " +
                            text(most) + " is expected");
  }
  return ranges;
}

/// Single turns about x, about x and y, or about all move from the ranges into the rotation, as
/// problem files do: an exact pose then has no angle near a pitch of 90 degrees.
void takeExactTurns(planner::FramePose& pose) {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 3 && pose.rpy[i].first == pose.rpy[i].second; ++i) {
    turn[static_cast<Eigen::Index>(i)] = pose.rpy[i].first;
    pose.rpy[i] = {0, 0};
  }
  pose.rotation = robots::rotationOf(turn);
}

/// A tolerance given without what it belongs to would be ignored.
void expectBeside(const py::object& tolerance, const char* name, bool is_there, const char* what) {
  if (!tolerance.is_none() && !is_there)
    throw py::value_error(std::string(name) + " is given without " + what +
                          ", whose it is; both are expected");
}

double toleranceOf(const py::object& given, const char* name, double otherwise) {
  const double value = given.is_none() ? otherwise : number(given, name);
  if (!(value >= robots::kLeastPoseTolerance) || std::isinf(value))
    throw py::value_error(std::string(name) + " is " + text(value) + "; at least " +
                          text(robots::kLeastPoseTolerance) + " is expected");
  return value;
}

FramePose makePose(const std::string& frame, const py::object& position,
                   const py::object& orientation, const py::object& rpy,
                   const py::object& relative_to, const py::object& position_tolerance,
                   const py::object& angle_tolerance) {
  if (position.is_none() && orientation.is_none() && rpy.is_none())
    throw py::value_error("nothing says where; position, and rpy or orientation are expected");
  if (!orientation.is_none() && !rpy.is_none())
    throw py::value_error("orientation and rpy are both given; one is expected");
  planner::FramePose made;
  made.frame = frame;
  if (!relative_to.is_none()) made.relative_to = word(relative_to, "relative_to");
  made.position.fill({-kAnyPosition, kAnyPosition});
  if (!position.is_none())
    made.position = rangesOf(position, "position", kAnyPosition, kAnyPosition);
  if (!orientation.is_none()) {
    made.rpy.fill({0, 0});
    made.rotation = pose(py::none(), orientation, py::none()).rotation;
  } else {
    made.rpy.fill({-std::numbers::pi, std::numbers::pi});
    if (!rpy.is_none()) made.rpy = rangesOf(rpy, "rpy", std::numbers::pi, kLargestAngle);
    takeExactTurns(made);
  }
  expectBeside(position_tolerance, "position_tolerance", !position.is_none(), "position");
  expectBeside(angle_tolerance, "angle_tolerance", !orientation.is_none() || !rpy.is_none(),
               "orientation or rpy");
  made.position_tolerance =
      toleranceOf(position_tolerance, "position_tolerance", made.position_tolerance);
  made.angle_tolerance = toleranceOf(angle_tolerance, "angle_tolerance", made.angle_tolerance);
  return {made};
}

planner::Constraint makeConstraint(const std::string& frame, const py::object& position,
                                   const py::object& orientation, const py::object& rpy,
                                   const py::object& axis, const py::object& direction,
                                   const py::object& relative_to,
                                   const py::object& position_tolerance, const py::object& angle,
                                   const py::object& name) {
  planner::Constraint made;
  made.frame = frame;
  if (!name.is_none()) made.name = py::str(name);
  if (!relative_to.is_none()) made.relative_to = word(relative_to, "relative_to");
  if (!position.is_none())
    made.position = rangesOf(position, "position", std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::infinity());
  expectBeside(position_tolerance, "position_tolerance", !position.is_none(), "position");
  if (!position_tolerance.is_none())
    made.position_tolerance = number(position_tolerance, "position_tolerance");
  expectBeside(angle, "angle", !orientation.is_none() || !rpy.is_none() || !axis.is_none(),
               "axis, orientation or rpy");
  if (int{!orientation.is_none()} + int{!rpy.is_none()} + int{!axis.is_none()} > 1)
    throw py::value_error("more than one of orientation, rpy and axis is given; one is expected");
  if (!orientation.is_none()) made.rotation = pose(py::none(), orientation, py::none()).rotation;
  if (!rpy.is_none()) made.rotation = robots::rotationOf(vector3(rpy, "rpy"));
  if (!orientation.is_none() || !rpy.is_none()) made.turn = planner::Constraint::Turn::kFixed;
  if (!axis.is_none()) {
    made.turn = planner::Constraint::Turn::kAxis;
    made.axis = vector3(axis, "axis");
  }
  if (angle.is_none() && !axis.is_none())
    throw py::value_error(
        "axis is given without angle, how far it may be off [rad]; both are expected");
  if (!angle.is_none()) made.angle = number(angle, "angle");
  if (!direction.is_none()) {
    if (axis.is_none()) throw py::value_error("direction is given without axis; both are expected");
    made.direction = vector3(direction, "direction");
  }
  return made;
}

py::array_t<double> rangeArray(const std::array<Range, 3>& ranges) {
  std::vector<double> values;
  for (const auto& [lower, upper] : ranges) values.insert(values.end(), {lower, upper});
  return array(std::move(values), {3, 2});
}

}  // namespace

int variableOf(const planner::Problem& problem, const std::string& name) {
  const int variable = problem.robot.model->findVariable(name);
  if (variable >= 0) return variable;
  std::vector<std::string> known;
  for (const robots::Variable& v : problem.robot.model->variables) known.push_back(v.name);
  const std::string* const near = robots::nearestName(name, known);
  throw py::value_error("no joint '" + name + "'" +
                        (near != nullptr ? "; did you mean '" + *near + "'?" : ""));
}

namespace {

/// The problem as if the group of this name alone were planned; nothing for a joint's name, and for
/// one that is unknown.
std::optional<planner::Problem> ofGroup(const planner::Problem& problem, const std::string& name) {
  const robots::Model& model = *problem.robot.model;
  const int group = model.findVariable(name) < 0 ? model.findGroup(name) : -1;
  if (group < 0) return std::nullopt;
  planner::Problem alone = problem;
  alone.robot.variables = model.groups[at(group)].variables;
  return alone;
}

/// Adds the poses of a group, which one of its joints must move.
void addPosesOfGroup(const planner::Problem& problem, const planner::Problem& group,
                     const std::string& name, const std::vector<FramePose>& poses,
                     std::vector<robots::PoseRegion>& regions) {
  for (const robots::PoseRegion& region : regionsOf(problem, poses)) {
    const robots::Model& model = *problem.robot.model;
    if (!robots::movesLink(model, group.robot.variables, region.link))
      throw py::value_error("no joint of group '" + name + "' moves '" +
                            model.links[at(region.link)].name +
                            "'; a pose of a frame that it moves is expected");
    regions.push_back(region);
  }
}

[[noreturn]] void refuseMixed(const char* what) {
  throw py::value_error(std::string(what) +
                        " has joint values beside the pose of a group; poses alone, beside them "
                        "'any', or joint values alone are expected");
}

/// A goal by joint and group: {'left': 'up', 'elbow': (0, 1)}, or {'left': Pose(...), ...}.
planner::Goal goalOfMap(const planner::Problem& problem, const py::dict& goal, bool of_group) {
  const robots::Model& model = *problem.robot.model;
  planner::Goal result;
  result.name = "goal";
  std::map<int, Range> given;
  bool has_values = false;
  const auto give = [&](int variable, const Range& range) {
    if (!given.emplace(variable, range).second)
      throw py::value_error("goal gives joint '" + model.variables[at(variable)].name +
                            "' twice; once is expected");
  };
  for (const auto& [key, value] : goal) {
    const std::string name = py::str(key);
    const auto item = py::reinterpret_borrow<py::object>(value);
    const std::optional<planner::Problem> group = ofGroup(problem, name);
    const bool is_any = py::isinstance<py::str>(item) && word(item, "goal") == "any";
    if (group && of_group && group->robot.variables.size() >= problem.robot.variables.size())
      throw py::value_error("goal has the group '" + name +
                            "' within one that is not larger; joints are expected");
    if (group)
      if (const std::vector<FramePose> poses = framePoses(item); !poses.empty()) {
        addPosesOfGroup(problem, *group, name, poses, result.poses);
        continue;
      }
    has_values = has_values || !group || !is_any;
    if (!group) {
      const int variable = variableOf(problem, name);
      give(variable, rangeOf(problem, variable, value));
    } else if (is_any) {
      for (const int variable : group->robot.variables)
        give(variable, rangeOf(problem, variable, item));
    } else {
      const planner::Goal own = goalOf(*group, item, true);
      for (std::size_t i = 0; i < own.ranges.size(); ++i)
        give(group->robot.variables[i], own.ranges[i]);
    }
  }
  if (!result.poses.empty()) {
    if (has_values) refuseMixed("goal");
    return result;
  }
  for (const int variable : problem.robot.variables) {
    const auto found = given.find(variable);
    if (found == given.end())
      throw py::value_error("goal says nothing of joint '" + model.variables[at(variable)].name +
                            "'");
    result.ranges.push_back(found->second);
    given.erase(found);
  }
  if (!given.empty())
    throw py::value_error("goal names joint '" + model.variables[at(given.begin()->first)].name +
                          "', which is not planned");
  return result;
}

}  // namespace

planner::Goal goalOf(const planner::Problem& problem, const py::object& goal, bool of_group) {
  planner::Goal result;
  result.name = "goal";
  if (const std::vector<FramePose> poses = framePoses(goal); !poses.empty()) {
    result.poses = regionsOf(problem, poses);
    return result;
  }
  if (py::isinstance<py::str>(goal)) {
    result.name = word(goal, "goal");
    const Robot robot(problem.robot.model, problem.robot.variables);
    for (const double value : namedState(robot, result.name))
      result.ranges.emplace_back(value, value);
    return result;
  }
  if (py::isinstance<py::dict>(goal))
    return goalOfMap(problem, py::reinterpret_borrow<py::dict>(goal), of_group);
  // A list of numbers, ranges and words; else an array.
  if (py::isinstance<py::list>(goal) || py::isinstance<py::tuple>(goal)) {
    const auto list = py::reinterpret_borrow<py::sequence>(goal);
    if (py::len(list) != count(problem))
      throw py::value_error("goal holds " + std::to_string(py::len(list)) + " values; " +
                            std::to_string(count(problem)) + " are expected");
    for (std::size_t i = 0; i < count(problem); ++i)
      result.ranges.push_back(rangeOf(problem, problem.robot.variables[i], list[i]));
    return result;
  }
  if (py::isinstance<py::array>(goal) && goal.cast<py::array>().ndim() == 2)
    return goalOf(problem, goal.attr("tolist")());  // ranges, as goalObject() gives them
  for (const double value : numbers(goal, "goal", count(problem)))
    result.ranges.emplace_back(value, value);
  return result;
}

namespace {

/// Sets the planned values in `q`: those of a group state, by joint, or in order.
void setValues(const planner::Problem& problem, const py::object& values, const std::string& what,
               std::vector<double>& q) {
  const Robot robot(problem.robot.model, problem.robot.variables);
  if (py::isinstance<py::dict>(values)) {
    for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(values)) {
      const std::string name = py::str(key);
      const int variable = variableOf(problem, name);
      const std::vector<int>& own = problem.robot.variables;
      if (std::find(own.begin(), own.end(), variable) == own.end())
        throw py::value_error(what + " names joint '" + name + "', which the group does not have");
      q[at(variable)] = number(value, (what + "." + name).c_str());
    }
    return;
  }
  const std::vector<double> point = py::isinstance<py::str>(values)
                                        ? namedState(robot, word(values, what.c_str()))
                                        : numbers(values, what.c_str(), count(problem));
  robot.expand(point, q);
}

}  // namespace

void setStart(planner::Problem& problem, const py::object& start) {
  if (start.is_none()) return;
  if (const std::vector<FramePose> poses = framePoses(start); !poses.empty()) {
    problem.start_poses = regionsOf(problem, poses);
    return;
  }
  std::vector<double> q = problem.start;
  if (py::isinstance<py::dict>(start)) {
    std::vector<robots::PoseRegion> regions;
    bool has_values = false;
    // A joint that the map leaves out would keep an old value: the robot may be elsewhere.
    std::vector<double> given(q.size(), std::numeric_limits<double>::quiet_NaN());
    for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(start)) {
      const std::string name = py::str(key);
      const auto item = py::reinterpret_borrow<py::object>(value);
      const std::optional<planner::Problem> group = ofGroup(problem, name);
      const std::vector<FramePose> poses = group ? framePoses(item) : std::vector<FramePose>();
      if (!poses.empty()) {
        addPosesOfGroup(problem, *group, name, poses, regions);
        continue;
      }
      has_values = true;
      std::vector<double> own(q.size(), std::numeric_limits<double>::quiet_NaN());
      if (group)
        setValues(*group, item, "start of " + name, own);
      else
        own[at(variableOf(problem, name))] = number(value, ("start of " + name).c_str());
      for (std::size_t v = 0; v < own.size(); ++v) {
        if (std::isnan(own[v])) continue;
        if (!std::isnan(given[v]))
          throw py::value_error("start gives joint '" + problem.robot.model->variables[v].name +
                                "' twice; once is expected");
        q[v] = given[v] = own[v];
      }
    }
    if (!regions.empty()) {
      if (has_values) refuseMixed("start");
      problem.start_poses = std::move(regions);
      return;
    }
    for (const int variable : problem.robot.variables)
      if (std::isnan(given[at(variable)]))
        throw py::value_error("start says nothing of joint '" +
                              problem.robot.model->variables[at(variable)].name +
                              "'; a value for every planned joint is expected");
  } else {
    setValues(problem, start, "start", q);
  }
  problem.start = std::move(q);
  problem.start_poses.clear();
}

void setGoals(planner::Problem& problem, const py::object& goal, bool several) {
  std::vector<planner::Goal> goals;
  if (goal.is_none()) {
    // None yet: plan() will ask for one.
  } else if (several) {
    for (const py::handle item : py::list(goal))
      goals.push_back(goalOf(problem, py::reinterpret_borrow<py::object>(item)));
    for (std::size_t i = 1; i < goals.size(); ++i)
      if (goals[i].name == "goal") goals[i].name += " " + std::to_string(i + 1);
  } else {
    goals.push_back(goalOf(problem, goal));
  }
  problem.goals = std::move(goals);
}

py::object goalObject(const planner::Problem& problem, const planner::Goal& goal) {
  if (!goal.poses.empty()) return framePoseList(problem, goal.poses);
  std::vector<double> values;
  for (const auto& [lower, upper] : goal.ranges) values.insert(values.end(), {lower, upper});
  return array(std::move(values), {static_cast<py::ssize_t>(goal.ranges.size()), 2});
}

void setConstraints(planner::Problem& problem, const py::object& constraints) {
  std::vector<planner::Constraint> made;
  for (const py::handle item : constraints.is_none() ? py::list() : py::list(constraints)) {
    if (!py::isinstance<planner::Constraint>(item))
      throw py::type_error(std::string("constraints hold a ") + Py_TYPE(item.ptr())->tp_name +
                           "; Constraints are expected");
    made.push_back(item.cast<const planner::Constraint&>());
    if (made.back().name.empty()) made.back().name = "constraint " + std::to_string(made.size());
  }
  problem.constraints = std::move(made);
}

py::object constraintList(const planner::Problem& problem) {
  py::list list;
  for (const planner::Constraint& constraint : problem.constraints) list.append(constraint);
  return py::object(list);
}

std::vector<FramePose> framePoses(const py::object& value) {
  if (py::isinstance<FramePose>(value)) return {value.cast<const FramePose&>()};
  std::vector<FramePose> poses;
  if (!py::isinstance<py::list>(value) && !py::isinstance<py::tuple>(value)) return poses;
  const auto list = py::reinterpret_borrow<py::sequence>(value);
  for (const py::handle item : list)
    if (py::isinstance<FramePose>(item)) poses.push_back(item.cast<const FramePose&>());
  if (!poses.empty() && poses.size() != list.size())
    throw py::type_error("a list holds poses and something else; poses alone are expected");
  return poses;
}

std::vector<robots::PoseRegion> regionsOf(const planner::Problem& problem,
                                          const std::vector<FramePose>& poses) {
  std::vector<robots::PoseRegion> regions;
  for (const FramePose& pose : poses) {
    // One that a problem held says where it is; its link is looked up all the same.
    planner::FramePose named = pose.given;
    if (pose.found) named.relative_to.clear();
    regions.push_back(planner::poseRegion(problem, named));
    if (!pose.found) continue;
    regions.back().X_LF = pose.found->X_LF;
    regions.back().X_WR = pose.found->X_WR;
  }
  return regions;
}

py::list framePoseList(const planner::Problem& problem,
                       const std::vector<robots::PoseRegion>& regions) {
  py::list poses;
  for (const robots::PoseRegion& region : regions) {
    FramePose pose{{}, FramePose::Found{region.X_LF, region.X_WR}};
    pose.given.frame = problem.robot.model->links[at(region.link)].name;
    pose.given.position = region.position;
    pose.given.rpy = region.rpy;
    pose.given.position_tolerance = region.position_tolerance;
    pose.given.angle_tolerance = region.angle_tolerance;
    poses.append(pose);
  }
  return poses;
}

std::vector<std::pair<std::string, std::string>> namePairs(const planner::Problem& problem,
                                                           py::handle item, const char* name) {
  const auto isTuple = [](py::handle value) {
    return py::isinstance<py::tuple>(value) || py::isinstance<py::list>(value);
  };
  const auto fail = [&] {
    throw py::type_error(std::string(name) + " holds " + shown(item) +
                         "; pairs (a, b) of different names, or of tuples of names, are expected");
  };
  if (!isTuple(item) || py::len(item) != 2) fail();
  std::vector<std::string> sides[2];
  std::vector<std::string> robot;
  for (const robots::Link& link : problem.robot.model->links) robot.push_back(link.name);
  for (const planner::Attachment& held : problem.robot.attachments)
    robot.push_back(held.object.name);
  const planner::World& world = problem.world;
  const auto isThing = [&](const std::string& given) {
    return hasObject(world, given) || std::find(robot.begin(), robot.end(), given) != robot.end();
  };
  const auto add = [&](py::handle member, std::vector<std::string>& side) {
    if (!py::isinstance<py::str>(member)) fail();
    const std::string given = py::str(member);
    if (given == "robot" &&
        (robot.size() == 1 || std::find(robot.begin(), robot.end(), given) == robot.end()))
      return void(side.insert(side.end(), robot.begin(), robot.end()));
    if (given == "robot")
      throw py::value_error(std::string(name) +
                            ": 'robot' is the name of a link, and stands for all links and what "
                            "they hold; a group of "
                            "the links that are meant is expected");
    if (isThing(given)) return side.push_back(given);
    std::vector<std::string> known = robot;
    for (const std::string& object : objectNames(world)) known.push_back(object);
    const std::string* const near = robots::nearestName(given, known);
    throw py::value_error(std::string(name) + ": no link or object is named '" + given + "'" +
                          (near != nullptr ? "; did you mean '" + *near + "'?" : ""));
  };
  const auto pair = py::reinterpret_borrow<py::sequence>(item);
  const auto isWord = [](const py::object& side, const char* word) {
    return py::isinstance<py::str>(side) && std::string(py::str(side)) == word;
  };
  // In margins words stay words, so that they hold for what comes later, too.
  const bool takes_words = std::string(name) == "margins";
  const auto isRobot = [&](const py::object& side) {
    return takes_words && isWord(side, "robot") && !isThing("robot");
  };
  for (std::size_t i = 0; i < 2; ++i) {
    const py::object side = pair[i];
    if ((takes_words && isWord(side, "world")) || isRobot(side))
      sides[i].push_back(py::str(side));
    else if (isWord(side, "world") && !isThing("world"))
      throw py::value_error(std::string(name) +
                            ": 'world' stands for all objects in margins only; the names of the "
                            "objects that are meant are expected");
    else if (isTuple(side))
      for (const py::handle member : side) add(member, sides[i]);
    else
      add(side, sides[i]);
  }
  if (isRobot(pair[0]) && isRobot(pair[1])) return {{"robot", "robot"}};
  if (sides[0] == sides[1] && sides[0].size() == 1)
    throw py::value_error(std::string(name) + ": '" + sides[0][0] +
                          "' stands twice; two different names of links or objects are expected");
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const std::string& a : sides[0])
    for (const std::string& b : sides[1])
      if (a != b) pairs.emplace_back(a, b);
  return pairs;
}

namespace {

void defineConstraint(py::module_& module) {
  using planner::Constraint;
  const std::string init =
      "(frame, position=None, orientation=None, rpy=None, *, axis=None, direction=None, "
      "relative_to=None, position_tolerance=None, angle=None, name=None)";
  auto constraint = defineClass<py::class_<Constraint>>(
      module, "Constraint", init,
      "What a frame (a frame of the problem, a link or a held object) keeps on all of a path: "
      "proven everywhere, as margins are.\n\n"
      "position: (x, y, z) of its origin [m]; in place of a number a pair (from, to) or 'any'; "
      "to within position_tolerance, 0.001 by default [m]. Of its rotation: orientation (x y z "
      "w) or rpy [rad]; "
      "or that its own axis (x, y, z) points along direction, up by default; to within angle "
      "[rad], 0.01 by default for a rotation. relative_to: an object, a frame, a link or a "
      "held "
      "object, which may move, too; None: the world.",
      makeConstraint);
  defineCopiesOfConstant(constraint);
  defineConstant(constraint, "frame", &Constraint::frame, "The frame's name.");
  defineConstant(constraint, "name", &Constraint::name, "Its name in messages and results.");
  constraint.def("__repr__", [](const Constraint& self) {
    return "<leeway.Constraint" + (self.name.empty() ? "" : " '" + self.name + "'") + " of '" +
           self.frame + "'>";
  });
}

}  // namespace

void defineGoals(py::module_& module) {
  defineConstraint(module);
  const std::string init =
      "(frame, position=None, orientation=None, rpy=None, *, relative_to=None, "
      "position_tolerance=None, angle_tolerance=None)";
  auto pose = defineClass<py::class_<FramePose>>(
      module, "FramePose", init,
      "Where a frame (a frame of the problem, a link or a held object) may be, as a goal or a "
      "start: goal=FramePose('hand', ...); a list of them holds all at once.\n\n"
      "position: (x, y, z) [m]; rpy: (roll, pitch, yaw) [rad]; in place of a number a pair "
      "(from, to) or 'any'. orientation: x y z w. Without them: any. relative_to: an object, "
      "or "
      "a frame or link at rest; None: the world. A solution is at most position_tolerance [m] "
      "and "
      "angle_tolerance [rad] outside, 1e-9 by default. "
      "Names are looked up when a problem takes it.",
      makePose);
  defineCopiesOfConstant(pose);
  defineConstant(
      pose, "frame", [](const FramePose& self) { return self.given.frame; },
      "The frame's name; of one that a problem has looked up, its link's.");
  defineConstant(
      pose, "position", [](const FramePose& self) { return rangeArray(self.given.position); },
      "Ranges of its origin: (3, 2) [m].");
  defineConstant(
      pose, "rpy", [](const FramePose& self) { return rangeArray(self.given.rpy); },
      "Ranges of roll, pitch and yaw besides what is exact: (3, 2) [rad].");
  pose.def("__repr__", [](const FramePose& self) {
    return "<leeway.FramePose of '" + self.given.frame + "'" +
           (self.found                       ? " as a problem holds it"
            : self.given.relative_to.empty() ? " in the world"
                                             : " relative to '" + self.given.relative_to + "'") +
           ">";
  });
}

}  // namespace leeway::python
