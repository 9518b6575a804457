#include "planner/save/problem_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <stdexcept>
#include <string_view>

#include "collision/base/numbers.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/settings.h"
#include "leeway/robots/groups.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/named_states.h"
#include "planner/base/tolerances.h"
#include "planner/save/motion_text.h"
#include "planner/save/yaml_text.h"
#include "planner/validate/checks.h"
#include "planner/validate/format_keys.h"
#include "planner/validate/names.h"

namespace leeway::planner {
namespace {

using collision::Shape;
using collision::ShapeType;
using robots::InputError;
using robots::Model;
using robots::Pose;

[[noreturn]] void refuse(const std::string& message) { throw InputError("", 0, message); }

bool isIdentity(const Eigen::Matrix3d& rotation) {
  return (rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kSavedRotation;
}

class Writer {
 public:
  Writer(const Problem& problem, std::string folder,
         const std::function<std::string(const std::string&)>& name_of, const robots::Stop& stop)
      : problem_(problem),
        model_(*problem.robot.model),
        files_(std::move(folder), result_.files),
        name_of_(name_of),
        stop_(stop) {}

  ProblemText write() {
    line("leeway", "1");
    line("name", wordText(problem_.name));
    writeRobot();
    writeStates();
    writeObjects();
    writeDeforming();
    writePairs();
    writeConstraints();
    writeSettings();
    if (!frames_.empty()) line("frames", frames_.text());
    if (!files_.treatments.empty()) line("meshes", files_.treatments.text());
    result_.text = std::move(text_);
    return std::move(result_);
  }

 private:
  void line(std::string_view key, const std::string& value) {
    text_ += fmt::format("{}: {}\n", key, value);
  }
  void list(std::string_view key, const std::vector<std::string>& items) {
    if (items.empty()) return;
    text_ += fmt::format("{}:\n", key);
    for (const std::string& item : items) text_ += "  - " + item + "\n";
  }

  // ----------------------------------------------------------------------------------------------
  // The robot

  void writeRobot() {
    if (model_.urdf_file.empty()) return writeBody();
    const robots::ReadWith& with = model_.read_with;
    robots::LoadOptions load;
    for (const auto& [name, folder] : with.packages)
      load.packages.emplace_back(name, model_.placeOf(folder));
    load.xacro = with.xacro;
    load.kinematics_only = true;
    load.stop = stop_;
    const auto plain =
        robots::loadModel(model_.placeOf(model_.urdf_file), model_.placeOf(model_.srdf_file), load);
    if (plain->variables.size() != model_.variables.size() ||
        plain->joints.size() != model_.joints.size())
      refuse("robot.model has other joints than its file " + model_.urdf_file +
             "; a robot as loadModel() made it is expected");
    MapText robot;
    robot.add("urdf", wordText(name_of_(model_.placeOf(model_.urdf_file))));
    if (!model_.srdf_file.empty())
      robot.add("srdf", wordText(name_of_(model_.placeOf(model_.srdf_file))));
    robot.add("group", groupText(*plain));
    if (!with.packages.empty()) {
      MapText packages;
      for (const auto& [name, folder] : with.packages)
        packages.add(wordText(name), wordText(name_of_(model_.placeOf(folder))));
      robot.add("packages", packages.text());
    }
    if (!with.xacro.empty()) {
      MapText arguments;
      for (const auto& [name, value] : with.xacro) arguments.add(wordText(name), quoted(value));
      robot.add("xacro", arguments.text());
    }
    if (with.visual_as_collision) robot.add("visual_as_collision", "true");
    if (const std::string limits = motionLimitsText(*plain); !limits.empty())
      robot.add("joint_limits", wordText(files_.add("joint_limits", ".yaml", limits)));
    const Pose &X = model_.joints[0].X_PJ, &X_plain = plain->joints[0].X_PJ;
    if (X.translation != X_plain.translation || X.rotation != X_plain.rotation)
      robot.add("position", vectorText(X.translation, "the robot's base"))
          .add("orientation", quaternionText(X.rotation, "the robot's base"));
    line("robot", robot.text());
    if (const MapText bounds = boundsText(*plain); !bounds.empty()) line("bounds", bounds.text());
    for (const auto& [name, treatment] : with.meshes)
      files_.treatments.add(wordText(name), treatmentText(treatment));
  }

  static std::string quoted(const std::string& value) {
    const std::string text = wordText(value);
    return text.starts_with('"') ? text : "\"" + text + "\"";
  }

  static std::string treatmentText(const robots::MeshTreatment& treatment) {
    using Solid = robots::MeshTreatment::Solid;
    MapText text;
    text.add("solid", treatment.solid == Solid::kHull      ? "hull"
                      : treatment.solid == Solid::kSurface ? "surface"
                                                           : "auto");
    if (treatment.weld > 0) text.add("weld", numberText(treatment.weld, "weld"));
    return text.text();
  }

  std::string groupText(const Model& plain) const {
    const std::vector<std::string> names = robots::groupsOf(plain, problem_.robot.variables);
    if (names.empty())
      refuse(
          "robot.variables are not those of groups and joints that the robot's files have; "
          "robots::variablesOf() is expected to make them");
    if (names.size() == 1) return wordText(names[0]);
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "[" : ", ") + wordText(name);
    return text + "]";
  }

  /// MoveIt's joint_limits.yaml, of joints whose velocity, acceleration or jerk is not the file's.
  std::string motionLimitsText(const Model& plain) const {
    std::string text;
    for (std::size_t v = 0; v < model_.variables.size(); ++v) {
      const robots::Variable &ours = model_.variables[v], &theirs = plain.variables[v];
      MapText limits;
      const auto add = [&](const char* key, double value, double other) {
        if (value == other) return;
        limits.add(fmt::format("has_{}_limits", key), "true")
            .add(fmt::format("max_{}", key),
                 numberText(value, fmt::format("the {} limit of '{}'", key, ours.name)));
      };
      add("velocity", ours.velocity, theirs.velocity);
      add("acceleration", ours.acceleration, theirs.acceleration);
      add("jerk", ours.jerk, theirs.jerk);
      if (!limits.empty()) text += fmt::format("  {}: {}\n", wordText(ours.name), limits.text());
    }
    return text.empty() ? text : "joint_limits:\n" + text;
  }

  /// `bounds`, of variables whose range is not the file's.
  MapText boundsText(const Model& plain) const {
    MapText bounds;
    for (const robots::Joint& joint : model_.joints) {
      MapText axes;
      for (int i = 0; i < joint.variable_count; ++i) {
        const robots::Variable& ours = model_.variables[at(joint.first_variable + i)];
        const robots::Variable& theirs = plain.variables[at(joint.first_variable + i)];
        if (ours.lower == theirs.lower && ours.upper == theirs.upper) continue;
        const std::string range =
            numbersText(std::array{ours.lower, ours.upper}, "a bound of '" + ours.name + "'");
        const bool widens = ours.lower < theirs.lower || ours.upper > theirs.upper;
        if (joint.variable_count > 1)
          axes.add(ours.name.substr(ours.name.rfind('/') + 1), range);
        else
          axes.add("range", range).add("widen", widens ? "true" : "false");
      }
      if (!axes.empty()) bounds.add(wordText(joint.name), axes.text());
    }
    return bounds;
  }

  void writeBody() {
    const bool is_body = model_.links.size() == 1 && model_.joints.size() == 1 &&
                         model_.joints[0].variable_count > 0 &&
                         (model_.joints[0].type == robots::JointType::kPlanar ||
                          model_.joints[0].type == robots::JointType::kFloating);
    if (!is_body)
      refuse("robot.model comes from no file; a robot of loadModel() or freeBody() is expected");
    const std::size_t axes = model_.joints[0].type == robots::JointType::kPlanar ? 2 : 3;
    std::vector<double> lower, upper;
    for (std::size_t i = 0; i < axes; ++i) {
      lower.push_back(model_.variables[i].lower);
      upper.push_back(model_.variables[i].upper);
    }
    const robots::Link& link = model_.links[0];
    line("body", MapText()
                     .add("name", wordText(link.name))
                     .add("joint", axes == 2 ? "planar" : "floating")
                     .add("bounds", MapText()
                                        .add("lower", numbersText(lower, "the body's bounds"))
                                        .add("upper", numbersText(upper, "the body's bounds"))
                                        .text())
                     .add("shapes", shapesText(link.geometries, link.name))
                     .text());
  }

  // ----------------------------------------------------------------------------------------------
  // States and poses

  void writeStates() {
    const std::vector<double> rest = model_.defaultConfiguration();
    MapText others;
    std::vector<double> start;
    const std::vector<int>& planned = problem_.robot.variables;
    for (std::size_t v = 0; v < rest.size(); ++v)
      if (std::find(planned.begin(), planned.end(), static_cast<int>(v)) == planned.end() &&
          problem_.start[v] != rest[v])
        others.add(wordText(model_.variables[v].name), numberText(problem_.start[v], "start"));
    for (const int v : planned) start.push_back(problem_.start[at(v)]);
    if (!others.empty()) line("joints", others.text());
    for (const Frame& frame : problem_.robot.frames) addFrame(frame);
    line("start", problem_.start_poses.empty() ? numbersText(start, "start")
                                               : posesText(problem_.start_poses, "start_poses"));
    if (!problem_.steps.empty()) {
      std::vector<std::string> steps;
      for (const Step& step : problem_.steps) steps.push_back(stepText(step));
      return list("steps", steps);
    }
    std::vector<std::string> goals;
    const std::size_t count = problem_.goals.size();
    if (count == 0) refuse("goals is empty; at least one goal, or steps, is expected");
    for (const Goal& goal : problem_.goals)
      goals.push_back(goalText(goal, isGivenByPlace(goal.name) ? goal.name : "goal"));
    if (count == 1) return line("goal", goals[0]);
    list("goals", goals);
  }

  void addFrame(const Frame& frame) {
    frames_.add(wordText(frame.name), MapText()
                                          .add("link", wordText(model_.links[at(frame.link)].name))
                                          .addPose(frame.X_LF, "frame '" + frame.name + "'")
                                          .text());
  }

  static std::string rangeText(const std::pair<double, double>& range, const std::string& what) {
    return range.first == range.second ? numberText(range.first, what)
                                       : numbersText(std::array{range.first, range.second}, what);
  }

  /// `other_name`: the name that a goal has where it is not a group state.
  std::string goalText(const Goal& goal, const std::string& other_name) {
    if (!goal.poses.empty() && goal.name == other_name)
      return posesText(goal.poses, "the poses of '" + goal.name + "'");
    if (goal.name == other_name) {
      std::vector<std::string> values;
      for (const auto& range : goal.ranges) values.push_back(rangeText(range, goal.name));
      return listText(values);
    }
    for (const robots::GroupState& state : robots::namedStates(model_))
      if (state.name == goal.name && goal.poses.empty()) return wordText(goal.name);
    refuse(
        fmt::format("a goal is named '{}'; files give goals no name: '{}', or the name of a "
                    "group state with its values, is expected",
                    goal.name, other_name));
  }

  std::string posesText(const std::vector<robots::PoseRegion>& regions, const std::string& what) {
    std::vector<std::string> poses;
    for (const robots::PoseRegion& region : regions) poses.push_back(regionText(region, what));
    return MapText().add("poses", listText(poses)).text();
  }

  static bool isNear(const Pose& a, const Pose& b) {
    return a.translation == b.translation &&
           (a.rotation - b.rotation).cwiseAbs().maxCoeff() < kSavedRotation;
  }

  /// Returns the name of a thing at X_WR, which a pose may be relative to; nothing: none is there.
  std::optional<std::string> referenceAt(const Pose& X_WR) {
    if (isNear(X_WR, Pose())) return std::string();
    for (const Object& object : problem_.world.objects)
      if (isNear(X_WR, object.X_WO)) return object.name;
    for (const DeformingObstacle& obstacle : problem_.world.deforming)
      if (isNear(X_WR, obstacle.object.X_WO)) return obstacle.object.name;
    std::vector<std::string> names;
    for (const robots::Link& link : model_.links) names.push_back(link.name);
    for (const Frame& frame : problem_.robot.frames) names.push_back(frame.name);
    for (const std::string& name : names) try {
        // (Its frame does not matter here, only where the reference is.)
        FramePose pose = anyPose();
        pose.relative_to = name;
        if (isNear(regionOf(problem_, pose).X_WR, X_WR)) return name;
      } catch (const std::invalid_argument&) {  // it moves
      }
    return std::nullopt;
  }

  /// A pose of a link that planned joints move.
  FramePose anyPose() const {
    FramePose pose;
    pose.frame =
        model_
            .links[at(model_.joints[at(model_.variables[at(problem_.robot.variables.back())].joint)]
                          .child_link)]
            .name;
    pose.position.fill({0, 0});
    pose.rpy.fill({0, 0});
    return pose;
  }

  std::string regionText(const robots::PoseRegion& region, const std::string& what) {
    FramePose pose;
    const std::optional<std::string> reference = referenceAt(region.X_WR);
    if (!reference)
      refuse(what +
             " are relative to a pose at which no object and no link at rest stands; one is "
             "expected there, to be named");
    pose.relative_to = *reference;
    pose.position = region.position;
    pose.rpy = region.rpy;
    pose.position_tolerance = region.position_tolerance;
    pose.angle_tolerance = region.angle_tolerance;
    const auto fits = [&](const std::string& name, int link, const Pose& X_LF) {
      if (link != region.link || X_LF.translation != region.X_LF.translation) return false;
      pose.frame = name;
      pose.rotation = region.X_LF.rotation.transpose() * X_LF.rotation;
      if (isIdentity(pose.rotation)) pose.rotation.setIdentity();
      return rotationText(pose, what).has_value();
    };
    for (const Frame& frame : problem_.robot.frames)
      if (fits(frame.name, frame.link, frame.X_LF)) return poseText(pose, what);
    if (fits(model_.links[at(region.link)].name, region.link, Pose())) return poseText(pose, what);
    for (const Attachment& held : problem_.robot.attachments)
      if (fits(held.object.name, held.link, held.X_LO)) return poseText(pose, what);
    const Names names(problem_);
    const auto isTaken = [&](const std::string& name) {
      return names.isKnown(name) ||
             std::any_of(problem_.robot.frames.begin(), problem_.robot.frames.end(),
                         [&](const Frame& frame) { return frame.name == name; });
    };
    do pose.frame = fmt::format("pose frame {}", ++added_frames_);
    while (isTaken(pose.frame));
    pose.rotation.setIdentity();
    addFrame({pose.frame, region.link, region.X_LF});
    return poseText(pose, what);
  }

  /// `orientation: ...` or `rpy: ...` of a pose; nothing: ranges of angles about turned axes, which
  /// files cannot say.
  static std::optional<std::pair<std::string, std::string>> rotationText(const FramePose& pose,
                                                                         const std::string& what) {
    const auto isZero = [](const std::pair<double, double>& range) {
      return range.first == 0 && range.second == 0;
    };
    if (std::all_of(pose.rpy.begin(), pose.rpy.end(), isZero))
      return std::pair("orientation", quaternionText(pose.rotation, what));
    // Reading takes leading turns that are single values into the rotation.
    const Eigen::Vector3d turn = robots::rollPitchYaw(pose.rotation);
    if (turn[2] != 0 && !isIdentity(robots::rotationOf({0, 0, turn[2]}))) return std::nullopt;
    std::array<std::string, 3> texts;
    bool leads = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const double own = i < 2 ? turn[static_cast<Eigen::Index>(i)] : 0;
      leads = leads && isZero(pose.rpy[i]);
      if (own != 0 && !leads) return std::nullopt;
      texts[i] = leads ? numberText(own, what) : rangeText(pose.rpy[i], what);
    }
    return std::pair("rpy", listText(texts));
  }

