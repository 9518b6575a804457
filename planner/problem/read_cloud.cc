#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "planner/problem/read_shapes.h"
#include "planner/validate/checks.h"
#include "planner/validate/format_keys.h"

namespace leeway::planner {
namespace {

using robots::Geometry;

/// Whether `name` moves with the robot. A start by poses does not place it until it is solved.
bool isOfRobot(const Problem& problem, const std::string& name) {
  return problem.robot.model->findLink(name) >= 0 ||
         std::any_of(problem.robot.attachments.begin(), problem.robot.attachments.end(),
                     [&](const Attachment& held) { return held.object.name == name; });
}

bool isCloud(const Problem& problem, const std::string& name) {
  return std::any_of(problem.world.objects.begin(), problem.world.objects.end(),
                     [&](const Object& o) { return o.name == name && o.cloud; });
}

/// Refuses a crop in a task that attaches an object: the robot then reaches farther than now.
void requireNoGrasp(const YamlReader& crop, const Problem& problem) {
  for (const Step& step : problem.steps)
    if (std::holds_alternative<AttachStep>(step.action))
      crop.fail(
          fmt::format("{} stands in a task whose step '{}' attaches an object, which reaches "
                      "farther than the robot at the start; a cloud that is not cropped is "
                      "expected",
                      crop.where(), step.name));
}

PointCloud carvedOf(const YamlReader& cloud, const std::vector<std::string>& names,
                    const Problem& problem, const Object& object) {
  const YamlReader carve = *cloud.find("carve");
  if (names.empty())
    carve.fail(fmt::format("{} is empty; names of links or objects are expected", carve.where()));
  std::vector<Geometry> shapes_W;
  std::string what;
  for (const std::string& name : names) {
    if (isCloud(problem, name))
      carve.fail(
          fmt::format("{} names '{}', which is a cloud; links and objects with shapes are "
                      "expected",
                      carve.where(), name));
    if (!problem.start_poses.empty() && isOfRobot(problem, name))
      carve.fail(
          fmt::format("{} names '{}', and the start is given by poses; a start by joint "
                      "values, which places the robot, is expected",
                      carve.where(), name));
    const std::vector<Geometry> of = placedShapes(problem, name, {});
    shapes_W.insert(shapes_W.end(), of.begin(), of.end());
  }
  for (const YamlReader& item : carve.items()) what += (what.empty() ? "" : ", ") + item.text();
  const auto margin = cloud.find("carve_margin");
  return carved(*object.cloud, object.X_WO, shapes_W, margin ? margin->sizeNumber() : 0, what);
}

}  // namespace

std::shared_ptr<const PointCloud> readCloud(const YamlReader& cloud,
                                            std::vector<std::string>& warnings,
                                            const robots::Stop& stop) {
  cloud.expectKeys(keysOf("cloud"));
  const YamlReader file = cloud.at("file", "a file of points (PLY, PCD, XYZ, CSV)");
  const YamlReader radius = cloud.at("radius", "the radius of each point's ball [m]");
  if (const auto margin = cloud.find("carve_margin"); margin && !cloud.has("carve"))
    margin->fail("key 'carve_margin' stands without 'carve'; both are expected");
  try {
    return std::make_shared<const PointCloud>(
        loadCloud(resolvedPath(file), radius.number(), warnings, stop));
  } catch (const std::invalid_argument& error) {
    radius.fail(fmt::format("{}: {}", radius.where(), error.what()));
  }
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
  filter("carve", [&](const YamlReader&) { return carvedOf(cloud, carve, problem, object); });
  filter("crop", [&](const YamlReader& crop) {
    requireNoGrasp(crop, problem);
    return cropped(*object.cloud, object.X_WO, robotReach(problem), crop.number());
  });
  filter("thin", [&](const YamlReader& thin) { return thinned(*object.cloud, thin.number()); });
}

}  // namespace leeway::planner
