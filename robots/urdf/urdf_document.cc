// urdfdom keeps no line numbers and lets much pass in silence: a link's collisions vanish with one
// unknown geometry, two parents, cycles apart from the tree, zero axes, swapped limits and unknown
// mimic masters are accepted. So this pass looks first, and says where.

#include "robots/urdf/urdf_document.h"

#include <algorithm>
#include <array>
#include <map>
#include <string_view>

#include "collision/base/sine_cosine.h"
#include "leeway/robots/kinematics.h"
#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

std::string inQuotes(const std::string& text) { return '"' + text + '"'; }

std::string lineOf(int line) { return "line " + std::to_string(line); }

template <typename Visit>
void eachChild(const XMLElement& parent, const char* name, const Visit& visit) {
  for (const XMLElement* child = parent.FirstChildElement(name); child != nullptr;
       child = child->NextSiblingElement(name))
    visit(*child);
}

class Reader {
 public:
  explicit Reader(const std::string& path) : file_(path, "URDF") { document_.path = path; }

  UrdfDocument read() {
    document_.name = file_.attribute(file_.root(), "name");
    warnUnread(file_.root(), {"link", "joint", "material", "gazebo", "transmission", "sensor",
                              "ros2_control", "plugin"});
    eachChild(file_.root(), "link", [&](const XMLElement& link) { readLink(link); });
    if (document_.links.empty())
      file_.fail(file_.root(), "the robot has no <link>; at least one is needed");
    eachChild(file_.root(), "joint", [&](const XMLElement& joint) { readJoint(joint); });
    checkParents();
    checkTree();
    checkMimics();
    document_.essence = essence();
    return std::move(document_);
  }

 private:
  void warnUnread(const XMLElement& parent, std::initializer_list<std::string_view> known) {
    for (const XMLElement* child = parent.FirstChildElement(); child != nullptr;
         child = child->NextSiblingElement())
      if (std::find(known.begin(), known.end(), child->Name()) == known.end())
        document_.warnings.push_back(file_.locate(*child, "<" + std::string(child->Name()) +
                                                              "> in <" + parent.Name() +
                                                              "> is not known and is left out"));
  }

  std::string uniqueName(const XMLElement& element, std::map<std::string, int>& lines) {
    std::string name = file_.attribute(element, "name");
    const auto [entry, fresh] = lines.emplace(name, element.GetLineNum());
    if (!fresh)
      file_.fail(element, "a second " + std::string(element.Name()) + ' ' + inQuotes(name) +
                              ", the first is in " + lineOf(entry->second) +
                              "; names must be unique");
    return name;
  }

  Pose readOrigin(const XMLElement& parent, Eigen::Vector3d* xyz = nullptr) {
    Pose pose;
    if (const XMLElement* origin = file_.onlyChild(parent, "origin")) {
      file_.allowAttributes(*origin, {"xyz", "rpy"});
      if (const auto position = file_.vector(*origin, "xyz")) pose.translation = *position;
      if (const auto angles = file_.vector(*origin, "rpy")) pose.rotation = rollPitchYaw(*angles);
    }
    if (xyz != nullptr) *xyz = pose.translation;
    return pose;
  }

  void readLink(const XMLElement& element) {
    UrdfLink link;
    link.name = uniqueName(element, link_lines_);
    link.line = element.GetLineNum();
    link_index_[link.name] = static_cast<int>(document_.links.size());
    link_names_.push_back(link.name);
    warnUnread(element,
               {"visual", "collision", "inertial", "contact", "sensor", "material", "gravity"});
    eachChild(element, "collision", [&](const XMLElement& collision) {
      link.collisions.push_back(readCollision(collision));
    });
    if (link.collisions.empty() && element.FirstChildElement("visual") != nullptr)
      document_.warnings.push_back(
          file_.locate(element, "link " + inQuotes(link.name) +
                                    " has a <visual> and no <collision>: it will touch nothing"));
    document_.links.push_back(std::move(link));
  }

