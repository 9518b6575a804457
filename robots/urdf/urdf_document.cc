// Reads before urdfdom does, which keeps no line numbers and is silent about much: it drops all
// collisions of a link for one unknown geometry, and accepts two parents, cycles apart from the
// tree, zero axes, swapped limits and unknown mimic masters.

#include "robots/urdf/urdf_document.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

#include "collision/base/sine_cosine.h"
#include "leeway/robots/kinematics.h"
#include "robots/base/tolerances.h"
#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

class UrdfReader {
 public:
  UrdfReader(const std::string& path, const LoadOptions& options)
      : file_(path, "URDF", options), errors_(options.errors), wrong_(options.errors) {
    document_.path = path;
  }

  UrdfDocument read() {
    document_.name = file_.attribute(file_.root(), "name");
    warnUnread(file_.root(), {"link", "joint", "material", "gazebo", "transmission", "sensor",
                              "ros2_control", "plugin"});
    file_.eachChild(file_.root(), "link", [&](const XMLElement& link) { readLink(link); });
    if (document_.links.empty())
      file_.fail(file_.root(), file_.root().FirstChildElement("group") != nullptr
                                   ? "the robot has no <link>, but a <group>: it is an SRDF; a "
                                     "URDF is expected"
                                   : "the robot has no <link>; at least one is needed");
    file_.eachChild(file_.root(), "joint", [&](const XMLElement& joint) { readJoint(joint); });
    // What is between links and joints says little while some of them are wrong.
    wrong_.throwFirst();
    checkStructure(document_);
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
      if (const auto position = file_.vector(*origin, "xyz")) {
        if (!(position->cwiseAbs().maxCoeff() <= kFarthestOrigin))
          file_.fail(*origin, "xyz of <origin> is " + inQuotes(origin->Attribute("xyz")) +
                                  "; numbers from -1e9 to 1e9 [m] would be accepted");
        pose.translation = *position;
      }
      if (const auto angles = file_.vector(*origin, "rpy")) {
        if (!(angles->cwiseAbs().maxCoeff() <= kFarthestOrigin))
          file_.fail(*origin, "rpy of <origin> is " + inQuotes(origin->Attribute("rpy")) +
                                  "; numbers from -1e9 to 1e9 [rad] would be accepted");
        pose.rotation = rollPitchYaw(*angles);
      }
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
    file_.eachChild(element, "collision", [&](const XMLElement& collision) {
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
    for (const auto part : {&UrdfReader::readAxis, &UrdfReader::readLimit, &UrdfReader::readMimic})
      readOn(errors_, [&] { (this->*part)(element, joint); });
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
    // The square of a norm outside these bounds loses digits.
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
    for (const char* name : {"lower", "upper"})
      if (bounded && !(std::abs(file_.number(*limit, name).value_or(0)) <= kGreatestLimit))
        file_.fail(*limit, std::string("the ") + name + " limit " +
                               inQuotes(limit->Attribute(name)) + " of joint " +
                               inQuotes(joint.name) +
                               " is too large; numbers from -1e16 to 1e16 would be accepted");
    if (bounded && joint.lower > joint.upper)
      file_.fail(*limit, "the lower limit " +
                             inQuotes(limit->Attribute("lower") ? limit->Attribute("lower") : "0") +
                             " of joint " + inQuotes(joint.name) + " is above the upper limit " +
                             inQuotes(limit->Attribute("upper") ? limit->Attribute("upper") : "0") +
                             "; lower at most upper would be accepted");
    if (!(joint.velocity <= kGreatestLimit))
      file_.fail(*limit, "the velocity limit " + inQuotes(limit->Attribute("velocity")) +
                             " of joint " + inQuotes(joint.name) +
                             " is too large; numbers from 0 to 1e16 would be accepted");
    if (joint.velocity < 0)
      file_.fail(*limit, "the velocity limit " + inQuotes(limit->Attribute("velocity")) +
                             " of joint " + inQuotes(joint.name) +
                             " is negative; zero or more would be accepted");
    if (joint.velocity == 0 && joint.type != JointType::kFixed &&
        element.FirstChildElement("mimic") == nullptr)
      document_.warnings.push_back(file_.locate(
          *limit, "the velocity limit of joint " + inQuotes(joint.name) +
                      " is 0, which is taken for none: it may move at 1 rad/s or 1 m/s"));
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
    for (const char* name : {"multiplier", "offset"})
      if (!(std::abs(file_.number(*mimic, name).value_or(0)) <= kGreatestLimit))
        file_.fail(*mimic, std::string("the ") + name + " " + inQuotes(mimic->Attribute(name)) +
                               " of joint " + inQuotes(joint.name) +
                               " is too large; numbers from -1e16 to 1e16 would be accepted");
    // Grippers are often frozen by making a mimic joint fixed.
    joint.has_mimic = joint.type != JointType::kFixed;
    if (!joint.has_mimic)
      document_.warnings.push_back(file_.locate(
          *mimic, "joint " + inQuotes(joint.name) + " is fixed: its <mimic> is left out"));
  }

  /// Removes all children of `parent` but elements of these names.
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
  InputErrors* errors_;
  ErrorsSince wrong_;
  UrdfDocument document_;
  std::map<std::string, int> link_lines_, joint_lines_, link_index_;
  std::vector<std::string> link_names_;
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

UrdfDocument readUrdf(const std::string& path, const LoadOptions& options) {
  return UrdfReader(path, options).read();
}

}  // namespace leeway::robots
