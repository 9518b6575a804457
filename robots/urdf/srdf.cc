// SRDF as MoveIt reads it (moveit_core, RobotModel::addJointModelGroup): a link means the joint
// above it, a chain the joints between its two ends. One deviation: of a chain that goes up and
// down again, the joint above its highest link is left out, because it moves both ends alike.

#include "robots/urdf/srdf.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "leeway/robots/groups.h"
#include "leeway/robots/text.h"
#include "robots/base/tolerances.h"

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

/// Calls read(errors), which gathers all that is wrong with an entry. False: it is left out.
template <class Read>
bool readEntry(XmlFile& file, const XMLElement& e, const std::string& kind, RobotDescription& model,
               const Read& read) {
  InputErrors wrong;
  try {
    readOn(&wrong, [&] { read(wrong); });
  } catch (const InputError&) {  // there are more than it has room for
  }
  if (wrong.list().empty()) return true;
  const char* name = e.Attribute("name");
  const char* group = e.Attribute("group");
  const std::string which = name == nullptr ? "" : ' ' + inQuotes(name);
  model.left_out.push_back({kind, name == nullptr ? "" : name, group == nullptr ? "" : group,
                            wrong.list().front().what()});
  for (const InputError& error : wrong.list()) {
    file.leaveOut(error, "; the " + kind + which + " is left out");
    if (!file.gathersErrors()) break;
  }
  return false;
}

Group groupOf(const RobotDescription& model, const std::string& name, const std::set<int>& joints) {
  Group group;
  group.name = name;
  for (int j : joints) {  // ascending: tree order
    const Joint& joint = model.joints[static_cast<std::size_t>(j)];
    group.links.push_back(joint.child_link);
    for (int k = 0; k < joint.variable_count; ++k)
      group.variables.push_back(joint.first_variable + k);
  }
  return group;
}

class SrdfReader {
 public:
  SrdfReader(XmlFile& file, RobotDescription& model) : file_(file), model_(model) {}

  void read() {
    model_.has_srdf = true;
    if (const XMLElement* link = file_.root().FirstChildElement("link"))
      file_.fail(*link, "<link> is no part of an SRDF: the file is a URDF; an SRDF is expected");
    const char* name = file_.root().Attribute("name");
    if (name != nullptr && name != model_.name)
      file_.warn(file_.root(), "the SRDF is for the robot " + inQuotes(name) + ", the URDF's is " +
                                   inQuotes(model_.name));
    leaveOutUnknown();
    readGroups();
    readGroupStates();
    readCollisions();
    readEntries("end_effector", "end effector",
                [&](const XMLElement& e, InputErrors& wrong) { checkEndEffector(e, wrong); });
    readEntries("passive_joint", "passive joint",
                [&](const XMLElement& e, InputErrors&) { checkPassiveJoint(e); });
  }

 private:
  /// A <group> while groups are read. It may name groups further down.
  struct RawGroup {
    const XMLElement* element;
    std::string name;
    std::set<int> joints = {};
    enum class State { kNotRead, kBeingRead, kRead, kWrong } state = State::kNotRead;
  };

  template <class Read>
  void readEntries(const char* element, const char* kind, const Read& read) {
    file_.eachChild(file_.root(), element, [&](const XMLElement& e) {
      readEntry(file_, e, kind, model_, [&](InputErrors& wrong) { read(e, wrong); });
    });
  }