  UrdfCollision readCollision(const XMLElement& element) {
    warnUnread(element, {"origin", "geometry", "material", "verbose", "contact_coefficients"});
    UrdfCollision collision;
    if (const char* name = element.Attribute("name")) collision.name = name;
    collision.X_LG = readOrigin(element);
    const XMLElement& geometry = file_.requiredChild(element, "geometry");
    const XMLElement* shape = geometry.FirstChildElement();
    const std::string accepted = "<box>, <sphere>, <cylinder> or <mesh> would be accepted";
    if (shape == nullptr) file_.fail(geometry, "<geometry> is empty; " + accepted);
    if (const XMLElement* second = shape->NextSiblingElement())
      file_.fail(
          *second,
          "a second shape <" + std::string(second->Name()) +
              "> in one <geometry>; one would be accepted, more go into collisions of their own");
    collision.line = shape->GetLineNum();
    const std::string kind = shape->Name();
    if (kind == "box") {
      collision.kind = UrdfCollision::Kind::kBox;
      file_.allowAttributes(*shape, {"size"});
      file_.attribute(*shape, "size");
      collision.size = *file_.vector(*shape, "size");
      if ((collision.size.array() < 0).any())
        file_.fail(*shape, "size of <box> is " + inQuotes(shape->Attribute("size")) +
                               "; edges of zero or more would be accepted");
    } else if (kind == "sphere") {
      collision.kind = UrdfCollision::Kind::kSphere;
      file_.allowAttributes(*shape, {"radius"});
      collision.radius = readSize(*shape, "radius");
    } else if (kind == "cylinder") {
      collision.kind = UrdfCollision::Kind::kCylinder;
      file_.allowAttributes(*shape, {"radius", "length"});
      collision.radius = readSize(*shape, "radius");
      collision.length = readSize(*shape, "length");
    } else if (kind == "mesh") {
      collision.kind = UrdfCollision::Kind::kMesh;
      file_.allowAttributes(*shape, {"filename", "scale"});
      collision.mesh_file = file_.attribute(*shape, "filename");
      if (const auto scale = file_.vector(*shape, "scale")) collision.mesh_scale = *scale;
      if ((collision.mesh_scale.array() == 0).any())
        file_.fail(*shape, "scale of <mesh> is " + inQuotes(shape->Attribute("scale")) +
                               "; three numbers other than zero would be accepted");
    } else {
      file_.fail(*shape, "the geometry <" + kind + "> is not known; " + accepted);
    }
    return collision;
  }

  double readSize(const XMLElement& shape, const char* name) {
    const double size = file_.requiredNumber(shape, name);
    if (size < 0)
      file_.fail(shape, std::string(name) + " of <" + shape.Name() + "> is " +
                            inQuotes(shape.Attribute(name)) + "; zero or more would be accepted");
    return size;
  }

  JointType readType(const XMLElement& element) {
    static const std::vector<std::string> kNames = {"fixed",     "revolute", "continuous",
                                                    "prismatic", "planar",   "floating"};
    static constexpr std::array kTypes = {JointType::kFixed,      JointType::kRevolute,
                                          JointType::kContinuous, JointType::kPrismatic,
                                          JointType::kPlanar,     JointType::kFloating};
    const std::string type = file_.attribute(element, "type");
    const auto found = std::find(kNames.begin(), kNames.end(), type);
    if (found == kNames.end()) {
      const std::string nearest = suggestion(type, kNames);
      file_.fail(
          element,
          "the joint type " + inQuotes(type) + " is not known; " +
              (nearest.empty() ? "" : nearest + " ") +
              "fixed, revolute, continuous, prismatic, planar and floating would be accepted");
    }
    return kTypes[static_cast<std::size_t>(found - kNames.begin())];
  }

  int readLinkReference(const XMLElement& joint, const char* role) {
    const XMLElement& element = file_.requiredChild(joint, role);
    file_.allowAttributes(element, {"link"});
    const std::string name = file_.attribute(element, "link");
    const auto found = link_index_.find(name);
    if (found == link_index_.end()) {
      const std::string nearest = suggestion(name, link_names_);
      file_.fail(element,
                 "the " + std::string(role) + " link " + inQuotes(name) + " is not defined; " +
                     (nearest.empty() ? "the name of a <link> would be accepted" : nearest));
    }
    return found->second;
  }

  void readJoint(const XMLElement& element) {
    UrdfJoint joint;
    joint.name = uniqueName(element, joint_lines_);
    joint.line = element.GetLineNum();
    joint.type = readType(element);
    warnUnread(element, {"origin", "parent", "child", "axis", "limit", "mimic", "dynamics",
                         "calibration", "safety_controller", "sensor", "gazebo"});
    joint.parent = readLinkReference(element, "parent");
    joint.child = readLinkReference(element, "child");
    joint.X_PJ = readOrigin(element, &joint.xyz);
    readAxis(element, joint);
    readLimit(element, joint);
    readMimic(element, joint);
    joint_names_.push_back(joint.name);
    document_.joints.push_back(std::move(joint));
  }

  void readAxis(const XMLElement& element, UrdfJoint& joint) {
    if (joint.type == JointType::kFixed || joint.type == JointType::kFloating) return;
    const XMLElement* axis = file_.onlyChild(element, "axis");
    if (axis == nullptr) {
      if (joint.type == JointType::kPlanar)
        document_.warnings.push_back(file_.locate(
            element,
            "planar joint " + inQuotes(joint.name) + " has no <axis>: its plane is normal to x"));
      return;
    }
    file_.allowAttributes(*axis, {"xyz"});
    file_.attribute(*axis, "xyz");
    joint.axis = *file_.vector(*axis, "xyz");
    // A norm outside of these bounds would lose digits when squared.
    const double norm = joint.axis.norm();
    if (!(norm > 1e-100 && norm < 1e100))
      file_.fail(*axis, "the axis " + inQuotes(axis->Attribute("xyz")) + " of joint " +
                            inQuotes(joint.name) +
                            " has no direction; a vector other than zero would be accepted");
  }

