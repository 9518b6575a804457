// Reads the objects of MoveIt's planning scene (moveit_msgs/PlanningScene).

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "leeway/robots/kinematics.h"
#include "planner/base/did_you_mean.h"
#include "planner/problem/moveit/fields.h"
#include "planner/problem/read_shapes.h"
#include "planner/validate/names.h"

namespace leeway::planner {
namespace {

using robots::Model;
using robots::Pose;

/// Reads a text that may be missing. MoveIt writes an empty text if a value is not set.
std::string optionalText(const YamlReader& map, std::string_view key) {
  const auto value = map.find(key);
  return hasContent(value) ? value->text() : std::string();
}

/// The frames that objects may refer to, with their poses in the planning frame (the robot's root).
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
        fmt::format("unknown frame '{}' in {}{}", name, header->where(), didYouMean(name, known)));
  }
  return found->second;
}

}  // namespace

bool hasContent(const std::optional<YamlReader>& value) {
  if (!value || value->isEmpty()) return false;
  if (!value->isMap()) return true;
  // A message has content if one of its fields has some.
  const auto fields = value->entries();
  return std::any_of(fields.begin(), fields.end(),
                     [](const auto& field) { return hasContent(field.second); });
}

void refuseContent(const YamlReader& map, std::string_view key, std::string_view accepted) {
  if (const auto value = map.find(key); hasContent(value))
    value->fail(fmt::format("{} is not supported; {} is expected", value->where(), accepted));
}

Eigen::Vector3d readMoveitVector(const YamlReader& vector) {
  if (!vector.isMap()) return vector.vector3();
  return {vector.at("x", "a number").number(), vector.at("y", "a number").number(),
          vector.at("z", "a number").number()};
}

Eigen::Vector4d readMoveitQuaternion(const YamlReader& reader, std::vector<std::string>& warnings) {
  std::vector<double> q;
  if (reader.isMap())
    for (const char* key : {"x", "y", "z", "w"}) q.push_back(reader.at(key, "a number").number());
  else
    q = reader.numbers();
  // A message with all fields at their defaults. MoveIt also takes it as the identity.
  if (q == std::vector<double>(4, 0.0)) {
    warnings.push_back(fmt::format("{}:{}: {} is all 0, taken as no rotation", reader.file(),
                                   reader.line(), reader.where()));
    return Eigen::Vector4d::UnitW();
  }
  return unitQuaternion(reader, q, warnings);
}

Pose readMoveitPose(const YamlReader& map, const char* translation, const char* rotation,
                    std::vector<std::string>& warnings) {
  Pose pose;
  if (const auto p = map.find(translation)) pose.translation = readMoveitVector(*p);
  if (const auto q = map.find(rotation))
    pose.rotation = rotationFromQuaternion(readMoveitQuaternion(*q, warnings));
  return pose;
}

SceneObjects::SceneObjects(Problem& problem) : problem_(problem) {
  for (const robots::Link& link : problem.robot.model->links) names_.insert(link.name);
}

void SceneObjects::add(const std::string& file, int line, Object object) {
  if (object.geometries.empty())
    throw robots::InputError(
        file, line,
        fmt::format("object '{}' has no shape; primitives, meshes or planes are expected",
                    object.name));
  if (const std::string fault = objectNameFault(object.name, !names_.insert(object.name).second);
      !fault.empty())
    throw robots::InputError(file, line, fmt::format("object '{}' {}", object.name, fault));
  problem_.world.objects.push_back(std::move(object));
}

