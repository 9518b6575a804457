#include "planner/problem/read_poses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/robots/groups.h"
#include "planner/base/did_you_mean.h"
#include "planner/base/tolerances.h"
#include "planner/problem/fail_at.h"
#include "planner/problem/read_motion.h"
#include "planner/problem/read_shapes.h"
#include "planner/validate/checks.h"
#include "planner/validate/format_keys.h"

namespace leeway::planner {
namespace {

/// Fails where a key stands without what it belongs to: it would be ignored.
void expectBeside(const YamlReader& map, const char* key, bool is_there, const char* what) {
  if (const auto given = map.find(key); given && !is_there)
    given->fail(
        fmt::format("key '{}' stands without {}, whose it is; both are expected", key, what));
}

using Range = std::pair<double, double>;

/// Reads a number, a pair [from, to], or `any`, which means from -any to any.
Range readRange(const YamlReader& reader, double any, double most) {
  if (reader.isScalar() && reader.text() == "any") return {-any, any};
  Range range;
  if (reader.isList()) {
    const std::vector<double> numbers = reader.numbers();
    if (numbers.size() != 2 || !(numbers[0] <= numbers[1]))
      reader.fail(
          fmt::format("{} is no range; a number, [from, to] with from <= to, or any is "
                      "expected",
                      reader.where()));
    range = {numbers[0], numbers[1]};
  } else {
    range.first = range.second = reader.number();
  }
  if (const double farthest = std::max(std::abs(range.first), std::abs(range.second));
      farthest > most)
    reader.fail(fmt::format("{} is {}; at most {} is expected", reader.where(), farthest, most));
  return range;
}

void readRanges(const YamlReader& reader, double any, double most, std::array<Range, 3>& ranges) {
  const std::vector<YamlReader> items = reader.items();
  if (items.size() != 3)
    reader.fail(
        fmt::format("{} is a list of {}; three numbers, pairs [from, to] or any are "
                    "expected",
                    reader.where(), items.size()));
  for (std::size_t i = 0; i < 3; ++i) ranges[i] = readRange(items[i], any, most);
}

/// Moves turns with a single value from the ranges into the rotation: those about x and y in their
/// order, or all three. An exact pose then has no angles near a pitch of 90 degrees, where roll and
/// yaw turn about the same axis.
void takeExactTurns(FramePose& pose) {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 3 && pose.rpy[i].first == pose.rpy[i].second; ++i) {
    turn[static_cast<Eigen::Index>(i)] = pose.rpy[i].first;
    pose.rpy[i] = {0, 0};
  }
  pose.rotation = rotationFromQuaternion(quaternionFromRpy(turn));
}

FramePose readFramePose(const YamlReader& map, std::vector<std::string>& warnings) {
  map.expectKeys(keysOf("frame_pose"));
  FramePose pose;
  pose.frame = map.at("frame", "the name of a frame, link or attached object").text();
  if (const auto reference = map.find("relative_to")) pose.relative_to = reference->text();
  const auto position = map.find("position"), rpy = map.find("rpy"),
             orientation = map.find("orientation");
  if (!position && !rpy && !orientation)
    map.fail(fmt::format("{} says nothing of where; position, and rpy or orientation are expected",
                         map.where()));
  if (rpy && orientation)
    rpy->fail(fmt::format("{} has both 'orientation' and 'rpy'; one is expected", map.where()));
  pose.position.fill({-kAnyPosition, kAnyPosition});
  if (position) readRanges(*position, kAnyPosition, kAnyPosition, pose.position);
  if (orientation) {
    pose.rotation = rotationFromQuaternion(readQuaternion(*orientation, warnings));
    pose.rpy.fill({0, 0});
  } else {
    pose.rpy.fill({-std::numbers::pi, std::numbers::pi});
    if (rpy) readRanges(*rpy, std::numbers::pi, kLargestAngle, pose.rpy);
    takeExactTurns(pose);
  }
  expectBeside(map, "position_tolerance", position.has_value(), "'position'");
  expectBeside(map, "angle_tolerance", rpy.has_value() || orientation.has_value(),
               "'rpy' or 'orientation'");
  for (const auto& [key, tolerance] : {std::pair("position_tolerance", &pose.position_tolerance),
                                       {"angle_tolerance", &pose.angle_tolerance}})
    if (const auto given = map.find(key)) *tolerance = given->number();
  return pose;
}

}  // namespace

