// SDF as sdformat.org defines it. A joint's frame is fixed in its child: by default it is the
// child's. The links of a static model stand still in the world.

#include "robots/sdf/sdf.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/robots/text.h"
#include "robots/base/read_on.h"
#include "robots/base/tolerances.h"
#include "robots/sdf/sdf_models.h"
#include "robots/sdf/sdf_shapes.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

constexpr int kWorld = -1;  // in place of a frame

class SdfReader {
 public:
  SdfReader(XmlFile& file, const LoadOptions& options, bool with_visuals)
      : wrong_(options.errors), files_(file, options), models_(readModels(files_)) {
    document_.path = file.path();
    document_.name = models_.name;
    document_.with_visuals = with_visuals;
  }

  UrdfDocument read() {
    if (models_.links.empty())
      main().fail(main().root(), "the model has no <link>; at least one is needed");
    wrong_.throwFirst();
    for (const int link : models_.links) addLink(link);
    files_.leaveOutShapesBeyondLinks();
    for (const int joint : models_.joints) each([&] { readJoint(joint); });
    wrong_.throwFirst();
    for (const int joint : models_.joints) each([&] { readMimic(joint); });
    joinToWorld();
    wrong_.throwFirst();
    checkStructure(document_);
    checkPlanes();
    wrong_.throwFirst();
    warn();
    for (std::string& warning : files_.takeWarnings())
      document_.warnings.push_back(std::move(warning));
    return std::move(document_);
  }

 private:
  XmlFile& main() const { return *files_.main().file; }
  const SdfFrame& frame(int index) const { return models_.frames[index]; }
  template <typename Part>
  void each(const Part& part) const {
    readOn(files_.options().errors, part);
  }

  // Links.

  void addLink(int index) {
    const SdfFrame& f = frame(index);
    const XMLElement& e = *f.element;
    UrdfLink link;
    link.name = f.name;
    link.file = f.file->path();
    link.line = e.GetLineNum();
    links_[index] = static_cast<int>(document_.links.size());
    link_names_.insert(link.name);
    const auto add = [&](const XMLElement& shape) {
      if (auto read = readShape(shape, models_.frames, index))
        link.collisions.push_back(std::move(*read));
    };
    XmlFile& file = f.scope.file();
    link.has_visual = e.FirstChildElement("visual") != nullptr;
    if (e.FirstChildElement("collision") == nullptr && files_.options().visual_as_collision) {
      file.eachChild(e, "visual", add);
      link.visual_stands_in = !link.collisions.empty();
    } else {
      file.eachChild(e, "collision", add);
    }
    if (document_.with_visuals) readVisuals(index, link);
    document_.links.push_back(std::move(link));
  }

  void readVisuals(int index, UrdfLink& link) {
    for (const XMLElement* e = frame(index).element->FirstChildElement("visual"); e != nullptr;
         e = e->NextSiblingElement("visual")) {
      try {
        if (auto read = readShape(*e, models_.frames, index))
          link.visuals.push_back(std::move(*read));
      } catch (const InputError& error) {
        document_.unread_visuals.emplace_back(error.what());
      }
    }
  }

  /// The document's link of a frame's link, or the world's, which is made for it.
  int linkOf(int link) {
    if (link != kWorld) return links_.at(link);
    const auto [entry, is_new] = links_.emplace(kWorld, static_cast<int>(document_.links.size()));
    if (is_new) {
      UrdfLink world;
      world.name = "world";
      world.file = main().path();
      world.line = main().root().GetLineNum();
      document_.links.push_back(std::move(world));
    }
    return entry->second;
  }

  // Joints.

  UrdfJoint newJoint(const std::string& name, const SdfFrame& at, int parent, int child,
                     const Pose& X_PJ) const {
    UrdfJoint joint;
    joint.name = name;
    joint.file = at.file->path();
    joint.line = at.element->GetLineNum();
    joint.parent = parent;
    joint.child = child;
    joint.X_PJ = X_PJ;
    joint.xyz = X_PJ.translation;
    return joint;
  }

