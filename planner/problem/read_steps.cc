#include "planner/problem/read_steps.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>

#include "leeway/robots/text.h"
#include "planner/base/tolerances.h"
#include "planner/problem/read_motion.h"
#include "planner/problem/read_poses.h"
#include "planner/problem/read_shapes.h"
#include "planner/problem/read_states.h"
#include "planner/sensed/cloud_source.h"
#include "planner/validate/checks.h"
#include "planner/validate/format_keys.h"
#include "robots/base/read_file.h"

namespace leeway::planner {
namespace {

MoveStep readMove(const YamlReader& reader, const std::string& name, Problem& world) {
  if (!givesPoses(reader, *world.robot.model)) return {readGoal(reader, name, world), {}};
  readPoseRegions(reader, world);  // for errors with lines
  return {{}, readFramePoses(reader, *world.robot.model, world.warnings)};
}

/// Reads `rpy` or `orientation` of a map; returns nothing without either.
std::optional<Eigen::Matrix3d> readRotation(const YamlReader& map,
                                            std::vector<std::string>& warnings) {
  if (!map.has("rpy") && !map.has("orientation")) return std::nullopt;
  return rotationFromQuaternion(readOrientation(map, warnings));
}

Waypoint readWaypoint(const YamlReader& map, std::vector<std::string>& warnings) {
  map.expectKeys(keysOf("waypoint"));
  Waypoint pose{map.at("position", "[x, y, z] in m").vector3()};
  pose.rotation = readRotation(map, warnings);
  if (const auto via = map.find("via")) pose.via = via->vector3();
  return pose;
}

/// The names of columns in a file of poses, in this order.
constexpr std::string_view kPosition[] = {"x", "y", "z"};
constexpr std::string_view kQuaternion[] = {"qx", "qy", "qz", "qw"};
constexpr std::string_view kTurns[] = {"roll", "pitch", "yaw"};

/// The columns with the numbers of a pose.
struct PoseColumns {
  std::vector<std::size_t> position, quaternion, turns;
};

/// Finds columns by their names. Without names, their number decides: x y z alone, with a
/// quaternion, or with roll, pitch and yaw.
PoseColumns poseColumns(const CloudSource& source, const ColumnRow& first) {
  PoseColumns columns;
  const std::size_t count = first.cells.size();
  const bool has_names = !robots::parseNumber(first.cells[0]).has_value();
  if (!has_names && count != 3 && count != 6 && count != 7)
    source.fail(
        {first.line, 0},
        fmt::format("the row has {} numbers; x y z, with roll pitch yaw or qx qy qz qw, are "
                    "expected, or a line of names before",
                    count));
  std::vector<std::string_view> names = first.cells;
  if (!has_names) {
    refuseUnclearNames(source, first);
    names.assign(std::begin(kPosition), std::end(kPosition));
    if (count == 7) names.insert(names.end(), std::begin(kQuaternion), std::end(kQuaternion));
    if (count == 6) names.insert(names.end(), std::begin(kTurns), std::end(kTurns));
    if (!first.names.empty()) names = first.names;
  }
  const auto take = [&](std::span<const std::string_view> wanted, std::vector<std::size_t>& into) {
    for (const std::string_view name : wanted)
      for (std::size_t i = 0; i < names.size(); ++i)
        if (names[i] == name) into.push_back(i);
  };
  take(kPosition, columns.position);
  take(kQuaternion, columns.quaternion);
  take(kTurns, columns.turns);
  const std::size_t known =
      columns.position.size() + columns.quaternion.size() + columns.turns.size();
  if (columns.position.size() != 3 || columns.quaternion.size() % 4 != 0 ||
      columns.turns.size() % 3 != 0 || known != names.size() ||
      (!columns.quaternion.empty() && !columns.turns.empty()))
    source.fail({first.line, 0},
                fmt::format("the columns are {}; x, y, z, with qx, qy, qz, qw or roll, pitch, yaw, "
                            "are expected, each once",
                            fmt::join(names, ", ")));
  return columns;
}

std::vector<Waypoint> readPoseColumns(const std::string& file, std::vector<std::string>& warnings) {
  const robots::Stop never;
  const CloudSource source(file, robots::readTextFile(file, "a file of poses"), never);
  std::optional<PoseColumns> columns;
  std::vector<Waypoint> poses;
  std::size_t last = 0;
  eachRow(source, [&](const ColumnRow& row) {
    last = row.line;
    if (!columns) {
      columns = poseColumns(source, row);
      if (!robots::parseNumber(row.cells[0]).has_value()) return;
    }
    const auto numbers = [&](const std::vector<std::size_t>& places) {
      std::vector<double> values;
      for (const std::size_t place : places) {
        const std::optional<double> value = robots::parseFinite(row.cells[place]);
        if (!value)
          source.fail({row.line, 0}, fmt::format("'{}' stands where a finite number is expected",
                                                 row.cells[place]));
        values.push_back(*value);
      }
      return values;
    };
    const std::vector<double> p = numbers(columns->position), q = numbers(columns->quaternion),
                              rpy = numbers(columns->turns);
    Waypoint pose{{p[0], p[1], p[2]}};
    if (!q.empty()) {
      Eigen::Vector4d xyzw(q[0], q[1], q[2], q[3]);
      const double norm = xyzw.norm();
      if (!(std::abs(norm - 1) <= kMendableQuaternion))
        source.fail({row.line, 0},
                    fmt::format("a quaternion of length {}; unit length (within {}) is expected",
                                norm, kMendableQuaternion));
      if (std::abs(norm - 1) > kSilentQuaternion)
        warnings.push_back(
            fmt::format("{}:{}: a quaternion of length {} was normalised", file, row.line, norm));
      pose.rotation = rotationFromQuaternion(xyzw / norm);
    }
    if (!rpy.empty())
      pose.rotation = rotationFromQuaternion(quaternionFromRpy({rpy[0], rpy[1], rpy[2]}));
    poses.push_back(pose);
  });
  if (poses.empty()) throw robots::InputError(file, 0, "has no pose; at least one is expected");
  if (!robots::lastLineEnds(source.text()))
    warnings.push_back(fmt::format("{}:{}: {}", file, last, robots::kLastLineOpen));
  return poses;
}

std::vector<Waypoint> readPoseList(const YamlReader& list, std::vector<std::string>& warnings) {
  std::vector<Waypoint> poses;
  list.eachItem([&](const YamlReader& item) { poses.push_back(readWaypoint(item, warnings)); });
  if (poses.empty()) list.fail(list.where() + " has no pose; at least one is expected");
  return poses;
}

bool isTable(const std::string& file) {
  const std::string ending = std::filesystem::path(file).extension().string();
  if (ending != ".csv" && ending != ".yaml" && ending != ".yml" && ending != ".json")
    throw robots::InputError(
        file, 0,
        fmt::format("the ending '{}' names no format of poses; .csv, .yaml or .json is expected",
                    ending));
  return ending == ".csv";
}

/// Reads a list of poses, or a file of poses by its name.
std::vector<Waypoint> readWaypoints(const YamlReader& reader, std::vector<std::string>& warnings) {
  if (!reader.isScalar()) return readPoseList(reader, warnings);
  const std::string file = resolvedPath(reader);
  return isTable(file) ? readPoseColumns(file, warnings)
                       : readPoseList(YamlReader::load(file), warnings);
}

/// Reads a line. Its frame is `frame`, or is named in the map if `frame` is empty.
LineStep readLine(const YamlReader& reader, std::vector<std::string>& warnings,
                  const std::string& frame = {}) {
  reader.expectKeys(keysOf("line"));
  LineStep line;
  line.frame = frame;
  if (frame.empty())
    line.frame = reader.at("frame", "the name of a frame, link or attached object").text();
  else if (const auto named = reader.find("frame"))
    named->fail("the file names its frame itself; one of both is expected");
  const auto by = reader.find("by"), poses = reader.find("poses");
  const std::optional<Eigen::Matrix3d> turn = readRotation(reader, warnings);
  if (poses && (by || turn))
    poses->fail(fmt::format("{} has 'poses' and '{}'; one of them is expected", reader.where(),
                            by ? "by" : "a rotation"));
  if (!poses && !by && !turn)
    reader.fail(
        fmt::format("{} goes nowhere; by, how far and where to [x, y, z] in m, or poses "
                    "are expected",
                    reader.where()));
  if (by) line.by = by->vector3();
  if (turn) line.turn = *turn;
  if (poses) line.poses = readWaypoints(*poses, warnings);
  if (const auto axes = reader.find("relative_to")) line.relative_to = axes->text();
  line.position_tolerance = optionalNumber(reader, "position_tolerance", line.position_tolerance);
  line.angle_tolerance = optionalNumber(reader, "angle_tolerance", line.angle_tolerance);
  line.speed = optionalNumber(reader, "speed", line.speed);
  return line;
}

AttachStep readAttach(const YamlReader& reader) {
  reader.expectKeys(keysOf("attach_step"));
  AttachStep attach;
  attach.object = reader.at("object", "the name of an object").text();
  attach.link = reader.at("link", "the name of the link that takes hold of it").text();
  if (const auto touch = reader.find("touch"))
    for (const YamlReader& link : touch->items()) attach.touch.push_back(link.text());
  return attach;
}

}  // namespace

void readWay(const YamlReader& reader, Problem& problem) {
  Step step;
  step.name = "waypoints";
  step.action = readLine(reader, problem.warnings);
  try {
    takeStep(step, problem, true);
  } catch (const std::invalid_argument& error) {
    reader.fail(fmt::format("{}: {}", reader.where(), error.what()));
  }
  problem.steps.push_back(std::move(step));
}

LineStep loadWaypoints(const std::string& file, const std::string& frame,
                       std::vector<std::string>& warnings) {
  LineStep line;
  line.frame = frame;
  if (isTable(file)) {
    line.poses = readPoseColumns(file, warnings);
  } else {
    const YamlReader reader = YamlReader::load(file);
    if (reader.isMap()) return readLine(reader, warnings, frame);
    line.poses = readPoseList(reader, warnings);
  }
  if (frame.empty())
    throw robots::InputError(file, 0,
                             "does not say which frame goes through its poses; the name of one is "
                             "expected (--frame)");
  return line;
}

void readSteps(const YamlReader& reader, const ReadPair& readPair, Problem& problem) {
  // The world before each step, as far as names go: objects are attached where they are at the
  // start.
  Problem world = problem;
  std::map<std::string, int> named;  // the number of steps that have only a default name
  bool is_first = true;              // that moves
  for (const YamlReader& map : reader.items()) {
    map.expectKeys(keysOf("step"));
    std::string action;
    for (const char* key : {"move", "line", "attach", "detach"}) {
      if (!map.has(key)) continue;
      if (!action.empty())
        map.fail(
            fmt::format("{} has both '{}' and '{}'; one is expected", map.where(), action, key));
      action = key;
    }
    if (action.empty())
      map.fail(
          fmt::format("{} does nothing; move, line, attach or detach is expected", map.where()));
    Step step;
    const auto name = map.find("name");
    const int count = name ? 0 : ++named[action];
    step.name = name ? name->text() : count == 1 ? action : fmt::format("{} {}", action, count);
    for (const Step& other : problem.steps)
      if (other.name == step.name)
        name.value_or(map).fail(fmt::format(
            "two steps are named '{}'; a name of its own is expected for each", step.name));
    if (const auto allowed = map.find("allowed"))
      for (const YamlReader& pair : allowed->items())
        for (auto& names : readPair(pair)) step.allowed.push_back(std::move(names));
    const YamlReader value = map.at(action, "what it does");
    if (action == "move") {
      step.action = readMove(value, step.name, world);
    } else if (action == "line") {
      step.action = readLine(value, world.warnings);
    } else if (action == "attach") {
      step.action = readAttach(value);
    } else {
      step.action = DetachStep{value.text()};
    }
    try {
      takeStep(step, world, is_first);
      is_first = is_first && !movesRobot(step);
    } catch (const std::invalid_argument& error) {
      value.fail(fmt::format("{}: {}", value.where(), error.what()));
    }
    problem.steps.push_back(std::move(step));
  }
  if (problem.steps.empty()) reader.fail("steps is empty; at least one step is expected");
  problem.warnings = world.warnings;
}

}  // namespace leeway::planner
