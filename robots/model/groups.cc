#include "leeway/robots/groups.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <stdexcept>

#include "collision/base/numbers.h"

namespace leeway::robots {
namespace {

/// The variables of a joint; none where it is fixed or follows.
std::vector<int> variablesOf(const Joint& joint) {
  std::vector<int> variables;
  for (int k = 0; k < joint.variable_count; ++k) variables.push_back(joint.first_variable + k);
  return variables;
}

std::vector<int> variablesOf(const RobotDescription& robot, const std::string& name) {
  if (const int group = robot.findGroup(name); group >= 0) return robot.groups[at(group)].variables;
  return variablesOf(robot.joints[at(robot.findJoint(name))]);
}

std::string wordFor(const RobotDescription& robot, const std::string& name) {
  return (robot.findGroup(name) >= 0 ? "group '" : "joint '") + name + "'";
}

std::set<int> jointsAbove(const RobotDescription& robot, int link) {
  std::set<int> joints;
  for (int j = robot.links[at(link)].joint; j >= 0;) {
    joints.insert(j);
    const int parent = robot.joints[at(j)].parent_link;
    j = parent < 0 ? -1 : robot.links[at(parent)].joint;
  }
  return joints;
}

bool beginsWith(std::span<const int> variables, const std::vector<int>& own) {
  return !own.empty() && own.size() <= variables.size() &&
         std::equal(own.begin(), own.end(), variables.begin());
}

}  // namespace

bool isGroup(const RobotDescription& robot, std::string_view name) {
  return robot.findGroup(name) >= 0 || robot.findJoint(name) >= 0;
}

std::string groupsFault(const RobotDescription& robot, std::span<const std::string> groups) {
  if (groups.empty()) return "no group is named; at least one is expected";
  std::map<int, std::string> taken;
  for (const std::string& name : groups) {
    const std::vector<int> variables = variablesOf(robot, name);
    if (variables.empty())
      return wordFor(robot, name) + (robot.findGroup(name) >= 0
                                         ? " has no joint that can move; another group is expected"
                                         : " cannot move by itself; another joint is expected");
    for (const int v : variables) {
      const auto [other, is_new] = taken.emplace(v, name);
      if (is_new) continue;
      if (other->second == name) return wordFor(robot, name) + " stands twice; once is expected";
      const bool are_groups = robot.findGroup(name) >= 0 && robot.findGroup(other->second) >= 0;
      return (are_groups ? "groups '" + other->second + "' and '" + name + "'"
                         : wordFor(robot, other->second) + " and " + wordFor(robot, name)) +
             " both have joint '" + robot.variables[at(v)].name +
             "'; groups without a common joint are expected";
    }
  }
  return {};
}

std::vector<int> variablesOf(const RobotDescription& robot, std::span<const std::string> groups) {
  for (const std::string& name : groups)
    if (!isGroup(robot, name))
      throw std::invalid_argument("robot '" + robot.name + "' has no group or joint '" + name +
                                  "'");
  if (const std::string fault = groupsFault(robot, groups); !fault.empty())
    throw std::invalid_argument(fault);
  std::vector<int> variables;
  for (const std::string& name : groups) {
    const std::vector<int> own = variablesOf(robot, name);
    variables.insert(variables.end(), own.begin(), own.end());
  }
  return variables;
}

std::vector<std::string> groupsOf(const RobotDescription& robot, std::span<const int> variables) {
  std::vector<std::string> names;
  while (!variables.empty()) {
    const Group* longest = nullptr;
    for (const Group& group : robot.groups)
      if (beginsWith(variables, group.variables) &&
          (longest == nullptr || group.variables.size() > longest->variables.size()))
        longest = &group;
    if (longest != nullptr) {
      names.push_back(longest->name);
      variables = variables.subspan(longest->variables.size());
      continue;
    }
    const Joint& joint = robot.joints[at(robot.variables[at(variables[0])].joint)];
    const std::vector<int> own = variablesOf(joint);
    if (!beginsWith(variables, own) || robot.findGroup(joint.name) >= 0) return {};
    names.push_back(joint.name);
    variables = variables.subspan(own.size());
  }
  return names;
}

std::vector<int> chainJoints(const RobotDescription& robot, int base_link, int tip_link) {
  const std::set<int> base = jointsAbove(robot, base_link), tip = jointsAbove(robot, tip_link);
  std::vector<int> joints;
  std::set_symmetric_difference(base.begin(), base.end(), tip.begin(), tip.end(),
                                std::back_inserter(joints));
  return joints;
}

std::vector<int> chainVariables(const RobotDescription& robot, int base_link, int tip_link) {
  std::vector<int> variables;
  for (const int joint : chainJoints(robot, base_link, tip_link))
    for (const int v : variablesOf(robot.joints[at(joint)])) variables.push_back(v);
  return variables;
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