namespace {

int readFrameLink(const YamlReader& frame, const robots::Model& model) {
  const YamlReader name = frame.at("link", "the name of a link");
  const int link = model.findLink(name.text());
  if (link >= 0) return link;
  std::vector<std::string> names;
  for (const robots::Link& candidate : model.links) names.push_back(candidate.name);
  name.fail(fmt::format("unknown link '{}' in {}{}", name.text(), frame.where(),
                        didYouMean(name.text(), names)));
}

}  // namespace

void readFrames(const YamlReader& reader, Problem& problem) {
  const robots::Model& model = *problem.robot.model;
  const Names names(problem);
  reader.eachEntry([&](const std::string& name, const YamlReader& map) {
    map.expectKeys(keysOf("frame"));
    if (const std::string fault = frameNameFault(names, name); !fault.empty()) map.fail(fault);
    // If reading goes on after a fault in it, the frame's name is still known.
    Frame frame{name, 0, {}};
    map.readOn([&] {
      frame.link = readFrameLink(map, model);
      frame.X_LF = readPose(map, problem.warnings);
    });
    problem.robot.frames.push_back(std::move(frame));
  });
}

namespace {

bool givesOwnPoses(const YamlReader& map, const robots::Model& model) {
  if (!map.isMap()) return false;
  for (const char* key : {"pose", "poses"})
    if (map.has(key) && model.findJoint(key) < 0) return true;
  return false;
}

/// The map of a pose, and the group under whose name it stands; -1: none.
struct PlacedPose {
  YamlReader map;
  int group;
};

void addPoses(const YamlReader& map, int group, std::vector<PlacedPose>& places) {
  map.expectKeys(keysOf("poses"));
  const auto pose = map.find("pose"), poses = map.find("poses");
  if (pose && poses)
    poses->fail(fmt::format("{} has both 'pose' and 'poses'; one is expected", map.where()));
  if (pose) return places.push_back({*pose, group});
  for (const YamlReader& item : poses->items()) places.push_back({item, group});
  if (poses->items().empty())
    poses->fail(fmt::format("{} is empty; a pose is expected", poses->where()));
}

/// The poses of a map, by group or not.
std::vector<PlacedPose> placedPoses(const YamlReader& map, const robots::Model& model) {
  std::vector<PlacedPose> places;
  if (givesOwnPoses(map, model)) {
    addPoses(map, -1, places);
    return places;
  }
  for (const auto& [name, value] : map.entries()) {
    if (value.isScalar() && value.text() == "any" && model.findGroup(name) >= 0) continue;
    if (!givesOwnPoses(value, model))
      value.fail(
          fmt::format("{} gives joint values, and another group has a pose; poses alone, "
                      "beside them 'any', or joint values alone are expected",
                      value.where()));
    addPoses(value, model.findGroup(name), places);
  }
  return places;
}

}  // namespace

bool givesPoses(const YamlReader& map, const robots::Model& model) {
  if (givesOwnPoses(map, model)) return true;
  if (!map.isMap()) return false;
  const auto entries = map.entries();
  return std::any_of(entries.begin(), entries.end(), [&](const auto& entry) {
    return model.findJoint(entry.first) < 0 && model.findGroup(entry.first) >= 0 &&
           givesOwnPoses(entry.second, model);
  });
}

