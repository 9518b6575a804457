// MJCF as MuJoCo reads it (its XML reference, and src/user/user_objects.cc).

#include "robots/mjcf/mjcf.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "collision/base/numbers.h"
#include "leeway/robots/text.h"
#include "robots/base/read_on.h"
#include "robots/mjcf/mjcf_bodies.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

class MjcfReader {
 public:
  MjcfReader(XmlFile& file, const LoadOptions& options, bool with_visuals)
      : wrong_(options.errors),
        file_(file, options),
        settings_(readSettings(file_)),
        classes_(file_) {
    document_.path = file.path();
    document_.with_visuals = with_visuals;
    const char* name = file.root().Attribute("model");
    document_.name = name != nullptr && *name != '\0'
                         ? name
                         : std::filesystem::path(file.path()).stem().string();
  }

  UrdfDocument read() {
    checkSections();
    tree_ = readBodies(file_, settings_, classes_, document_);
    if (document_.links.size() == 1 && document_.links[0].collisions.empty())
      file_.fail(file_.main().root(),
                 "the model has no body; at least one <body> in <worldbody> is "
                 "needed");
    // Errors between bodies say little while some bodies are wrong.
    wrong_.throwFirst();
    readContacts(file_, settings_, tree_, document_);
    file_.eachOf("equality", [&](const XMLElement& e) { readEquality(e); });
    file_.eachOf("keyframe", [&](const XMLElement& e) { readKey(e); });
    addRest();
    warnOfLeftOut();
    wrong_.throwFirst();
    for (std::string& warning : file_.takeWarnings())
      document_.warnings.push_back(std::move(warning));
    return std::move(document_);
  }

 private:
  void checkSections() {
    static const std::vector<std::string> kKnown = {
        "compiler", "option",   "size",      "visual",     "statistic", "default",
        "custom",   "asset",    "contact",   "tendon",     "equality",  "actuator",
        "sensor",   "keyframe", "extension", "deformable", "worldbody"};
    file_.eachChild(file_.main().root(), [&](const XMLElement& e) {
      const std::string tag = e.Name();
      if (std::find(kKnown.begin(), kKnown.end(), tag) != kKnown.end()) {
        if (tag != "worldbody") file_.expectNoBodyIn(e);
        return;
      }
      const std::string nearest = suggestion(tag, kKnown);
      file_.fail(e, "<" + tag + "> in <mujoco> is not known; " +
                        (nearest.empty() ? "worldbody, asset, default and the other sections of "
                                           "MuJoCo would be accepted"
                                         : nearest));
    });
    for (const char* section : {"actuator", "sensor", "tendon"})
      file_.eachOf(section, [&](const XMLElement&) { ++left_out_[section]; });
    file_.eachOf("deformable", [&](const XMLElement& e) {
      if (std::string_view(e.Name()) == "skin") {
        ++left_out_["skin"];
        return;
      }
      file_.fail(e, "<" + std::string(e.Name()) +
                        "> is not read, and it collides; a file without it would be accepted");
    });
  }

  void warn(const XMLElement& at, const std::string& message) {
    document_.warnings.push_back(file_.locate(at, message));
  }

  // Equality constraints.

  /// The hinge or slide joint that an attribute names.
  UrdfJoint& jointOf(const Attributes& a, const char* attribute) {
    const XMLElement& e = a.element();
    const std::string name = file_.of(e).attribute(e, attribute);
    std::vector<std::string> known;
    for (UrdfJoint& joint : document_.joints) {
      known.push_back(joint.name);
      if (joint.name != name) continue;
      if (!hasOnePosition(joint))
        a.fail(attribute, "a hinge or slide joint that is not locked would be accepted");
      return joint;
    }
    file_.failUnknown(e, "joint", name, known);
  }

  static bool hasOnePosition(const UrdfJoint& joint) {
    return joint.type == JointType::kRevolute || joint.type == JointType::kContinuous ||
           joint.type == JointType::kPrismatic;
  }

  const std::vector<double>& restOf(int joint) const { return document_.joints[at(joint)].rest; }
  static double restOf(const UrdfJoint& joint) {
    return joint.rest.empty() ? 0 : joint.rest.front();
  }

  /// q1 - rest1 = c0 + c1 (q2 - rest2) + ...: a mimic joint where that is a line.
  void readEquality(const XMLElement& e) {
    const Attributes a = classes_.of(e, "", "equality");
    if (!a.flag("active", true)) return;
    if (std::string_view(e.Name()) != "joint")
      return warn(e,
                  "<" + std::string(e.Name()) +
                      "> in <equality> is left out: the joints that it couples move on their own");
    file_.of(e).allowAttributes(
        e, {"name", "class", "active", "joint1", "joint2", "polycoef", "solref", "solimp"});
    UrdfJoint& joint = jointOf(a, "joint1");
    const auto leaveOut = [&](const char* why) {
      warn(e, "the equality of joint " + inQuotes(joint.name) + " is left out: " + why);
    };
    constexpr const char* kCoupled = "another equality couples the joint already";
    const std::vector<double> c = a.over("polycoef", {0, 1, 0, 0, 0});
    if (e.Attribute("joint2") == nullptr) {
      if (joint.has_mimic || isFollowed(joint)) return leaveOut(kCoupled);
      return lockAt(joint, restOf(joint) + c[0]);
    }
    const UrdfJoint& master = jointOf(a, "joint2");
    if (c[2] != 0 || c[3] != 0 || c[4] != 0)
      return leaveOut("its polycoef is not a line; the joint is independent");
    if (joint.has_mimic || follows(master, joint)) return leaveOut(kCoupled);
    joint.has_mimic = true;
    joint.mimic = master.name;
    joint.multiplier = c[1];
    joint.offset = restOf(joint) + c[0] - c[1] * restOf(master);
  }