namespace {

/// Reads the content of octomap_msgs/Octomap: a list of bytes, signed or unsigned.
std::string readBytes(const YamlReader& data) {
  std::string bytes;
  for (const YamlReader& item : data.items()) {
    const std::int64_t value = item.integer(-128);
    if (value > 255)
      item.fail(
          fmt::format("{} is {}; a byte, from -128 to 255, is expected", item.where(), value));
    bytes.push_back(static_cast<char>(value));
  }
  return bytes;
}

/// Reads octomap_msgs/OctomapWithPose as an object with the name that MoveIt's matrices use for it.
/// Unknown space is free, as in MoveIt.
void readOctomap(const YamlReader& map, const Frames& frames, SceneObjects& objects,
                 std::vector<std::string>& warnings) {
  const auto octree = map.find("octomap");
  if (!octree || !octree->isMap()) return;
  const auto data = octree->find("data");
  if (!hasContent(data)) return;
  const std::string bytes = readBytes(*data);
  OctreeData read;
  read.id = octree->at("id", "OcTree").text();
  read.resolution = octree->at("resolution", "the edge of the smallest cells [m]").number();
  read.binary = octree->at("binary", "true or false").boolean();
  read.data = bytes;
  Object object{"<octomap>", {}, framePose(map, frames)};
  if (const auto origin = map.find("origin"); origin && origin->isMap())
    object.X_WO = object.X_WO * readMoveitPose(*origin, "position", "orientation", warnings);
  try {
    object.geometries = namedOctree(*octree, octreeBoxes(read, Unseen::kFree), object.name,
                                    Unseen::kFree, warnings);
  } catch (const std::invalid_argument& error) {
    octree->fail(fmt::format("{}: {}", octree->where(), error.what()));
  }
  if (!object.geometries.empty()) objects.add(map.file(), map.line(), std::move(object));
}

}  // namespace

void readSceneObjects(const YamlReader& scene, const robots::LoadOptions& load, Problem& problem) {
  const auto world = scene.find("world");
  if (!world || world->isNull()) return;
  const auto octomap = world->find("octomap"), list = world->find("collision_objects");
  if (!hasContent(octomap) && !hasContent(list)) return;
  const Frames frames = readFrames(scene, *problem.robot.model, problem.warnings);
  SceneObjects objects(problem);
  if (hasContent(octomap) && octomap->isMap())
    octomap->readOn([&] { readOctomap(*octomap, frames, objects, problem.warnings); });
  if (!hasContent(list)) return;
  list->eachItem([&](const YamlReader& entry) {
    const bool is_whole = entry.readOn([&] {
      Object object = readCollisionObject(entry, load, problem.warnings);
      object.X_WO = framePose(entry, frames) * object.X_WO;
      objects.add(entry.file(), entry.line(), std::move(object));
    });
    // If reading goes on, attached objects may still name this one.
    if (!is_whole)
      problem.world.objects.push_back({entry.at("id", "the object's name").text(), {}, {}});
  });
}

namespace {

int readLink(const YamlReader& name, const Model& model) {
  const int link = model.findLink(name.text());
  if (link >= 0) return link;
  std::vector<std::string> known;
  for (const robots::Link& candidate : model.links) known.push_back(candidate.name);
  name.fail(fmt::format("unknown link '{}' in {}{}", name.text(), name.where(),
                        didYouMean(name.text(), known)));
}

/// Reads one moveit_msgs/AttachedCollisionObject, attached while the robot is at the problem's
/// start. An object without shapes is the object of the world with that name.
void readAttached(const YamlReader& map, const Frames& scene_frames,
                  const robots::LoadOptions& load, Problem& problem) {
  const Model& model = *problem.robot.model;
  const YamlReader link_name = map.at("link_name", "the link that holds it");
  const YamlReader of = map.at("object", "the object that is held");
  Attachment held;
  held.link = readLink(link_name, model);
  if (const auto touch = map.find("touch_links"); hasContent(touch))
    for (const YamlReader& link : touch->items()) held.touch_links.push_back(readLink(link, model));
  refuseContent(of, "planes", "a held object of primitives or meshes");
  held.object = readCollisionObject(of, load, problem.warnings);

  std::vector<Pose> X_WL(model.links.size());
  robots::forwardKinematics(model, problem.start, X_WL);
  const std::size_t link = static_cast<std::size_t>(held.link);
  auto& world = problem.world.objects;
  const auto in_world = std::find_if(world.begin(), world.end(), [&](const Object& object) {
    return object.name == held.object.name;
  });
  if (held.object.geometries.empty()) {
    if (in_world == world.end())
      of.fail(fmt::format(
          "object '{}' has no shape, and the world no object of that name; shapes are expected",
          held.object.name));
    held.object = std::move(*in_world);
    world.erase(in_world);
    held.X_LO = X_WL[link].inverse() * held.object.X_WO;
  } else {
    const bool is_taken = in_world != world.end() || model.findLink(held.object.name) >= 0;
    if (const std::string fault = objectNameFault(held.object.name, is_taken); !fault.empty())
      of.fail(fmt::format("object '{}' {}", held.object.name, fault));
    // Its pose is in the frame of a link, usually its own, or in a frame of the scene.
    Frames frames = scene_frames;
    for (std::size_t i = 0; i < X_WL.size(); ++i) frames[model.links[i].name] = X_WL[i];
    for (auto& [name, pose] : frames) pose = X_WL[link].inverse() * pose;
    frames[model.links[link].name] = Pose();  // exactly the identity
    held.X_LO = framePose(of, frames) * held.object.X_WO;
  }
  held.object.X_WO = Pose();
  problem.robot.attachments.push_back(std::move(held));
}

}  // namespace

