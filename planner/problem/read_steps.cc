#include "planner/problem/read_steps.h"

#include <fmt/format.h>

#include <map>
#include <stdexcept>

#include "planner/problem/read_motion.h"
#include "planner/problem/read_poses.h"
#include "planner/problem/read_states.h"
#include "planner/validate/checks.h"
#include "planner/validate/format_keys.h"

namespace leeway::planner {
namespace {

MoveStep readMove(const YamlReader& reader, const std::string& name, Problem& world) {
  if (!givesPoses(reader, *world.robot.model)) return {readGoal(reader, name, world), {}};
  readPoseRegions(reader, world);  // for the lines of what is wrong
  return {{}, readFramePoses(reader, world.warnings)};
}

LineStep readLine(const YamlReader& reader) {
  reader.expectKeys(keysOf("line"));
  LineStep line;
  line.frame = reader.at("frame", "the name of a frame, link or attached object").text();
  line.by = reader.at("by", "how far and where to: [x, y, z] in m").vector3();
  if (const auto axes = reader.find("relative_to")) line.relative_to = axes->text();
  line.position_tolerance = optionalNumber(reader, "position_tolerance", line.position_tolerance);
  line.angle_tolerance = optionalNumber(reader, "angle_tolerance", line.angle_tolerance);
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

void readAllowed(const YamlReader& reader, const Names& names, Step& step) {
  for (const YamlReader& pair : reader.items()) {
    const std::vector<YamlReader> items = pair.items();
    if (items.size() != 2)
      pair.fail(fmt::format("{} is no pair; two different names of links or objects are expected",
                            pair.where()));
    step.allowed.emplace_back(items[0].text(), items[1].text());
    const auto& [a, b] = step.allowed.back();
    if (const std::string fault = names.pairFault(a, b); !fault.empty())
      pair.fail(fmt::format("{}: {}", pair.where(), fault));
  }
}

}  // namespace

void readSteps(const YamlReader& reader, Problem& problem) {
  // The world as each step finds it, as far as names go: objects are taken from where they stand.
  Problem world = problem;
  const Names names(problem);
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
    if (const auto allowed = map.find("allowed")) readAllowed(*allowed, names, step);
    const YamlReader value = map.at(action, "what it does");
    if (action == "move") {
      step.action = readMove(value, step.name, world);
    } else if (action == "line") {
      step.action = readLine(value);
    } else if (action == "attach") {
      step.action = readAttach(value);
    } else {
      step.action = DetachStep{value.text()};
    }
    try {
      takeStep(step, world);
    } catch (const std::invalid_argument& error) {
      value.fail(fmt::format("{}: {}", value.where(), error.what()));
    }
    problem.steps.push_back(std::move(step));
  }
  if (problem.steps.empty()) reader.fail("steps is empty; at least one step is expected");
  problem.warnings = world.warnings;
}

}  // namespace leeway::planner