  void leaveOutUnknown() {
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
        file_.leaveOut(*e, "<" + std::string(e->Name()) + "> is not known and is left out");
      else
        leaveOutUnknownIn(*e);
    }
  }

  /// Attributes and text that have no meaning in an element, and in those inside it.
  void leaveOutUnknownIn(const XMLElement& e) {
    static const std::map<std::string, std::vector<std::string>> kAttributes = {
        {"group", {"name"}},
        {"chain", {"base_link", "tip_link"}},
        {"joint", {"name", "value"}},
        {"link", {"name"}},
        {"group_state", {"name", "group"}},
        {"disable_collisions", {"link1", "link2", "reason"}},
        {"enable_collisions", {"link1", "link2", "reason"}},
        {"disable_default_collisions", {"link"}},
        {"virtual_joint", {"name", "type", "parent_frame", "child_link"}},
        {"end_effector", {"name", "parent_link", "group", "parent_group"}},
        {"passive_joint", {"name"}},
        {"joint_property", {"joint_name", "property_name", "value"}}};
    const auto known = kAttributes.find(e.Name());
    if (known == kAttributes.end()) return;
    file_.allowAttributes(e, known->second, XmlFile::Misspelt::kLeftOut);
    for (const XMLElement* child = e.FirstChildElement(); child != nullptr;
         child = child->NextSiblingElement())
      leaveOutUnknownIn(*child);
  }

  template <typename Item>
  int require(const XMLElement& at, const char* what, const std::string& name,
              const std::vector<Item>& items, int found) const {
    if (found >= 0) return found;
    const std::string which =
        "the " + std::string(what) + ' ' + inQuotes(name) + " in <" + at.Name() + "> ";
    const std::string kind = std::strcmp(what, "joint") == 0 ? "virtual joint" : what;
    if (!model_.whyLeftOut(kind, name).empty()) file_.fail(at, which + "is left out itself");
    const std::string nearest = suggestion(name, namesOf(items));
    file_.fail(at,
               which + "is not defined; " +
                   (nearest.empty() ? "the name of a " + std::string(what) + " would be accepted"
                                    : nearest));
  }
  int requireLink(const XMLElement& at, const char* attribute) const {
    const std::string name = file_.attribute(at, attribute);
    return require(at, "link", name, model_.links, model_.findLink(name));
  }
  int requireJoint(const XMLElement& at, const char* attribute) const {
    const std::string name = file_.attribute(at, attribute);
    return require(at, "joint", name, model_.joints, model_.findJoint(name));
  }
  int requireGroup(const XMLElement& at, const char* attribute) const {
    const std::string name = file_.attribute(at, attribute);
    return require(at, "group", name, model_.groups, model_.findGroup(name));
  }

  void readGroups() {
    file_.eachChild(file_.root(), "group", [&](const XMLElement& e) {
      const char* name = e.Attribute("name");
      raw_groups_.push_back({&e, name == nullptr ? "" : name});
    });
    for (RawGroup& group : raw_groups_) collect(group);
    for (const RawGroup& group : raw_groups_)
      if (group.state == RawGroup::State::kRead) keep(group);
  }

  void collect(RawGroup& group) {
    if (group.state != RawGroup::State::kNotRead) return;
    group.state = RawGroup::State::kBeingRead;
    const XMLElement& e = *group.element;
    const bool is_right = readEntry(file_, e, "group", model_, [&](InputErrors& wrong) {
      file_.attribute(e, "name");
      failIfTwice(e, [&](const XMLElement&) { return true; });
      for (const XMLElement* member = e.FirstChildElement(); member != nullptr;
           member = member->NextSiblingElement())
        readOn(&wrong, [&] { collectMember(group, *member); });
    });
    group.state = is_right ? RawGroup::State::kRead : RawGroup::State::kWrong;
  }

  /// Fails where another element of e's kind has its name, and isSame(other): which of them is
  /// meant cannot be known.
  template <class IsSame>
  void failIfTwice(const XMLElement& e, const IsSame& isSame) const {
    const char* name = e.Attribute("name");
    for (const XMLElement* other = file_.root().FirstChildElement(e.Name()); other != nullptr;
         other = other->NextSiblingElement(e.Name()))
      if (other != &e && other->Attribute("name", name) != nullptr && isSame(*other))
        file_.fail(e, "<" + std::string(e.Name()) + " name=" + inQuotes(name) +
                          "> is there twice, in line " + std::to_string(other->GetLineNum()) +
                          ", too; one would be accepted");
  }

  void collectMember(RawGroup& group, const XMLElement& e) {
    const std::string kind = e.Name();
    if (kind == "chain") {
      addChain(e, group.joints);
    } else if (kind == "joint" || kind == "passive_joint") {
      group.joints.insert(requireJoint(e, "name"));
    } else if (kind == "link") {
      group.joints.insert(model_.links[static_cast<std::size_t>(requireLink(e, "name"))].joint);
    } else if (kind == "group") {
      addGroup(e, group);
    } else {
      file_.fail(
          e,
          "<" + kind + "> in <group> is not known; chain, joint, link and group would be accepted");
    }
  }

  void addGroup(const XMLElement& e, RawGroup& group) {
    const std::string name = file_.attribute(e, "name");
    const auto found = std::find_if(raw_groups_.begin(), raw_groups_.end(),
                                    [&](const RawGroup& other) { return other.name == name; });
    if (found == raw_groups_.end()) require(e, "group", name, raw_groups_, -1);
    if (found->state == RawGroup::State::kBeingRead)
      file_.fail(e, "the group " + inQuotes(group.name) + " contains itself by way of " +
                        inQuotes(name) + "; groups below it would be accepted");
    collect(*found);
    if (found->state == RawGroup::State::kWrong)
      file_.fail(e, "the group " + inQuotes(name) + " in <group> is left out itself");
    group.joints.insert(found->joints.begin(), found->joints.end());
  }

  void addChain(const XMLElement& e, std::set<int>& joints) const {
    const int base = requireLink(e, "base_link"), tip = requireLink(e, "tip_link");
    for (const int joint : chainJoints(model_, base, tip)) joints.insert(joint);
  }

  void keep(const RawGroup& raw) {
    model_.groups.push_back(groupOf(model_, raw.name, raw.joints));
    group_joints_.push_back(raw.joints);
  }

  void readGroupStates() {
    readEntries("group_state", "group state", [&](const XMLElement& e, InputErrors& wrong) {
      GroupState state = readGroupState(e, wrong);
      if (wrong.list().empty()) model_.group_states.push_back(std::move(state));
    });
  }

  /// Returns whether --state and --start read a name as something other than a group state.
  static bool readsOtherwise(const std::string& name) {
    if (name == "start" || name == "goal" || name.find('=') != std::string::npos) return true;
    std::string spaced = name;
    std::replace(spaced.begin(), spaced.end(), ',', ' ');
    std::istringstream words(spaced);
    for (std::string word; words >> word;)
      if (!parseNumber(word)) return false;
    return true;
  }

  GroupState readGroupState(const XMLElement& e, InputErrors& wrong) {
    GroupState state;
    state.name = file_.attribute(e, "name");
    if (readsOtherwise(state.name))
      file_.warn(e, "the name " + inQuotes(state.name) +
                        " of a group state may be read as values, or as a problem's own start or "
                        "goal; another name would be clear");
    const int group = requireGroup(e, "group");
    state.group = model_.groups[static_cast<std::size_t>(group)].name;
    failIfTwice(e, [&](const XMLElement& other) {
      return other.Attribute("group", state.group.c_str()) != nullptr;
    });
    std::map<int, int> lines;
    std::vector<const XMLElement*> followers;
    for (const XMLElement* value = e.FirstChildElement("joint"); value != nullptr;
         value = value->NextSiblingElement("joint"))
      readOn(&wrong, [&] {
        const int joint = requireJoint(*value, "name");
        const auto [entry, is_new] = lines.emplace(joint, value->GetLineNum());
        if (!is_new)
          file_.fail(*value, "a second value for joint " + inQuotes(value->Attribute("name")) +
                                 ", the first is in line " + std::to_string(entry->second) +
                                 "; one would be accepted");
        if (group_joints_[static_cast<std::size_t>(group)].count(joint) == 0)
          file_.fail(*value, "joint " + inQuotes(value->Attribute("name")) +
                                 " is not in the group " + inQuotes(state.group) +
                                 "; a joint of that group would be accepted");
        addValue(*value, model_.joints[static_cast<std::size_t>(joint)], state);
        if (model_.joints[static_cast<std::size_t>(joint)].mimic >= 0) followers.push_back(value);
      });
    for (const XMLElement* value : followers) warnOfFollower(*value, state);
    return state;
  }

  /// Warns of a value of a joint that follows another one, unless it follows from the state's.
  void warnOfFollower(const XMLElement& e, const GroupState& state) {
    const auto jointAt = [&](int index) -> const Joint& {
      return model_.joints[static_cast<std::size_t>(index)];
    };
    const Joint& joint = jointAt(model_.findJoint(e.Attribute("name")));
    const Joint& master = jointAt(joint.mimic);
    for (const auto& [variable, value] : state.values)
      if (variable == master.first_variable &&
          std::abs(joint.multiplier * value + joint.offset - file_.numbers(e, "value").front()) <=
              kSameStated)
        return;
    file_.warn(e, "joint " + inQuotes(joint.name) + " follows " + inQuotes(master.name) +
                      ": its value " + inQuotes(e.Attribute("value")) + " in the group state " +
                      inQuotes(state.name) + " is left out");
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
        file_.warn(e, "joint " + inQuotes(joint.name) + " is fixed: its value " +
                          inQuotes(e.Attribute("value")) + " is left out");
      return;  // a mimic joint follows its master
    }
    for (std::size_t k = 0; k < values.size(); ++k) {
      const int index = joint.first_variable + static_cast<int>(k);
      const Variable& variable = model_.variables[static_cast<std::size_t>(index)];
      if (values[k] < variable.lower || values[k] > variable.upper)
        file_.warn(e, "value " + inQuotes(e.Attribute("value")) + " of joint " +
                          inQuotes(joint.name) + " in the group state " + inQuotes(state.name) +
                          " is outside of its limits " + std::to_string(variable.lower) + " to " +
                          std::to_string(variable.upper));
      state.values.emplace_back(index, values[k]);
    }
  }

  /// As MoveIt's matrix (collision_detection, AllowedCollisionMatrix): defaults of links first,
  /// then the pairs that are enabled, then those that are disabled.
  void readCollisions() {
    std::set<std::pair<int, int>> enabled, disabled;
    readEntries("disable_collisions", "disabled pair", [&](const XMLElement& e, InputErrors&) {
      const std::pair<int, int> pair = readPair(e);
      if (!disabled.insert(pair).second) return;
      const char* reason = e.Attribute("reason");
      model_.disabled_pairs.push_back({pair.first, pair.second, reason != nullptr ? reason : ""});
    });
    readEntries("enable_collisions", "enabled pair", [&](const XMLElement& e, InputErrors&) {
      const std::pair<int, int> pair = readPair(e);
      if (disabled.count(pair) == 0 && enabled.insert(pair).second)
        model_.enabled_pairs.push_back(pair);
    });
    std::set<int> unchecked;
    readEntries("disable_default_collisions", "default", [&](const XMLElement& e, InputErrors&) {
      const int link = requireLink(e, "link");
      if (unchecked.insert(link).second) model_.unchecked_links.push_back(link);
    });
    for (const int link : unchecked)
      for (int other = 0; other < static_cast<int>(model_.links.size()); ++other) {
        const std::pair<int, int> pair = std::minmax(link, other);
        if (other == link || enabled.count(pair) != 0 || !disabled.insert(pair).second) continue;
        model_.disabled_pairs.push_back({pair.first, pair.second, "disable_default_collisions"});
      }
  }

  /// Two links, the lower number first.
  std::pair<int, int> readPair(const XMLElement& e) const {
    const std::pair<int, int> pair =
        std::minmax({requireLink(e, "link1"), requireLink(e, "link2")});
    if (pair.first == pair.second)
      file_.fail(e, "<" + std::string(e.Name()) + "> names the link " +
                        inQuotes(e.Attribute("link1")) + " twice; two links would be accepted");
    return pair;
  }

  void checkEndEffector(const XMLElement& e, InputErrors& wrong) const {
    readOn(&wrong, [&] { requireGroup(e, "group"); });
    readOn(&wrong, [&] { requireLink(e, "parent_link"); });
    if (e.Attribute("parent_group") != nullptr) requireGroup(e, "parent_group");
  }

  void checkPassiveJoint(const XMLElement& e) {
    const int joint = requireJoint(e, "name");
    if (model_.joints[static_cast<std::size_t>(joint)].variable_count == 0) return;
    for (std::size_t i = 0; i < group_joints_.size(); ++i)
      if (group_joints_[i].count(joint) != 0)
        file_.warn(e, "the passive joint " + inQuotes(e.Attribute("name")) + " is in the group " +
                          inQuotes(model_.groups[i].name) + " and is planned with it");
  }

  XmlFile& file_;
  RobotDescription& model_;
  std::vector<RawGroup> raw_groups_;
  std::vector<std::set<int>> group_joints_;  // of each group of the model
};

