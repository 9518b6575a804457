// Objects of MoveIt's planning scene (moveit_msgs/PlanningScene).

#include <fmt/format.h>

#include <map>
#include <set>

#include "planner/base/nearest_name.h"
#include "planner/problem/moveit/fields.h"
#include "planner/problem/read_shapes.h"

namespace leeway::planner {
namespace {

using robots::Model;
using robots::Pose;
using Shape = collision::Shape;

/// MoveIt writes an empty text where it has nothing to say.
std::string optionalText(const YamlReader& map, std::string_view key) {
  const auto value = map.find(key);
  return value && value->isScalar() && !value->isEmpty() ? value->text() : std::string();
}

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
  try {
    if (count == 3) return Shape::box(Eigen::Vector3d(d[0], d[1], d[2]) / 2);
    if (count == 1) return Shape::sphere(d[0]);
    // MoveIt's cone has its apex at +z and its origin at half the height, as ours.
    return word == "cylinder" ? Shape::cylinder(d[1], d[0] / 2) : Shape::cone(d[1], d[0] / 2);
  } catch (const collision::InvalidShape& error) {
    sizes.fail(fmt::format("{}: {}", sizes.where(), error.what()));
  }
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

}  // namespace

bool hasContent(const std::optional<YamlReader>& value) { return value && !value->isEmpty(); }

void refuseContent(const YamlReader& map, std::string_view key, std::string_view accepted) {
  if (const auto value = map.find(key); hasContent(value))
    value->fail(fmt::format("{} is not supported; {} is expected", value->where(), accepted));
}

Pose readMoveitPose(const YamlReader& map, const char* translation, const char* rotation,
                    std::vector<std::string>& warnings) {
  Pose pose;
  if (const auto p = map.find(translation)) pose.translation = p->vector3();
  if (const auto q = map.find(rotation))
    pose.rotation = rotationFromQuaternion(readQuaternion(*q, warnings));
  return pose;
}

void readSceneObjects(const YamlReader& scene, Problem& problem) {
  const auto world = scene.find("world");
  if (!world || world->isNull()) return;
  if (const auto octomap = world->find("octomap"); octomap && octomap->isMap())
    if (const auto inner = octomap->find("octomap"); inner && inner->isMap())
      refuseContent(*inner, "data", "an empty octomap");
  const auto objects = world->find("collision_objects");
  if (!hasContent(objects)) return;
  const Frames frames = readFrames(scene, *problem.robot.model, problem.warnings);
  std::set<std::string> names;
  for (const robots::Link& link : problem.robot.model->links) names.insert(link.name);
  for (const YamlReader& entry : objects->items()) {
    Object object = readCollisionObject(entry, problem.warnings);
    object.X_WO = framePose(entry, frames) * object.X_WO;
    if (!names.insert(object.name).second)
      entry.fail(fmt::format(
          "object '{}' has the name of another object or link; a name of its own is expected",
          object.name));
    problem.world.objects.push_back(std::move(object));
  }
}

}  // namespace leeway::planner
