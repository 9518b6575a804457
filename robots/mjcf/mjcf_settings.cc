#include "robots/mjcf/mjcf_settings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "collision/base/sine_cosine.h"
#include "robots/base/tolerances.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

const std::vector<std::string> kBooleans = {"false", "true"};

std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return text;
}

void expectFinite(const Attributes& attributes, const char* name, std::span<const double> values) {
  for (const double value : values)
    if (!(std::abs(value) <= kFarthestOrigin))
      attributes.fail(name, "numbers from -1e9 to 1e9 would be accepted");
}

Eigen::Matrix3d rotationOfEuler(const std::vector<double>& angles, const MjcfSettings& settings) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (std::size_t i = 0; i < 3; ++i) {
    const char axis = settings.euler[i];
    const bool is_moving = axis >= 'a';
    const Eigen::Matrix3d turn = rotationAbout(
        Eigen::Vector3d::Unit(axis - (is_moving ? 'x' : 'X')), settings.angle(angles[i]));
    R = is_moving ? Eigen::Matrix3d(R * turn) : Eigen::Matrix3d(turn * R);
  }
  return R;
}

Eigen::Matrix3d rotationOfAxes(const Attributes& attributes, const std::vector<double>& xy) {
  Eigen::Vector3d x(xy[0], xy[1], xy[2]), y(xy[3], xy[4], xy[5]);
  if (!(x.norm() > 0)) attributes.fail("xyaxes", "an x axis other than 0 0 0 would be accepted");
  x.normalize();
  const double length = y.norm();
  y -= x.dot(y) * x;
  if (!(y.norm() > 1e-9 * length))
    attributes.fail("xyaxes", "a y axis that is not along x would be accepted");
  y.normalize();
  Eigen::Matrix3d R;
  R << x, y, x.cross(y);
  return R;
}

}  // namespace

double MjcfSettings::angle(double written) const {
  return degrees ? written * (std::numbers::pi / 180) : written;
}

MjcfSettings readSettings(const MjcfFile& file) {
  MjcfSettings settings;
  file.eachSection("compiler", [&](const XMLElement& e) {
    checkAttributes(file, e);
    const Attributes a(file, {&e});
    if (a.word("coordinate", {"local", "global"}, "local") == 1)
      file.fail(e,
                "coordinate is \"global\"; \"local\" would be accepted, as MuJoCo from 3.0 on "
                "has it");
    settings.degrees =
        a.word("angle", {"radian", "degree"}, settings.degrees ? "degree" : "radian") == 1;
    const std::string euler = a.text("eulerseq", settings.euler);
    if (euler.size() != 3 || euler.find_first_not_of("xyzXYZ") != std::string::npos)
      a.fail("eulerseq", "three letters of xyzXYZ would be accepted");
    settings.euler = euler;
    settings.mesh_folder = a.text("assetdir", settings.mesh_folder);
    settings.mesh_folder = a.text("meshdir", settings.mesh_folder);
    settings.strips_paths = a.flag("strippath", settings.strips_paths);
    settings.auto_limits = a.flag("autolimits", settings.auto_limits);
  });
  file.eachOf("option", [&](const XMLElement& e) {
    if (std::string_view(e.Name()) == "flag")
      settings.filters_parents = Attributes(file, {&e})
                                     .word("filterparent", {"disable", "enable"},
                                           settings.filters_parents ? "enable" : "disable") == 1;
  });
  return settings;
}

const XMLElement* Attributes::find(const char* name) const {
  const auto gives = [&](const XMLElement* e) { return e->Attribute(name) != nullptr; };
  const auto found = std::find_if(levels_.begin(), levels_.end(), gives);
  return found == levels_.end() ? nullptr : *found;
}

std::string Attributes::text(const char* name, const std::string& otherwise) const {
  const XMLElement* at = find(name);
  return at == nullptr ? otherwise : at->Attribute(name);
}

std::optional<std::vector<double>> Attributes::numbers(const char* name, std::size_t count) const {
  const XMLElement* at = find(name);
  if (at == nullptr) return std::nullopt;
  std::vector<double> values = file_.of(*at).numbers(*at, name);
  if (values.size() != count)
    fail(name,
         std::to_string(count) + (count == 1 ? " number" : " numbers") + " would be accepted");
  expectFinite(*this, name, values);
  return values;
}

double Attributes::number(const char* name, double otherwise) const {
  const auto values = numbers(name, 1);
  return values ? values->front() : otherwise;
}

Eigen::Vector3d Attributes::vector(const char* name, const Eigen::Vector3d& otherwise) const {
  const auto values = numbers(name, 3);
  return values ? Eigen::Vector3d(values->data()) : otherwise;
}

