#include "planner/problem/read_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <stdexcept>

#include "planner/base/did_you_mean.h"
#include "planner/base/tolerances.h"
#include "planner/problem/read_poses.h"
#include "planner/problem/read_states.h"
#include "planner/yaml/format_keys.h"

namespace leeway::planner {
namespace {

/// Calls `function`, whose complaints about names and order become errors at `place`.
template <class Function>
auto checked(const YamlReader& place, const Function& function) {
  try {
    return function();
  } catch (const std::invalid_argument& error) {
    place.fail(fmt::format("{}: {}", place.where(), error.what()));
  }
}

MoveStep readMove(const YamlReader& reader, const std::string& name, Problem& world) {
  if (!givesPoses(reader, *world.robot.model)) return {readGoal(reader, name, world), {}};
  readPoseRegions(reader, world);
  return {{}, readFramePoses(reader, world.warnings)};
}

LineStep readLine(const YamlReader& reader, const Problem& world) {
  reader.expectKeys(keysOf("line"));
  LineStep line;
  line.frame = reader.at("frame", "the name of a frame, link or attached object").text();
  const YamlReader by = reader.at("by", "how far and where to: [x, y, z] in m");
  line.by = by.vector3();
  if (!(line.by.norm() > 0))
    by.fail(fmt::format("{} is of no length; the way from here [x, y, z] in m is expected",
                        by.where()));
  if (const auto axes = reader.find("relative_to")) line.relative_to = axes->text();
  const auto tolerance = [&](const char* key, double& value) {
    const auto found = reader.find(key);
    if (!found) return;
    value = found->number();
    if (!(value >= kLeastLineTolerance))
      found->fail(fmt::format("{} is {}; at least {} is expected", found->where(), value,
                              kLeastLineTolerance));
  };
  tolerance("position_tolerance", line.position_tolerance);
  tolerance("angle_tolerance", line.angle_tolerance);
  FramePose place;
  place.frame = line.frame;
  place.relative_to = line.relative_to == "world" ? "" : line.relative_to;
  place.position.fill({0, 0});
  place.rpy.fill({0, 0});
  checked(reader, [&] { return poseRegion(world, place); });
  return line;
}

AttachStep readAttach(const YamlReader& reader, Problem& world) {
  reader.expectKeys(keysOf("attach_step"));
  AttachStep attach;
  attach.object = reader.at("object", "the name of an object").text();
  attach.link = reader.at("link", "the name of the link that takes hold of it").text();
  if (const auto touch = reader.find("touch"))
    for (const YamlReader& link : touch->items()) attach.touch.push_back(link.text());
  for (const Attachment& held : world.robot.attachments)
    if (held.object.name == attach.object)
      reader.fail(
          fmt::format("{}: object '{}' is held already; an object that stands in the world "
                      "is expected",
                      reader.where(), attach.object));
  world = checked(reader,
                  [&] { return attachObject(world, attach.object, attach.link, attach.touch); });
  return attach;
}

void readAllowed(const YamlReader& reader, const Problem& world, Step& step) {
  std::vector<std::string> known;
  for (const robots::Link& link : world.robot.model->links) known.push_back(link.name);
  for (const Object& object : world.world.objects) known.push_back(object.name);
  for (const DeformingObstacle& obstacle : world.world.deforming)
    known.push_back(obstacle.object.name);
  for (const Attachment& held : world.robot.attachments) known.push_back(held.object.name);
  for (const YamlReader& pair : reader.items()) {
    const std::vector<YamlReader> names = pair.items();
    if (names.size() != 2 || names[0].text() == names[1].text())
      pair.fail(fmt::format("{} is no pair; two different names of links or objects are expected",
                            pair.where()));
    for (const YamlReader& name : names)
      if (std::find(known.begin(), known.end(), name.text()) == known.end())
        name.fail(fmt::format("unknown link or object '{}' in {}{}", name.text(), pair.where(),
                              didYouMean(name.text(), known)));
    step.allowed.emplace_back(names[0].text(), names[1].text());
  }
}

}  // namespace

void readSteps(const YamlReader& reader, Problem& problem) {
  // The world as each step finds it, as far as names go: objects are taken from where they stand.
  Problem world = problem;
  std::map<std::string, int> named;  // how many steps have no name but that
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
    if (const auto allowed = map.find("allowed")) {
      if (action == "attach" || action == "detach")
        allowed->fail(fmt::format("{}: nothing moves in this step; a step that moves is expected",
                                  allowed->where()));
      readAllowed(*allowed, world, step);
    }
    const YamlReader value = map.at(action, "what it does");
    if (action == "move") {
      step.action = readMove(value, step.name, world);
    } else if (action == "line") {
      step.action = readLine(value, world);
    } else if (action == "attach") {
      step.action = readAttach(value, world);
    } else {
      step.action = DetachStep{value.text()};
      world = checked(value, [&] { return detachObject(world, value.text()); });
    }
    problem.steps.push_back(std::move(step));
  }
  if (problem.steps.empty()) reader.fail("steps is empty; at least one step is expected");
  problem.warnings = world.warnings;
}

}  // namespace leeway::planner
