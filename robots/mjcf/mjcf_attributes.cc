#include "robots/mjcf/mjcf_attributes.h"

#include <algorithm>
#include <cmath>
#include <span>

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

}  // namespace

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
  }
  const std::string own = parent.empty() ? main_ : name;
  const auto [entry, is_new] = classes_.try_emplace(own);
  if (!parent.empty() && !is_new)
    file_.fail(element, "a second class " + inQuotes(own) + "; names must be unique");
  if (!parent.empty()) entry->second = classes_.at(parent);
  std::vector<const XMLElement*> nested;
  file_.eachChild(element, [&](const XMLElement& child) {
    if (std::string_view(child.Name()) == "default") return nested.push_back(&child);
    checkAttributes(file_, child);
    // Later elements of a class overwrite earlier ones.
    std::vector<const XMLElement*>& elements = classes_.at(own);
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
  for (const XMLElement* e : classes_.at(own != nullptr       ? own
                                         : childclass.empty() ? main_
                                                              : childclass))
    if (e->Name() == wanted) levels.push_back(e);
  return {file_, std::move(levels)};
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
  else if (tag == "flag")
    in.allowAttributes(element, {"constraint", "equality", "frictionloss", "limit", "contact",
        "passive", "spring", "damper", "gravity", "clampctrl", "warmstart", "filterparent",
        "actuation", "refsafe", "sensor", "midphase", "nativeccd", "eulerdamp", "autoreset",
        "island", "sleep", "override", "energy", "fwdinv", "invdiscrete", "multiccd"});
  else if (tag == "worldbody")
    in.allowAttributes(element, {"childclass"});
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
  else if (tag == "key")
    in.allowAttributes(element, {"name", "time", "qpos", "qvel", "act", "ctrl", "mpos", "mquat"});
  // clang-format on
}

}  // namespace leeway::robots