  static std::string jointName(const SdfFrame& f) {
    return f.scope.prefix + f.element->Attribute("name");
  }

  /// False for a joint that is left out.
  bool readType(const SdfFrame& f, UrdfJoint& joint) const {
    XmlFile& file = f.scope.file();
    static const std::map<std::string, JointType> kRead = {{"revolute", JointType::kRevolute},
                                                           {"continuous", JointType::kContinuous},
                                                           {"prismatic", JointType::kPrismatic},
                                                           {"fixed", JointType::kFixed}};
    const std::string type = file.attribute(*f.element, "type");
    if (type == "gearbox") {
      file.leaveOut(*f.element, "the gearbox " + inQuotes(joint.name) +
                                    " is left out: the joints that it couples move on their own");
      return false;
    }
    const auto found = kRead.find(type);
    if (found == kRead.end()) {
      std::vector<std::string> names;
      for (const auto& [name, read] : kRead) names.push_back(name);
      const bool turns = type == "ball" || type == "universal" || type == "revolute2";
      const std::string nearest = turns ? "" : suggestion(type, names);
      file.fail(
          *f.element,
          "the joint type " + inQuotes(type) + " is not read; " +
              (nearest.empty() ? "" : nearest + " ") +
              "revolute, continuous, prismatic and fixed would be accepted" +
              (turns ? ", revolute joints in series, with a link between, turn the same way" : ""));
    }
    joint.type = found->second;
    return true;
  }

  /// The link that a <parent> or <child> names; kWorld only for a parent.
  int linkNamed(const SdfFrame& joint, const char* role) const {
    XmlFile& file = joint.scope.file();
    const XMLElement& e = file.requiredChild(*joint.element, role);
    const std::string name = file.text(e);
    if (name == "world" && std::string_view(role) == "parent") return kWorld;
    return models_.frames.linkOf(models_.frames.find(joint.scope.whole(name), file, e));
  }

  void readJoint(int index) {
    const SdfFrame& f = frame(index);
    UrdfJoint made = newJoint(jointName(f), f, -1, -1, {});
    if (!joint_names_.insert(made.name).second)
      f.file->fail(*f.element, "a second joint " + inQuotes(made.name) + "; names must be unique");
    if (!readType(f, made)) return;
    const int parent = linkNamed(f, "parent"), child = linkNamed(f, "child");
    if (child == kWorld || frame(child).scope.is_static) {
      ++still_;
      return;
    }
    // The links of static models are joined to the world.
    made.parent = linkOf(parent);
    made.child = linkOf(child);
    const auto [first, is_only] = joint_above_.emplace(made.child, &f);
    if (!is_only)
      f.file->fail(*f.element, "link " + inQuotes(document_.links[at(made.child)].name) +
                                   " has two parents, through joint " +
                                   inQuotes(jointName(*first->second)) + " (" +
                                   lineOf(first->second->element->GetLineNum()) + ") and joint " +
                                   inQuotes(made.name) + "; one would be accepted");
    if (made.type != JointType::kFixed) readAxis(f, index, made);
    const Pose X_JC = models_.frames.relative(index, child);
    const bool turns = made.type == JointType::kRevolute || made.type == JointType::kContinuous;
    // About an axis through the link's origin the link turns in place.
    const bool is_beside = turns && X_JC.translation.cross(made.axis) != Eigen::Vector3d::Zero();
    if (is_beside) {
      const int between = static_cast<int>(document_.links.size());
      UrdfLink link;
      link.name = unique(frame(child).name + "/" + made.name, link_names_);
      link.file = made.file;
      link.line = made.line;
      document_.links.push_back(std::move(link));
      made.X_PJ = models_.frames.relative(parent, index);
      fixed_.push_back(newJoint(frame(child).name + "_fixed", f, between, made.child, X_JC));
      // Gazebo never collides links that a joint joins.
      document_.disabled_pairs.push_back({made.parent, made.child, "joined by " + made.name, true});
      made.child = between;
    } else {
      made.X_PJ = models_.frames.relative(parent, child);
      if (X_JC.rotation != Eigen::Matrix3d::Identity())
        made.axis = X_JC.rotation.transpose() * made.axis;
    }
    made.xyz = made.X_PJ.translation;
    document_.joints.push_back(std::move(made));
  }