std::vector<FramePose> readFramePoses(const YamlReader& map, const robots::Model& model,
                                      std::vector<std::string>& warnings) {
  std::vector<FramePose> read;
  for (const PlacedPose& place : placedPoses(map, model))
    read.push_back(readFramePose(place.map, warnings));
  return read;
}

std::vector<robots::PoseRegion> readPoseRegions(const YamlReader& map, Problem& problem) {
  const robots::Model& model = *problem.robot.model;
  std::vector<robots::PoseRegion> regions;
  for (const auto& [place, group] : placedPoses(map, model)) {
    const FramePose pose = readFramePose(place, problem.warnings);
    try {
      regions.push_back(regionOf(problem, pose));
    } catch (const std::invalid_argument& error) {
      place.fail(fmt::format("{}: {}", place.where(), error.what()));
    }
    if (group >= 0 &&
        !robots::movesLink(model, model.groups[at(group)].variables, regions.back().link))
      place.fail(
          fmt::format("{}: no joint of group '{}' moves '{}'; a frame that it moves is "
                      "expected",
                      place.where(), model.groups[at(group)].name, pose.frame));
  }
  return regions;
}

namespace {

Constraint readConstraint(const YamlReader& map, const std::string& name, Problem& problem) {
  map.expectKeys(keysOf("constraint"));
  Constraint constraint;
  constraint.name = name;
  constraint.frame = map.at("frame", "the name of a frame, link or attached object").text();
  if (const auto reference = map.find("relative_to")) constraint.relative_to = reference->text();
  if (const auto position = map.find("position"))
    readRanges(*position, kInfinity, kAnyPosition, constraint.position);
  const auto rpy = map.find("rpy"), orientation = map.find("orientation"), axis = map.find("axis");
  if (static_cast<int>(rpy.has_value()) + static_cast<int>(orientation.has_value()) +
          static_cast<int>(axis.has_value()) >
      1)
    map.fail(fmt::format("{} has more than one of 'rpy', 'orientation' and 'axis'; one is expected",
                         map.where()));
  if (rpy) constraint.rotation = rotationFromQuaternion(quaternionFromRpy(rpy->vector3()));
  if (orientation)
    constraint.rotation = rotationFromQuaternion(readQuaternion(*orientation, problem.warnings));
  if (rpy || orientation) constraint.turn = Constraint::Turn::kFixed;
  if (axis) {
    constraint.turn = Constraint::Turn::kAxis;
    constraint.axis = axis->vector3();
    // No default angle suits both a cup and a camera.
    map.at("angle", "how far the axis may be from its direction [rad]");
  }
  expectBeside(map, "direction", axis.has_value(), "'axis'");
  expectBeside(map, "angle", constraint.turn != Constraint::Turn::kAny,
               "'axis', 'rpy' or 'orientation'");
  expectBeside(map, "position_tolerance", map.has("position"), "'position'");
  if (const auto direction = map.find("direction")) constraint.direction = direction->vector3();
  constraint.position_tolerance =
      optionalNumber(map, "position_tolerance", constraint.position_tolerance);
  constraint.angle = optionalNumber(map, "angle", constraint.angle);
  if (const auto fault = constraintFault(problem, constraint, map.where())) failAt(map, *fault);
  return constraint;
}

}  // namespace

void readConstraints(const YamlReader& list, Problem& problem) {
  int number = 0;
  list.eachItem([&](const YamlReader& map) {
    const auto given = map.find("name");
    ++number;
    const std::string name = given ? given->text() : fmt::format("constraint {}", number);
    for (const Constraint& other : problem.constraints)
      if (other.name == name)
        given.value_or(map).fail(fmt::format(
            "two constraints are named '{}'; a name of its own is expected for each", name));
    problem.constraints.push_back(readConstraint(map, name, problem));
  });
  if (number == 0) list.fail("constraints is empty; at least one is expected");
  if (const auto fault = constraintsFault(problem)) list.fail(*fault);
}

}  // namespace leeway::planner
