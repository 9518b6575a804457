#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/trajectory.h"
#include "leeway/robots/input_error.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/pair_samples.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/scene_names.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"

namespace leeway::tools {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  ProblemSource source;
  std::string file;
  int samples = 500;
  std::uint64_t seed = 1;
  bool json = false;
};

// ------------------------------------------------------------------------------------------------
// what the file is

std::string rootElementName(const std::string& file, std::string& robot_name) {
  tinyxml2::XMLDocument document;
  if (document.LoadFile(file.c_str()) != tinyxml2::XML_SUCCESS ||
      document.RootElement() == nullptr) {
    return {};
  }
  const char* name = document.RootElement()->Attribute("name");
  robot_name = name == nullptr ? "" : name;
  return document.RootElement()->Name();
}

/// An SRDF only has meaning beside its URDF: the one of that robot name in the SRDF's folder or the
/// folder above.
std::string findUrdfOf(const std::string& srdf) {
  std::string robot_name;
  rootElementName(srdf, robot_name);
  const fs::path folder = fs::absolute(srdf).parent_path();
  std::vector<std::string> found;
  for (const fs::path& place : {folder, folder.parent_path()}) {
    for (const auto& entry : fs::directory_iterator(place)) {
      std::string name;
      if (entry.path().extension() == ".urdf" &&
          rootElementName(entry.path().string(), name) == "robot" && name == robot_name) {
        found.push_back(entry.path().string());
      }
    }
    if (!found.empty()) {
      break;
    }
  }
  if (found.size() != 1) {
    throw robots::InputError(srdf, 0,
                             fmt::format("an SRDF is read together with its URDF, and {} URDF of a "
                                         "robot '{}' lies beside it; name it with --robot",
                                         found.empty() ? "no" : "more than one", robot_name));
  }
  return found.front();
}

/// A robot alone, as a problem in which every variable is planned and nothing is around it.
planner::Problem robotProblem(const std::string& urdf, const std::string& srdf,
                              const ProblemSource& source) {
  planner::Problem problem;
  problem.robot.model = robots::loadModel(urdf, srdf, loadOptions(source));
  printWarnings(problem.robot.model->warnings);
  problem.name = problem.robot.model->name;
  problem.start = problem.robot.model->defaultConfiguration();
  planner::Goal goal{"default", {}};
  for (std::size_t i = 0; i < problem.robot.model->variables.size(); ++i) {
    problem.robot.variables.push_back(static_cast<int>(i));
    goal.ranges.emplace_back(problem.start[i], problem.start[i]);
  }
  problem.goals = {goal};
  return problem;
}

enum class FileKind { kUrdf, kSrdf, kProblem };

FileKind kindOf(const std::string& file) {
  const std::string ending = fs::path(file).extension().string();
  if (ending == ".srdf") {
    return FileKind::kSrdf;
  }
  if (ending == ".urdf" || ending == ".xacro") {
    return FileKind::kUrdf;
  }
  if (ending == ".yaml" || ending == ".yml") {
    return FileKind::kProblem;
  }
  throw robots::InputError(
      file, 0, fmt::format("unknown ending '{}'; .urdf, .srdf and .yaml are accepted", ending));
}

planner::Problem load(Arguments& arguments, FileKind kind) {
  if (!fs::exists(arguments.file)) {
    throw robots::InputError(arguments.file, 0, "there is no such file");
  }
  ProblemSource& source = arguments.source;
  switch (kind) {
    case FileKind::kUrdf:
      return robotProblem(arguments.file, source.srdf, source);
    case FileKind::kSrdf:
      return robotProblem(source.robot.empty() ? findUrdfOf(arguments.file) : source.robot,
                          arguments.file, source);
    case FileKind::kProblem:
      break;
  }
  source.problem = arguments.file;
  return loadProblem(source);
}

// ------------------------------------------------------------------------------------------------
// what is in it

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

/// Triangles of every component that is not closed: a surface, without an inside.
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

/// Why a mesh has no convex pieces.
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
    case Use::kExtreme:
      return "extreme size";
    case Use::kNotAsked:
      return "not asked for";
  }
  return "";
}