  /// The axis in the joint's frame, and the limits.
  void readAxis(const SdfFrame& f, int index, UrdfJoint& joint) const {
    XmlFile& file = f.scope.file();
    joint.axis = Eigen::Vector3d::UnitZ();
    const XMLElement* axis = file.onlyChild(*f.element, "axis");
    if (axis == nullptr) {
      file.warn(*f.element, "joint " + inQuotes(joint.name) + " has no <axis>: it is z");
      setLimits(file, *f.element, nullptr, joint);
      return;
    }
    const int minor = f.scope.source->minor;
    expectOnly(file, *axis, {}, {"xyz", "limit", "mimic", "use_parent_model_frame"},
               {"dynamics", "initial_position"});
    leaveOutChildren(file, *f.element, "axis2", "the joint has one axis");
    if (numberIn(file, *axis, "initial_position", 0) != 0)
      leaveOutChildren(file, *axis, "initial_position", "joints begin where a state puts them");
    if (minor >= 7)
      leaveOutChildren(file, *axis, "use_parent_model_frame",
                       "from SDF 1.7 on, expressed_in=\"__model__\" of <xyz> has its place");
    const XMLElement* xyz = leafIn(file, *axis, "xyz", {"expressed_in"});
    if (xyz == nullptr) {
      file.warn(*axis, "joint " + inQuotes(joint.name) + " has no <xyz> in <axis>: it is z");
    } else {
      joint.axis = vectorOf(file, *xyz);
      const double norm = joint.axis.norm();
      if (!(norm > 1e-100))
        file.fail(*xyz, "the axis " + inQuotes(file.text(*xyz)) + " of joint " +
                            inQuotes(joint.name) +
                            " has no direction; a vector other than zero would be accepted");
    }
    // Up to SDF 1.4 axes are in the model's frame, in 1.5 and 1.6 there is a flag for it.
    const XMLElement& where = xyz == nullptr ? *axis : *xyz;
    const char* given = xyz == nullptr ? nullptr : xyz->Attribute("expressed_in");
    std::string in = given == nullptr ? "" : given;
    if (minor <= 6 && flagIn(file, *axis, "use_parent_model_frame", minor <= 4)) {
      if (!in.empty())
        file.fail(where, "expressed_in is " + inQuotes(in) +
                             ", and the axis is in the model's frame" +
                             (minor <= 4 ? ", as this version of SDF has it" : "") +
                             "; one of them would be accepted");
      in = "__model__";
    }
    if (!in.empty()) {
      const int other = models_.frames.find(f.scope.whole(in), file, where);
      joint.axis = models_.frames.relative(index, other).rotation * joint.axis;
    }
    setLimits(file, *axis, file.onlyChild(*axis, "limit"), joint);
  }

  /// A limit of a joint; `otherwise` where it is not given, and for 1e16 and more.
  static double limitIn(XmlFile& file, const XMLElement& limit, const char* name,
                        double otherwise) {
    const XMLElement* e = leafIn(file, limit, name);
    if (e == nullptr) return otherwise;
    const std::string text = file.text(*e);
    const std::optional<double> value = parseNumber(text);
    if (!value || std::isnan(*value))
      file.fail(
          *e, "<" + std::string(name) + "> is " + inQuotes(text) + "; a number would be accepted");
    return std::abs(*value) >= kGreatestLimit ? std::copysign(kInfinity, *value) : *value;
  }

  /// The same of a position, which has an end only on the side of `none`.
  static double positionIn(XmlFile& file, const XMLElement& limit, const char* name, double none) {
    const double value = limitIn(file, limit, name, none);
    if (std::isinf(value) && value != none)
      file.fail(limit, "<" + std::string(name) + "> is " + inQuotes(textIn(file, limit, name)) +
                           "; a number from -1e16 to 1e16 would be accepted");
    return value;
  }

