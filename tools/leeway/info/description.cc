#include "tools/leeway/info/description.h"

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/settings.h"
#include "leeway/planner/trajectory.h"
#include "tools/leeway/support/pair_samples.h"
#include "tools/view/base/scene_names.h"

namespace leeway::tools::info {
namespace {

const char* typeName(robots::JointType type) {
  switch (type) {
    case robots::JointType::kFixed:
      return "fixed";
    case robots::JointType::kRevolute:
      return "revolute";
    case robots::JointType::kContinuous:
      return "continuous";
    case robots::JointType::kPrismatic:
      return "prismatic";
    case robots::JointType::kPlanar:
      return "planar";
    case robots::JointType::kFloating:
      break;
  }
  return "floating";
}

std::size_t shapeBytes(const collision::Shape& shape) {
  std::size_t bytes = sizeof(collision::Shape);
  if (const auto* mesh = shape.mesh()) {
    bytes += mesh->bytes();
  }
  if (const auto* hull = shape.hull()) {
    bytes += hull->vertices().size_bytes() + hull->facets().size_bytes();
    for (std::size_t i = 0; hull->hasNeighbours() && i < hull->vertices().size(); ++i) {
      bytes += hull->neighbours(static_cast<std::int32_t>(i)).size_bytes();
    }
  }
  return bytes;
}

/// The edges of the box around a shape, along the axes of its frame [m]; null for a half-space.
Json sizeJson(const collision::Shape& shape) {
  using collision::ShapeType;
  const auto around = [](auto vertices) -> Json {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(kInfinity), high = -low;
    for (const Eigen::Vector3d& v : vertices) {
      low = low.cwiseMin(v);
      high = high.cwiseMax(v);
    }
    return {high.x() - low.x(), high.y() - low.y(), high.z() - low.z()};
  };
  const double r = shape.radius(), h = shape.halfLength();
  switch (shape.type()) {
    case ShapeType::kBox:
    case ShapeType::kEllipsoid: {
      const Eigen::Vector3d& half = shape.halfExtents();
      return {2 * half.x(), 2 * half.y(), 2 * half.z()};
    }
    case ShapeType::kSphere:
      return {2 * r, 2 * r, 2 * r};
    case ShapeType::kCapsule:
      return {2 * r, 2 * r, 2 * (h + r)};
    case ShapeType::kCylinder:
    case ShapeType::kCone:
      return {2 * r, 2 * r, 2 * h};
    case ShapeType::kConvexHull:
      return around(shape.hull()->vertices());
    case ShapeType::kMesh:
      return around(shape.mesh()->vertices());
    case ShapeType::kDeformable:
      return around(shape.deformable()->vertices());
    case ShapeType::kHalfSpace:
      break;
  }
  return {};
}

/// The number of triangles of each component that is not closed and so has no inside.
std::map<int, int> openComponents(const collision::TriangleMesh& mesh) {
  std::map<int, int> triangles;
  for (int t = 0; t < static_cast<int>(mesh.triangles().size()); ++t) {
    const int component = mesh.component(t);
    if (!mesh.isClosed(component)) {
      ++triangles[component];
    }
  }
  return triangles;
}

/// The reason why a mesh has no convex pieces.
const char* reason(collision::PieceSummary::Use use) {
  using Use = collision::PieceSummary::Use;
  switch (use) {
    case Use::kUsed:
      break;
    case Use::kOpen:
      return "not closed";
    case Use::kSmall:
      return "few triangles";
    case Use::kConcave:
      return "too many for its triangles";
    case Use::kLaborious:
      return "too long to find";
    case Use::kNotAsked:
      return "not asked for";
  }
  return "";
}

/// A mesh's convex pieces, or the reason why it has none.
Json piecesJson(const collision::PieceSummary& pieces) {
  Json json = {{"used", pieces.use == collision::PieceSummary::Use::kUsed}};
  if (!json["used"].get<bool>()) {
    json["reason"] = reason(pieces.use);
    return json;
  }
  json["pieces"] = pieces.pieces;
  json["loose_triangles"] = pieces.loose_triangles;
  json["excess"] = pieces.excess;
  return json;
}

/// One collision shape of a link, an object or an attached object.
Json geometryJson(const std::string& owner, const robots::Geometry& geometry) {
  const collision::Shape& shape = geometry.shape;
  Json json = {{"of", owner},
               {"name", geometry.name},
               {"type", collision::toString(shape.type())},
               {"size", sizeJson(shape)},
               {"bytes", shapeBytes(shape)}};
  if (const auto* mesh = shape.mesh()) {
    json["vertices"] = mesh->vertices().size();
    json["triangles"] = mesh->triangles().size();
    json["components"] = mesh->componentCount();
    json["closed_components"] = mesh->closedComponentCount();
    json["hull_excess"] = jsonNumber(mesh->hullExcess());
    json["convex_pieces"] = piecesJson(mesh->pieces());
    json["open"] = Json::array();
    for (const auto& [component, triangles] : openComponents(*mesh)) {
      json["open"].push_back({{"component", component}, {"triangles", triangles}});
    }
  } else if (const auto* hull = shape.hull()) {
    json["vertices"] = hull->vertices().size();
  } else if (const auto* snapshot = shape.deformable()) {
    json["vertices"] = snapshot->mesh().vertexCount();
    json["triangles"] = snapshot->mesh().triangleCount();
    json["components"] = snapshot->mesh().componentCount();
    json["closed_components"] = snapshot->mesh().closedComponentCount();
  }
  return json;
}

/// Deforming obstacles: strategy, bytes, and bounds at the start.
Json deformingJson(const planner::Problem& problem) {
  Json list = Json::array();
  for (const planner::DeformingObstacle& obstacle : problem.world.deforming) {
    collision::Deformable deformable(obstacle.mesh, obstacle.motion, obstacle.options);
    if (obstacle.motion) {
      deformable.update(problem.execution.start);
    }
    const double end = problem.execution.start + problem.execution.duration;
    list.push_back(
        {{"name", obstacle.object.name},
         {"vertices", obstacle.mesh->vertexCount()},
         {"triangles", obstacle.mesh->triangleCount()},
         {"motion", obstacle.motion ? collision::toString(obstacle.motion->kind()) : "program"},
         {"key_times", obstacle.motion ? obstacle.motion->keyTimes().size() : 0},
         {"speed_bound",
          jsonNumber(obstacle.motion ? obstacle.motion->speedBound(problem.execution.start, end)
                                     : obstacle.speed_bound)},
         {"strategy_asked", collision::toString(obstacle.options.strategy)},
         {"strategy", collision::toString(deformable.statistics().strategy)},
         {"reason", deformable.statistics().reason},
         {"bytes", deformable.bytes()}});
  }
  return list;
}

/// Objects with a motion, and bounds on the speed of their points.
Json movingJson(const planner::Problem& problem) {
  Json list = Json::array();
  const double start = problem.execution.start, end = start + problem.execution.duration;
  for (const planner::Object& object : problem.world.objects) {
    if (!object.motion) continue;
    const auto& poses = object.motion->poses;
    double extent = 0;
    for (const collision::Geometry& g : object.geometries)
      extent =
          std::max(extent, (g.X_BG * g.shape.boundingCenter()).norm() + g.shape.boundingRadius());
    if (object.cloud)
      for (const planner::PointCloud::Ball& ball : object.cloud->balls)
        extent = std::max(extent, ball.center.norm() + ball.radius);
    list.push_back({{"name", object.name},
                    {"motion", !poses              ? "seen"
                               : poses->isSteady() ? "steady"
                                                   : "keys"},
                    {"keys", poses ? poses->keyPoses().size() : 0},
                    {"age", object.motion->age},
                    {"speed_bound", jsonNumber(poses ? poses->speedBound(start, end, extent)
                                                     : object.motion->speed_bound +
                                                           object.motion->turn_bound * extent)}});
  }
  return list;
}

Json executionJson(const planner::Problem& problem) {
  constexpr std::string_view kSection = "execution.";
  Json result;
  for (const planner::Setting& setting : planner::settings()) {
    if (!setting.key.starts_with(kSection)) continue;
    Json& value = result[std::string(setting.key.substr(kSection.size()))];
    if (const auto* number = std::get_if<planner::SettingPlace<double>>(&setting.value))
      value = jsonNumber(*planner::settingValue(problem, *number));
    if (const auto* choice = std::get_if<planner::WordSetting>(&setting.value))
      for (const planner::WordSetting::Word& word : choice->words)
        if (word.value == choice->get(problem)) value = word.text;
  }
  const planner::MotionLimits limits = planner::motionLimits(problem);
  Json jerks = Json::array();  // null: no limit
  for (const double jerk : limits.jerk) jerks.push_back(jsonNumber(jerk));
  result["velocities"] = limits.velocity;
  result["accelerations"] = limits.acceleration;
  result["jerks"] = jerks;
  return result;
}

/// Pairs of bodies by name that touched in no sample, and in every sample.
struct SampledPairs {
  Json never = Json::array(), always = Json::array();
};

SampledPairs samplePairsOfBodies(const planner::CompiledScene& scene, int samples,
                                 std::uint64_t seed) {
  SampledPairs result;
  if (samples == 0) return result;
  for (const PairSamples& entry : samplePairs(scene, samples, seed)) {
    if (entry.hits != 0 && entry.hits != samples) continue;
    const PairNames names = pairNames(scene, entry.pair);
    (entry.hits == 0 ? result.never : result.always).push_back({names.a, names.b});
  }
  return result;
}

}  // namespace

Json robotJson(const robots::Model& model) {
  std::map<std::string, int> joint_types;
  int mimic = 0;
  for (const auto& joint : model.joints) {
    ++joint_types[typeName(joint.type)];
    mimic += joint.mimic >= 0 ? 1 : 0;
  }
  Json variables = Json::array();
  for (const auto& variable : model.variables) {
    const auto [least, most] =
        variable.file_limits.value_or(std::pair(variable.lower, variable.upper));
    const bool is_wider = variable.lower < least || variable.upper > most;
    variables.push_back({{"name", variable.name},
                         {"lower", jsonNumber(variable.lower)},
                         {"upper", jsonNumber(variable.upper)},
                         {"velocity", jsonNumber(variable.velocity)},
                         {"narrowed_by", is_wider ? "" : variable.narrowed_by},
                         {"widened_by", is_wider ? variable.narrowed_by : ""}});
  }
  Json groups = Json::array();
  for (const auto& group : model.groups) {
    Json names = Json::array();
    for (const int variable : group.variables) {
      names.push_back(model.variables[static_cast<std::size_t>(variable)].name);
    }
    groups.push_back({{"name", group.name}, {"variables", names}});
  }
  Json states = Json::array();
  for (const auto& state : model.group_states) {
    states.push_back({{"name", state.name}, {"group", state.group}});
  }
  return {{"name", model.name},        {"links", model.links.size()},
          {"joints", joint_types},     {"mimic_joints", mimic},
          {"variables", variables},    {"groups", groups},
          {"group_states", states},    {"disabled_pairs", model.disabled_pairs.size()},
          {"warnings", model.warnings}};
}

Json problemJson(const planner::Problem& problem) {
  Json planned = Json::array();
  for (const int variable : problem.robot.variables) {
    planned.push_back(
        {{"name", problem.robot.model->variables[static_cast<std::size_t>(variable)].name},
         {"start", problem.start[static_cast<std::size_t>(variable)]}});
  }
  Json goals = Json::array();
  for (const auto& goal : problem.goals) {
    Json ranges = Json::array();
    for (const auto& [lower, upper] : goal.ranges) {
      ranges.push_back({jsonNumber(lower), jsonNumber(upper)});
    }
    Json poses = Json::array();
    for (const auto& region : goal.poses) {
      poses.push_back(
          {{"link", problem.robot.model->links[static_cast<std::size_t>(region.link)].name},
           {"position", region.position},
           {"rpy", region.rpy}});
    }
    goals.push_back({{"name", goal.name}, {"ranges", ranges}, {"poses", poses}});
  }
  Json steps = Json::array();
  for (const auto& step : problem.steps) {
    steps.push_back(step.name);
  }
  Json objects = Json::array();
  for (const auto& object : problem.world.objects) {
    objects.push_back(object.name);
  }
  for (const auto& obstacle : problem.world.deforming) {
    objects.push_back(obstacle.object.name);
  }
  Json attached = Json::array();
  for (const auto& attachment : problem.robot.attachments) {
    attached.push_back(
        {{"name", attachment.object.name},
         {"link", problem.robot.model->links[static_cast<std::size_t>(attachment.link)].name}});
  }
  return {{"name", problem.name},
          {"planned", planned},
          {"goals", goals},
          {"steps", steps},
          {"objects", objects},
          {"attached", attached},
          {"clouds", planner::cloudsJson(problem)},
          {"warnings", problem.warnings},
          {"moving", movingJson(problem)},
          {"deforming", deformingJson(problem)},
          {"execution", executionJson(problem)},
          {"margin", problem.margins.common},
          {"planner", problem.planner.name},
          {"objective", planner::toString(problem.objective)},
          {"time_limit", problem.limits.time},
          {"seed", problem.seed}};
}

Json geometriesJson(const planner::Problem& problem) {
  Json list = Json::array();
  const auto append = [&](const std::string& owner,
                          const std::vector<robots::Geometry>& geometries) {
    for (const auto& geometry : geometries) {
      list.push_back(geometryJson(owner, geometry));
    }
  };
  for (const auto& link : problem.robot.model->links) {
    append(link.name, link.geometries);
  }
  for (const auto& object : problem.world.objects) {
    append(object.name, object.geometries);
  }
  for (const auto& obstacle : problem.world.deforming) {
    append(obstacle.object.name, obstacle.object.geometries);
  }
  for (const auto& attachment : problem.robot.attachments) {
    append(attachment.object.name, attachment.object.geometries);
  }
  return list;
}

Json compiledJson(const planner::CompiledScene& scene, int samples, std::uint64_t seed) {
  int moving = 0;
  for (const auto& body : scene.scene().bodies()) {
    moving += body.moving ? 1 : 0;
  }
  std::map<std::string, int> reasons;
  Json dropped = Json::array();
  for (const auto& entry : scene.dropped()) {
    ++reasons[entry.reason];
    dropped.push_back({{"a", entry.a}, {"b", entry.b}, {"reason", entry.reason}});
  }
  const SampledPairs sampled = samplePairsOfBodies(scene, samples, seed);
  const std::size_t bodies = scene.scene().bodies().size();
  const std::string nothing = scene.nothingChecked();
  return {{"moving_bodies", moving},
          {"static_bodies", static_cast<int>(bodies) - moving},
          {"pairs_kept", scene.scene().pairs().size()},
          {"pairs_dropped", scene.dropped().size()},
          {"dropped_by_reason", reasons},
          {"dropped", dropped},
          {"nothing_checked", nothing.empty() ? Json() : Json(nothing)},
          {"samples", samples},
          {"seed", seed},
          {"sampled_never_touching", sampled.never},
          {"sampled_always_touching", sampled.always}};
}

}  // namespace leeway::tools::info
