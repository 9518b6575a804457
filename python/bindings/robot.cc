#include "python/bindings/robot.h"

#include <algorithm>
#include <filesystem>
#include <limits>

#include "leeway/planner/problem.h"
#include "leeway/robots/cache_folder.h"
#include "leeway/robots/groups.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/named_states.h"
#include "leeway/robots/placed_model.h"
#include "leeway/robots/text.h"
#include "python/base/arrays.h"
#include "python/base/at.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/shapes.h"

namespace leeway::python {
namespace {

template <typename Things>
std::vector<std::string> namesOfThings(const Things& things) {
  std::vector<std::string> names;
  for (const auto& thing : things) names.push_back(thing.name);
  return names;
}

[[noreturn]] void unknown(const char* what, const std::string& name,
                          const std::vector<std::string>& known) {
  const std::string* const near = robots::nearestName(name, known);
  std::string message = std::string("no ") + what + " '" + name + "'";
  if (near != nullptr) message += "; did you mean '" + *near + "'?";
  throw py::value_error(message);
}

/// `why`: the end of a message, empty for a name that is not left out.
void refuseLeftOut(const char* what, const std::string& name, const std::string& why) {
  if (!why.empty()) throw py::value_error("no " + std::string(what) + " '" + name + "'" + why);
}

std::vector<int> plannedVariables(const robots::Model& model,
                                  const std::vector<std::string>& groups) {
  for (const std::string& name : groups)
    if (!robots::isGroup(model, name)) {
      refuseLeftOut("group", name, model.whyLeftOut("group", name));
      std::vector<std::string> known = namesOfThings(model.groups);
      const std::vector<std::string> joints = namesOfThings(model.joints);
      known.insert(known.end(), joints.begin(), joints.end());
      unknown("group", name, known);
    }
  if (const std::string fault = robots::groupsFault(model, groups); !fault.empty())
    throw py::value_error(fault);
  return robots::variablesOf(model, groups);
}

robots::LoadOptions loadOptions(const py::object& packages, const py::object& meshes, bool cache) {
  robots::LoadOptions options;
  options.meshes = treatments(meshes);
  if (!packages.is_none())
    for (const auto& [name, folder] : py::dict(packages)) {
      options.packages.emplace_back(py::str(name), py::str(folder));
      const auto& [package, directory] = options.packages.back();
      if (!std::filesystem::is_directory(directory))
        throw py::value_error("package '" + package + "' has no folder '" + directory +
                              "'; an existing folder is expected");
    }
  if (cache) options.cache = robots::cacheFolder();
  return options;
}

/// {joint: (lower, upper)}, {joint: {'range': (lower, upper), 'widen': True}}, and {joint: {axis:
/// (lower, upper)}} of planar and floating joints.
robots::JointBounds jointBounds(const py::object& bounds) {
  if (!py::isinstance<py::dict>(bounds))
    throw py::type_error(
        "bounds: {joint: (lower, upper)} or {joint: {'x': (lower, upper), 'y': ...}} is expected");
  robots::JointBounds read;
  for (const auto& [joint, given] : py::reinterpret_borrow<py::dict>(bounds)) {
    const std::string name = py::str(joint);
    read[name];  // withBounds() refuses a joint without any
    const auto add = [&](const std::string& axis, py::handle range, bool widens) {
      const std::string what = "bounds: " + name + (axis.empty() ? "" : "." + axis);
      const std::vector<double> ends = numbers(range, what.c_str(), 2);
      read[name].insert_or_assign(axis, robots::JointBound{ends[0], ends[1], widens});
    };
    if (!py::isinstance<py::dict>(given)) {
      add("", given, false);
      continue;
    }
    const auto axes = py::reinterpret_borrow<py::dict>(given);
    const bool has_range = axes.contains("range");
    for (const auto& [key, value] : axes) {
      const std::string axis = py::str(key);
      if (has_range && axis != "range" && axis != "widen")
        throw py::value_error("bounds: " + name + " has '" + axis +
                              "' beside 'range'; 'range' and 'widen' are expected");
      if (!has_range && axis == "widen")
        throw py::value_error("bounds: " + name +
                              " has no 'range' beside 'widen'; both are expected");
      if (axis == "widen") continue;
      bool widens = false;
      if (has_range && axes.contains("widen")) {
        if (!py::isinstance<py::bool_>(axes["widen"]))
          throw py::type_error("bounds: " + name + ".widen: True or False is expected");
        widens = axes["widen"].cast<bool>();
      }
      add(has_range ? "" : axis, value, widens);
    }
  }
  return read;
}

/// The joints between two links.
std::vector<int> chainVariables(const robots::Model& model, const py::object& chain) {
  std::vector<int> ends;
  if (py::isinstance<py::list>(chain) || py::isinstance<py::tuple>(chain))
    for (const py::handle name : chain) {
      const std::string link = py::str(name);
      ends.push_back(model.findLink(link));
      if (ends.back() < 0) unknown("link", link, namesOfThings(model.links));
    }
  if (ends.size() != 2)
    throw py::type_error("chain is " + shown(chain) +
                         "; a pair of links, (base, tip), is expected");
  std::vector<int> variables = robots::chainVariables(model, ends[0], ends[1]);
  if (variables.empty())
    throw py::value_error(
        "chain: no joint between the links can move by itself; two links with "
        "such a joint between them are expected");
  return variables;
}

Robot loadRobot(const py::object& urdf, const py::object& srdf, const py::object& group,
                const py::object& chain, const py::object& joint_limits,
                const py::object& base_pose, const py::object& bounds, const py::object& packages,
                const py::object& xacro, const py::object& meshes, bool kinematics_only,
                bool visual_as_collision, bool cache) {
  Interrupt interrupt;
  robots::LoadOptions options = loadOptions(packages, meshes, cache);
  if (!xacro.is_none())
    for (const auto& [name, value] : py::dict(xacro))
      options.xacro.emplace_back(py::str(name), py::str(value));
  options.kinematics_only = kinematics_only;
  options.visual_as_collision = visual_as_collision;
  options.stop = interrupt.callback();
  const std::string urdf_file = fileName(urdf, "urdf");
  const std::string srdf_file = srdf.is_none() ? "" : fileName(srdf, "srdf");
  auto model = interrupt.released([&] { return robots::loadModel(urdf_file, srdf_file, options); });
  if (!joint_limits.is_none()) {
    const std::string limits_file = fileName(joint_limits, "joint_limits");
    model =
        interrupt.released([&] { return planner::withJointLimits(*model, limits_file, options); });
  }
  if (!base_pose.is_none()) model = robots::withBasePose(*model, pose(base_pose, "base_pose"));
  if (!bounds.is_none()) model = robots::withBounds(*model, jointBounds(bounds));
  if (chain.is_none())
    return {model, group.is_none() ? std::vector<std::string>{"all"} : groupNames(group)};
  if (!group.is_none())
    throw py::value_error("group and chain both say what is planned; one of them is expected");
  return {model, chainVariables(*model, chain)};
}

Robot freeBody(const std::string& name, const py::object& shapes, const std::string& joint,
               const py::object& lower, const py::object& upper) {
  if (joint != "planar" && joint != "floating")
    unknownWord("joint", joint, "'planar' or 'floating'");
  std::vector<robots::Geometry> geometries = geometriesOf(shapes, name);
  const bool planar = joint == "planar";
  const auto bounds = [&](const py::object& value, const char* what) {
    std::vector<double> numbers_given = numbers(value, what, planar ? 2 : 3);
    numbers_given.resize(3, 0);
    return Eigen::Vector3d(numbers_given[0], numbers_given[1], numbers_given[2]);
  };
  return {robots::freeBody(name, std::move(geometries),
                           planar ? robots::JointType::kPlanar : robots::JointType::kFloating,
                           bounds(lower, "lower"), bounds(upper, "upper")),
          std::vector<std::string>{"all"}};
}

}  // namespace

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::vector<double> namedState(const Robot& robot, const std::string& name) {
  std::vector<std::string> known;
  refuseLeftOut("group state", name, robot.model->whyStateLeftOut(name, robot.space->variables()));
  for (const robots::GroupState& state : robots::namedStates(*robot.model)) {
    std::vector<double> point;
    for (const int variable : robot.space->variables())
      for (const auto& [given, value] : state.values)
        if (given == variable) point.push_back(value);
    if (point.size() != robot.size()) continue;  // of another group, without all of our joints
    if (state.name == name) return point;
    known.push_back(state.name);
  }
  refuseLeftOut("group state", name, robot.model->whyLeftOut("group state", name));
  if (const std::string fault =
          robots::stateLackFault(*robot.model, name, robot.space->variables());
      !fault.empty())
    throw py::value_error(fault);
  unknown("group state", name, known);
}

std::vector<std::string> groupNames(const py::object& group) {
  if (py::isinstance<py::str>(group)) return {word(group, "group")};
  std::vector<std::string> names;
  if (py::isinstance<py::list>(group) || py::isinstance<py::tuple>(group))
    for (const py::handle name : group)
      if (py::isinstance<py::str>(name)) names.push_back(word(name, "group"));
  if (names.empty() || names.size() != py::len(group))
    throw py::type_error("group is a " + std::string(Py_TYPE(group.ptr())->tp_name) +
                         "; the name of a group, or a list of such names, is expected");
  return names;
}

namespace {

/// Poses of all links, row by row.
std::vector<double> linkMatrices(const Robot& robot, const Rows& points, int only) {
  const std::size_t links = robot.model->links.size();
  std::vector<double> q = robot.model->defaultConfiguration();
  std::vector<robots::Pose> X_WL(links);
  const std::size_t kept = only < 0 ? links : 1;
  std::vector<double> matrices(points.count() * kept * 16);
  for (std::size_t i = 0; i < points.count(); ++i) {
    robot.expand(points.row(i), q);
    robots::forwardKinematics(*robot.model, q, X_WL);
    for (std::size_t k = 0; k < kept; ++k)
      writeMatrix(X_WL[only < 0 ? k : at(only)], &matrices[(i * kept + k) * 16]);
  }
  return matrices;
}

py::array_t<double> poses(const Robot& robot, const py::object& q) {
  Rows points = rows(q, "q", robot.size());
  std::vector<double> matrices = released([&] { return linkMatrices(robot, points, -1); });
  points.shape.insert(points.shape.end(),
                      {static_cast<py::ssize_t>(robot.model->links.size()), 4, 4});
  return array(std::move(matrices), points.shape);
}

py::array_t<double> linkPose(const Robot& robot, const std::string& link, const py::object& q) {
  const int index = robot.model->findLink(link);
  if (index < 0) unknown("link", link, namesOfThings(robot.model->links));
  Rows points = rows(q, "q", robot.size());
  std::vector<double> matrices = released([&] { return linkMatrices(robot, points, index); });
  points.shape.insert(points.shape.end(), {4, 4});
  return array(std::move(matrices), points.shape);
}

py::array_t<double> limits(const Robot& robot, bool upper) {
  std::vector<double> values;
  for (int i = 0; i < robot.space->size(); ++i)
    values.push_back(upper ? robot.space->upper(i) : robot.space->lower(i));
  return array(std::span<const double>(values));
}

std::vector<std::string> variableNames(const Robot& robot) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < robot.size(); ++i) names.push_back(robot.variableName(i));
  return names;
}