  static void setLimits(XmlFile& file, const XMLElement& at, const XMLElement* limit,
                        UrdfJoint& joint) {
    joint.has_limit = true;
    const XMLElement& where = limit == nullptr ? at : *limit;
    joint.limit_line = where.GetLineNum();
    joint.lower = -kInfinity;
    joint.upper = kInfinity;
    joint.velocity = kInfinity;
    if (limit != nullptr) {
      expectOnly(file, *limit, {}, {"lower", "upper", "velocity"},
                 {"effort", "stiffness", "dissipation"});
      joint.lower = positionIn(file, *limit, "lower", -kInfinity);
      joint.upper = positionIn(file, *limit, "upper", kInfinity);
      const double velocity = limitIn(file, *limit, "velocity", kInfinity);
      if (velocity > 0)  // (Less than 0 is none.)
        joint.velocity = velocity;
      else if (velocity == 0)
        file.warn(*limit, "the velocity limit \"0\" of joint " + inQuotes(joint.name) +
                              " is taken for none: it may move at 1 rad/s or 1 m/s");
      if (joint.type == JointType::kContinuous &&
          (joint.lower != -kInfinity || joint.upper != kInfinity))
        file.leaveOut(*limit, "joint " + inQuotes(joint.name) +
                                  " is continuous: its <lower> and <upper> are left out");
    }
    if (joint.type == JointType::kContinuous ||
        (joint.type == JointType::kRevolute && joint.lower == -kInfinity &&
         joint.upper == kInfinity)) {
      joint.type = JointType::kContinuous;
      return;
    }
    if (joint.lower > joint.upper)
      file.fail(where, "the lower limit " + inQuotes(textIn(file, where, "lower")) + " of joint " +
                           inQuotes(joint.name) + " is above the upper limit " +
                           inQuotes(textIn(file, where, "upper")) +
                           "; lower at most upper would be accepted");
    if (joint.lower == joint.upper)
      file.warn(where, "joint " + inQuotes(joint.name) +
                           " cannot move: its lower and upper limits are equal");
  }

  void readMimic(int index) {
    const SdfFrame& f = frame(index);
    XmlFile& file = f.scope.file();
    const XMLElement* axis = f.element->FirstChildElement("axis");
    const XMLElement* mimic = axis == nullptr ? nullptr : file.onlyChild(*axis, "mimic");
    if (mimic == nullptr) return;
    const std::string name = jointName(f);
    const auto joint = std::find_if(document_.joints.begin(), document_.joints.end(),
                                    [&](const UrdfJoint& j) { return j.name == name; });
    if (joint == document_.joints.end() || joint->type == JointType::kFixed) {
      file.leaveOut(*mimic, "joint " + inQuotes(name) + " does not move: its <mimic> is left out");
      return;
    }
    expectOnly(file, *mimic, {"joint", "axis"}, {"multiplier", "offset", "reference"});
    const char* which = mimic->Attribute("axis");
    if (which != nullptr && std::string_view(which) != "axis")
      file.fail(*mimic, "axis of <mimic> is " + inQuotes(which) +
                            "; \"axis\" would be accepted, joints have one here");
    const int master =
        models_.frames.find(f.scope.whole(file.attribute(*mimic, "joint")), file, *mimic);
    if (frame(master).kind != SdfFrame::Kind::kJoint)
      file.fail(*mimic, "<mimic> names " + inQuotes(frame(master).name) +
                            ", which is no joint; the name of a joint would be accepted");
    const double multiplier = numberIn(file, *mimic, "multiplier", 1),
                 offset = numberIn(file, *mimic, "offset", 0) -
                          multiplier * numberIn(file, *mimic, "reference", 0);
    const auto isMaster = [&](const UrdfJoint& j) { return j.name == jointName(frame(master)); };
    if (std::none_of(document_.joints.begin(), document_.joints.end(), isMaster)) {
      const std::string left_out = "joint " + inQuotes(name) + " mimics " +
                                   inQuotes(jointName(frame(master))) + ", which is left out: it ";
      // Joints of static models stand at 0, a gearbox has no position.
      const bool is_still = std::string_view(frame(master).element->Attribute("type")) != "gearbox";
      if (is_still) lockAt(*joint, offset);
      return file.leaveOut(*mimic,
                           left_out + (is_still ? "stands still" : "is an independent joint"));
    }
    joint->has_mimic = true;
    joint->mimic = jointName(frame(master));
    joint->mimic_line = mimic->GetLineNum();
    joint->multiplier = multiplier;
    joint->offset = offset;
  }