  std::string poseText(const FramePose& pose, const std::string& what) {
    const auto rotation = rotationText(pose, what);
    if (!rotation)
      refuse(what +
             " have ranges of angles beside a rotation, which files cannot say; a frame of "
             "the robot that is turned so is expected");
    std::array<std::string, 3> position;
    for (std::size_t i = 0; i < 3; ++i) position[i] = rangeText(pose.position[i], what);
    MapText text;
    text.add("frame", wordText(pose.frame));
    if (!pose.relative_to.empty()) text.add("relative_to", wordText(pose.relative_to));
    text.add("position", listText(position)).add(rotation->first, rotation->second);
    const FramePose plain;
    if (pose.position_tolerance != plain.position_tolerance)
      text.add("position_tolerance", numberText(pose.position_tolerance, what));
    if (pose.angle_tolerance != plain.angle_tolerance)
      text.add("angle_tolerance", numberText(pose.angle_tolerance, what));
    return text.text();
  }

  std::string stepText(const Step& step) {
    const std::string what = "step '" + step.name + "'";
    MapText text;
    text.add("name", wordText(step.name));
    if (const auto* move = std::get_if<MoveStep>(&step.action)) {
      std::vector<std::string> poses;
      for (const FramePose& pose : move->poses) poses.push_back(poseText(pose, what));
      text.add("move", poses.empty() ? goalText(move->goal, step.name)
                                     : MapText().add("poses", listText(poses)).text());
    } else if (const auto* way = std::get_if<LineStep>(&step.action)) {
      text.add("line", lineText(*way, what));
    } else if (const auto* attach = std::get_if<AttachStep>(&step.action)) {
      MapText map;
      map.add("object", wordText(attach->object)).add("link", wordText(attach->link));
      if (!attach->touch.empty()) map.add("touch", wordsText(attach->touch));
      text.add("attach", map.text());
    } else {
      text.add("detach", wordText(std::get<DetachStep>(step.action).object));
    }
    std::vector<std::string> allowed;
    for (const auto& [a, b] : step.allowed) allowed.push_back(wordsText({a, b}));
    if (!allowed.empty()) text.add("allowed", listText(allowed));
    return text.text();
  }