std::vector<double> Attributes::over(const char* name, std::vector<double> values) const {
  for (auto level = levels_.rbegin(); level != levels_.rend(); ++level) {
    if ((*level)->Attribute(name) == nullptr) continue;
    const std::vector<double> written = file_.of(**level).numbers(**level, name);
    if (written.size() > values.size())
      fail(name, "up to " + std::to_string(values.size()) + " numbers would be accepted");
    std::copy(written.begin(), written.end(), values.begin());
  }
  expectFinite(*this, name, values);
  return values;
}

std::size_t Attributes::word(const char* name, const std::vector<std::string>& words,
                             std::string_view otherwise) const {
  const std::string written = text(name, std::string(otherwise));
  const auto found = std::find(words.begin(), words.end(), written);
  if (found == words.end()) fail(name, listed(words) + " would be accepted");
  return static_cast<std::size_t>(found - words.begin());
}

bool Attributes::flag(const char* name, bool otherwise) const {
  return word(name, kBooleans, otherwise ? "true" : "false") == 1;
}

unsigned Attributes::mask(const char* name, unsigned otherwise) const {
  const double value = number(name, otherwise);
  if (value != std::floor(value) || std::abs(value) > 0x7fffffff)
    fail(name, "a whole number would be accepted");
  return static_cast<unsigned>(static_cast<int>(value));
}

void Attributes::fail(const char* name, const std::string& message) const {
  const XMLElement* at = find(name);
  const XMLElement& place = at == nullptr ? element() : *at;
  file_.fail(place, std::string(name) + " of <" + place.Name() + "> is " +
                        (at == nullptr ? "not given" : inQuotes(at->Attribute(name))) + "; " +
                        message);
}

DefaultClasses::DefaultClasses(const MjcfFile& file) : file_(file) {
  classes_[main_];
  file.eachSection("default", [&](const XMLElement& e) { read(e, ""); });
}

void DefaultClasses::read(const XMLElement& element, const std::string& parent) {
  const char* name = element.Attribute("class");
  if (!parent.empty() && (name == nullptr || *name == '\0'))
    file_.fail(element, "<default> in <default> has no class; class=\"...\" is needed");
  // The outermost class may have any name.
  if (parent.empty() && name != nullptr && main_ != name && *name != '\0') {
    if (classes_.count(name) != 0)
      file_.fail(element, "a second class " + inQuotes(name) + "; names must be unique");
    auto node = classes_.extract(main_);
    node.key() = main_ = name;
    classes_.insert(std::move(node));
    for (auto& [key, value] : classes_)
      if (value.parent == "main") value.parent = main_;
  }
  const std::string own = parent.empty() ? main_ : name;
  const auto [entry, is_new] = classes_.try_emplace(own);
  if (!parent.empty() && !is_new)
    file_.fail(element, "a second class " + inQuotes(own) + "; names must be unique");
  entry->second.parent = parent;
  std::vector<const XMLElement*> nested;
  file_.eachChild(element, [&](const XMLElement& child) {
    if (std::string_view(child.Name()) == "default") return nested.push_back(&child);
    checkAttributes(file_, child);
    // What is written later lies over what is written before.
    std::vector<const XMLElement*>& elements = classes_.at(own).elements;
    elements.insert(elements.begin(), &child);
  });
  for (const XMLElement* child : nested) read(*child, own);
}

void DefaultClasses::expectClass(const XMLElement& element, const char* attribute) const {
  const char* name = element.Attribute(attribute);
  if (name == nullptr || classes_.count(name) != 0) return;
  std::vector<std::string> names;
  for (const auto& [known, content] : classes_) names.push_back(known);
  const std::string nearest = suggestion(name, names);
  file_.fail(element,
             "the class " + inQuotes(name) + " of <" + element.Name() + "> is not defined; " +
                 (nearest.empty() ? "the class of a <default> would be accepted" : nearest));
}

Attributes DefaultClasses::of(const XMLElement& element, const std::string& childclass,
                              const char* tag) const {
  expectClass(element, "class");
  const char* own = element.Attribute("class");
  const std::string_view wanted = tag == nullptr ? element.Name() : tag;
  std::vector<const XMLElement*> levels = {&element};
  std::string name = own != nullptr ? own : childclass.empty() ? main_ : childclass;
  for (; !name.empty(); name = classes_.at(name).parent)
    for (const XMLElement* e : classes_.at(name).elements)
      if (e->Name() == wanted) levels.push_back(e);
  return {file_, std::move(levels)};
}

Eigen::Matrix3d rotationAbout(const Eigen::Vector3d& axis, double angle) {
  double sine, cosine;
  collision::sineCosine(angle, sine, cosine);
  const Eigen::Vector3d a = axis.normalized();
  Eigen::Matrix3d cross;
  cross << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return cosine * Eigen::Matrix3d::Identity() + sine * cross + (1 - cosine) * (a * a.transpose());
}

