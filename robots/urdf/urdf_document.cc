// Reads before urdfdom does, which keeps no line numbers and is silent about much: it drops all
// collisions of a link for one unknown geometry, and accepts two parents, cycles apart from the
// tree, zero axes, swapped limits and unknown mimic masters.

#include "robots/urdf/urdf_document.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <locale>
#include <map>
#include <sstream>
#include <string_view>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/text.h"
#include "robots/base/tolerances.h"
#include "robots/urdf/rotation.h"
#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

class UrdfReader {
 public:
  UrdfReader(XmlFile& file, const LoadOptions& options, bool with_visuals)
      : file_(file),
        errors_(options.errors),
        wrong_(options.errors),
        takes_visuals_(options.visual_as_collision) {
    document_.path = file.path();
    document_.with_visuals = with_visuals;
  }

  UrdfDocument read() {
    readName();
    file_.allowAttributes(file_.root(), {"name", "version"}, XmlFile::Misspelt::kLeftOut);
    file_.leaveOutUnknown(
        file_.root(), {"link", "joint"},
        {"material", "gazebo", "transmission", "sensor", "ros2_control", "plugin"});
    file_.eachChild(file_.root(), "link", [&](const XMLElement& link) { readLink(link); });
    if (document_.links.empty())
      file_.fail(file_.root(), file_.root().FirstChildElement("group") != nullptr
                                   ? "the robot has no <link>, but a <group>: it is an SRDF; a "
                                     "URDF is expected"
                                   : "the robot has no <link>; at least one is needed");
    file_.eachChild(file_.root(), "joint", [&](const XMLElement& joint) { readJoint(joint); });
    file_.leaveOutShapesBeyond({"robot"});
    // What is between links and joints says little while some of them are wrong.
    wrong_.throwFirst();
    checkStructure(document_);
    warnOfUnusedLimits();
    document_.essence = essence();
    for (std::string& warning : file_.takeWarnings())
      document_.warnings.push_back(std::move(warning));
    return std::move(document_);
  }

 private:
  void readName() {
    const char* name = file_.root().Attribute("name");
    const bool is_given = name != nullptr && *name != '\0';
    document_.name = is_given ? name : std::filesystem::path(file_.path()).stem().string();
    if (!is_given)
      file_.leaveOut(file_.root(),
                     "<robot> has no name; " + inQuotes(document_.name) + " is taken");
  }