  static std::string lineText(const LineStep& way, const std::string& what) {
    MapText text;
    text.add("frame", wordText(way.frame));
    if (way.poses.empty()) {
      text.add("by", vectorText(way.by, what));
      if (way.turn != Eigen::Matrix3d::Identity())
        text.add("orientation", quaternionText(way.turn, what));
    } else {
      std::vector<std::string> poses;
      for (const Waypoint& place : way.poses) {
        MapText pose;
        pose.add("position", vectorText(place.position, what));
        if (place.rotation) pose.add("orientation", quaternionText(*place.rotation, what));
        if (place.via) pose.add("via", vectorText(*place.via, what));
        poses.push_back(pose.text());
      }
      text.add("poses", listText(poses));
    }
    if (!way.relative_to.empty()) text.add("relative_to", wordText(way.relative_to));
    if (way.speed < kInfinity) text.add("speed", numberText(way.speed, what));
    return text.add("position_tolerance", numberText(way.position_tolerance, what))
        .add("angle_tolerance", numberText(way.angle_tolerance, what))
        .text();
  }

  void writeConstraints() {
    std::vector<std::string> all;
    for (const Constraint& c : problem_.constraints) {
      const std::string what = "constraint '" + c.name + "'";
      MapText text;
      text.add("name", wordText(c.name)).add("frame", wordText(c.frame));
      if (!c.relative_to.empty()) text.add("relative_to", wordText(c.relative_to));
      if (!isNear(c.X_SR, Pose()))
        refuse(what + " has an X_SR of its own, which files cannot say; the identity is expected");
      if (c.position != std::array{Constraint::kFree, Constraint::kFree, Constraint::kFree}) {
        std::array<std::string, 3> position;
        for (std::size_t i = 0; i < 3; ++i)
          position[i] = c.position[i] == Constraint::kFree ? "any" : rangeText(c.position[i], what);
        text.add("position", listText(position))
            .add("position_tolerance", numberText(c.position_tolerance, what));
      }
      if (c.turn == Constraint::Turn::kFixed)
        text.add("orientation", quaternionText(c.rotation, what));
      if (c.turn == Constraint::Turn::kAxis)
        text.add("axis", vectorText(c.axis, what)).add("direction", vectorText(c.direction, what));
      if (c.turn != Constraint::Turn::kAny) text.add("angle", numberText(c.angle, what));
      all.push_back(text.text());
    }
    list("constraints", all);
  }