  bool isFollowed(const UrdfJoint& joint) const {
    return std::any_of(document_.joints.begin(), document_.joints.end(),
                       [&](const UrdfJoint& j) { return j.has_mimic && j.mimic == joint.name; });
  }

  /// Whether `joint` is `master`, or follows it, perhaps by way of others.
  bool follows(const UrdfJoint& joint, const UrdfJoint& master) const {
    const UrdfJoint* next = &joint;
    while (next->name != master.name && next->has_mimic)
      next = &*std::find_if(document_.joints.begin(), document_.joints.end(),
                            [&](const UrdfJoint& j) { return j.name == next->mimic; });
    return next->name == master.name;
  }

  // Keyframes.

  void readKey(const XMLElement& e) {
    checkAttributes(file_, e);
    const char* name = e.Attribute("name");
    if (name == nullptr || *name == '\0') {
      ++left_out_["key without a name"];
      return;
    }
    std::vector<double> qpos;
    if (e.Attribute("qpos") != nullptr) qpos = file_.of(e).numbers(e, "qpos");
    std::size_t count = 0;
    for (const int joint : tree_.positions) count += restOf(joint).size();
    if (!qpos.empty() && qpos.size() != count)
      return warn(e, "key " + inQuotes(name) + " is left out: qpos has " +
                         std::to_string(qpos.size()) + " numbers; " + std::to_string(count) +
                         " would be accepted");
    addState(name, e, qpos);
  }

  void addRest() {
    const auto isNamed = [](const UrdfState& s) { return s.name == "qpos0"; };
    if (std::none_of(document_.states.begin(), document_.states.end(), isNamed))
      addState("qpos0", file_.main().root(), {});
  }

  /// Adds the state of a key; an empty `qpos` means the rest position.
  void addState(const std::string& name, const XMLElement& e, const std::vector<double>& qpos) {
    for (const UrdfState& other : document_.states)
      if (other.name == name)
        return warn(e, "a second key " + inQuotes(name) + " is left out; names must be unique");
    UrdfState state;
    state.name = name;
    auto next = qpos.begin();
    for (const int joint : tree_.positions) {
      std::vector<double> values = restOf(joint);
      if (!qpos.empty()) {
        std::copy_n(next, values.size(), values.begin());
        next += static_cast<std::ptrdiff_t>(values.size());
        // Ours is x y z w.
        if (values.size() == 7) std::rotate(values.begin() + 3, values.begin() + 4, values.end());
      }
      if (values.size() == 7 && !(Eigen::Vector4d(values.data() + 3).norm() > 1e-12))
        return warn(
            e, "key " + inQuotes(name) + " is left out: the quaternion of a free joint is zero");
      state.values.emplace_back(joint, std::move(values));
    }
    document_.states.push_back(std::move(state));
  }

  void warnOfLeftOut() {
    if (file_.options().visual_as_collision)
      document_.warnings.push_back(document_.path +
                                   ": visual_as_collision has no effect: visual geoms of MJCF "
                                   "files are not taken for what collides");
    for (const auto& [what, count] : tree_.left_out) left_out_[what] += count;
    std::string text;
    for (const auto& [what, count] : left_out_)
      text += (text.empty() ? "" : ", ") + std::to_string(count) + ' ' + plural(what, count);
    if (!text.empty())
      document_.warnings.push_back(document_.path + ": planning does not use " + text);
    if (const auto count = static_cast<int>(document_.links.front().collisions.size()); count > 0)
      document_.warnings.push_back(document_.path + ": " + std::to_string(count) + ' ' +
                                   plural("geom", count) + " of <worldbody> " +
                                   (count == 1 ? "counts" : "count") +
                                   " as a part of the robot, its link "
                                   "'world': clearance from the world, "
                                   "which --keep and objectives ask for, does not include them");
  }

  static std::string plural(const std::string& what, int count) {
    if (count == 1) return what;
    return what.starts_with("key") ? "keys" + what.substr(3) : what + "s";
  }

  ErrorsSince wrong_;
  MjcfFile file_;
  MjcfSettings settings_;
  DefaultClasses classes_;
  UrdfDocument document_;
  MjcfBodies tree_;
  std::map<std::string, int> left_out_;
};

}  // namespace

bool isMjcf(const XmlFile& file) { return std::string_view(file.root().Name()) == "mujoco"; }

UrdfDocument readMjcf(XmlFile& file, const LoadOptions& options, bool with_visuals) {
  return MjcfReader(file, options, with_visuals).read();
}

}  // namespace leeway::robots
