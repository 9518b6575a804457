#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "leeway/planner/depth_image.h"
#include "planner/problem/read_shapes.h"
#include "planner/sensed/cloud_source.h"
#include "planner/validate/checks.h"
#include "planner/validate/format_keys.h"
#include "robots/base/read_file.h"

namespace leeway::planner {
namespace {

using robots::Geometry;

/// Whether `name` moves with the robot. A start by poses places the robot only after it is solved.
bool isOfRobot(const Problem& problem, const std::string& name) {
  return problem.robot.model->findLink(name) >= 0 ||
         std::any_of(problem.robot.attachments.begin(), problem.robot.attachments.end(),
                     [&](const Attachment& held) { return held.object.name == name; });
}

/// Leaves out of the object's cloud and unseen space what `carve` names.
PointCloud carvedOf(const YamlReader& cloud, const std::vector<std::string>& names,
                    const Problem& problem, Object& object) {
  const YamlReader listed = *cloud.find("carve");
  for (const std::string& name : names)
    if (!problem.start_poses.empty() && isOfRobot(problem, name))
      listed.fail(
          fmt::format("{} names '{}', and the start is given by poses; a start by joint "
                      "values, which places the robot, is expected",
                      listed.where(), name));
  const std::vector<Geometry> shapes_W = carveShapes(problem, names, {});
  std::string what;
  for (const YamlReader& item : listed.items()) what += (what.empty() ? "" : ", ") + item.text();
  const auto margin = cloud.find("carve_margin");
  const double within = margin ? margin->sizeNumber() : 0;
  PointCloud kept = *object.cloud;
  carve(kept, object.geometries, object.X_WO, shapes_W, within, what);
  return kept;
}

DepthCamera readCamera(const YamlReader& map) {
  map.expectKeys(keysOf("camera"));
  DepthCamera camera;
  camera.fx = map.at("fx", "the focal length along rows [pixels]").number();
  camera.fy = map.at("fy", "the focal length along columns [pixels]").number();
  camera.cx = map.at("cx", "the column of the optical axis [pixels]").number();
  camera.cy = map.at("cy", "the row of the optical axis [pixels]").number();
  if (const auto scale = map.find("scale")) camera.scale = scale->number();
  if (const auto slant = map.find("slant")) camera.slant = slant->number();
  try {
    depthSpread(camera);
  } catch (const std::invalid_argument& error) {
    map.fail(fmt::format("{}: {}", map.where(), error.what()));
  }
  return camera;
}

void expectUnseenFree(const YamlReader& cloud) {
  if (const auto unseen = cloud.find("unseen"); unseen && unseen->text() != "free")
    unseen->fail(
        fmt::format("{} is '{}'; only 'free' is accepted without a camera: add shapes where "
                    "something that was not seen may be",
                    unseen->where(), unseen->text()));
}

/// The space that counts as occupied because the camera did not see it; nothing if it is free.
std::optional<UnseenSpace> readUnseen(const YamlReader& cloud, const YamlReader& camera) {
  const auto unseen = cloud.find("unseen");
  const auto range = camera.find("range"), parts = camera.find("parts");
  const bool is_free = !unseen || unseen->text() == "free";
  if (!is_free && unseen->text() != "occupied")
    unseen->fail(
        fmt::format("{} is '{}'; free or occupied is expected", unseen->where(), unseen->text()));
  for (const auto& only : {range, parts})
    if (is_free && only)
      only->fail(
          fmt::format("{} stands without 'unseen: occupied'; both are expected", only->where()));
  if (is_free) return std::nullopt;
  if (!range)
    camera.fail(
        fmt::format("{} has no 'range' beside 'unseen: occupied'; the depth [m] up to "
                    "which unseen space is occupied is expected",
                    camera.where()));
  UnseenSpace space;
  space.range = range->number();
  if (parts) space.most_parts = static_cast<std::size_t>(parts->integer(1));
  return space;
}

/// Reads the points of the file, or the pixels of a depth image, with their radii.
PointCloud loadFile(const YamlReader& cloud, const YamlReader& file, double radius,
                    std::vector<Geometry>& unseen, std::vector<std::string>& warnings,
                    const robots::Stop& stop) {
  const std::string path = resolvedPath(file), ending = robots::endingOf(path);
  const auto camera = cloud.find("camera");
  const bool is_picture = ending == ".png" || ending == ".pgm";
  if (!is_picture && camera)
    camera->fail(
        fmt::format("{} stands beside '{}', which is no depth image; .png or .pgm is "
                    "expected",
                    camera->where(), file.text()));
  if (!is_picture) expectUnseenFree(cloud);
  if (!is_picture) return loadCloud(path, radius, warnings, stop);
  if (!camera)
    file.fail(
        fmt::format("{} is '{}', a picture; 'camera' with fx, fy, cx and cy is expected "
                    "beside it",
                    file.where(), file.text()));
  const DepthCamera read = readCamera(*camera);
  const auto mask = camera->find("mask");
  const std::optional<UnseenSpace> space = readUnseen(cloud, *camera);
  return loadDepthImage(path, mask ? resolvedPath(*mask) : std::string(), read, radius, stop,
                        space ? &*space : nullptr, &unseen);
}

std::vector<PointCloud::Ball> readBallList(const YamlReader& list, const robots::Stop& stop) {
  std::vector<PointCloud::Ball> balls;
  for (const YamlReader& item : list.items()) {
    if (balls.size() % 1024 == 0) robots::throwIfStopped(stop, "a cloud was read");
    const std::vector<double> v = item.numbers();
    if (v.size() != 4)
      item.fail(fmt::format("{} is a list of {}; [x, y, z, radius] in m is expected", item.where(),
                            v.size()));
    balls.push_back({{v[0], v[1], v[2]}, v[3]});
  }
  return balls;
}

/// `carved`, `thinned` and `cropped`: what a cloud lacked when it was saved, and for which place
/// and robot.
void readSavedFilters(const YamlReader& map, PointCloud& cloud, std::vector<std::string>& warnings,
                      const robots::Stop& stop) {
  const std::string what = "balls, before the cloud was saved";
  const auto removed = [](const YamlReader& of, int least) {
    return static_cast<std::size_t>(
        of.at("removed", "how many balls the filter removed").integer(least));
  };
  if (const auto carved = map.find("carved")) {
    carved->expectKeys(keysOf("carved"));
    cloud.filters.push_back({"carve", what, removed(*carved, 1), readPose(*carved, warnings)});
  }
  if (const auto cropped = map.find("cropped"))
    for (const YamlReader& crop : cropped->items()) {
      crop.expectKeys(keysOf("cropped"));
      cloud.filters.push_back({"crop", what, removed(crop, 0)});
      cloud.crops.push_back({crop.at("distance", "the crop's distance [m]").sizeNumber(),
                             readPose(crop, warnings),
                             readBallList(crop.at("reach", "the robot's reach"), stop)});
    }
  if (const auto thin = map.find("thinned"))
    cloud.filters.push_back({"thin", what, static_cast<std::size_t>(thin->integer(1))});
}

/// `balls:` of a cloud. None may be left where all were carved out or cropped.
std::shared_ptr<const PointCloud> readBalls(const YamlReader& map, const YamlReader& balls,
                                            std::vector<std::string>& warnings,
                                            const robots::Stop& stop) {
  PointCloud cloud;
  readSavedFilters(map, cloud, warnings, stop);
  cloud.balls = readBallList(balls, stop);
  if (cloud.balls.empty() && cloud.filters.empty())
    balls.fail(fmt::format("{} is empty; at least one ball is expected", balls.where()));
  if (const std::string fault = cloudFault(cloud); !fault.empty())
    balls.fail(fmt::format("{}: {}", balls.where(), fault));
  return std::make_shared<const PointCloud>(std::move(cloud));
}

}  // namespace

void readCloud(const YamlReader& cloud, Object& object, std::vector<std::string>& warnings,
               const robots::Stop& stop) {
  cloud.expectKeys(keysOf("cloud"));
  if (const auto margin = cloud.find("carve_margin"); margin && !cloud.has("carve"))
    margin->fail("key 'carve_margin' stands without 'carve'; both are expected");
  if (const auto balls = cloud.find("balls")) {
    for (const char* const other : {"file", "camera", "radius"})
      if (const auto beside = cloud.find(other))
        beside->fail(fmt::format("key '{}' stands beside 'balls' in {}; one of them is expected",
                                 other, cloud.where()));
    expectUnseenFree(cloud);
    object.cloud = readBalls(cloud, *balls, warnings, stop);
    return;
  }
  for (const char* const key : {"carved", "cropped", "thinned"})
    if (const auto saved = cloud.find(key))
      saved->fail(
          fmt::format("key '{}' stands without 'balls'; it says what a saved cloud lacks", key));
  const YamlReader file =
      cloud.at("file", "a file of points (PLY, PCD, XYZ, CSV) or a depth image (PNG, PGM)");
  const YamlReader radius = cloud.at("radius", "the radius of each point's ball [m]");
  const std::string path = resolvedPath(file);
  if (!std::filesystem::exists(path))
    file.fail(fmt::format("{} names '{}', and there is no such file; an existing file is expected",
                          file.where(), path));
  try {
    object.cloud = std::make_shared<const PointCloud>(
        loadFile(cloud, file, radius.number(), object.geometries, warnings, stop));
  } catch (const std::invalid_argument& error) {
    const YamlReader& wrong = std::string_view(error.what()).starts_with("radius") ? radius : file;
    wrong.fail(fmt::format("{}: {}", wrong.where(), error.what()));
  }
}

std::vector<Geometry> namedOctree(const YamlReader& place, std::vector<Geometry> boxes,
                                  const std::string& owner, Unseen unseen,
                                  std::vector<std::string>& warnings) {
  for (Geometry& box : boxes) box.name = owner;
  warnings.push_back(fmt::format("{}:{}: octree '{}' has {} occupied boxes; unseen space is {}",
                                 place.file(), place.line(), owner, boxes.size(),
                                 unseen == Unseen::kFree ? "free" : "occupied"));
  return boxes;
}

std::vector<Geometry> readOctree(const YamlReader& octree, const std::string& owner,
                                 std::vector<std::string>& warnings, const robots::Stop& stop) {
  octree.expectKeys(keysOf("octree"));
  const YamlReader file = octree.at("file", "a file of OctoMap (.bt, .ot)");
  const YamlReader unseen = octree.at("unseen", "free or occupied");
  if (unseen.text() != "free" && unseen.text() != "occupied")
    unseen.fail(
        fmt::format("{} is '{}'; free or occupied is expected", unseen.where(), unseen.text()));
  const Unseen taken = unseen.text() == "free" ? Unseen::kFree : Unseen::kOccupied;
  return namedOctree(octree, loadOctree(resolvedPath(file), taken, stop), owner, taken, warnings);
}

void filterCloud(const YamlReader& cloud, const std::vector<std::string>& carve,
                 const Problem& problem, Object& object) {
  const auto keep = [&](PointCloud filtered) {
    object.cloud = std::make_shared<const PointCloud>(std::move(filtered));
  };
  const auto filter = [&](const char* key, const auto& apply) {
    const auto found = cloud.find(key);
    if (!found) return;
    try {
      keep(apply(*found));
    } catch (const std::invalid_argument& error) {
      found->fail(fmt::format("{}: {}", found->where(), error.what()));
    }
  };
  if (const auto saved = cloud.find("carved"))
    if (const std::string fault = carveFault(*object.cloud, object.X_WO); !fault.empty())
      saved->fail(fmt::format("{}: cloud '{}' {}", saved->where(), object.name, fault));
  if (const auto saved = cloud.find("cropped"))
    if (const std::string fault = cropFault(object, cropNeeds(problem)); !fault.empty())
      saved->fail(fmt::format("{}: {}", saved->where(), fault));
  filter("carve", [&](const YamlReader&) { return carvedOf(cloud, carve, problem, object); });
  filter("crop", [&](const YamlReader& crop) {
    keep(cropped(*object.cloud, object.X_WO, robotReach(problem), crop.number()));
    if (const std::string fault = cropFault(object, cropNeeds(problem)); !fault.empty())
      crop.fail(fmt::format("{}: {}", crop.where(), fault));
    return *object.cloud;
  });
  filter("thin", [&](const YamlReader& thin) { return thinned(*object.cloud, thin.number()); });
  filter("most_balls", [&](const YamlReader& most) {
    return thinnedTo(*object.cloud, static_cast<std::size_t>(most.integer(1)));
  });
  if (object.motion && !object.geometries.empty())
    cloud.fail(fmt::format(
        "object '{}' moves, and unseen space does not; 'unseen: free' is expected", object.name));
  if (const std::string fault = motionFault(object, problem.execution.start); !fault.empty())
    cloud.fail(fmt::format("object '{}' {}", object.name, fault));
}

}  // namespace leeway::planner