  // ----------------------------------------------------------------------------------------------
  // Objects

  std::string hullText(const Shape& shape, const std::string& owner) {
    std::vector<std::string> points;
    for (const Eigen::Vector3d& p : shape.hull()->vertices())
      points.push_back(vectorText(p, "a point of '" + owner + "'"));
    return MapText().add("points", listText(points)).text();
  }

  std::string meshText(const Shape& shape, const std::string& owner) {
    const collision::TriangleMesh& mesh = *shape.mesh();
    // Without closed parts and open edges: a surface, or flat, where both mean the same.
    const bool is_surface = mesh.closedComponentCount() == 0 && mesh.openEdgeCount() == 0;
    const std::string file = files_.addMesh(owner, mesh.vertices(), mesh.triangles());
    if (is_surface) files_.treatments.add(wordText(file), "{solid: surface}");
    return MapText().add("file", wordText(file)).text();
  }

  /// Adds the shape to a map.
  void addShape(const Shape& shape, const std::string& owner, MapText& text) {
    const std::string what = "a shape of '" + owner + "'";
    const auto number = [&](double value) { return numberText(value, what); };
    const auto round = [&](const char* word, const char* length) {
      text.add(word, MapText()
                         .add("radius", number(shape.radius()))
                         .add(length, number(2 * shape.halfLength()))
                         .text());
    };
    switch (shape.type()) {
      case ShapeType::kSphere:
        text.add("sphere", MapText().add("radius", number(shape.radius())).text());
        return;
      case ShapeType::kCapsule:
        return round("capsule", "length");
      case ShapeType::kCylinder:
        return round("cylinder", "length");
      case ShapeType::kCone:
        return round("cone", "height");
      case ShapeType::kBox:
        text.add("box", MapText().add("size", vectorText(2 * shape.halfExtents(), what)).text());
        return;
      case ShapeType::kEllipsoid:
        text.add("ellipsoid",
                 MapText().add("semi_axes", vectorText(shape.halfExtents(), what)).text());
        return;
      case ShapeType::kHalfSpace:
        text.add("half_space", "{}");
        return;
      case ShapeType::kConvexHull:
        text.add("convex_hull", hullText(shape, owner));
        return;
      case ShapeType::kMesh:
        text.add("mesh", meshText(shape, owner));
        return;
      case ShapeType::kDeformable:
        break;
    }
    refuse(what + " deforms; it belongs to world.deforming");
  }