std::string htmlOfRobot(const Robot& robot) {
  std::vector<std::vector<std::string>> table;
  for (std::size_t i = 0; i < robot.size(); ++i) {
    const auto& variable = robot.model->variables[at(robot.space->variables()[i])];
    table.push_back(
        {variable.name, text(variable.lower), text(variable.upper), text(variable.velocity)});
  }
  return htmlTable(robot.model->name + ", group " + robot.group,
                   {"planned joint", "lower", "upper", "velocity"}, table);
}

}  // namespace

Robot::Robot(std::shared_ptr<const robots::Model> of, const std::vector<std::string>& groups)
    : model(std::move(of)),
      group(listed(groups)),
      space(std::make_shared<const planner::ConfigurationSpace>(
          model, plannedVariables(*model, groups))) {}

Robot::Robot(std::shared_ptr<const robots::Model> of, std::vector<int> variables)
    : model(std::move(of)),
      space(std::make_shared<const planner::ConfigurationSpace>(model, variables)) {
  group = listed(robots::groupsOf(*model, variables));
}

const std::string& Robot::variableName(std::size_t i) const {
  return model->variables[at(space->variables()[i])].name;
}

void Robot::expand(std::span<const double> point, std::span<double> base) const {
  for (std::size_t i = 0; i < size(); ++i) base[at(space->variables()[i])] = point[i];
}

