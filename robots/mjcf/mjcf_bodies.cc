// MuJoCo places a body by its pose in its parent, then by its joints in their order, each about or
// along an axis in the body's frame. A joint's link has its origin at the joint's anchor; the
// body's link follows it.

#include "robots/mjcf/mjcf_bodies.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "collision/base/numbers.h"
#include "robots/base/read_on.h"
#include "robots/urdf/rotation.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

const std::vector<std::string> kJointTypes = {"free", "ball", "slide", "hinge"};

Pose translationBy(const Eigen::Vector3d& by) {
  Pose pose;
  pose.translation = by;
  return pose;
}

bool isIdentity(const Pose& pose) {
  return pose.translation == Eigen::Vector3d::Zero() &&
         pose.rotation == Eigen::Matrix3d::Identity();
}

class BodyReader {
 public:
  BodyReader(const MjcfFile& file, const MjcfSettings& settings, const DefaultClasses& classes,
             UrdfDocument& document)
      : file_(file),
        settings_(settings),
        classes_(classes),
        geoms_(file, settings, classes),
        errors_(file.options().errors),
        document_(document) {}

  MjcfBodies read() {
    addBody("world", file_.main().root(), -1);
    addLink("world", file_.main().root(), 0);
    tree_.bodies[0].link = 0;
    file_.eachSection("worldbody", [&](const XMLElement& e) {
      checkAttributes(file_, e);
      classes_.expectClass(e, "childclass");
      const char* own = e.Attribute("childclass");
      const Frame frame{0, own == nullptr ? "" : own, {}};
      readContents(e, frame);
      readChildren(e, frame);
    });
    nameTheRest();
    return std::move(tree_);
  }

 private:
  /// Where an element stands: a body, or a <frame> in it.
  struct Frame {
    int body;
    std::string childclass;
    Pose X_BF;
  };

  int addBody(const std::string& name, const XMLElement& at, int parent) {
    const int index = static_cast<int>(tree_.bodies.size());
    MjcfBody body;
    body.name = name;
    body.parent = parent;
    if (!name.empty()) {
      if (!tree_.by_name.emplace(name, index).second)
        file_.fail(at, "a second body " + inQuotes(name) + "; names must be unique" +
                           (name == "world" ? ", and this is the <worldbody>'s" : ""));
    }
    tree_.bodies.push_back(std::move(body));
    return index;
  }

  int addLink(const std::string& name, const XMLElement& at, int body) {
    UrdfLink link;
    link.name = name;
    link.file = file_.of(at).path();
    link.line = at.GetLineNum();
    document_.links.push_back(std::move(link));
    link_bodies_.push_back(body);
    return static_cast<int>(document_.links.size()) - 1;
  }

  UrdfJoint& addJoint(const XMLElement& at, int parent, int child, const Pose& X_PJ) {
    UrdfJoint joint;
    joint.file = file_.of(at).path();
    joint.line = at.GetLineNum();
    joint.parent = parent;
    joint.child = child;
    joint.X_PJ = X_PJ;
    joint.xyz = X_PJ.translation;
    document_.joints.push_back(std::move(joint));
    return document_.joints.back();
  }

  Frame inner(const XMLElement& e, const Frame& frame) const {
    classes_.expectClass(e, "childclass");
    const char* own = e.Attribute("childclass");
    return {frame.body, own == nullptr ? frame.childclass : own,
            frame.X_BF * poseOf(Attributes(file_, {&e}), settings_)};
  }

  static constexpr std::array<std::string_view, 7> kLeaves = {
      "geom", "joint", "freejoint", "inertial", "site", "camera", "light"};

