// SRDF as MoveIt reads it (moveit_core, RobotModel::addJointModelGroup): a link means the joint
// above it, a chain the joints between its two ends. One deviation: of a chain that goes up and
// down again, the joint above its highest link is left out, because it moves both ends alike.

#include "robots/urdf/srdf.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

template <typename Item>
std::vector<std::string> namesOf(const std::vector<Item>& items) {
  std::vector<std::string> names;
  names.reserve(items.size());
  for (const Item& item : items) names.push_back(item.name);
  return names;
}

class SrdfReader {
 public:
  SrdfReader(const std::string& path, RobotDescription& model, const LoadOptions& options)
      : file_(path, "SRDF", options),
        errors_(options.errors),
        wrong_(options.errors),
        model_(model) {}

  void read() {
    model_.has_srdf = true;
    if (const XMLElement* link = file_.root().FirstChildElement("link"))
      file_.fail(*link, "<link> is no part of an SRDF: the file is a URDF; an SRDF is expected");
    const char* name = file_.root().Attribute("name");
    if (name != nullptr && name != model_.name)
      warn(file_.root(), "the SRDF is for the robot " + inQuotes(name) + ", the URDF's is " +
                             inQuotes(model_.name));
    warnUnread();
    readGroups();
    file_.eachChild(file_.root(), "group_state", [&](const XMLElement& e) { readGroupState(e); });
    readCollisions();
    file_.eachChild(file_.root(), "end_effector",
                    [&](const XMLElement& e) { checkEndEffector(e); });
    file_.eachChild(file_.root(), "passive_joint",
                    [&](const XMLElement& e) { checkPassiveJoint(e); });
  }

 private:
  void warn(const XMLElement& at, const std::string& message) {
    model_.warnings.push_back(file_.locate(at, message));
  }

  void warnUnread() {
    static constexpr const char* kKnown[] = {"group",
                                             "group_state",
                                             "disable_collisions",
                                             "disable_default_collisions",
                                             "enable_collisions",
                                             "virtual_joint",
                                             "end_effector",
                                             "passive_joint",
                                             "link_sphere_approximation",
                                             "joint_property"};
    for (const XMLElement* e = file_.root().FirstChildElement(); e != nullptr;
         e = e->NextSiblingElement()) {
      const auto same = [&](const char* name) { return std::strcmp(name, e->Name()) == 0; };
      if (std::none_of(std::begin(kKnown), std::end(kKnown), same))
        warn(*e, "<" + std::string(e->Name()) + "> is not known and is left out");
    }
  }

  template <typename Item>
  int require(const XMLElement& at, const char* what, const std::string& name,
              const std::vector<Item>& items, int found) {
    if (found >= 0) return found;
    const std::string nearest = suggestion(name, namesOf(items));
    file_.fail(at,
               "the " + std::string(what) + ' ' + inQuotes(name) + " in <" + at.Name() +
                   "> is not defined; " +
                   (nearest.empty() ? "the name of a " + std::string(what) + " would be accepted"
                                    : nearest));
  }
  int requireLink(const XMLElement& at, const char* attribute) {
    const std::string name = file_.attribute(at, attribute);
    return require(at, "link", name, model_.links, model_.findLink(name));
  }
  int requireJoint(const XMLElement& at, const char* attribute) {
    const std::string name = file_.attribute(at, attribute);
    return require(at, "joint", name, model_.joints, model_.findJoint(name));
  }
  /// Groups may name groups further down: readGroups() reads all names first.
  int requireGroup(const XMLElement& at, const char* attribute) {
    const std::string name = file_.attribute(at, attribute);
    return require(at, "group", name, model_.groups, model_.findGroup(name));
  }

  void readGroups() {
    std::vector<const XMLElement*> elements;
    std::map<std::string, int> lines;
    file_.eachChild(file_.root(), "group", [&](const XMLElement& e) {
      Group group;
      group.name = file_.attribute(e, "name");
      const auto [entry, fresh] = lines.emplace(group.name, e.GetLineNum());
      if (!fresh)
        file_.fail(e, "a second group " + inQuotes(group.name) + ", the first is in line " +
                          std::to_string(entry->second) + "; names must be unique");
      elements.push_back(&e);
      model_.groups.push_back(std::move(group));
    });
    group_joints_.resize(elements.size());
    std::vector<int> state(elements.size(), 0);
    for (std::size_t i = 0; i < elements.size(); ++i) collect(elements, i, state);
    for (std::size_t i = 0; i < elements.size(); ++i) fill(model_.groups[i], group_joints_[i]);
    groups_are_whole_ = !wrong_.any();
  }

  /// state: 0 not begun, 1 being collected, 2 done.
  void collect(const std::vector<const XMLElement*>& elements, std::size_t i,
               std::vector<int>& state) {
    if (state[i] == 2) return;
    state[i] = 1;
    for (const XMLElement* e = elements[i]->FirstChildElement(); e != nullptr;
         e = e->NextSiblingElement())
      readOn(errors_, [&] { collectMember(elements, i, *e, state); });
    state[i] = 2;
  }