  std::string shapesText(const std::vector<robots::Geometry>& geometries,
                         const std::string& owner) {
    std::vector<std::string> shapes;
    for (const robots::Geometry& geometry : geometries) {
      robots::throwIfStopped(stop_, "a problem was written");
      MapText text;
      if (geometry.name != owner) text.add("name", wordText(geometry.name));
      addShape(geometry.shape, owner, text);
      text.addPose(geometry.X_BG, "a shape of '" + owner + "'");
      shapes.push_back(text.text());
    }
    if (shapes.empty())
      refuse(fmt::format("'{}' has no shape; files name things with shapes only", owner));
    return listText(shapes);
  }

  std::string objectText(const Object& object, const Pose& pose, const Attachment* held) {
    robots::throwIfStopped(stop_, "a problem was written");
    const std::string what = "'" + object.name + "'";
    MapText text;
    text.add("name", wordText(object.name));
    const collision::PoseMotion* const poses = object.motion ? object.motion->poses.get() : nullptr;
    if (poses == nullptr)
      text.addPose(pose, "the pose of " + what);
    else if (poses->isSteady())
      text.addPose(poses->keyPoses().front().X_WB, "the pose of " + what);
    if (object.motion) text.add("moving", movingText(*object.motion, what));
    if (object.color) text.add("color", numbersText(*object.color, "the color of " + what));
    const bool is_simple = object.geometries.size() == 1 &&
                           isNear(object.geometries[0].X_BG, Pose()) &&
                           object.geometries[0].name == object.name;
    if (object.cloud) {
      text.add("cloud", cloudText(*object.cloud, object.X_WO, what));
      if (!object.geometries.empty())
        text.add("shapes", shapesText(object.geometries, object.name));
    } else if (is_simple) {
      addShape(object.geometries[0].shape, object.name, text);
    } else {
      text.add("shapes", shapesText(object.geometries, object.name));
    }
    if (held != nullptr) {
      MapText attach;
      attach.add("link", wordText(model_.links[at(held->link)].name));
      std::vector<std::string> touch;
      for (const int link : held->touch_links) touch.push_back(model_.links[at(link)].name);
      if (!touch.empty()) attach.add("touch", wordsText(touch));
      text.add("attach", attach.text());
    }
    return text.text();
  }