  /// The geoms of a body, in its frames, too.
  void readContents(const XMLElement& parent, const Frame& frame) {
    file_.eachChild(parent, [&](const XMLElement& e) {
      const std::string tag = e.Name();
      MjcfBody& body = tree_.bodies[at(frame.body)];
      if (std::find(kLeaves.begin(), kLeaves.end(), tag) != kLeaves.end()) expectNothingIn(e);
      if (tag == "frame") {
        checkAttributes(file_, e);
        return readContents(e, inner(e, frame));
      }
      if (tag == "geom") {
        GeomReader::Geom geom = geoms_.read(e, frame.childclass, frame.X_BF, body.weld == 0);
        if (!geom.name.empty() && !geom_names_.insert(geom.name).second)
          file_.fail(e, "a second geom " + inQuotes(geom.name) + "; names must be unique");
        if (!geom.name.empty()) body.geoms.insert(geom.name);
        if (document_.with_visuals) readVisual(e, frame);
        if (!geom.shape) {
          if (geom.masks.isNone()) ++tree_.left_out["visual geom"];
          return;
        }
        body.masks.insert(geom.masks);
        document_.links[at(body.link)].collisions.push_back(std::move(*geom.shape));
      } else if (tag == "site" || tag == "camera" || tag == "light") {
        ++tree_.left_out[tag];
      } else if (tag == "joint" || tag == "freejoint") {
        if (frame.body == 0)
          file_.fail(e, "<" + tag + "> in <worldbody>; one in a <body> would be accepted");
      } else if (tag == "plugin") {
        file_.expectNoBodyIn(e);
      } else if (tag != "body" && tag != "inertial") {
        failUnread(e);
      }
    });
  }

  void readVisual(const XMLElement& e, const Frame& frame) {
    UrdfLink& link = document_.links[at(tree_.bodies[at(frame.body)].link)];
    try {
      if (auto shape = geoms_.readVisual(e, frame.childclass, frame.X_BF))
        link.visuals.push_back(std::move(*shape));
    } catch (const InputError& error) {
      document_.unread_visuals.emplace_back(error.what());
    }
  }

  void expectNothingIn(const XMLElement& e) const {
    file_.eachChild(e, [&](const XMLElement& child) {
      if (std::string_view(child.Name()) != "plugin")
        file_.fail(child, "<" + std::string(child.Name()) + "> in <" + e.Name() +
                              ">, which holds no elements; one in a <body> would be accepted");
      file_.expectNoBodyIn(child);
    });
  }

  [[noreturn]] void failUnread(const XMLElement& e) const {
    const std::string tag = e.Name();
    if (tag == "composite" || tag == "flexcomp" || tag == "replicate" || tag == "attach")
      file_.fail(e, "<" + tag +
                        "> makes bodies, and is not read; the bodies themselves would be "
                        "accepted, as MuJoCo saves them (mj_saveLastXML)");
    const std::vector<std::string> known = {"body", "frame",  "joint", "freejoint", "geom",
                                            "site", "camera", "light", "inertial"};
    const std::string nearest = suggestion(tag, known);
    file_.fail(e, "<" + tag + "> in a body is not known; " +
                      (nearest.empty() ? "body, frame, joint, freejoint, geom, site, camera, light "
                                         "and inertial would be accepted"
                                       : nearest));
  }

  void readChildren(const XMLElement& parent, const Frame& frame) {
    file_.eachChild(parent, [&](const XMLElement& e) {
      const std::string_view tag = e.Name();
      if (tag == "frame") readChildren(e, inner(e, frame));
      if (tag == "body") readBody(e, frame);
    });
  }

  /// The joints of a body in their order, those in its frames, too.
  void collectJoints(const XMLElement& parent, const Frame& frame,
                     std::vector<std::pair<const XMLElement*, Frame>>& joints) {
    file_.eachChild(parent, [&](const XMLElement& e) {
      const std::string_view tag = e.Name();
      if (tag == "frame") collectJoints(e, inner(e, frame), joints);
      if (tag == "joint" || tag == "freejoint") joints.emplace_back(&e, frame);
    });
  }

  void readBody(const XMLElement& e, const Frame& frame) {
    checkAttributes(file_, e);
    const Frame own = inner(e, frame);
    const char* name = e.Attribute("name");
    const int parent = frame.body, index = addBody(name == nullptr ? "" : name, e, parent);
    if (Attributes(file_, {&e}).flag("mocap", false))
      document_.warnings.push_back(
          file_.locate(e, "body " + inQuotes(name == nullptr ? "" : name) +
                              " is a mocap body: it stands still where the file has it"));
    std::vector<std::pair<const XMLElement*, Frame>> joints;
    collectJoints(e, {index, own.childclass, {}}, joints);
    MjcfBody& body = tree_.bodies.back();
    body.weld = joints.empty() ? tree_.bodies[at(parent)].weld : index;
    placeBody(e, joints, own.X_BF, index);
    const Frame inside{index, own.childclass, {}};
    readContents(e, inside);
    readChildren(e, inside);
  }

