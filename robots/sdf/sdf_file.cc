#include "robots/sdf/sdf_file.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "robots/base/read_file.h"
#include "robots/base/tolerances.h"
#include "robots/mesh/mesh_path.h"
#include "robots/urdf/rotation.h"
#include "robots/urdf/urdf_document.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

constexpr int kOldest = 2, kNewest = 12;  // versions 1.2 to 1.12

/// 7 for "1.7"; -1 for other versions than are read.
int minorOf(const std::string& version) {
  for (int minor = kOldest; minor <= kNewest; ++minor)
    if (version == "1." + std::to_string(minor)) return minor;
  return -1;
}

int versionOf(const XmlFile& file) {
  const std::string version = file.attribute(file.root(), "version");
  const int minor = minorOf(version);
  if (minor < 0)
    file.fail(file.root(),
              "the version of <sdf> is " + inQuotes(version) + "; 1.2 to 1.12 would be accepted");
  return minor;
}

std::vector<double> numbersOf(const XmlFile& file, const XMLElement& element, std::size_t count) {
  const std::string tag = element.Name();
  std::vector<double> values = file.numbersOfText(element);
  if (values.size() != count)
    file.fail(element, "<" + tag + "> holds " + inQuotes(file.text(element)) + "; " +
                           std::to_string(count) + (count == 1 ? " number" : " numbers") +
                           " would be accepted");
  for (const double value : values)
    if (!(std::abs(value) <= kFarthestOrigin))
      file.fail(element, "<" + tag + "> holds " + inQuotes(file.text(element)) +
                             "; numbers from -1e9 to 1e9 would be accepted");
  return values;
}

}  // namespace

SdfFiles::SdfFiles(XmlFile& main, const LoadOptions& options)
    : options_(options), main_{&main, versionOf(main)} {}

const SdfSource& SdfFiles::include(const SdfSource& from, const XMLElement& uri) {
  const std::string name = from.file->text(uri), ending = endingOf(name);
  if (ending == ".urdf")
    from.file->fail(uri, "<include> names the URDF " + inQuotes(name) +
                             "; an SDF would be accepted, `gz sdf -p` makes one of it");
  const auto found = [&](const std::string& what) {
    return resolveFile(what, "model", from.file->path(), uri.GetLineNum(), options_, &warnings_);
  };
  const bool is_file = ending == ".sdf" || ending == ".xml" || ending == ".world";
  const std::string folder = name.substr(0, name.find_last_not_of('/') + 1);
  const std::string path = is_file ? found(name) : fileIn(found(folder + "/model.config"));
  const auto [entry, is_new] = sources_.try_emplace(path);
  if (is_new) {
    read_.push_back(std::make_unique<XmlFile>(path, "SDF", options_));
    entry->second.file = read_.back().get();
    entry->second.minor = versionOf(*read_.back());
  }
  return entry->second;
}

std::string SdfFiles::fileIn(const std::string& config) const {
  const XmlFile file(config, "model.config", options_);
  const XMLElement* newest = nullptr;
  int version = -1;
  for (const XMLElement* e = file.root().FirstChildElement("sdf"); e != nullptr;
       e = e->NextSiblingElement("sdf")) {
    // (A model that names one file may leave the version out.)
    const char* written = e->Attribute("version");
    const int minor = written == nullptr ? kOldest : minorOf(written);
    if (minor > version) {
      newest = e;
      version = minor;
    }
  }
  if (newest == nullptr)
    file.fail(file.root(),
              "it names no SDF of a version that is read; <sdf "
              "version=\"1.7\">model.sdf</sdf> would be accepted, 1.2 to 1.12");
  return resolveFile(file.text(*newest), "model", config, newest->GetLineNum(), options_);
}

void SdfFiles::leaveOutShapesBeyondLinks() {
  const std::vector<std::string_view> around = {"model", "world", "sdf", "gazebo"};
  main_.file->leaveOutShapesBeyond(around);
  for (const std::unique_ptr<XmlFile>& file : read_) file->leaveOutShapesBeyond(around);
}

std::vector<std::string> SdfFiles::takeWarnings() {
  std::vector<std::string> all = main_.file->takeWarnings();
  for (std::string& warning : std::exchange(warnings_, {})) all.push_back(std::move(warning));
  for (const std::unique_ptr<XmlFile>& file : read_)
    for (std::string& warning : file->takeWarnings()) all.push_back(std::move(warning));
  return all;
}

