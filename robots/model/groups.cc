#include "leeway/robots/groups.h"

#include <algorithm>
#include <map>
#include <stdexcept>

#include "collision/base/numbers.h"

namespace leeway::robots {

std::string groupsFault(const RobotDescription& robot, std::span<const std::string> groups) {
  if (groups.empty()) return "no group is named; at least one is expected";
  std::map<int, std::string> taken;
  for (const std::string& name : groups) {
    const std::vector<int>& variables = robot.groups[at(robot.findGroup(name))].variables;
    if (variables.empty())
      return "group '" + name + "' has no joint that can move; another group is expected";
    for (const int v : variables) {
      const auto [other, is_new] = taken.emplace(v, name);
      if (is_new) continue;
      if (other->second == name)
        return "group '" + name + "' stands twice; each group once is expected";
      return "groups '" + other->second + "' and '" + name + "' both have joint '" +
             robot.variables[at(v)].name + "'; groups without a common joint are expected";
    }
  }
  return {};
}

std::vector<int> variablesOf(const RobotDescription& robot, std::span<const std::string> groups) {
  for (const std::string& name : groups)
    if (robot.findGroup(name) < 0)
      throw std::invalid_argument("robot '" + robot.name + "' has no group '" + name + "'");
  if (const std::string fault = groupsFault(robot, groups); !fault.empty())
    throw std::invalid_argument(fault);
  std::vector<int> variables;
  for (const std::string& name : groups) {
    const std::vector<int>& own = robot.groups[at(robot.findGroup(name))].variables;
    variables.insert(variables.end(), own.begin(), own.end());
  }
  return variables;
}

std::vector<std::string> groupsOf(const RobotDescription& robot, std::span<const int> variables) {
  std::vector<std::string> names;
  while (!variables.empty()) {
    const Group* longest = nullptr;
    for (const Group& group : robot.groups) {
      const std::vector<int>& own = group.variables;
      if (own.empty() || own.size() > variables.size() ||
          !std::equal(own.begin(), own.end(), variables.begin()))
        continue;
      if (longest == nullptr || own.size() > longest->variables.size()) longest = &group;
    }
    if (longest == nullptr) return {};
    names.push_back(longest->name);
    variables = variables.subspan(longest->variables.size());
  }
  return names;
}

bool movesLink(const RobotDescription& robot, std::span<const int> variables, int link) {
  for (; link >= 0; link = robot.joints[at(robot.links[at(link)].joint)].parent_link) {
    const Joint* joint = &robot.joints[at(robot.links[at(link)].joint)];
    while (joint->mimic >= 0) joint = &robot.joints[at(joint->mimic)];
    for (int k = 0; k < joint->variable_count; ++k)
      if (std::find(variables.begin(), variables.end(), joint->first_variable + k) !=
          variables.end())
        return true;
  }
  return false;
}

}  // namespace leeway::robots