  /// Warns of unknown attributes and elements in what is not read, as in what is: a part of URDF
  /// with the elements inside it. Nothing there bears on planning.
  void checkUnread(const XMLElement& element) {
    static const std::map<std::string_view, std::vector<std::string>> kAttributes = {
        {"visual", {"name"}},
        {"inertial", {}},
        {"origin", {"xyz", "rpy", "quat_xyzw"}},
        {"geometry", {}},
        {"box", {"size"}},
        {"sphere", {"radius"}},
        {"cylinder", {"radius", "length"}},
        {"capsule", {"radius", "length"}},
        {"mesh", {"filename", "scale"}},
        {"material", {"name"}},
        {"color", {"rgba"}},
        {"texture", {"filename"}},
        {"mass", {"value"}},
        {"inertia", {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}},
        {"dynamics", {"damping", "friction"}},
        {"calibration", {"reference_position", "rising", "falling"}}};
    const auto known = kAttributes.find(element.Name());
    if (known == kAttributes.end()) return;
    file_.allowAttributes(element, known->second, XmlFile::Misspelt::kLeftOut);
    for (const XMLElement* e = element.FirstChildElement(); e != nullptr;
         e = e->NextSiblingElement()) {
      if (!kAttributes.contains(e->Name()))
        file_.leaveOut(*e, "<" + std::string(e->Name()) + "> in <" + element.Name() +
                               "> is not known and is left out");
      checkUnread(*e);
    }
  }
  void checkUnread(const XMLElement& parent, std::initializer_list<const char*> names) {
    for (const char* name : names)
      for (const XMLElement* e = parent.FirstChildElement(name); e != nullptr;
           e = e->NextSiblingElement(name))
        checkUnread(*e);
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
      for (const tinyxml2::XMLAttribute* a = origin->FirstAttribute(); a != nullptr; a = a->Next())
        if (std::string_view(a->Name()).starts_with("quat") &&
            a->Name() != std::string_view("quat_xyzw"))
          file_.fail(*origin, "<origin> has the attribute " + inQuotes(a->Name()) +
                                  ", which is not read; known are: xyz, rpy, quat_xyzw");
      file_.expectAttributes(*origin, {"xyz", "rpy", "quat_xyzw"});
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
      if (origin->Attribute("quat_xyzw") != nullptr) pose.rotation = quaternionOf(*origin);
    }
    if (xyz != nullptr) *xyz = pose.translation;
    return pose;
  }

  /// The rotation of quat_xyzw, of URDF 1.1.
  Eigen::Matrix3d quaternionOf(const XMLElement& origin) {
    if (origin.Attribute("rpy") != nullptr)
      file_.fail(origin, "<origin> has both rpy and quat_xyzw; one would be accepted");
    const std::vector<double> q = file_.numbers(origin, "quat_xyzw");
    double most = 0;
    for (const double x : q) most = std::max(most, std::abs(x));
    if (q.size() != 4 || !(most >= 1 / kFarthestOrigin && most <= kFarthestOrigin))
      file_.fail(origin, "quat_xyzw of <origin> is " + inQuotes(origin.Attribute("quat_xyzw")) +
                             "; four numbers x y z w that are not all 0, from -1e9 to 1e9, would "
                             "be accepted");
    return rotationOf({q[3], q[0], q[1], q[2]});
  }

  void readLink(const XMLElement& element) {
    UrdfLink link;
    link.name = uniqueName(element, link_lines_);
    link.file = file_.path();
    link.line = element.GetLineNum();
    link_index_[link.name] = static_cast<int>(document_.links.size());
    link_names_.push_back(link.name);
    file_.allowAttributes(element, {"name"});
    file_.leaveOutUnknown(element, {"collision"},
                          {"visual", "inertial", "contact", "sensor", "material", "gravity"});
    const auto add = [&](const XMLElement& shape) {
      link.collisions.push_back(readCollision(shape));
    };
    checkUnread(element, {"inertial"});
    if (document_.with_visuals) readVisuals(element, link);
    if (element.FirstChildElement("collision") == nullptr && takes_visuals_) {
      file_.eachChild(element, "visual", add);
      link.visual_stands_in = !link.collisions.empty();
    } else {
      checkUnread(element, {"visual"});
      file_.eachChild(element, "collision", add);
    }
    link.has_visual = element.FirstChildElement("visual") != nullptr;
    document_.links.push_back(std::move(link));
  }

  void readVisuals(const XMLElement& element, UrdfLink& link) {
    for (const XMLElement* visual = element.FirstChildElement("visual"); visual != nullptr;
         visual = visual->NextSiblingElement("visual")) {
      try {
        link.visuals.push_back(readCollision(*visual));
      } catch (const InputError& error) {
        document_.unread_visuals.emplace_back(error.what());
      }
    }
  }

  static constexpr std::string_view kDrakeCapsule = "drake:capsule",
                                    kDrakeEllipsoid = "drake:ellipsoid";

  /// Returns whether an element of a <geometry> is its shape. Drake's own shapes count only without
  /// a standard one.
  static bool isShape(const XMLElement& element) {
    static constexpr std::string_view kShapes[] = {"box", "sphere", "cylinder", "capsule", "mesh"};
    const auto isPlain = [](const XMLElement& e) {
      return std::find(std::begin(kShapes), std::end(kShapes), e.Name()) != std::end(kShapes);
    };
    if (isPlain(element)) return true;
    if (element.Name() != kDrakeCapsule && element.Name() != kDrakeEllipsoid) return false;
    for (const XMLElement* e = element.Parent()->FirstChildElement(); e != nullptr;
         e = e->NextSiblingElement())
      if (isPlain(*e)) return false;
    return true;
  }

  /// The one element of a <geometry> that is a shape. Others beside it are extensions.
  const XMLElement& shapeOf(const XMLElement& geometry) {
    const std::string accepted =
        "<box>, <sphere>, <cylinder>, <capsule> or <mesh> would be accepted";
    const XMLElement* first = geometry.FirstChildElement();
    if (first == nullptr) file_.fail(geometry, "<geometry> is empty; " + accepted);
    const XMLElement* shape = nullptr;
    for (const XMLElement* e = first; e != nullptr; e = e->NextSiblingElement()) {
      if (!isShape(*e)) continue;
      if (shape != nullptr)
        file_.fail(
            *e,
            "a second shape <" + std::string(e->Name()) +
                "> in one <geometry>; one would be accepted, more go into collisions of their own");
      shape = e;
    }
    if (shape == nullptr)
      file_.fail(*first,
                 "the geometry <" + std::string(first->Name()) + "> is not known; " + accepted);
    file_.leaveOutUnknown(geometry, {shape->Name()}, {});
    return *shape;
  }

  UrdfCollision readCollision(const XMLElement& element) {
    file_.allowAttributes(element, {"name"});
    file_.leaveOutUnknown(element, {"origin", "geometry"},
                          {"material", "verbose", "contact_coefficients"});
    UrdfCollision collision;
    if (const char* name = element.Attribute("name")) collision.name = name;
    collision.X_LG = readOrigin(element);
    const XMLElement& geometry = file_.requiredChild(element, "geometry");
    file_.allowAttributes(geometry, {});
    const XMLElement& shape = shapeOf(geometry);
    collision.file = file_.path();
    collision.line = shape.GetLineNum();
    const std::string kind = shape.Name();
    if (kind == "box") {
      collision.kind = UrdfCollision::Kind::kBox;
      file_.expectAttributes(shape, {"size"});
      file_.attribute(shape, "size");
      collision.size = *file_.vector(shape, "size");
      if ((collision.size.array() < 0).any())
        file_.fail(shape, "size of <box> is " + inQuotes(shape.Attribute("size")) +
                              "; edges of zero or more would be accepted");
    } else if (kind == "sphere") {
      collision.kind = UrdfCollision::Kind::kSphere;
      file_.expectAttributes(shape, {"radius"});
      collision.radius = readSize(shape, "radius");
    } else if (kind == "cylinder" || kind == "capsule" || kind == kDrakeCapsule) {
      collision.kind =
          kind == "cylinder" ? UrdfCollision::Kind::kCylinder : UrdfCollision::Kind::kCapsule;
      file_.expectAttributes(shape, {"radius", "length"});
      collision.radius = readSize(shape, "radius");
      collision.length = readSize(shape, "length");
    } else if (kind == kDrakeEllipsoid) {
      collision.kind = UrdfCollision::Kind::kEllipsoid;
      file_.expectAttributes(shape, {"a", "b", "c"});
      collision.size =
          2 * Eigen::Vector3d(readSize(shape, "a"), readSize(shape, "b"), readSize(shape, "c"));
    } else {
      collision.kind = UrdfCollision::Kind::kMesh;
      file_.expectAttributes(shape, {"filename", "scale"});
      collision.mesh_file = file_.attribute(shape, "filename");
      if (const auto scale = file_.vector(shape, "scale")) collision.mesh_scale = *scale;
      if ((collision.mesh_scale.array() == 0).any())
        file_.fail(shape, "scale of <mesh> is " + inQuotes(shape.Attribute("scale")) +
                              "; three numbers other than zero would be accepted");
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
    file_.expectAttributes(element, {"link"});
    const std::string name = file_.attribute(element, "link");
    auto found = link_index_.find(name);
    if (found == link_index_.end() && name == "world" && std::string_view(role) == "parent")
      found = addWorld(element);
    if (found == link_index_.end()) {
      const std::string nearest = suggestion(name, link_names_);
      file_.fail(element,
                 "the " + std::string(role) + " link " + inQuotes(name) + " is not defined; " +
                     (nearest.empty() ? "the name of a <link> would be accepted" : nearest));
    }
    return found->second;
  }

  /// Some files join their root to a link "world" that they do not define, as Drake and Gazebo do.
  std::map<std::string, int>::iterator addWorld(const XMLElement& element) {
    file_.leaveOut(
        element, "the parent link \"world\" is not defined; it is taken as a link without shapes");
    UrdfLink world;
    world.name = "world";
    world.file = file_.path();
    world.line = element.GetLineNum();
    document_.links.push_back(world);
    return link_index_.emplace(world.name, static_cast<int>(document_.links.size()) - 1).first;
  }

  void readJoint(const XMLElement& element) {
    UrdfJoint joint;
    joint.name = uniqueName(element, joint_lines_);
    joint.file = file_.path();
    joint.line = element.GetLineNum();
    joint.type = readType(element);
    file_.allowAttributes(element, {"name", "type"});
    file_.leaveOutUnknown(
        element, {"origin", "parent", "child", "axis", "limit", "mimic", "safety_controller"},
        {"dynamics", "calibration", "sensor", "gazebo"});
    checkUnread(element, {"dynamics", "calibration"});
    joint.parent = readLinkReference(element, "parent");
    joint.child = readLinkReference(element, "child");
    joint.X_PJ = readOrigin(element, &joint.xyz);
    for (const auto part : {&UrdfReader::readAxis, &UrdfReader::readLimit,
                            &UrdfReader::noteSoftLimits, &UrdfReader::readMimic})
      readOn(errors_, [&] { (this->*part)(element, joint); });
    document_.joints.push_back(std::move(joint));
  }

  static bool isBounded(const UrdfJoint& joint) {
    return joint.type == JointType::kRevolute || joint.type == JointType::kPrismatic;
  }

  void readAxis(const XMLElement& element, UrdfJoint& joint) {
    if (joint.type == JointType::kFixed || joint.type == JointType::kFloating) return;
    const XMLElement* axis = file_.onlyChild(element, "axis");
    if (axis == nullptr) {
      if (joint.type == JointType::kPlanar)
        file_.warn(element, "planar joint " + inQuotes(joint.name) +
                                " has no <axis>: its plane is normal to x");
      return;
    }
    file_.expectAttributes(*axis, {"xyz"});
    file_.attribute(*axis, "xyz");
    joint.axis = *file_.vector(*axis, "xyz");
    // The square of a norm outside these bounds loses digits.
    const double norm = joint.axis.norm();
    if (!(norm > 1e-100 && norm < 1e100))
      file_.fail(*axis, "the axis " + inQuotes(axis->Attribute("xyz")) + " of joint " +
                            inQuotes(joint.name) +
                            " has no direction; a vector other than zero would be accepted");
    if (joint.type == JointType::kPlanar && joint.axis / norm != Eigen::Vector3d::UnitZ())
      file_.warn(*axis, "planar joint " + inQuotes(joint.name) + " moves in the plane normal to " +
                            inQuotes(axis->Attribute("xyz")) +
                            ", as URDF has it; MoveIt would take z");
  }

  void readLimit(const XMLElement& element, UrdfJoint& joint) {
    const XMLElement* limit = file_.onlyChild(element, "limit");
    if (limit == nullptr) {
      if (joint.type == JointType::kRevolute)
        file_.fail(element, "joint " + inQuotes(joint.name) +
                                " has no <limit>; a revolute joint needs <limit lower=\"...\" "
                                "upper=\"...\" effort=\"...\" velocity=\"...\"/>, or the type "
                                "continuous");
      if (joint.type != JointType::kPrismatic) return;
      joint.lower = -kInfinity;
      joint.upper = kInfinity;
      if (element.FirstChildElement("mimic") == nullptr)
        file_.warn(element, "joint " + inQuotes(joint.name) +
                                " has no <limit>: it needs bounds to be planned, and may move at 1 "
                                "m/s");
      return;
    }
    file_.expectAttributes(
        *limit, {"lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"});
    joint.has_limit = true;
    joint.limit_line = limit->GetLineNum();
    joint.lower = file_.number(*limit, "lower").value_or(0);
    joint.upper = file_.number(*limit, "upper").value_or(0);
    joint.lacks_range = !limit->Attribute("lower") && !limit->Attribute("upper");
    readVelocity(*limit, joint);
    for (const char* name : {"acceleration", "deceleration"})
      joint.acceleration = std::min(joint.acceleration, readRate(*limit, name, joint));
    joint.jerk = readRate(*limit, "jerk", joint);
    if (!isBounded(joint)) {
      // Many files give a continuous joint a whole turn, to some digits.
      const bool is_whole_turn =
          joint.type == JointType::kContinuous && joint.upper - joint.lower > 6.28;
      if (joint.type != JointType::kFixed && joint.lower != joint.upper && !is_whole_turn)
        unused_limits_.add(*limit, joint.name);
      return;
    }
    for (const char* name : {"lower", "upper"})
      if (!(std::abs(file_.number(*limit, name).value_or(0)) <= kGreatestLimit))
        file_.fail(*limit, std::string("the ") + name + " limit " +
                               inQuotes(limit->Attribute(name)) + " of joint " +
                               inQuotes(joint.name) +
                               " is too large; numbers from -1e16 to 1e16 would be accepted");
    if (joint.lower > joint.upper)
      file_.fail(*limit, "the lower limit " +
                             inQuotes(limit->Attribute("lower") ? limit->Attribute("lower") : "0") +
                             " of joint " + inQuotes(joint.name) + " is above the upper limit " +
                             inQuotes(limit->Attribute("upper") ? limit->Attribute("upper") : "0") +
                             "; lower at most upper would be accepted");
    if (joint.lower == joint.upper && element.FirstChildElement("mimic") == nullptr)
      file_.warn(*limit, "joint " + inQuotes(joint.name) + " cannot move: " +
                             (limit->Attribute("lower") || limit->Attribute("upper")
                                  ? "its lower and upper limits are equal"
                                  : "its lower and upper limits are not given, and 0 then"));
  }

  /// Efforts are not used. A missing or senseless velocity limit means that there is no limit.
  void readVelocity(const XMLElement& limit, UrdfJoint& joint) {
    const bool moves =
        joint.type != JointType::kFixed && limit.Parent()->FirstChildElement("mimic") == nullptr;
    try {
      if (!file_.number(limit, "effort"))
        file_.leaveOut(limit, "<limit> has no effort, which is not used");
    } catch (const InputError& error) {
      file_.leaveOut(error, "; it is not used");
    }
    const char* given = limit.Attribute("velocity");
    const bool is_endless = given != nullptr && parseNumber(given) && !parseFinite(given);
    const double velocity = is_endless ? 0 : file_.number(limit, "velocity").value_or(0);
    if (velocity > 0 && velocity <= kGreatestLimit) {
      joint.velocity = velocity;
      return;
    }
    if (moves)
      file_.warn(limit, (given ? "the velocity limit " + inQuotes(given) + " of joint " +
                                     inQuotes(joint.name) + " is taken for none"
                               : "joint " + inQuotes(joint.name) + " has no velocity limit") +
                            ": it may move at 1 rad/s or 1 m/s");
  }

  /// A limit that URDF 1.2 adds. One that is zero, negative or too large means that there is none.
  double readRate(const XMLElement& limit, const char* name, const UrdfJoint& joint) {
    const char* given = limit.Attribute(name);
    if (given == nullptr) return kInfinity;
    const auto value = parseNumber(given);
    if (value && *value > 0 && *value <= kGreatestLimit) return *value;
    if (!value || std::isnan(*value)) static_cast<void>(file_.number(limit, name));  // it throws
    if (joint.type != JointType::kFixed)
      file_.warn(limit, std::string("the ") + name + " limit " + inQuotes(given) + " of joint " +
                            inQuotes(joint.name) + " is taken for none");
    return kInfinity;
  }

  /// Soft limits are named and not used: published problems have starts and goals beyond them.
  void noteSoftLimits(const XMLElement& element, UrdfJoint& joint) {
    const XMLElement* safety = file_.onlyChild(element, "safety_controller");
    if (safety == nullptr || joint.type == JointType::kFixed) return;
    file_.expectAttributes(*safety,
                           {"soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"},
                           XmlFile::Misspelt::kLeftOut);
    try {
      const auto lower = file_.number(*safety, "soft_lower_limit"),
                 upper = file_.number(*safety, "soft_upper_limit");
      if (!lower && !upper) return;
      const bool narrows = lower.value_or(0) > joint.lower || upper.value_or(0) < joint.upper;
      if (isBounded(joint) && !narrows) return;  // the other is 0 then, URDF's default
      soft_limits_.add(*safety, joint.name);
    } catch (const InputError& error) {
      file_.leaveOut(error, "; it is not used");
    }
  }

  void warnOfUnusedLimits() {
    if (soft_limits_.first != nullptr)
      file_.warn(
          *soft_limits_.first,
          "soft limits are not used, joints move within their <limit>: " + soft_limits_.joints);
    if (unused_limits_.first != nullptr)
      file_.warn(*unused_limits_.first,
                 "lower and upper limits are not used of joints that are not revolute or "
                 "prismatic: " +
                     unused_limits_.joints);
  }

  void readMimic(const XMLElement& element, UrdfJoint& joint) {
    const XMLElement* mimic = file_.onlyChild(element, "mimic");
    if (mimic == nullptr) return;
    file_.expectAttributes(*mimic, {"joint", "multiplier", "offset"});
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
      file_.warn(*mimic, "joint " + inQuotes(joint.name) + " is fixed: its <mimic> is left out");
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

  /// Makes white space in numbers single spaces: urdfdom knows no other.
  static void spaceNumbers(XMLElement& element) {
    for (const char* name : {"xyz", "rpy", "size", "scale", "radius", "length", "lower", "upper",
                             "velocity", "multiplier", "offset"}) {
      const char* text = element.Attribute(name);
      if (text == nullptr) continue;
      std::istringstream words(text);
      std::string spaced;
      for (std::string word; words >> word;) spaced += (spaced.empty() ? "" : " ") + word;
      element.SetAttribute(name, spaced.c_str());
    }
    for (XMLElement* child = element.FirstChildElement(); child != nullptr;
         child = child->NextSiblingElement())
      spaceNumbers(*child);
  }

  /// Fills in a <limit> or attributes of it that urdfdom requires and this reader does not use.
  static void fillLimit(XMLElement& element, const UrdfJoint& joint) {
    XMLElement* limit = element.FirstChildElement("limit");
    if (limit == nullptr && joint.type == JointType::kPrismatic)
      limit = element.InsertNewChildElement("limit");
    if (limit == nullptr) return;
    limit->SetAttribute("effort", "0");
    if (std::isinf(joint.velocity)) limit->SetAttribute("velocity", "0");
  }

  /// Writes a quaternion as rpy. Where roll and yaw are about one axis, roll takes what yaw leaves.
  void fillAngles(XMLElement& parent) {
    XMLElement* origin = parent.FirstChildElement("origin");
    if (origin == nullptr || origin->Attribute("quat_xyzw") == nullptr) return;
    const Eigen::Matrix3d R = quaternionOf(*origin);
    const double yaw = std::atan2(R(1, 0), R(0, 0)), c = std::cos(yaw), s = std::sin(yaw);
    const double roll = std::atan2(s * R(0, 2) - c * R(1, 2), c * R(1, 1) - s * R(0, 1));
    const double pitch = std::atan2(-R(2, 0), c * R(0, 0) + s * R(1, 0));
    origin->DeleteAttribute("quat_xyzw");
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text.precision(17);
    text << roll << ' ' << pitch << ' ' << yaw;
    origin->SetAttribute("rpy", text.str().c_str());
  }

  void keepShapes(XMLElement& link) {
    const bool visual = link.FirstChildElement("collision") == nullptr && takes_visuals_;
    keepOnly(link, {visual ? "visual" : "collision"});
    for (XMLElement* c = link.FirstChildElement(); c != nullptr; c = c->NextSiblingElement()) {
      c->SetName("collision");
      keepOnly(*c, {"origin", "geometry"});
      fillAngles(*c);
      XMLElement& geometry = *c->FirstChildElement("geometry");
      XMLElement* shape = geometry.FirstChildElement();
      while (!isShape(*shape)) shape = shape->NextSiblingElement();
      const std::string kind = shape->Name();
      keepOnly(geometry, {kind});
      if (kind == "capsule" || kind == kDrakeCapsule) shape->SetName("cylinder");
      if (kind == kDrakeEllipsoid) {
        shape->SetName("box");
        std::string size;
        for (const char* half : {"a", "b", "c"}) size += std::string(shape->Attribute(half)) + " ";
        shape->SetAttribute("size", size.c_str());
      }
    }
  }

  std::string essence() {
    XMLElement& robot = *file_.document().RootElement();
    keepOnly(robot, {"link", "joint"});
    // Versions after 1.0 add capsules and quaternions, which urdfdom may not know.
    if (const char* version = robot.Attribute("version");
        version != nullptr && std::string_view(version).starts_with("1."))
      robot.DeleteAttribute("version");
    robot.SetAttribute("name", document_.name.c_str());
    if (link_index_.size() > link_lines_.size())
      robot.InsertNewChildElement("link")->SetAttribute("name", "world");
    auto joint = document_.joints.begin();
    for (XMLElement* e = robot.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
      if (std::string_view(e->Name()) == "joint") {
        keepOnly(*e, {"origin", "parent", "child", "axis", "limit", "mimic"});
        fillAngles(*e);
        fillLimit(*e, *joint++);
      } else {
        keepShapes(*e);
      }
    }
    spaceNumbers(robot);
    tinyxml2::XMLPrinter printer;
    robot.Accept(&printer);
    return printer.CStr();
  }

  XmlFile& file_;
  InputErrors* errors_;
  ErrorsSince wrong_;
  bool takes_visuals_;
  UrdfDocument document_;
  std::map<std::string, int> link_lines_, joint_lines_, link_index_;
  std::vector<std::string> link_names_;
  /// Limits that are not used.
  struct UnusedLimits {
    const XMLElement* first = nullptr;
    std::string joints;  // in quotes

    void add(const XMLElement& element, const std::string& joint) {
      if (first == nullptr) first = &element;
      joints += (joints.empty() ? "" : ", ") + inQuotes(joint);
    }
  };
  UnusedLimits soft_limits_, unused_limits_;
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

UrdfDocument readUrdf(XmlFile& file, const LoadOptions& options, bool with_visuals) {
  return UrdfReader(file, options, with_visuals).read();
}

}  // namespace leeway::robots