  static std::string movingText(const ObjectMotion& motion, const std::string& what) {
    MapText text;
    if (motion.poses != nullptr && motion.poses->isSteady()) {
      text.add("velocity", vectorText(motion.poses->velocity(), what))
          .add("turning", vectorText(motion.poses->angularVelocity(), what))
          .add("time", numberText(motion.poses->keyPoses().front().time, what));
    } else if (motion.poses != nullptr) {
      std::vector<std::string> keys;
      for (const collision::PoseMotion::Key& key : motion.poses->keyPoses())
        keys.push_back(
            MapText().add("time", numberText(key.time, what)).addPose(key.X_WB, what).text());
      text.add("keys", listText(keys));
    } else if (motion.age != 0) {
      text.add("age", numberText(motion.age, what));
    }
    if (motion.speed_bound < kInfinity)
      text.add("speed_bound", numberText(motion.speed_bound, what));
    if (motion.turn_bound < kInfinity) text.add("turn_bound", numberText(motion.turn_bound, what));
    return text.text();
  }

  static std::string ballsText(std::span<const PointCloud::Ball> balls, const std::string& what) {
    std::vector<std::string> texts;
    for (const PointCloud::Ball& ball : balls)
      texts.push_back(numbersText(
          std::array{ball.center.x(), ball.center.y(), ball.center.z(), ball.radius}, what));
    return listText(texts);
  }

  /// With what was carved out and cropped, and where: the cloud holds for that place and robot. And
  /// with how many balls were thinned out: others stand for several points.
  static std::string cloudText(const PointCloud& cloud, const Pose& X_WC, const std::string& what) {
    MapText text;
    text.add("balls", ballsText(cloud.balls, what));
    const auto removedBy = [&](std::string_view name) {
      std::size_t removed = 0;
      for (const CloudFilter& filter : cloud.filters)
        // (A region that was renewed may have left nothing.)
        if (filter.name == name ||
            (name == "carve" && filter.name == "renew" && cloud.balls.empty()))
          removed += filter.removed;
      return std::to_string(removed);
    };
    if (const std::string removed = removedBy("carve"); removed != "0")
      text.add("carved", MapText().add("removed", removed).addPose(X_WC, what).text());
    if (cloud.isThinned()) text.add("thinned", removedBy("thin"));
    std::vector<std::string> crops;
    for (const PointCloud::Crop& crop : cloud.crops)
      crops.push_back(MapText()
                          .add("removed", crops.empty() ? removedBy("crop") : "0")
                          .add("distance", numberText(crop.distance, what))
                          .addPose(crop.X_WC, what)
                          .add("reach", ballsText(crop.reach_W, what))
                          .text());
    if (!crops.empty()) text.add("cropped", listText(crops));
    return text.text();
  }

  void writeObjects() {
    std::vector<std::string> objects;
    for (const Object& object : problem_.world.objects)
      objects.push_back(objectText(object, object.X_WO, nullptr));
    for (const Attachment& held : problem_.robot.attachments)
      objects.push_back(objectText(held.object, held.X_LO, &held));
    list("objects", objects);
  }

  void writeDeforming() {
    std::vector<std::string> all;
    for (const DeformingObstacle& obstacle : problem_.world.deforming) {
      robots::throwIfStopped(stop_, "a problem was written");
      all.push_back(deformingText(obstacle, files_));
    }
    list("deforming", all);
  }

  // ----------------------------------------------------------------------------------------------
  // Pairs

  using NamePairs = std::vector<std::pair<std::string, std::string>>;