  void readLimit(const XMLElement& element, UrdfJoint& joint) {
    const bool bounded = joint.type == JointType::kRevolute || joint.type == JointType::kPrismatic;
    const XMLElement* limit = file_.onlyChild(element, "limit");
    if (limit == nullptr) {
      if (bounded)
        file_.fail(element,
                   "joint " + inQuotes(joint.name) + " has no <limit>; a " +
                       element.Attribute("type") +
                       " joint needs <limit lower=\"...\" upper=\"...\" effort=\"...\" "
                       "velocity=\"...\"/>" +
                       (joint.type == JointType::kRevolute ? ", or the type continuous" : ""));
      return;
    }
    file_.allowAttributes(
        *limit, {"lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"});
    joint.has_limit = true;
    joint.lower = file_.number(*limit, "lower").value_or(0);
    joint.upper = file_.number(*limit, "upper").value_or(0);
    file_.requiredNumber(*limit, "effort");
    joint.velocity = file_.requiredNumber(*limit, "velocity");
    if (bounded && joint.lower > joint.upper)
      file_.fail(*limit, "the lower limit " +
                             inQuotes(limit->Attribute("lower") ? limit->Attribute("lower") : "0") +
                             " of joint " + inQuotes(joint.name) + " is above the upper limit " +
                             inQuotes(limit->Attribute("upper") ? limit->Attribute("upper") : "0") +
                             "; lower at most upper would be accepted");
    if (joint.velocity < 0)
      file_.fail(*limit, "the velocity limit " + inQuotes(limit->Attribute("velocity")) +
                             " of joint " + inQuotes(joint.name) +
                             " is negative; zero or more would be accepted");
  }

  void readMimic(const XMLElement& element, UrdfJoint& joint) {
    const XMLElement* mimic = file_.onlyChild(element, "mimic");
    if (mimic == nullptr) return;
    file_.allowAttributes(*mimic, {"joint", "multiplier", "offset"});
    if (joint.type == JointType::kPlanar || joint.type == JointType::kFloating)
      file_.fail(*mimic, "joint " + inQuotes(joint.name) + " is " + element.Attribute("type") +
                             " and cannot mimic; revolute, continuous and prismatic joints can");
    joint.mimic = file_.attribute(*mimic, "joint");
    joint.mimic_line = mimic->GetLineNum();
    joint.multiplier = file_.number(*mimic, "multiplier").value_or(1);
    joint.offset = file_.number(*mimic, "offset").value_or(0);
    // A fixed joint stays where it is, whatever it is said to mimic (grippers are often frozen so).
    joint.has_mimic = joint.type != JointType::kFixed;
    if (!joint.has_mimic)
      document_.warnings.push_back(file_.locate(
          *mimic, "joint " + inQuotes(joint.name) + " is fixed: its <mimic> is left out"));
  }

  [[noreturn]] void failAt(int line, const std::string& message) const {
    throw InputError(document_.path, line, message);
  }

  void checkParents() {
    parent_joint_.assign(document_.links.size(), -1);
    for (std::size_t i = 0; i < document_.joints.size(); ++i) {
      const UrdfJoint& joint = document_.joints[i];
      const std::string& child = document_.links[static_cast<std::size_t>(joint.child)].name;
      if (joint.parent == joint.child)
        failAt(joint.line, "joint " + inQuotes(joint.name) + " joins link " + inQuotes(child) +
                               " to itself; two different links would be accepted");
      int& parent = parent_joint_[static_cast<std::size_t>(joint.child)];
      if (parent >= 0) {
        const UrdfJoint& first = document_.joints[static_cast<std::size_t>(parent)];
        failAt(joint.line, "link " + inQuotes(child) + " has two parents, through joint " +
                               inQuotes(first.name) + " (" + lineOf(first.line) + ") and joint " +
                               inQuotes(joint.name) + "; one would be accepted");
      }
      parent = static_cast<int>(i);
    }
  }