SdfPose poseIn(const SdfSource& source, const XMLElement& parent) {
  XmlFile& file = *source.file;
  SdfPose pose;
  pose.element = file.onlyChild(parent, "pose");
  if (pose.element == nullptr) return pose;
  const XMLElement& e = *pose.element;
  std::vector<std::string> known = {"relative_to", "rotation_format", "degrees"};
  if (const char* base = e.Attribute("relative_to")) pose.relative_to = base;
  if (source.minor <= 6) {  // SDF 1.5 and 1.6 call it so
    known.emplace_back("frame");
    if (const char* base = e.Attribute("frame")) pose.relative_to = base;
  }
  for (const char* wrong : {"xyz", "rpy"})
    if (e.Attribute(wrong) != nullptr)
      file.fail(e, std::string("<pose> has the attribute ") + wrong +
                       "; its values as text, x y z roll pitch yaw, would be accepted");
  file.knownAttributes(e, known);
  file.leaveOutUnknown(e, {}, {});
  const char* format = e.Attribute("rotation_format");
  const std::string rotation = format == nullptr || *format == '\0' ? "euler_rpy" : format;
  const bool is_quaternion = rotation == "quat_xyzw";
  if (!is_quaternion && rotation != "euler_rpy")
    file.fail(e, "rotation_format of <pose> is " + inQuotes(rotation) +
                     "; euler_rpy or quat_xyzw would be accepted");
  const char* unit = e.Attribute("degrees");
  const bool degrees = unit != nullptr && flagOf(file, e, unit);
  if (is_quaternion && degrees)
    file.fail(e, "<pose> has degrees and a quaternion; one of them would be accepted");
  if (file.text(e).empty()) return pose;  // as if it were not there
  const std::vector<double> values = numbersOf(file, e, is_quaternion ? 7 : 6);
  pose.X.translation = Eigen::Vector3d(values.data());
  if (!is_quaternion) {
    const double scale = degrees ? std::numbers::pi / 180 : 1;
    pose.X.rotation = rollPitchYaw(scale * Eigen::Vector3d(values.data() + 3));
    return pose;
  }
  if (!(Eigen::Vector4d(values.data() + 3).norm() > 1e-12))
    file.fail(e, "the quaternion of <pose> is zero; another one would be accepted");
  pose.X.rotation = rotationOf({values[6], values[3], values[4], values[5]});
  return pose;
}

void expectOnly(XmlFile& file, const XMLElement& element,
                const std::vector<std::string>& attributes,
                std::initializer_list<std::string_view> used,
                std::initializer_list<std::string_view> unused) {
  for (const std::string_view child : used) {
    const std::string name(child);
    const char* value = element.Attribute(name.c_str());
    if (value != nullptr &&
        std::find(attributes.begin(), attributes.end(), name) == attributes.end())
      file.fail(element, "<" + std::string(element.Name()) + "> has the attribute " +
                             inQuotes(name + "=\"" + value + "\"") + "; <" + name + ">" + value +
                             "</" + name + "> would be accepted");
  }
  file.allowAttributes(element, attributes);
  file.leaveOutUnknown(element, used, unused);
}

void leaveOutChildren(XmlFile& file, const XMLElement& parent, const char* name,
                      const std::string& consequence) {
  file.eachChild(parent, name, [&](const XMLElement& e) {
    file.leaveOut(
        e, "<" + std::string(name) + "> in <" + parent.Name() + "> is left out: " + consequence);
  });
}

const XMLElement* leafIn(XmlFile& file, const XMLElement& parent, const char* name,
                         const std::vector<std::string>& attributes) {
  const XMLElement* leaf = file.onlyChild(parent, name);
  if (leaf == nullptr) return nullptr;
  file.knownAttributes(*leaf, attributes);
  file.leaveOutUnknown(*leaf, {}, {});
  return leaf;
}

std::string textIn(XmlFile& file, const XMLElement& parent, const char* name) {
  const XMLElement* child = leafIn(file, parent, name);
  return child == nullptr ? "" : file.text(*child);
}

std::optional<std::vector<double>> numbersIn(XmlFile& file, const XMLElement& parent,
                                             const char* name, std::size_t count) {
  const XMLElement* child = leafIn(file, parent, name);
  if (child == nullptr) return std::nullopt;
  return numbersOf(file, *child, count);
}

Eigen::Vector3d vectorOf(const XmlFile& file, const XMLElement& element) {
  return Eigen::Vector3d(numbersOf(file, element, 3).data());
}

Eigen::Vector3d vectorIn(XmlFile& file, const XMLElement& parent, const char* name,
                         const Eigen::Vector3d& otherwise) {
  const XMLElement* child = leafIn(file, parent, name);
  return child == nullptr ? otherwise : vectorOf(file, *child);
}

double numberIn(XmlFile& file, const XMLElement& parent, const char* name, double otherwise) {
  const auto values = numbersIn(file, parent, name, 1);
  return values ? values->front() : otherwise;
}

double sizeIn(XmlFile& file, const XMLElement& parent, const char* name) {
  static_cast<void>(file.requiredChild(parent, name));
  const XMLElement& child = *leafIn(file, parent, name);
  const double size = numbersOf(file, child, 1).front();
  if (!(size >= 0))
    file.fail(child, std::string("<") + name + "> of <" + parent.Name() + "> is " +
                         inQuotes(file.text(child)) + "; zero or more would be accepted");
  return size;
}

bool flagOf(const XmlFile& file, const XMLElement& at, const std::string& text) {
  std::string lower = text;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  if (lower == "true" || lower == "1") return true;
  if (lower != "false" && lower != "0")
    file.fail(at, "<" + std::string(at.Name()) + "> has " + inQuotes(text) +
                      "; true or false would be accepted");
  return false;
}

bool flagIn(XmlFile& file, const XMLElement& parent, const char* name, bool otherwise) {
  const XMLElement* child = leafIn(file, parent, name);
  return child == nullptr ? otherwise : flagOf(file, *child, file.text(*child));
}

}  // namespace leeway::robots