/// The virtual joint of one element. Fails for one that cannot be the root link's.
VirtualJoint virtualJointOf(const XmlFile& srdf, const XMLElement& e, const std::string& root_link,
                            std::span<const std::string> joints) {
  VirtualJoint joint;
  joint.name = srdf.attribute(e, "name");
  const std::string child = srdf.attribute(e, "child_link"), type = srdf.attribute(e, "type");
  if (child != root_link)
    srdf.fail(e, "the virtual joint's child_link is " + inQuotes(child) + "; the root link " +
                     inQuotes(root_link) + " would be accepted");
  if (std::find(joints.begin(), joints.end(), joint.name) != joints.end())
    srdf.fail(e, "the virtual joint's name " + inQuotes(joint.name) +
                     " is that of a joint of the URDF; another name would be accepted");
  if (type == "planar") {
    joint.type = JointType::kPlanar;
  } else if (type == "floating") {
    joint.type = JointType::kFloating;
  } else if (type != "fixed") {
    srdf.fail(e, "the virtual joint's type is " + inQuotes(type) +
                     "; fixed, planar or floating would be accepted");
  }
  for (const XMLElement* other = srdf.root().FirstChildElement("virtual_joint"); other != nullptr;
       other = other->NextSiblingElement("virtual_joint"))
    if (other != &e && other->Attribute("child_link", child.c_str()) != nullptr)
      srdf.fail(e, "a virtual joint of the same link is in line " +
                       std::to_string(other->GetLineNum()) + ", too; one would be accepted");
  return joint;
}

}  // namespace

