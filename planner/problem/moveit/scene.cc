// Reads the objects of MoveIt's planning scene (moveit_msgs/PlanningScene).

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "planner/base/did_you_mean.h"
#include "planner/problem/moveit/fields.h"
#include "planner/problem/moveit/header_frames.h"
#include "planner/problem/read_shapes.h"
#include "planner/validate/names.h"

namespace leeway::planner {

using robots::Model;
using robots::Pose;

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

bool readMoveitBoolean(const YamlReader& reader) {
  if (reader.isScalar())
    if (const std::string word = reader.text(); word == "True" || word == "False")
      return word == "True";
  return reader.boolean();
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
void readOctomap(const YamlReader& map, HeaderFrames& frames, SceneObjects& objects,
                 std::vector<std::string>& warnings) {
  const auto octree = map.find("octomap");
  if (!octree || !octree->isMap()) return;
  const auto data = octree->find("data");
  if (!hasContent(data)) return;
  const std::string bytes = readBytes(*data);
  OctreeData read;
  read.id = octree->at("id", "OcTree").text();
  read.resolution = octree->at("resolution", "the edge of the smallest cells [m]").number();
  read.binary = readMoveitBoolean(octree->at("binary", "true or false"));
  read.data = bytes;
  // As in MoveIt, the frame is that of the outer header.
  if (const auto header = octree->find("header"); hasContent(header))
    if (const auto id = header->find("frame_id"); hasContent(id))
      warnings.push_back(fmt::format("{}:{}: {} is not used; {}.header.frame_id says the frame",
                                     id->file(), id->line(), id->where(), map.where()));
  Object object{"<octomap>", {}, frames.ofObject(map)};
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

void readSceneObjects(const YamlReader& scene, const robots::LoadOptions& load,
                      HeaderFrames& frames, Problem& problem) {
  const auto world = scene.find("world");
  if (!world || world->isNull()) return;
  const auto octomap = world->find("octomap"), list = world->find("collision_objects");
  if (!hasContent(octomap) && !hasContent(list)) return;
  SceneObjects objects(problem);
  if (hasContent(octomap) && octomap->isMap())
    octomap->readOn([&] { readOctomap(*octomap, frames, objects, problem.warnings); });
  if (!hasContent(list)) return;
  list->eachItem([&](const YamlReader& entry) {
    const bool is_whole = entry.readOn([&] {
      Object object = readCollisionObject(entry, load, problem.warnings);
      object.X_WO = frames.ofObject(entry) * object.X_WO;
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
/// start. An object without shapes is the object of the world with that name. `of_scene`: the
/// scene attaches it, not the request.
void readAttached(const YamlReader& map, bool of_scene, const robots::LoadOptions& load,
                  HeaderFrames& frames, Problem& problem) {
  const Model& model = *problem.robot.model;
  const YamlReader link_name = map.at("link_name", "the link that holds it");
  const YamlReader of = map.at("object", "the object that is held");
  Attachment held;
  held.link = readLink(link_name, model);
  if (const auto touch = map.find("touch_links"); hasContent(touch))
    for (const YamlReader& link : touch->items()) held.touch_links.push_back(readLink(link, model));
  refuseContent(of, "planes", "a held object of primitives or meshes");
  held.object = readCollisionObject(of, load, problem.warnings);

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
    held.X_LO = frames.inLink(of, held.object.X_WO, held.link, of_scene);
  } else {
    const bool is_taken = in_world != world.end() || model.findLink(held.object.name) >= 0;
    if (const std::string fault = objectNameFault(held.object.name, is_taken); !fault.empty())
      of.fail(fmt::format("object '{}' {}", held.object.name, fault));
    // Its pose is in the frame of a link, usually its own, or in a frame of the scene.
    held.X_LO = frames.inLink(of, held.link, of_scene) * held.object.X_WO;
  }
  held.object.X_WO = Pose();
  problem.robot.attachments.push_back(std::move(held));
}

}  // namespace

void readAttachedObjects(const YamlReader* scene, const YamlReader& request,
                         const robots::LoadOptions& load, HeaderFrames& frames, Problem& problem) {
  const auto heldIn = [](const std::optional<YamlReader>& state) {
    const auto held = state && state->isMap() ? state->find("attached_collision_objects")
                                              : std::optional<YamlReader>();
    return hasContent(held) ? held->items() : std::vector<YamlReader>();
  };
  std::set<std::string> names;
  const auto read = [&](const YamlReader& map, bool of_scene) {
    readAttached(map, of_scene, load, frames, problem);
    if (!names.insert(problem.robot.attachments.back().object.name).second)
      map.fail("the object is held twice; once is expected");
  };
  const auto start = request.find("start_state");
  for (const YamlReader& map : heldIn(start)) read(map, false);
  if (scene == nullptr) return;
  // The request may place an attached object elsewhere than the scene does.
  const std::set<std::string> requested = names;
  const auto diff = hasContent(start) ? start->find("is_diff") : std::nullopt;
  const bool changes_scene = !hasContent(start) || (hasContent(diff) && readMoveitBoolean(*diff));
  for (const YamlReader& map : heldIn(scene->find("robot_state"))) {
    const auto object = map.find("object");
    const auto id = object && object->isMap() ? object->find("id") : std::nullopt;
    if (id && id->isScalar() && requested.count(std::string(id->text())) != 0) continue;
    read(map, true);
    if (!changes_scene)
      problem.warnings.push_back(
          fmt::format("{}:{}: '{}' is held as the scene says; MoveIt would drop it, because "
                      "start_state.is_diff is not true",
                      map.file(), map.line(), problem.robot.attachments.back().object.name));
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
  std::vector<std::string> world = {kWorldWord};  // it holds for objects that are added later
  if (const Names names(problem); !names.marginFault(padding.begin()->first, kWorldWord).empty()) {
    world.clear();
    for (const Object& object : problem.world.objects) world.push_back(object.name);
    for (const DeformingObstacle& obstacle : problem.world.deforming)
      world.push_back(obstacle.object.name);
  }
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