  /// `between` of pairs: their names, or groups that stand for them. `named`: "robot and table".
  std::string betweenText(const NamePairs& pairs, const std::string& named) {
    if (pairs.size() == 1) return wordsText({pairs[0].first, pairs[0].second});
    std::vector<std::string> sides[2];
    const auto add = [](std::vector<std::string>& side, const std::string& name) {
      if (std::find(side.begin(), side.end(), name) == side.end()) side.push_back(name);
    };
    for (const auto& [a, b] : pairs) {
      add(sides[0], a);
      add(sides[1], b);
    }
    NamePairs product;
    for (const std::string& a : sides[0])
      for (const std::string& b : sides[1]) product.emplace_back(a, b);
    if (product != pairs) return {};
    const std::size_t cut = named.find(" and ");
    const std::string names[2] = {named.substr(0, cut),
                                  cut == std::string::npos ? "" : named.substr(cut + 5)};
    std::vector<std::string> words;
    for (std::size_t i = 0; i < 2; ++i) words.push_back(sideName(sides[i], names[i]));
    return wordsText(words);
  }

  /// A name that stands for all members of a side: its own, or that of a group.
  std::string sideName(const std::vector<std::string>& members, const std::string& wanted) {
    if (members.size() == 1) return members[0];
    for (const auto& [name, of] : groups_)
      if (of == members) return name;
    std::vector<std::string> robot;
    for (const robots::Link& link : model_.links) robot.push_back(link.name);
    for (const Attachment& held : problem_.robot.attachments) robot.push_back(held.object.name);
    if (members == robot && !Names(problem_).isKnown(kRobotWord)) return kRobotWord;
    const auto isFree = [&](const std::string& name) {
      return !name.empty() && name != kRobotWord && name != kWorldWord &&
             groups_.count(name) == 0 && !Names(problem_).isKnown(name);
    };
    std::string name = wanted;
    for (int i = 1; !isFree(name); ++i) name = fmt::format("group {}", i);
    groups_[name] = members;
    return name;
  }

  void writePairs() {
    std::vector<std::string> allowed, checked, margins;
    for (const auto& [a, b] : problem_.contacts.allowed) allowed.push_back(wordsText({a, b}));
    for (const auto& [a, b] : problem_.contacts.checked) checked.push_back(wordsText({a, b}));
    if (problem_.contacts.replace_srdf) line("replace_srdf", "true");
    const std::vector<PairMargin>& pairs = problem_.margins.pairs;
    for (std::size_t i = 0; i < pairs.size();) {
      std::size_t end = i + 1;
      while (!pairs[i].group.empty() && end < pairs.size() && pairs[end].group == pairs[i].group &&
             pairs[end].margin == pairs[i].margin)
        ++end;
      NamePairs names;
      for (std::size_t k = i; k < end; ++k) names.emplace_back(pairs[k].a, pairs[k].b);
      const std::string margin = numberText(pairs[i].margin, "a margin");
      const std::string between = betweenText(names, pairs[i].group);
      if (!between.empty())
        margins.push_back(MapText().add("between", between).add("margin", margin).text());
      else
        for (const auto& [a, b] : names)
          margins.push_back(
              MapText().add("between", wordsText({a, b})).add("margin", margin).text());
      i = end;
    }
    for (const Wish& wish : problem_.margins.wishes) {
      const std::string what = "wish '" + wish.name + "'";
      const std::string between = betweenText(wish.pairs, wish.name);
      if (between.empty())
        refuse(what +
               " is between pairs that are not all pairs of two groups; a wish for each "
               "group is expected");
      margins.push_back(MapText()
                            .add("between", between)
                            .add("wish", numberText(wish.clearance, what))
                            .add("weight", numberText(wish.weight, what))
                            .text());
    }
    if (!groups_.empty()) {
      MapText groups;
      for (const auto& [name, members] : groups_) groups.add(wordText(name), wordsText(members));
      line("groups", groups.text());
    }
    list("allowed", allowed);
    list("checked", checked);
    list("margins", margins);
  }

  // ----------------------------------------------------------------------------------------------
  // Settings