  void collectMember(const std::vector<const XMLElement*>& elements, std::size_t i,
                     const XMLElement& e, std::vector<int>& state) {
    std::set<int>& joints = group_joints_[i];
    const std::string kind = e.Name();
    if (kind == "chain") {
      addChain(e, joints);
    } else if (kind == "joint" || kind == "passive_joint") {
      joints.insert(requireJoint(e, "name"));
    } else if (kind == "link") {
      joints.insert(model_.links[static_cast<std::size_t>(requireLink(e, "name"))].joint);
    } else if (kind == "group") {
      const auto other = static_cast<std::size_t>(requireGroup(e, "name"));
      if (state[other] == 1)
        file_.fail(e, "the group " + inQuotes(model_.groups[i].name) +
                          " contains itself by way of " + inQuotes(model_.groups[other].name) +
                          "; groups below it would be accepted");
      collect(elements, other, state);
      joints.insert(group_joints_[other].begin(), group_joints_[other].end());
    } else {
      file_.fail(
          e,
          "<" + kind + "> in <group> is not known; chain, joint, link and group would be accepted");
    }
  }

  /// The joints above `link`, nearest first, the root's last.
  std::vector<int> jointsAbove(int link) const {
    std::vector<int> joints;
    for (; link >= 0; link = model_.joints[static_cast<std::size_t>(joints.back())].parent_link)
      joints.push_back(model_.links[static_cast<std::size_t>(link)].joint);
    return joints;
  }

  void addChain(const XMLElement& e, std::set<int>& joints) {
    const std::vector<int> base = jointsAbove(requireLink(e, "base_link"));
    const std::vector<int> tip = jointsAbove(requireLink(e, "tip_link"));
    for (int joint : tip)
      if (std::find(base.begin(), base.end(), joint) == base.end()) joints.insert(joint);
    for (int joint : base)
      if (std::find(tip.begin(), tip.end(), joint) == tip.end()) joints.insert(joint);
  }

  void fill(Group& group, const std::set<int>& joints) {
    for (int j : joints) {  // ascending: tree order
      const Joint& joint = model_.joints[static_cast<std::size_t>(j)];
      group.links.push_back(joint.child_link);
      for (int k = 0; k < joint.variable_count; ++k)
        group.variables.push_back(joint.first_variable + k);
    }
  }

  void readGroupState(const XMLElement& e) {
    GroupState state;
    state.name = file_.attribute(e, "name");
    const int group = requireGroup(e, "group");
    state.group = model_.groups[static_cast<std::size_t>(group)].name;
    for (const GroupState& other : model_.group_states)
      if (other.name == state.name && other.group == state.group)
        file_.fail(e, "a second group_state " + inQuotes(state.name) + " of the group " +
                          inQuotes(state.group) + "; names must be unique in a group");
    std::map<int, int> lines;
    file_.eachChild(e, "joint", [&](const XMLElement& value) {
      const int joint = requireJoint(value, "name");
      const auto [entry, fresh] = lines.emplace(joint, value.GetLineNum());
      if (!fresh)
        file_.fail(value, "a second value for joint " + inQuotes(value.Attribute("name")) +
                              ", the first is in line " + std::to_string(entry->second) +
                              "; one would be accepted");
      if (groups_are_whole_ && group_joints_[static_cast<std::size_t>(group)].count(joint) == 0)
        file_.fail(value, "joint " + inQuotes(value.Attribute("name")) + " is not in the group " +
                              inQuotes(state.group) + "; a joint of that group would be accepted");
      addValue(value, model_.joints[static_cast<std::size_t>(joint)], state);
    });
    model_.group_states.push_back(std::move(state));
  }

  void addValue(const XMLElement& e, const Joint& joint, GroupState& state) {
    const std::vector<double> values = file_.numbers(e, "value");
    const std::size_t expected =
        joint.variable_count == 0 ? 1 : static_cast<std::size_t>(joint.variable_count);
    if (values.size() != expected)
      file_.fail(e, "value of joint " + inQuotes(joint.name) + " is " +
                        inQuotes(e.Attribute("value")) + ", " + std::to_string(values.size()) +
                        " numbers; " + std::to_string(expected) + " would be accepted");
    if (joint.variable_count == 0) {
      if (joint.mimic < 0 && values.front() != 0)
        warn(e, "joint " + inQuotes(joint.name) + " is fixed: its value " +
                    inQuotes(e.Attribute("value")) + " is left out");
      return;  // a mimic joint follows its master
    }
    for (std::size_t k = 0; k < values.size(); ++k) {
      const int index = joint.first_variable + static_cast<int>(k);
      const Variable& variable = model_.variables[static_cast<std::size_t>(index)];
      if (values[k] < variable.lower || values[k] > variable.upper)
        warn(e, "value " + inQuotes(e.Attribute("value")) + " of joint " + inQuotes(joint.name) +
                    " in the group state " + inQuotes(state.name) + " is outside of its limits " +
                    std::to_string(variable.lower) + " to " + std::to_string(variable.upper));
      state.values.emplace_back(index, values[k]);
    }
  }