std::optional<VirtualJoint> readVirtualJoint(XmlFile& srdf, const std::string& root_link,
                                             std::span<const std::string> joints,
                                             RobotDescription& model) {
  std::optional<VirtualJoint> joint;
  srdf.eachChild(srdf.root(), "virtual_joint", [&](const XMLElement& e) {
    readEntry(srdf, e, "virtual joint", model,
              [&](InputErrors&) { joint = virtualJointOf(srdf, e, root_link, joints); });
  });
  return joint;
}

std::string parentFrame(const RobotDescription& robot, const Stop& stop) {
  const int root = robot.links.empty() ? -1 : robot.links.front().joint;
  if (robot.srdf_file.empty() || root < 0) return {};
  LoadOptions options;
  options.xacro = robot.read_with.xacro;
  options.stop = stop;
  const XmlFile srdf(robot.placeOf(robot.srdf_file), "SRDF", options);
  const std::string& name = robot.joints[static_cast<std::size_t>(root)].name;
  for (const XMLElement* e = srdf.root().FirstChildElement("virtual_joint"); e != nullptr;
       e = e->NextSiblingElement("virtual_joint"))
    if (const char* frame = e->Attribute("parent_frame");
        frame != nullptr && e->Attribute("name", name.c_str()) != nullptr &&
        e->Attribute("child_link", robot.links.front().name.c_str()) != nullptr)
      return frame;
  return {};
}

void readSrdf(XmlFile& srdf, RobotDescription& model) {
  SrdfReader(srdf, model).read();
  for (std::string& warning : srdf.takeWarnings()) model.warnings.push_back(std::move(warning));
}

}  // namespace leeway::robots