  /// The links and joints from a body's parent to the body.
  void placeBody(const XMLElement& e,
                 const std::vector<std::pair<const XMLElement*, Frame>>& joints, const Pose& X_PB,
                 int index) {
    int link = tree_.bodies[at(tree_.bodies[at(index)].parent)].link;
    Pose X_LB = X_PB;  // from the last link, before the next joint
    bool is_body = false;
    for (std::size_t i = 0; i < joints.size(); ++i) {
      Moved moved = {};
      // A joint that is wrong still gets a link, so that the links below have a parent.
      readOn(errors_,
             [&] { moved = readJoint(*joints[i].first, joints[i].second, joints.size()); });
      is_body = i + 1 == joints.size() && isIdentity(moved.X_JB);
      const int next = addLink("", *joints[i].first, index);
      const int joint = static_cast<int>(document_.joints.size());
      UrdfJoint& made = addJoint(*joints[i].first, link, next, X_LB * moved.X_BJ);
      made.type = moved.type;
      made.axis = moved.axis;
      made.has_limit = moved.has_limit;
      made.limit_line = joints[i].first->GetLineNum();
      made.lower = moved.lower;
      made.upper = moved.upper;
      made.velocity = kInfinity;
      if (moved.type == JointType::kFloating) made.X_PJ = Pose();
      nameJoint(*joints[i].first, index, joints.size(), i, joint);
      if (!is_body) part_links_.emplace_back(next, joint);
      document_.joints[at(joint)].rest = {moved.rest};
      if (moved.type == JointType::kFloating) document_.joints[at(joint)].rest = variablesOf(X_PB);
      tree_.positions.push_back(joint);
      link = next;
      X_LB = moved.X_JB;
    }
    if (!is_body) {
      const int next = addLink("", e, index);
      fixed_joints_.push_back(static_cast<int>(document_.joints.size()));
      addJoint(e, link, next, X_LB);
      link = next;
    }
    tree_.bodies[at(index)].link = link;
  }

  static std::vector<double> variablesOf(const Pose& X) {
    const Eigen::Quaterniond q(X.rotation);
    const Eigen::Vector3d& p = X.translation;
    return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
  }

  struct Moved {
    JointType type = JointType::kFixed;
    Pose X_BJ, X_JB;  ///< from the body's frame to the joint's, and back after it has moved
    Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
    bool has_limit = false;
    double lower = -kInfinity, upper = kInfinity;
    double rest = 0;
  };

  Moved readJoint(const XMLElement& e, const Frame& frame, std::size_t count) {
    checkAttributes(file_, e);
    const bool is_free_joint = std::string_view(e.Name()) == "freejoint";
    const Attributes a = is_free_joint ? Attributes(file_, {&e}) : classes_.of(e, frame.childclass);
    const std::size_t type = is_free_joint ? 0 : a.word("type", kJointTypes, "hinge");
    Moved moved;
    if (type == 0) {
      moved.type = JointType::kFloating;
      if (count > 1)
        file_.fail(e, "a free joint beside others of its body; it alone would be accepted");
      if (tree_.bodies[at(frame.body)].parent != 0)
        file_.fail(e,
                   "a free joint of a body in another one; one of a body in <worldbody> would be "
                   "accepted");
      return moved;
    }
    if (type == 1)
      a.fail("type",
             "hinge, slide and free would be accepted, a ball joint is not read; three "
             "hinges turn the same way");
    const bool is_hinge = type == 3;
    const Eigen::Vector3d axis = a.vector("axis", Eigen::Vector3d::UnitZ());
    if (!(axis.norm() > 1e-12)) a.fail("axis", "an axis other than zero would be accepted");
    const Eigen::Vector3d pos = a.vector("pos", Eigen::Vector3d::Zero());
    moved.axis = frame.X_BF.rotation * axis.normalized();
    readLimits(a, is_hinge, moved);
    const double ref = a.number("ref", 0);
    moved.rest = is_hinge ? settings_.angle(ref) : ref;
    if (is_hinge) {
      // About an anchor on the axis through the origin, the body turns about its origin.
      const Eigen::Vector3d anchor = frame.X_BF * pos;
      const bool is_beside = anchor.cross(moved.axis) != Eigen::Vector3d::Zero();
      if (is_beside) {
        moved.X_BJ = translationBy(anchor);
        moved.X_JB = translationBy(-anchor);
      }
      if (moved.rest != 0) moved.X_BJ.rotation = rotationAbout(moved.axis, -moved.rest);
    } else if (moved.rest != 0) {
      moved.X_BJ = translationBy(-moved.rest * moved.axis);
    }
    return moved;
  }