Eigen::Matrix3d rotationOfZ(const Eigen::Vector3d& direction) {
  Eigen::Vector3d u, v;
  const Eigen::Vector3d z = direction.normalized();
  planeAxes(z, u, v);
  Eigen::Matrix3d R;
  R << u, v, z;
  return R;
}

Eigen::Matrix3d rotationOf(const std::vector<double>& q) {
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
}

Pose poseOf(const Attributes& attributes, const MjcfSettings& settings) {
  Pose pose;
  pose.translation = attributes.vector("pos", Eigen::Vector3d::Zero());
  const char* given = nullptr;
  for (const char* name : {"quat", "axisangle", "euler", "xyaxes", "zaxis"}) {
    if (attributes.find(name) == nullptr) continue;
    if (given != nullptr)
      attributes.fail(name, "there is " + std::string(given) +
                                " already, by the element or its class; one orientation would be "
                                "accepted");
    given = name;
  }
  if (given == nullptr) return pose;
  const std::string kind = given;
  const auto numbers = [&](std::size_t count) { return *attributes.numbers(given, count); };
  const auto requireLength = [&](double length, const char* what) {
    if (!(length > 1e-12))
      attributes.fail(given, std::string(what) + " other than zero would be accepted");
  };
  if (kind == "quat") {
    const std::vector<double> q = numbers(4);
    requireLength(Eigen::Vector4d(q.data()).norm(), "a quaternion");
    pose.rotation = rotationOf(q);
  } else if (kind == "axisangle") {
    const std::vector<double> a = numbers(4);
    const Eigen::Vector3d axis(a.data());
    requireLength(axis.norm(), "an axis");
    pose.rotation = rotationAbout(axis, settings.angle(a[3]));
  } else if (kind == "euler") {
    pose.rotation = rotationOfEuler(numbers(3), settings);
  } else if (kind == "xyaxes") {
    pose.rotation = rotationOfAxes(attributes, numbers(6));
  } else {
    const Eigen::Vector3d z(numbers(3).data());
    requireLength(z.norm(), "an axis");
    pose.rotation = rotationOfZ(z);
  }
  return pose;
}

void checkAttributes(const MjcfFile& file, const XMLElement& element) {
  const std::string_view tag = element.Name();
  XmlFile& in = file.of(element);
  // The lists of MuJoCo's schema (src/xml/mjcf.schema), and of its versions before.
  // clang-format off
  if (tag == "compiler")
    in.allowAttributes(element, {"autolimits", "boundmass", "boundinertia", "settotalmass",
        "balanceinertia", "strippath", "coordinate", "angle", "fitaabb", "eulerseq", "meshdir",
        "texturedir", "discardvisual", "usethread", "fusestatic", "inertiafromgeom",
        "inertiagrouprange", "saveinertial", "assetdir", "alignfree", "conflict", "convexhull",
        "exactmeshinertia"});
  else if (tag == "body")
    in.allowAttributes(element, {"name", "childclass", "pos", "quat", "axisangle", "xyaxes",
        "zaxis", "euler", "mocap", "gravcomp", "sleep", "simple", "user"});
  else if (tag == "frame")
    in.allowAttributes(element, {"name", "childclass", "pos", "quat", "axisangle", "xyaxes",
        "zaxis", "euler"});
  else if (tag == "joint")
    in.allowAttributes(element, {"name", "class", "type", "group", "pos", "axis", "springdamper",
        "limited", "actuatorfrclimited", "solreflimit", "solimplimit", "solreffriction",
        "solimpfriction", "stiffness", "range", "actuatorfrcrange", "actuatorgravcomp", "margin",
        "ref", "springref", "armature", "damping", "frictionloss", "user"});
  else if (tag == "freejoint")
    in.allowAttributes(element, {"name", "group", "align"});
  else if (tag == "geom")
    in.allowAttributes(element, {"name", "class", "type", "contype", "conaffinity", "condim",
        "group", "priority", "size", "material", "friction", "mass", "density", "shellinertia",
        "solmix", "solref", "solimp", "margin", "gap", "surfacevel", "adhesion", "fromto", "pos",
        "quat", "axisangle", "xyaxes", "zaxis", "euler", "hfield", "mesh", "fitscale", "rgba",
        "fluidshape", "fluidcoef", "user"});
  else if (tag == "mesh")
    in.allowAttributes(element, {"name", "class", "content_type", "file", "vertex", "normal",
        "texcoord", "face", "refpos", "refquat", "scale", "smoothnormal", "maxhullvert", "inertia",
        "builtin", "params", "material", "octree_maxdepth"});
  else if (tag == "exclude")
    in.allowAttributes(element, {"name", "body1", "body2"});
  // clang-format on
}

}  // namespace leeway::robots