std::map<std::string, robots::MeshTreatment, std::less<>> treatments(const py::object& meshes) {
  std::map<std::string, robots::MeshTreatment, std::less<>> result;
  if (meshes.is_none()) return result;
  for (const auto& [name, entry] : py::dict(meshes)) {
    std::string solid = "auto";
    double weld = 0;
    for (const auto& [key, value] : py::dict(py::reinterpret_borrow<py::object>(entry))) {
      const std::string word = py::str(key);
      if (word == "solid")
        solid = py::str(value);
      else if (word == "weld")
        weld = number(py::reinterpret_borrow<py::object>(value), "weld");
      else
        unknown("key of meshes", word, {"solid", "weld"});
    }
    result[py::str(name)] = meshTreatment(solid, weld);
  }
  return result;
}

void defineRobot(py::module_& module) {
  const std::string init =
      "(urdf, srdf=None, *, group=None, chain=None, joint_limits=None, base_pose=None, "
      "bounds=None, "
      "packages=None, xacro=None, meshes=None, kinematics_only=False, visual_as_collision=False, "
      "cache=True)";
  auto robot = defineClass<py::class_<Robot>>(
      module, "Robot", init,
      "A robot from a URDF and an SRDF, and the group of its joints that is planned. "
      "Constant: threads may share it.\n\n"
      "`group` is one of the SRDF's, or a joint, or 'all', or a list of groups and "
      "joints, which are planned together; `chain` is two links, (base, tip), and "
      "plans the joints between them. `joint_limits` is MoveIt's "
      "joint_limits.yaml. `base_pose` says where a base that is fixed stands in the "
      "world. `bounds` narrow the limits of joints, {joint: (lower, upper)} [rad or "
      "m], or widen them, {joint: {'range': (lower, upper), 'widen': True}}, and say "
      "where planar and floating joints may take their link, {joint: {'x': (lower, "
      "upper), 'y': ...}} [m]. `packages` maps names of package:// to folders. "
      "`xacro` maps names of arguments to "
      "values, for files that end in "
      ".xacro. With `kinematics_only` no mesh file is read; collisions of a robot "
      "that has some cannot be checked then. `visual_as_collision` lets the visual "
      "shapes of links without collision shapes stand in for these. `cache` keeps "
      "built meshes and proofs about the robot in "
      "$LEEWAY_CACHE_DIR or ~/.cache/leeway; answers are the same.\n"
      "Raises InputError, with file and line.",
      loadRobot);
  defineStatic(
      robot, "free_body", "(name, shapes, *, joint='floating', lower, upper)",
      "One rigid body that moves in space (its point is x y z qx qy qz qw) or, with "
      "joint='planar', in the plane (x y angle). `shapes` is a shape, or a list of shapes or of "
      "pairs (shape, pose). `lower` and `upper` bound its origin [m]: 3 numbers, planar 2.",
      freeBody);
  defineCopiesOfConstant(robot);
  define(robot, "with_group", "(self, group)",
         "The same robot, planned by another group, or by a list of groups and joints.",
         [](const Robot& self, const py::object& group) {
           return Robot(self.model, groupNames(group));
         });
  define(robot, "state", "(self, name)",
         "The planned joints' values in a group state of the SRDF: (joints,) [rad or m].",
         [](const Robot& self, const std::string& name) {
           const std::vector<double> point = namedState(self, name);
           return array(std::span<const double>(point));
         });
  define(robot, "poses", "(self, q)",
         "Poses of all links in the world, in the order of `links`: (..., links, 4, 4) for q of "
         "shape (..., joints) [rad or m; m]. Joints that are not planned are at zero (MJCF: "
         "qpos0), or at the "
         "nearest limit.",
         poses);
  define(robot, "pose", "(self, link, q)",
         "The pose of one link in the world: (..., 4, 4) for q of shape (..., joints).", linkPose);
  define(
      robot, "interpolate", "(self, a, b, t)",
      "The points at t in [0, 1] of the edge from a to b, as paths and certificates mean it "
      "(continuous joints go the shorter way, and straight: from 3 to -3 up to 3.28): (joints,) "
      "for a number, (n, joints) for (n,). Raises ValueError for t outside [0, 1].",
      [](const Robot& self, const py::object& a, const py::object& b, const py::object& t) {
        const std::vector<double> from = numbers(a, "a", self.size());
        std::vector<double> to = numbers(b, "b", self.size());
        self.space->unwrap(from, to);
        Rows times = scalars(t, "t");
        for (const double time : times.values)
          if (!(time >= 0 && time <= 1))
            throw py::value_error("t is " + std::string(py::str(py::float_(time))) +
                                  "; 0 to 1 is expected");
        std::vector<double> result(times.values.size() * self.size());
        for (std::size_t i = 0; i < times.values.size(); ++i)
          self.space->alongLine(from, to, times.values[i], {&result[i * self.size()], self.size()});
        times.shape.push_back(static_cast<py::ssize_t>(self.size()));
        return array(std::move(result), times.shape);
      });
  define(robot, "distance", "(self, a, b)",
         "Length of the edge from a to b, the measure of paths: Euclidean over the joints [rad and "
         "m].",
         [](const Robot& self, const py::object& a, const py::object& b) {
           return self.space->distance(numbers(a, "a", self.size()), numbers(b, "b", self.size()));
         });
  defineConstant(
      robot, "name", [](const Robot& self) { return self.model->name; }, "The robot's name.");
  defineConstant(
      robot, "group", &Robot::group,
      "The planned group's name; of several 'left, right'; '' where the joints are not a group's.");
  defineConstant(
      robot, "joint_names", [](const Robot& self) { return listOf(variableNames(self)); },
      "Names of the planned variables, in the order of points.");
  defineConstant(
      robot, "lower", [](const Robot& self) { return limits(self, false); },
      "Lower limits of the planned joints: (joints,) [rad or m]; -inf where there are none.");
  defineConstant(
      robot, "upper", [](const Robot& self) { return limits(self, true); },
      "Upper limits of the planned joints: (joints,) [rad or m]; inf where there are none.");
  defineConstant(
      robot, "links", [](const Robot& self) { return listOf(namesOfThings(self.model->links)); },
      "Names of all links, parents before children.");
  defineConstant(
      robot, "groups", [](const Robot& self) { return listOf(namesOfThings(self.model->groups)); },
      "Names of the groups that may be planned.");
  defineConstant(
      robot, "states",
      [](const Robot& self) { return listOf(namesOfThings(self.model->group_states)); },
      "Names of the SRDF's group states.");
  defineConstant(
      robot, "warnings", [](const Robot& self) { return listOf(self.model->warnings); },
      "What the loader found odd, each with file and line.");
  robot.def("__repr__", [](const Robot& self) {
    return "<leeway.Robot '" + self.model->name + "', group '" + self.group +
           "': " + std::to_string(self.size()) + " planned joints, " +
           std::to_string(self.model->links.size()) + " links>";
  });
  robot.def("_repr_html_", htmlOfRobot);
}

}  // namespace leeway::python