  void checkTree() {
    std::vector<std::size_t> roots;
    for (std::size_t i = 0; i < document_.links.size(); ++i)
      if (parent_joint_[i] < 0) roots.push_back(i);
    if (roots.size() > 1) {
      const UrdfLink& a = document_.links[roots[0]];
      const UrdfLink& b = document_.links[roots[1]];
      failAt(b.line,
             "the robot has " + std::to_string(roots.size()) + " roots, among them link " +
                 inQuotes(a.name) + " (" + lineOf(a.line) + ") and link " + inQuotes(b.name) +
                 "; one link without a parent would be accepted, a fixed joint can join them");
    }
    // Every link must lead up to the root; one that does not runs into a cycle.
    for (std::size_t start = 0; start < document_.links.size(); ++start) {
      std::size_t link = start;
      for (std::size_t steps = 0; parent_joint_[link] >= 0; ++steps) {
        if (steps > document_.links.size()) failCycle(link);
        link = static_cast<std::size_t>(
            document_.joints[static_cast<std::size_t>(parent_joint_[link])].parent);
      }
    }
  }

  [[noreturn]] void failCycle(std::size_t on_cycle) const {
    std::string way = inQuotes(document_.links[on_cycle].name);
    std::size_t link = on_cycle;
    int line = 0;
    do {
      const UrdfJoint& joint = document_.joints[static_cast<std::size_t>(parent_joint_[link])];
      line = std::max(line, joint.line);
      link = static_cast<std::size_t>(joint.parent);
      way += " < " + inQuotes(document_.links[link].name);
    } while (link != on_cycle);
    failAt(line,
           "the links form a cycle: " + way + " (each below the next); a tree would be accepted");
  }

  void checkMimics() {
    const auto find = [&](const std::string& name) {
      const auto found = std::find(joint_names_.begin(), joint_names_.end(), name);
      return found == joint_names_.end()
                 ? nullptr
                 : &document_.joints[static_cast<std::size_t>(found - joint_names_.begin())];
    };
    for (const UrdfJoint& joint : document_.joints) {
      if (!joint.has_mimic) continue;
      const UrdfJoint* master = &joint;
      for (std::size_t steps = 0; master->has_mimic; ++steps) {
        const UrdfJoint* next = find(master->mimic);
        if (next == nullptr) {
          const std::string nearest = suggestion(master->mimic, joint_names_);
          failAt(master->mimic_line,
                 "joint " + inQuotes(master->name) + " mimics " + inQuotes(master->mimic) +
                     ", which is not defined; " +
                     (nearest.empty() ? "the name of another <joint> would be accepted" : nearest));
        }
        if (steps > document_.joints.size() || next == &joint)
          failAt(joint.mimic_line,
                 "joint " + inQuotes(joint.name) + " mimics itself" +
                     (steps == 0 ? "" : " by way of others") +
                     "; a joint that has its own position would be accepted as master");
        master = next;
      }
      if (master->type != JointType::kRevolute && master->type != JointType::kContinuous &&
          master->type != JointType::kPrismatic)
        failAt(joint.mimic_line, "joint " + inQuotes(joint.name) + " mimics " +
                                     inQuotes(master->name) + " (" + lineOf(master->line) +
                                     "), which has no single position; a revolute, continuous or "
                                     "prismatic joint would be accepted");
    }
  }

  /// Takes from `parent` every child element that is not named; text and comments go with them.
  static void keepOnly(XMLElement& parent, std::initializer_list<std::string_view> names) {
    for (tinyxml2::XMLNode* child = parent.FirstChild(); child != nullptr;) {
      tinyxml2::XMLNode* next = child->NextSibling();
      const XMLElement* element = child->ToElement();
      if (element == nullptr ||
          std::find(names.begin(), names.end(), element->Name()) == names.end())
        parent.DeleteChild(child);
      child = next;
    }
  }

  std::string essence() {
    XMLElement& robot = *file_.document().RootElement();
    keepOnly(robot, {"link", "joint"});
    for (XMLElement* e = robot.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
      if (std::string_view(e->Name()) == "joint") {
        keepOnly(*e, {"origin", "parent", "child", "axis", "limit", "mimic"});
        continue;
      }
      keepOnly(*e, {"collision"});
      for (XMLElement* c = e->FirstChildElement(); c != nullptr; c = c->NextSiblingElement())
        keepOnly(*c, {"origin", "geometry"});
    }
    tinyxml2::XMLPrinter printer;
    robot.Accept(&printer);
    return printer.CStr();
  }

  XmlFile file_;
  UrdfDocument document_;
  std::map<std::string, int> link_lines_, joint_lines_, link_index_;
  std::vector<std::string> link_names_, joint_names_;
  std::vector<int> parent_joint_;
};

}  // namespace

Eigen::Matrix3d rollPitchYaw(const Eigen::Vector3d& rpy) {
  double sr, cr, sp, cp, sy, cy;
  collision::sineCosine(rpy.x(), sr, cr);
  collision::sineCosine(rpy.y(), sp, cp);
  collision::sineCosine(rpy.z(), sy, cy);
  Eigen::Matrix3d R;
  R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,   //
      -sp, cp * sr, cp * cr;
  return R;
}

UrdfDocument readUrdf(const std::string& path) { return Reader(path).read(); }

}  // namespace leeway::robots