  void readLimits(const Attributes& a, bool is_hinge, Moved& moved) const {
    const auto range = a.numbers("range", 2);
    const std::size_t limited = a.word("limited", {"false", "true", "auto"}, "auto");
    if (range && limited == 2 && !settings_.auto_limits && *range != std::vector<double>{0, 0})
      a.fail("range", "limited=\"true\" or \"false\" is needed with autolimits=\"false\"");
    // MuJoCo takes the joint for unlimited then, which is not what the file says.
    if (limited != 0 && range && (*range)[0] > (*range)[1])
      a.fail("range", "two numbers, the lower first, would be accepted");
    if (limited == 1 && !(range && (*range)[0] < (*range)[1]))
      a.fail("range", "two numbers, the lower first, would be accepted with limited=\"true\"");
    moved.has_limit = limited == 1 || (limited == 2 && range && (*range)[0] < (*range)[1]);
    moved.type = !is_hinge         ? JointType::kPrismatic
                 : moved.has_limit ? JointType::kRevolute
                                   : JointType::kContinuous;
    if (!moved.has_limit) return;
    moved.lower = is_hinge ? settings_.angle((*range)[0]) : (*range)[0];
    moved.upper = is_hinge ? settings_.angle((*range)[1]) : (*range)[1];
  }

  void nameJoint(const XMLElement& e, int body, std::size_t count, std::size_t i, int joint) {
    const char* name = e.Attribute("name");
    if (name == nullptr || *name == '\0') {
      unnamed_joints_.push_back({joint, body, count == 1 ? "" : "_" + std::to_string(i + 1)});
      return;
    }
    if (!joint_names_.insert(name).second)
      throwOrKeep(InputError(file_.of(e).path(), e.GetLineNum(),
                             "a second joint " + inQuotes(name) + "; names must be unique"),
                  errors_);
    document_.joints[at(joint)].name = name;
  }

  static std::string unique(std::string name, std::set<std::string>& taken) {
    while (!taken.insert(name).second) name += '_';
    return name;
  }

  /// Names the bodies, joints and links without a name. All names of the file must be known.
  void nameTheRest() {
    std::set<std::string> links;
    for (const MjcfBody& body : tree_.bodies)
      if (!body.name.empty()) links.insert(body.name);
    for (std::size_t b = 0; b < tree_.bodies.size(); ++b) {
      MjcfBody& body = tree_.bodies[b];
      if (body.name.empty()) body.name = unique("body_" + std::to_string(b), links);
      document_.links[at(body.link)].name = body.name;
    }
    const auto bodyOf = [&](int link) { return tree_.bodies[at(link_bodies_[at(link)])].name; };
    for (const auto& [joint, body, suffix] : unnamed_joints_)
      document_.joints[at(joint)].name = unique(tree_.bodies[at(body)].name + suffix, joint_names_);
    for (const auto& [link, joint] : part_links_)
      document_.links[at(link)].name =
          unique(bodyOf(link) + "/" + document_.joints[at(joint)].name, links);
    for (const int joint : fixed_joints_)
      document_.joints[at(joint)].name =
          unique(bodyOf(document_.joints[at(joint)].child) + "_fixed", joint_names_);
  }

  struct Unnamed {
    int joint, body;
    std::string suffix;
  };

  const MjcfFile& file_;
  const MjcfSettings& settings_;
  const DefaultClasses& classes_;
  GeomReader geoms_;
  InputErrors* errors_;
  UrdfDocument& document_;
  MjcfBodies tree_;
  std::vector<int> link_bodies_;                 // of each link
  std::vector<int> fixed_joints_;                // of bodies whose link is not that of a joint
  std::vector<std::pair<int, int>> part_links_;  // links that are no body's, each with its joint
  std::vector<Unnamed> unnamed_joints_;
  std::set<std::string> joint_names_, geom_names_;
};

}  // namespace

MjcfBodies readBodies(const MjcfFile& file, const MjcfSettings& settings,
                      const DefaultClasses& classes, UrdfDocument& document) {
  return BodyReader(file, settings, classes, document).read();
}

}  // namespace leeway::robots