  /// As MoveIt's matrix (collision_detection, AllowedCollisionMatrix): defaults of links first,
  /// then the pairs that are enabled, then those that are disabled.
  void readCollisions() {
    std::set<std::pair<int, int>> enabled, disabled;
    file_.eachChild(file_.root(), "disable_collisions", [&](const XMLElement& e) {
      const std::optional<std::pair<int, int>> pair = readPair(e);
      if (!pair || !disabled.insert(*pair).second) return;
      const char* reason = e.Attribute("reason");
      model_.disabled_pairs.push_back({pair->first, pair->second, reason != nullptr ? reason : ""});
    });
    file_.eachChild(file_.root(), "enable_collisions", [&](const XMLElement& e) {
      const std::optional<std::pair<int, int>> pair = readPair(e);
      if (pair && disabled.count(*pair) == 0 && enabled.insert(*pair).second)
        model_.enabled_pairs.push_back(*pair);
    });
    std::set<int> unchecked;
    file_.eachChild(file_.root(), "disable_default_collisions", [&](const XMLElement& e) {
      const std::string name = file_.attribute(e, "link");
      const int link = model_.findLink(name);
      if (link < 0) return warnUnknownLink(e, name);
      if (unchecked.insert(link).second) model_.unchecked_links.push_back(link);
    });
    for (const int link : unchecked)
      for (int other = 0; other < static_cast<int>(model_.links.size()); ++other) {
        const std::pair<int, int> pair = std::minmax(link, other);
        if (other == link || enabled.count(pair) != 0 || !disabled.insert(pair).second) continue;
        model_.disabled_pairs.push_back({pair.first, pair.second, "disable_default_collisions"});
      }
  }

  void warnUnknownLink(const XMLElement& e, const std::string& name) {
    const std::string nearest = suggestion(name, namesOf(model_.links));
    warn(e, std::string(e.Name()) + " names the link " + inQuotes(name) +
                ", which is not defined, and is left out" +
                (nearest.empty() ? "" : "; " + nearest));
  }

  /// Two links, the lower number first; nothing, with a warning, unless there are two.
  std::optional<std::pair<int, int>> readPair(const XMLElement& e) {
    const std::string name_a = file_.attribute(e, "link1"), name_b = file_.attribute(e, "link2");
    const int a = model_.findLink(name_a), b = model_.findLink(name_b);
    if (a < 0 || b < 0) {
      warnUnknownLink(e, a < 0 ? name_a : name_b);
      return std::nullopt;
    }
    if (a == b) {
      warn(e, std::string(e.Name()) + " names the link " + inQuotes(name_a) +
                  " twice and is left out; two links would be accepted");
      return std::nullopt;
    }
    return std::pair(std::min(a, b), std::max(a, b));
  }

  void checkEndEffector(const XMLElement& e) {
    requireGroup(e, "group");
    requireLink(e, "parent_link");
    if (e.Attribute("parent_group") != nullptr) requireGroup(e, "parent_group");
  }

  void checkPassiveJoint(const XMLElement& e) {
    const std::string name = file_.attribute(e, "name");
    const int joint = model_.findJoint(name);
    if (joint < 0) {
      warn(e, "the passive joint " + inQuotes(name) + " is not defined");
      return;
    }
    if (model_.joints[static_cast<std::size_t>(joint)].variable_count == 0) return;
    for (std::size_t i = 0; i < group_joints_.size(); ++i)
      if (group_joints_[i].count(joint) != 0)
        warn(e, "the passive joint " + inQuotes(name) + " is in the group " +
                    inQuotes(model_.groups[i].name) + " and is planned with it");
  }

  XmlFile file_;
  InputErrors* errors_;
  ErrorsSince wrong_;
  RobotDescription& model_;
  std::vector<std::set<int>> group_joints_;
  bool groups_are_whole_ = true;  // none lacks a member that is wrong
};

}  // namespace

std::optional<VirtualJoint> readVirtualJoint(const std::string& srdf_path,
                                             const LoadOptions& options) {
  const XmlFile file(srdf_path, "SRDF", options);
  const XMLElement* e = file.onlyChild(file.root(), "virtual_joint");
  if (e == nullptr) return std::nullopt;
  VirtualJoint joint;
  joint.name = file.attribute(*e, "name");
  joint.child_link = file.attribute(*e, "child_link");
  joint.line = e->GetLineNum();
  const std::string type = file.attribute(*e, "type");
  if (type == "planar") {
    joint.type = JointType::kPlanar;
  } else if (type == "floating") {
    joint.type = JointType::kFloating;
  } else if (type != "fixed") {
    file.fail(*e, "the virtual joint's type is " + inQuotes(type) +
                      "; fixed, planar or floating would be accepted");
  }
  return joint;
}

void readSrdf(const std::string& srdf_path, RobotDescription& model, const LoadOptions& options) {
  SrdfReader(srdf_path, model, options).read();
}

}  // namespace leeway::robots
