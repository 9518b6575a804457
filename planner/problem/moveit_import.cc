// MoveIt's planning scene and motion plan request as YAML, the way MotionBenchMaker writes them:
// moveit_msgs/PlanningScene and moveit_msgs/MotionPlanRequest, field by field. Fields that say
// nothing of geometry or of joints are passed over; what would change the problem and is not
// supported is an error, never skipped.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "leeway/planner/problem.h"
#include "planner/base/nearest_name.h"
#include "planner/base/tolerances.h"
#include "planner/problem/problem_shapes.h"
#include "planner/problem/problem_states.h"
#include "planner/problem/yaml_reader.h"

namespace leeway::planner {
namespace {

using robots::Joint;
using robots::JointType;
using robots::Model;
using robots::Pose;
using Shape = collision::Shape;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool isIdentity(const Pose& pose) {
  return pose.rotation == Eigen::Matrix3d::Identity() &&
         pose.translation == Eigen::Vector3d::Zero();
}

bool hasContent(const std::optional<YamlReader>& value) { return value && !value->isEmpty(); }

void refuseContent(const YamlReader& map, std::string_view key, std::string_view accepted) {
  if (const auto value = map.find(key); hasContent(value))
    value->fail(fmt::format("{} is not supported; {} is expected", value->where(), accepted));
}

/// MoveIt writes an empty text where it has nothing to say.
std::string optionalText(const YamlReader& map, std::string_view key) {
  const auto value = map.find(key);
  return value && value->isScalar() && !value->isEmpty() ? value->text() : std::string();
}

/// {position, orientation} or {translation, rotation}.
Pose readMoveitPose(const YamlReader& map, const char* translation, const char* rotation,
                    std::vector<std::string>& warnings) {
  Pose pose;
  if (const auto p = map.find(translation)) pose.translation = p->vector3();
  if (const auto q = map.find(rotation))
    pose.rotation = rotationFromQuaternion(readQuaternion(*q, warnings));
  return pose;
}

// ---- The scene ----

/// Frames that objects may stand in, each with its pose in the planning frame (the robot's root).
using Frames = std::map<std::string, Pose>;

Frames readFrames(const YamlReader& scene, const Model& model, std::vector<std::string>& warnings) {
  Frames frames = {{"", Pose()}, {"world", Pose()}, {model.links[0].name, Pose()}};
  const auto transforms = scene.find("fixed_frame_transforms");
  if (!hasContent(transforms)) return frames;
  for (const YamlReader& entry : transforms->items()) {
    const YamlReader name = entry.at("child_frame_id", "the name of a frame");
    frames[name.text()] = readMoveitPose(entry.at("transform", "translation and rotation"),
                                         "translation", "rotation", warnings);
  }
  return frames;
}

Pose framePose(const YamlReader& object, const Frames& frames) {
  const auto header = object.find("header");
  if (!header || !header->isMap()) return Pose();
  const std::string name = optionalText(*header, "frame_id");
  const auto found = frames.find(name);
  if (found == frames.end()) {
    std::vector<std::string> known;
    for (const auto& frame : frames)
      if (!frame.first.empty()) known.push_back(frame.first);
    header->fail(
        fmt::format("unknown frame '{}' in {}{}", name, header->where(), nearestName(name, known)));
  }
  return found->second;
}

/// `type` and `dimensions`: full edges for a box; height and radius, in this order, for cylinder
/// and cone.
Shape readPrimitive(const YamlReader& primitive) {
  const YamlReader type = primitive.at("type", "box, sphere, cylinder or cone");
  const YamlReader sizes = primitive.at("dimensions", "a list of numbers");
  const std::string word = type.text();
  const std::size_t count = word == "box"                          ? 3
                            : word == "sphere"                     ? 1
                            : word == "cylinder" || word == "cone" ? 2
                                                                   : 0;
  if (count == 0)
    type.fail(
        fmt::format("{} is '{}'; box, sphere, cylinder or cone is expected", type.where(), word));
  std::vector<double> d;
  for (const YamlReader& size : sizes.items()) d.push_back(size.sizeNumber());
  if (d.size() != count)
    sizes.fail(fmt::format("{} is a list of {} for a {}; {} expected", sizes.where(), d.size(),
                           word,
                           count == 3   ? "the three edges are"
                           : count == 1 ? "the radius is"
                                        : "height and radius are"));
  if (count == 3) return Shape::box(Eigen::Vector3d(d[0], d[1], d[2]) / 2);
  if (count == 1) return Shape::sphere(d[0]);
  // MoveIt's cone has its apex at +z and its origin at half the height, as ours.
  return word == "cylinder" ? Shape::cylinder(d[1], d[0] / 2) : Shape::cone(d[1], d[0] / 2);
}

Object readCollisionObject(const YamlReader& map, std::vector<std::string>& warnings) {
  const YamlReader id = map.at("id", "the object's name");
  refuseContent(map, "meshes", "a primitive");
  refuseContent(map, "planes", "a primitive");
  refuseContent(map, "subframe_names", "nothing");
  Object object;
  object.name = id.text();
  if (const auto pose = map.find("pose"))
    object.X_WO = readMoveitPose(*pose, "position", "orientation", warnings);
  const YamlReader primitives = map.at("primitives", "a list of primitives");
  const YamlReader poses = map.at("primitive_poses", "a list of poses");
  const std::vector<YamlReader> shapes = primitives.items(), places = poses.items();
  if (shapes.empty() || shapes.size() != places.size())
    poses.fail(
        fmt::format("object '{}' has {} primitives and {} primitive_poses; equally many, at least "
                    "one, are expected",
                    object.name, shapes.size(), places.size()));
  for (std::size_t i = 0; i < shapes.size(); ++i)
    object.geometries.push_back({readPrimitive(shapes[i]),
                                 readMoveitPose(places[i], "position", "orientation", warnings),
                                 object.name});
  return object;
}

void readObjects(const YamlReader& scene, Problem& problem) {
  const auto world = scene.find("world");
  if (!world || world->isNull()) return;
  if (const auto octomap = world->find("octomap"); octomap && octomap->isMap())
    if (const auto inner = octomap->find("octomap"); inner && inner->isMap())
      refuseContent(*inner, "data", "an empty octomap");
  const auto objects = world->find("collision_objects");
  if (!hasContent(objects)) return;
  const Frames frames = readFrames(scene, *problem.model, problem.warnings);
  std::set<std::string> names;
  for (const robots::Link& link : problem.model->links) names.insert(link.name);
  for (const YamlReader& entry : objects->items()) {
    Object object = readCollisionObject(entry, problem.warnings);
    object.X_WO = framePose(entry, frames) * object.X_WO;
    if (!names.insert(object.name).second)
      entry.fail(fmt::format(
          "object '{}' has the name of another object or link; a name of its own is expected",
          object.name));
    problem.objects.push_back(std::move(object));
  }
}

// ---- The matrix of pairs that may touch ----

struct Matrix {
  std::vector<std::string> names;
  std::vector<std::vector<bool>> allowed;
  int index(const std::string& name) const {
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? -1 : static_cast<int>(found - names.begin());
  }
};

Matrix readMatrix(const YamlReader& map) {
  Matrix matrix;
  const auto names = map.find("entry_names");
  if (!hasContent(names)) return matrix;
  for (const YamlReader& name : names->items()) matrix.names.push_back(name.text());
  const YamlReader rows = map.at("entry_values", "a row of true and false for each entry name");
  for (const YamlReader& row : rows.items()) {
    // MoveIt's own writer nests the row under `enabled`.
    const YamlReader flags = row.isMap() ? row.at("enabled", "a list of true and false") : row;
    std::vector<bool> line;
    for (const YamlReader& flag : flags.items()) line.push_back(flag.boolean());
    if (line.size() != matrix.names.size())
      flags.fail(fmt::format("{} has {} entries for {} names; equally many are expected",
                             flags.where(), line.size(), matrix.names.size()));
    matrix.allowed.push_back(std::move(line));
  }
  if (matrix.allowed.size() != matrix.names.size())
    rows.fail(fmt::format("{} has {} rows for {} names; equally many are expected", rows.where(),
                          matrix.allowed.size(), matrix.names.size()));
  return matrix;
}

/// The matrix entry that speaks for a link. A link that the matrix does not know, fixed to one that
/// it knows and named after it
/// (`torso_2` on `torso`), is a part that was split off the other's geometry: the other's entry
/// speaks for it. -1: none does.
int matrixEntry(const Model& model, const Matrix& matrix, int link) {
  const std::string& name = model.links[at(link)].name;
  while (true) {
    const std::string& candidate = model.links[at(link)].name;
    const int entry = matrix.index(candidate);
    if (entry >= 0 && (candidate == name || name.rfind(candidate + "_", 0) == 0)) return entry;
    const Joint& joint = model.joints[at(link)];
    if (joint.type != JointType::kFixed || joint.parent_link < 0) return -1;
    link = joint.parent_link;
  }
}

/// Pairs of links as the matrix says where it knows both, as the SRDF says where it does not; pairs
/// with objects as the matrix says.
void takeMatrix(const YamlReader& map, const Matrix& matrix, Problem& problem) {
  const Model& model = *problem.model;
  problem.replace_srdf_pairs = true;
  std::vector<int> entry(model.links.size());
  for (std::size_t l = 0; l < entry.size(); ++l) {
    entry[l] = matrixEntry(model, matrix, static_cast<int>(l));
    if (entry[l] >= 0 && matrix.names[at(entry[l])] != model.links[l].name)
      problem.warnings.push_back(
          fmt::format("{}:{}: link '{}' is not in the matrix, may touch what '{}' may touch",
                      map.file(), map.line(), model.links[l].name, matrix.names[at(entry[l])]));
  }
  std::set<std::pair<int, int>> disabled;
  for (const robots::DisabledPair& pair : model.disabled_pairs)
    disabled.insert(std::minmax(pair.link_a, pair.link_b));
  // An entry counts when it is said both ways: a matrix that contradicts itself allows nothing.
  const auto both = [&](int i, int j) {
    return matrix.allowed[at(i)][at(j)] && matrix.allowed[at(j)][at(i)];
  };
  for (std::size_t a = 0; a < entry.size(); ++a)
    for (std::size_t b = a + 1; b < entry.size(); ++b) {
      const bool known = entry[a] >= 0 && entry[b] >= 0 && entry[a] != entry[b];
      if (known ? both(entry[a], entry[b])
                : disabled.count({static_cast<int>(a), static_cast<int>(b)}) > 0)
        problem.allowed.emplace_back(model.links[a].name, model.links[b].name);
    }
  std::set<std::string> bodies;
  for (const Object& object : problem.objects) bodies.insert(object.name);
  for (const Attachment& attachment : problem.attachments) bodies.insert(attachment.object.name);
  for (std::size_t i = 0; i < matrix.names.size(); ++i) {
    const bool body = bodies.count(matrix.names[i]) > 0;
    if (!body && model.findLink(matrix.names[i]) < 0)
      problem.warnings.push_back(
          fmt::format("{}:{}: the matrix names '{}', which is no link and no object", map.file(),
                      map.line(), matrix.names[i]));
    for (std::size_t j = 0; body && j < matrix.names.size(); ++j) {
      const bool other_body = bodies.count(matrix.names[j]) > 0;
      if ((other_body ? i < j : model.findLink(matrix.names[j]) >= 0) &&
          both(static_cast<int>(i), static_cast<int>(j)))
        problem.allowed.emplace_back(matrix.names[i], matrix.names[j]);
    }
  }
}

// ---- The request ----

void readGroup(const YamlReader& request, Problem& problem) {
  const YamlReader name = request.at("group_name", "the group that moves");
  const Model& model = *problem.model;
  const int group = model.findGroup(name.text());
  if (group < 0) {
    std::vector<std::string> known;
    for (const robots::Group& candidate : model.groups) known.push_back(candidate.name);
    name.fail(fmt::format("robot '{}' has no group '{}'{}", model.name, name.text(),
                          nearestName(name.text(), known)));
  }
  problem.variables = model.groups[at(group)].variables;
  if (problem.variables.empty())
    name.fail(fmt::format("group '{}' has no joint that can move; another group is expected",
                          name.text()));
}

/// A value that is written just outside a planned joint's limit is moved onto it.
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
  return std::find(problem.variables.begin(), problem.variables.end(), variable) !=
         problem.variables.end();
}

void takeStartJoint(const YamlReader& place, const std::string& name, double value,
                    VariableRanges& given, Problem& problem) {
  const Model& model = *problem.model;
  const int v = model.findVariable(name);
  if (v >= 0) {
    if (given[at(v)].given)
      place.fail(
          fmt::format("joint '{}' stands twice in {}; once is expected", name, place.where()));
    if (isPlanned(problem, v)) takeOntoLimit(place, model.variables[at(v)], value, problem);
    given[at(v)] = {true, value, value, place.line()};
    return;
  }
  // Fixed and mimic joints may be named; a name that the model lacks is another version of the
  // robot.
  if (model.findJoint(name) < 0)
    problem.warnings.push_back(
        fmt::format("{}:{}: the robot has no joint '{}', its position {} is not used", place.file(),
                    place.line(), name, value));
}

/// {joint_names, transforms}: poses of planar and floating joints, above all the virtual joint's.
void readMultiDof(const YamlReader& state, VariableRanges& given, Problem& problem) {
  const auto names = state.find("joint_names");
  if (!hasContent(names)) return;
  const YamlReader transforms = state.at("transforms", "a transform for each joint name");
  const std::vector<YamlReader> name_items = names->items(), items = transforms.items();
  if (name_items.size() != items.size())
    transforms.fail(fmt::format("{} transforms for {} joint_names; equally many are expected",
                                items.size(), name_items.size()));
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Model& model = *problem.model;
    const int index = model.findJoint(name_items[i].text());
    const JointType type = index >= 0 ? model.joints[at(index)].type : JointType::kFixed;
    if (type == JointType::kFloating) {
      const int first = model.joints[at(index)].first_variable;
      Eigen::Vector3d p = Eigen::Vector3d::Zero();
      Eigen::Vector4d q = Eigen::Vector4d::UnitW();
      if (const auto translation = items[i].find("translation")) p = translation->vector3();
      if (const auto rotation = items[i].find("rotation"))
        q = readQuaternion(*rotation, problem.warnings);
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

void readStartState(const YamlReader& request, Problem& problem) {
  const YamlReader state = request.at("start_state", "the robot's start");
  const YamlReader joints = state.at("joint_state", "name and position");
  const YamlReader names = joints.at("name", "a list of joint names"),
                   positions = joints.at("position", "a list of positions");
  const std::vector<YamlReader> name_items = names.items(), items = positions.items();
  if (name_items.size() != items.size())
    positions.fail(fmt::format("{} positions for {} names; equally many are expected", items.size(),
                               name_items.size()));
  VariableRanges given(problem.model->variables.size());
  for (std::size_t i = 0; i < items.size(); ++i)
    takeStartJoint(items[i], name_items[i].text(), items[i].number(), given, problem);
  if (const auto multi = state.find("multi_dof_joint_state"); multi && multi->isMap())
    readMultiDof(*multi, given, problem);
  refuseContent(state, "attached_collision_objects", "a start without attached objects");
  takeStart(joints.file(), joints.line(), given, problem);
}

void readJointConstraint(const YamlReader& constraint, VariableRanges& given, Problem& problem) {
  const Model& model = *problem.model;
  const YamlReader name = constraint.at("joint_name", "the name of a joint");
  const YamlReader position = constraint.at("position", "a number");
  const int v = model.findVariable(name.text());
  if (v < 0) {
    std::vector<std::string> known;
    for (const int variable : problem.variables)
      known.push_back(model.variables[at(variable)].name);
    name.fail(fmt::format("unknown joint '{}' in {}{}", name.text(), constraint.where(),
                          nearestName(name.text(), known)));
  }
  if (given[at(v)].given)
    name.fail(fmt::format("joint '{}' has two constraints; one is expected", name.text()));
  double value = position.number();
  const robots::Variable& variable = model.variables[at(v)];
  if (isPlanned(problem, v)) takeOntoLimit(position, variable, value, problem);
  const auto tolerance = [&](const char* key) {
    const auto found = constraint.find(key);
    return found ? found->sizeNumber() : 0;
  };
  // Zero, as in all that MotionBenchMaker writes, means the position itself.
  double lower = value - tolerance("tolerance_below"), upper = value + tolerance("tolerance_above");
  if (value >= variable.lower && value <= variable.upper) {
    lower = std::max(lower, variable.lower);
    upper = std::min(upper, variable.upper);
  }
  given[at(v)] = {true, lower, upper, position.line()};
}

Goal readConstraints(const YamlReader& map, const std::string& name, Problem& problem) {
  for (const char* key :
       {"position_constraints", "orientation_constraints", "visibility_constraints"})
    refuseContent(map, key, "a goal of joint_constraints");
  const YamlReader joints = map.at("joint_constraints", "a list of joint_name and position");
  VariableRanges given(problem.model->variables.size());
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

void refusePathConstraints(const YamlReader& request) {
  const auto constraints = request.find("path_constraints");
  if (!constraints || !constraints->isMap()) return;
  for (const char* key : {"joint_constraints", "position_constraints", "orientation_constraints",
                          "visibility_constraints"})
    refuseContent(*constraints, key, "a path without constraints");
}

}  // namespace

Problem loadMoveit(std::shared_ptr<const Model> model, const std::string& scene_path,
                   const std::string& request_path) {
  Problem problem;
  problem.model = std::move(model);
  problem.name = std::filesystem::path(scene_path).stem().string();
  problem.configuration = problem.model->defaultConfiguration();

  const YamlReader scene = YamlReader::load(scene_path);
  const YamlReader request = YamlReader::load(request_path);
  readGroup(request, problem);
  readObjects(scene, problem);
  if (const auto map = scene.find("allowed_collision_matrix"); map && map->isMap())
    if (const Matrix matrix = readMatrix(*map); !matrix.names.empty())
      takeMatrix(*map, matrix, problem);

  // The scene's robot_state is not the start: it is all zeros in every file of MotionBenchMaker.
  // But a thing held there would be lost.
  if (const auto state = scene.find("robot_state"); state && state->isMap())
    refuseContent(*state, "attached_collision_objects", "a scene without attached objects");
  readStartState(request, problem);
  readGoalConstraints(request, problem);
  refusePathConstraints(request);
  if (const auto time = request.find("allowed_planning_time"); time && time->number() > 0)
    problem.time_limit = time->number();
  return problem;
}

}  // namespace leeway::planner