/// The convex pieces of a mesh, or why it has none.
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

/// Obstacles that deform: what follows them and what that takes, at the start.
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

Json executionJson(const planner::Problem& problem) {
  const planner::Execution& execution = problem.execution;
  const planner::MotionLimits limits = planner::motionLimits(problem);
  Json jerks = Json::array();  // null: no limit
  for (const double jerk : limits.jerk) jerks.push_back(jsonNumber(jerk));
  return {
      {"start", execution.start},
      {"step", execution.step},
      {"duration", execution.duration},
      {"speed", execution.speed},
      {"velocities", limits.velocity},
      {"accelerations", limits.acceleration},
      {"jerks", jerks},
      {"corners", execution.corners == planner::Corners::kStop ? "stop" : "blend"},
      {"foresight", execution.foresight == planner::Foresight::kMotion ? "motion" : "speed_bound"},
      {"look_ahead", execution.look_ahead},
      {"buffer", execution.buffer},
      {"patience", execution.patience}};
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

Json robotJson(const robots::Model& model) {
  std::map<std::string, int> joint_types;
  int mimic = 0;
  for (const auto& joint : model.joints) {
    ++joint_types[typeName(joint.type)];
    mimic += joint.mimic >= 0 ? 1 : 0;
  }
  Json variables = Json::array();
  for (const auto& variable : model.variables) {
    variables.push_back({{"name", variable.name},
                         {"lower", jsonNumber(variable.lower)},
                         {"upper", jsonNumber(variable.upper)},
                         {"velocity", jsonNumber(variable.velocity)}});
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
  return {{"name", model.name},     {"links", model.links.size()},
          {"joints", joint_types},  {"mimic_joints", mimic},
          {"variables", variables}, {"groups", groups},
          {"group_states", states}, {"disabled_pairs", model.disabled_pairs.size()}};
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
    goals.push_back({{"name", goal.name}, {"ranges", ranges}});
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
          {"objects", objects},
          {"attached", attached},
          {"deforming", deformingJson(problem)},
          {"execution", executionJson(problem)},
          {"margin", problem.margins.common},
          {"planner", problem.planner.name},
          {"objective", planner::toString(problem.objective)},
          {"time_limit", problem.limits.time},
          {"seed", problem.seed}};
}

// ------------------------------------------------------------------------------------------------
// what is kept of it

/// Pairs of bodies: never touching when no two of their shapes did, always when two of them always
/// did.
struct SampledPairs {
  Json never = Json::array(), always = Json::array();
};

SampledPairs samplePairsOfBodies(const planner::CompiledScene& scene, int samples,
                                 std::uint64_t seed) {
  std::map<std::pair<std::string, std::string>, int> most_hits;
  if (samples > 0) {
    for (const PairSamples& entry : samplePairs(scene, samples, seed)) {
      const PairNames names = pairNames(scene, entry.pair);
      int& hits = most_hits[{names.a, names.b}];
      hits = std::max(hits, entry.hits);
    }
  }
  SampledPairs result;
  for (const auto& [names, hits] : most_hits) {
    if (hits == 0 || hits == samples) {
      (hits == 0 ? result.never : result.always).push_back({names.first, names.second});
    }
  }
  return result;
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
  return {{"moving_bodies", moving},
          {"static_bodies", static_cast<int>(bodies) - moving},
          {"pairs_kept", scene.scene().pairs().size()},
          {"pairs_dropped", scene.dropped().size()},
          {"dropped_by_reason", reasons},
          {"dropped", dropped},
          {"samples", samples},
          {"seed", seed},
          {"sampled_never_touching", sampled.never},
          {"sampled_always_touching", sampled.always}};
}

// ------------------------------------------------------------------------------------------------
// for people

std::string limitText(const Json& value) {
  return value.is_null() ? "-" : fmt::format("{:.4f}", value.get<double>());
}

void printRobot(const Json& robot) {
  std::string joints;
  for (const auto& [type, count] : robot["joints"].items()) {
    joints += fmt::format("{}{} {}", joints.empty() ? "" : ", ", count.get<int>(), type);
  }
  fmt::print("robot {}: {} links; joints: {}; {} of them mimic\n\n",
             robot["name"].get<std::string>(), robot["links"].get<int>(), joints,
             robot["mimic_joints"].get<int>());
  std::vector<std::vector<std::string>> rows;
  for (const auto& variable : robot["variables"]) {
    rows.push_back({variable["name"], limitText(variable["lower"]), limitText(variable["upper"]),
                    limitText(variable["velocity"])});
  }
  fmt::print("{}\n", formatTable({"variable", "lower", "upper", "velocity"}, rows));
  for (const auto& group : robot["groups"]) {
    std::string states;
    for (const auto& state : robot["group_states"]) {
      if (state["group"] == group["name"]) {
        states += (states.empty() ? "; states " : ", ") + state["name"].get<std::string>();
      }
    }
    fmt::print("group {}: {} variables{}\n", group["name"].get<std::string>(),
               group["variables"].size(), states);
  }
  fmt::print("pairs of links that the SRDF lets touch: {}\n", robot["disabled_pairs"].get<int>());
}

void printDeforming(const Json& problem) {
  if (problem["deforming"].empty()) {
    return;
  }
  std::vector<std::vector<std::string>> rows;
  for (const auto& o : problem["deforming"]) {
    const Json& speed = o["speed_bound"];
    rows.push_back({o["name"], o["motion"], o["triangles"].dump(),
                    speed.is_null() ? "-" : formatUpper(speed.get<double>(), 3),
                    o["strategy"].get<std::string>() + " (" + o["reason"].get<std::string>() + ")",
                    formatBytes(o["bytes"].get<std::size_t>())});
  }
  const Json& e = problem["execution"];
  fmt::print("{}",
             formatTable({"deforming", "motion", "triangles", "at most [m/s]", "strategy", "size"},
                         rows, {1, 4}));
  fmt::print(
      "everything but replan sees them as they are at {} s; replan looks every {} s, for {} s at "
      "most, and knows their {}\n\n",
      e["start"].get<double>(), e["step"].get<double>(), e["duration"].get<double>(),
      e["foresight"] == "motion" ? "motion" : "speed bound");
}

void printProblem(const Json& problem) {
  fmt::print(
      "problem {}: {} planned variables, {} goals, {} objects, {} attached, margin {} m, {} for "
      "{}, {} s, seed {}\n\n",
      problem["name"].get<std::string>(), problem["planned"].size(), problem["goals"].size(),
      problem["objects"].size(), problem["attached"].size(), problem["margin"].get<double>(),
      problem["planner"].get<std::string>(), problem["objective"].get<std::string>(),
      problem["time_limit"].get<double>(), problem["seed"].get<std::uint64_t>());
  printDeforming(problem);
}

void printGeometries(const Json& geometries) {
  std::vector<std::vector<std::string>> rows;
  std::string open, pieces;
  std::size_t bytes = 0;
  const auto field = [](const Json& json, const char* key) {
    return json.contains(key) ? json[key].dump() : std::string();
  };
  for (const auto& geometry : geometries) {
    const std::string owner = geometry["of"];
    const bool mesh = geometry.contains("hull_excess");
    const std::string excess = mesh && !geometry["hull_excess"].is_null()
                                   ? formatUpper(geometry["hull_excess"].get<double>() * 1e3, 3)
                                   : std::string();
    rows.push_back({owner, geometry["type"], field(geometry, "vertices"),
                    field(geometry, "triangles"), excess,
                    mesh ? fmt::format("{} of {}", field(geometry, "closed_components"),
                                       field(geometry, "components"))
                         : "",
                    formatBytes(geometry["bytes"].get<std::size_t>())});
    bytes += geometry["bytes"].get<std::size_t>();
    if (!mesh) {
      continue;
    }
    const std::string name =
        geometry["name"].get<std::string>().empty() ? "mesh" : geometry["name"].get<std::string>();
    for (const auto& component : geometry["open"]) {
      open += fmt::format("  {} of {}: component {}, {} triangles\n", name, owner,
                          component["component"].get<int>(), component["triangles"].get<int>());
    }
    const Json& parts = geometry["convex_pieces"];
    pieces += fmt::format("  {} of {}: ", name, owner);
    pieces +=
        parts["used"].get<bool>()
            ? fmt::format("{} convex pieces and {} triangles, excess {} mm\n",
                          parts["pieces"].get<int>(), parts["loose_triangles"].get<int>(),
                          formatUpper(parts["excess"].get<double>() * 1e3, 6))
            : fmt::format("triangles, no convex pieces ({})\n", parts["reason"].get<std::string>());
  }
  fmt::print("\n{}", formatTable({"of", "shape", "vertices", "triangles", "hull excess [mm]",
                                  "closed", "size"},
                                 rows, {1}));
  fmt::print("{} shapes, {}\n", geometries.size(), formatBytes(bytes));
  if (!pieces.empty()) {
    fmt::print("\nqueries of meshes use\n{}", pieces);
  }
  if (!open.empty()) {
    fmt::print("\nnot closed, so surfaces without an inside:\n{}", open);
  }
}

void printPairs(const char* text, const Json& pairs) {
  if (pairs.empty()) {
    return;
  }
  fmt::print("{}:\n", text);
  std::map<std::string, std::string> partners;
  for (const auto& pair : pairs) {
    partners[pair[0].get<std::string>()] += " " + pair[1].get<std::string>();
  }
  for (const auto& [name, others] : partners) {
    fmt::print("  {} with{}\n", name, others);
  }
}

void printCompiled(const Json& compiled) {
  fmt::print(
      "\ncompiled: {} moving and {} static bodies, {} pairs of shapes kept, {} pairs left out\n",
      compiled["moving_bodies"].get<int>(), compiled["static_bodies"].get<int>(),
      compiled["pairs_kept"].get<int>(), compiled["pairs_dropped"].get<int>());
  for (const auto& [reason, count] : compiled["dropped_by_reason"].items()) {
    fmt::print("  {} left out: {}\n", count.get<int>(), reason);
  }
  const std::string samples = compiled["samples"].dump();
  printPairs(("touching at all of " + samples + " random configurations, still checked").c_str(),
             compiled["sampled_always_touching"]);
  printPairs(("touching at none of " + samples + " random configurations, still checked").c_str(),
             compiled["sampled_never_touching"]);
}

int run(Arguments& arguments) {
  if (arguments.samples < 0) {
    throw robots::InputError("command line", 0,
                             fmt::format("--samples {} is negative", arguments.samples));
  }
  const FileKind kind = kindOf(arguments.file);
  const planner::Problem problem = load(arguments, kind);
  const planner::CompiledScene scene(problem);
  Json document = {{"file", arguments.file}, {"robot", robotJson(*problem.robot.model)}};
  if (kind == FileKind::kProblem) {
    document["problem"] = problemJson(problem);
  }
  document["geometries"] = geometriesJson(problem);
  document["compiled"] = compiledJson(scene, arguments.samples, arguments.seed);
  if (arguments.json) {
    printJson(document);
    return kYes;
  }
  if (kind == FileKind::kProblem) {
    printProblem(document["problem"]);
  }
  printRobot(document["robot"]);
  printGeometries(document["geometries"]);
  printCompiled(document["compiled"]);
  return kYes;
}

}  // namespace

Verb addInfo(CLI::App& command) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app =
      command.add_subcommand("info", "what a URDF, SRDF or problem holds and what is kept of it");
  app->add_option("file", arguments->file, "URDF, SRDF or problem file")
      ->type_name("FILE")
      ->required();
  addRobotArguments(*app, arguments->source);
  app->add_option("--samples", arguments->samples,
                  "random configurations that look which links meet; 0: none")
      ->type_name("N")
      ->capture_default_str();
  app->add_option("--seed", arguments->seed, "seed of the samples")
      ->check(seedError)
      ->type_name("N")
      ->capture_default_str();
  app->add_flag("--json", arguments->json, "print one JSON document");
  app->footer("Example:\n  leeway info problems/shelf/reach.yaml");
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace leeway::tools