void readAttachedObjects(const YamlReader* scene, const YamlReader& request,
                         const robots::LoadOptions& load, Problem& problem) {
  const auto heldIn = [](const std::optional<YamlReader>& state) {
    const auto held = state && state->isMap() ? state->find("attached_collision_objects")
                                              : std::optional<YamlReader>();
    return hasContent(held) ? held->items() : std::vector<YamlReader>();
  };
  Frames frames = {{"", Pose()}, {"world", Pose()}};
  if (scene != nullptr) frames = readFrames(*scene, *problem.robot.model, problem.warnings);
  std::set<std::string> names;
  const auto read = [&](const YamlReader& map) {
    readAttached(map, frames, load, problem);
    if (!names.insert(problem.robot.attachments.back().object.name).second)
      map.fail("the object is held twice; once is expected");
  };
  for (const YamlReader& map : heldIn(request.find("start_state"))) read(map);
  if (scene == nullptr) return;
  // The start comes from the request, which may place an attached object elsewhere than the scene
  // does.
  const std::set<std::string> requested = names;
  for (const YamlReader& map : heldIn(scene->find("robot_state"))) {
    const auto object = map.find("object");
    const auto id = object && object->isMap() ? object->find("id") : std::nullopt;
    if (!id || !id->isScalar() || requested.count(std::string(id->text())) == 0) read(map);
  }
}

LinkPadding readLinkPadding(const YamlReader& scene, const Model& model) {
  LinkPadding padding;
  if (const auto list = scene.find("link_padding"); hasContent(list))
    for (const YamlReader& entry : list->items()) {
      const YamlReader name = entry.at("link_name", "the name of a link");
      const double value = entry.at("padding", "a distance [m]").sizeNumber();
      if (value > 0)
        padding[model.links[static_cast<std::size_t>(readLink(name, model))].name] = value;
    }
  if (const auto list = scene.find("link_scale"); hasContent(list))
    for (const YamlReader& entry : list->items())
      if (const YamlReader scale = entry.at("scale", "1"); scale.number() != 1)
        scale.fail(fmt::format("{} is {}; 1 is expected: link_padding keeps a distance",
                               scale.where(), scale.number()));
  return padding;
}

void applyLinkPadding(const LinkPadding& padding, Problem& problem) {
  if (padding.empty()) return;
  std::vector<std::string> world;
  for (const Object& object : problem.world.objects) world.push_back(object.name);
  for (const DeformingObstacle& obstacle : problem.world.deforming)
    world.push_back(obstacle.object.name);
  const auto keep = [&](const std::string& name, double distance) {
    if (distance > problem.margins.common)
      for (const std::string& object : world)
        problem.margins.pairs.push_back({name, object, distance, name + " and the world"});
  };
  for (const auto& [name, distance] : padding) keep(name, distance);
  for (const Attachment& held : problem.robot.attachments)
    if (const auto of =
            padding.find(problem.robot.model->links[static_cast<std::size_t>(held.link)].name);
        of != padding.end())
      keep(held.object.name, of->second);
}

}  // namespace leeway::planner