  /// A setting's value; empty where it is the one that a file without it has.
  std::string valueText(const Setting& setting) const {
    static const Problem plain;
    const std::string what(setting.member.empty() ? setting.key : setting.member);
    if (const auto* place = std::get_if<SettingPlace<bool>>(&setting.value)) {
      const bool value = *settingValue(problem_, *place);
      return value == *settingValue(plain, *place) ? "" : value ? "true" : "false";
    }
    if (const auto* place = std::get_if<SettingPlace<double>>(&setting.value)) {
      const double *value = settingValue(problem_, *place), *usual = settingValue(plain, *place);
      if (value == nullptr || (usual != nullptr && *value == *usual) ||
          *value == setting.range.none)
        return "";
      // 0 and infinity both stand for an unlimited time.
      const bool is_limit = setting.key == "limits.time";
      return numberText(is_limit && std::isinf(*value) ? 0 : *value, what);
    }
    if (const auto* place = std::get_if<SettingPlace<std::int64_t>>(&setting.value)) {
      const std::int64_t value = *settingValue(problem_, *place);
      return value == *settingValue(plain, *place) ? "" : fmt::format("{}", value);
    }
    if (const auto* place = std::get_if<SettingPlace<std::uint64_t>>(&setting.value)) {
      const std::uint64_t value = *settingValue(problem_, *place);
      return value == *settingValue(plain, *place) ? "" : fmt::format("{}", value);
    }
    if (const auto* place = std::get_if<SettingPlace<std::string>>(&setting.value)) {
      const std::string& value = *settingValue(problem_, *place);
      return value == *settingValue(plain, *place) ? "" : wordText(value);
    }
    MapText map;
    if (const auto* place =
            std::get_if<SettingPlace<std::map<std::string, double>>>(&setting.value))
      for (const auto& [name, value] : *settingValue(problem_, *place))
        map.add(wordText(name), numberText(value, what));
    if (const auto* place =
            std::get_if<SettingPlace<std::map<std::string, std::string>>>(&setting.value))
      for (const auto& [name, value] : *settingValue(problem_, *place))
        map.add(wordText(name), quoted(value));
    if (const auto* choice = std::get_if<WordSetting>(&setting.value); choice && !choice->or_map) {
      const int value = choice->get(problem_);
      for (const WordSetting::Word& word : choice->words)
        if (word.value == value && value != choice->get(plain)) return std::string(word.text);
    }
    return map.empty() ? "" : map.text();
  }

  void writeSettings() {
    for (const char* const place : {"", "planner", "limits", "execution"}) {
      MapText section;
      for (const Setting& setting : settings()) {
        const std::string_view key = keyIn(place, setting);
        if (key.empty() || (*place == '\0' && key == "name") ||
            key.find('.') != std::string_view::npos)
          continue;
        const std::string value = valueText(setting);
        if (value.empty()) continue;
        if (*place == '\0')
          line(key, value);
        else
          section.add(key, value);
      }
      if (!section.empty()) line(place, section.text());
    }
    writeObjective();
  }

  static std::string termText(const CostTerm& term, bool is_alone) {
    MapText text;
    text.add(term.nearness.kind == Nearness::Kind::kHinge ? "hinge" : "inverse",
             numberText(term.nearness.distance, "objective"));
    text.add("of", term.of == Pairs::kWorld ? "world" : term.of == Pairs::kSelf ? "self" : "all");
    if (!is_alone) text.add("weight", numberText(term.weight, "objective"));
    return text.text();
  }

  void writeObjective() {
    const auto* const cost = std::get_if<MinimumCost>(&problem_.objective);
    MapText map;
    if (cost == nullptr) {
      const std::string word = toString(problem_.objective);
      for (const Setting& setting : settings()) {
        const std::string_view key = keyIn("objective." + word, setting);
        if (key.empty()) continue;
        if (const std::string value = valueText(setting); !value.empty()) map.add(key, value);
      }
      if (!map.empty())
        line("objective", MapText().add(word, map.text()).text());
      else if (!std::holds_alternative<MinimumLength>(problem_.objective))
        line("objective", word);
      return;
    }
    if (cost->length == 0 && cost->terms.size() == 1 && cost->terms[0].weight == 1 &&
        !cost->terms[0].worst)
      return line("objective", MapText().add("integral", termText(cost->terms[0], true)).text());
    std::vector<std::string> integrals, worst;
    for (const CostTerm& term : cost->terms)
      (term.worst ? worst : integrals).push_back(termText(term, false));
    map.add("length", numberText(cost->length, "objective"));
    if (!integrals.empty()) map.add("integral", listText(integrals));
    if (!worst.empty()) map.add("worst", listText(worst));
    line("objective", MapText().add("weighted", map.text()).text());
  }

  const Problem& problem_;
  const Model& model_;
  ProblemText result_;
  SavedFiles files_;
  const std::function<std::string(const std::string&)>& name_of_;
  const robots::Stop& stop_;
  std::string text_;
  MapText frames_;
  int added_frames_ = 0;
  std::map<std::string, std::vector<std::string>> groups_;
};

}  // namespace

bool isGivenByPlace(const std::string& name) {
  return name == "goal" || (name.starts_with("goal ") && name.size() > 5 &&
                            name.find_first_not_of("0123456789", 5) == std::string::npos);
}

ProblemText problemText(const Problem& problem, const std::string& files_folder,
                        const std::function<std::string(const std::string&)>& nameOf,
                        const robots::Stop& stop) {
  return Writer(problem, files_folder, nameOf, stop).write();
}

}  // namespace leeway::planner