  // The world.

  static std::string unique(std::string name, std::set<std::string>& taken) {
    while (!taken.insert(name).second) name += '_';
    return name;
  }

  /// Joins the links of static models to the world; and the only root, unless it stands at the
  /// world's origin and nothing else is joined to the world.
  void joinToWorld() {
    std::set<int> children;
    for (const auto& joints : {document_.joints, fixed_})
      for (const UrdfJoint& joint : joints) children.insert(joint.child);
    std::vector<int> roots;
    for (const int link : models_.links) {
      if (frame(link).scope.is_static)
        hang(link);
      else if (children.count(links_.at(link)) == 0)
        roots.push_back(link);
    }
    if (roots.size() == 1 && links_.count(kWorld) == 0) {
      const Pose X = models_.frames.relative(kWorld, roots.front());
      if (X.translation != Eigen::Vector3d::Zero() || X.rotation != Eigen::Matrix3d::Identity())
        hang(roots.front());
    }
    for (UrdfJoint& joint : fixed_) {
      joint.name = unique(joint.name, joint_names_);
      document_.joints.push_back(std::move(joint));
    }
  }

  void hang(int link) {
    const int world = linkOf(kWorld);
    fixed_.push_back(newJoint(frame(link).name + "_fixed", frame(link), world, links_.at(link),
                              models_.frames.relative(kWorld, link)));
  }

  // Checks and warnings of the whole model.

  void checkPlanes() const {
    std::vector<const UrdfJoint*> above(document_.links.size(), nullptr);
    for (const UrdfJoint& joint : document_.joints) above[at(joint.child)] = &joint;
    for (std::size_t l = 0; l < document_.links.size(); ++l) {
      const UrdfJoint* joint = above[l];
      while (joint != nullptr && joint->type == JointType::kFixed) joint = above[at(joint->parent)];
      if (joint == nullptr) continue;
      for (const UrdfCollision& shape : document_.links[l].collisions)
        if (shape.kind == UrdfCollision::Kind::kPlane)
          each([&] {
            throw InputError(shape.file, shape.line,
                             "a plane moves with link " + inQuotes(document_.links[l].name) +
                                 "; planes of links that stand still would be accepted");
          });
    }
  }

  void warn() {
    if (still_ > 0)
      main().warn(main().root(),
                  std::to_string(still_) + (still_ == 1 ? " joint moves" : " joints move") +
                      " links of a model with <static>: they are left out, the links stand still");
  }

  ErrorsSince wrong_;
  SdfFiles files_;
  SdfModels models_;
  UrdfDocument document_;
  std::map<int, int> links_;      // of the document, by frame or kWorld
  std::vector<UrdfJoint> fixed_;  // names are made unique in the end
  std::set<std::string> link_names_ = {"world"}, joint_names_;
  std::map<int, const SdfFrame*> joint_above_;  // by link of the document
  int still_ = 0;                               // joints that move links of static models
};

}  // namespace

bool isSdf(const XmlFile& file) {
  const std::string_view root = file.root().Name();
  return root == "sdf" || root == "gazebo";
}

UrdfDocument readSdf(XmlFile& file, const LoadOptions& options, bool with_visuals) {
  return SdfReader(file, options, with_visuals).read();
}

}  // namespace leeway::robots
