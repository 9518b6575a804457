#include "robots/urdf/xml_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <utility>

#include "leeway/robots/text.h"
#include "robots/base/read_file.h"
#include "robots/urdf/xacro.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

constexpr std::string_view kSpace = " \t\r\n";

bool isXacroMacro(const XMLElement& element) {
  return std::strncmp(element.Name(), "xacro:", 6) == 0;
}

std::string expandCommand(const std::string& path, const std::string& kind) {
  const std::filesystem::path source(path);
  const std::string extension = kind == "SRDF" ? ".srdf" : ".urdf";
  std::filesystem::path target = source;
  if (target.extension() == ".xacro") target.replace_extension();
  if (target.extension() != extension || target == source)
    target.replace_extension(".expanded" + extension);
  return "xacro " + path + " > " + target.string();
}

/// Whether an element is XInclude's, by its prefix or its namespace.
bool isInclusion(const XMLElement& element) {
  const std::string_view name = element.Name();
  if (name == "xi:include") return true;
  if (name != "include" && !name.ends_with(":include")) return false;
  const std::string_view prefix = name.substr(0, name.size() - std::strlen("include"));
  const std::string key =
      prefix.empty() ? "xmlns" : "xmlns:" + std::string(prefix.substr(0, prefix.size() - 1));
  for (const tinyxml2::XMLNode* at = &element; at != nullptr; at = at->Parent())
    if (const XMLElement* open = at->ToElement())
      if (const char* space = open->Attribute(key.c_str()))
        return std::strstr(space, "XInclude") != nullptr;
  return false;
}

/// The first element that stands for others: a macro of xacro, or an inclusion (XInclude).
const XMLElement* findPlaceholder(const XMLElement& element) {
  if (isXacroMacro(element) || isInclusion(element)) return &element;
  for (const XMLElement* child = element.FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement())
    if (const XMLElement* found = findPlaceholder(*child)) return found;
  return nullptr;
}

/// Whether a <collision>, or a <geometry> in one, is in a link with only elements of these names
/// around it; true of a visual's <geometry>, too.
bool isShapeOfLink(const XMLElement& shape, const std::vector<std::string_view>& around_links) {
  const auto tag = [](const tinyxml2::XMLNode* node) {
    return std::string_view(node->ToElement() == nullptr ? "" : node->Value());
  };
  const tinyxml2::XMLNode* at = &shape;
  if (tag(at) == "geometry") at = at->Parent();
  if (tag(at) == "visual") return true;
  if (tag(at) != "collision" || tag(at->Parent()) != "link") return false;
  for (at = at->Parent()->Parent(); at->ToElement() != nullptr; at = at->Parent())
    if (std::find(around_links.begin(), around_links.end(), tag(at)) == around_links.end())
      return false;
  return true;
}

/// Whether there may be several elements of that name beside each other.
bool isList(std::string_view name) {
  return name == "link" || name == "joint" || name == "collision" || name == "frame" ||
         name == "model" || name == "include";
}

}  // namespace

std::string inQuotes(std::string_view text) { return '"' + std::string(text) + '"'; }

std::string suggestion(std::string_view wanted, std::span<const std::string> candidates) {
  const std::string* nearest = nearestName(wanted, candidates);
  return nearest == nullptr ? "" : "did you mean " + inQuotes(*nearest) + "?";
}

XmlFile::XmlFile(const std::string& path, const std::string& kind, const LoadOptions& options)
    : path_(path), errors_(options.errors) {
  std::string text = readTextFile(path, "a " + kind + " file");
  if (isXacro(path)) {
    std::optional<std::string> expanded = expandXacro(path, options.xacro, options.stop);
    if (!expanded)
      throw InputError(path, 0,
                       "is a xacro file, which holds macros and no " + kind +
                           ", and no xacro is installed: `pip install xacro` or the package "
                           "ros-DISTRO-xacro of ROS brings it; or expand it elsewhere: " +
                           expandCommand(path, kind));
    text = std::move(*expanded);
  }
  if (text.empty()) throw InputError(path, 0, "is empty; a " + kind + " file would be accepted");
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == std::string::npos || text[first] != '<')
    throw InputError(
        path, 0,
        "is no XML, as it does not begin with \"<\"; a " + kind + " file would be accepted");
  if (document_.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    const std::string name = tinyxml2::XMLDocument::ErrorIDToName(document_.ErrorID());
    throw InputError(path, document_.ErrorLineNum(),
                     "XML syntax error (" + name + "); well-formed XML would be accepted");
  }
  if (document_.RootElement() == nullptr)
    throw InputError(path, 0, "holds no element; a " + kind + " file would be accepted");
  const std::string name = root().Name();
  const bool is_robot = kind == "URDF";
  const std::string expected = kind == "SDF" ? "sdf" : kind == "model.config" ? "model" : "robot";
  // (SDF 1.2 has <gazebo>.)
  const bool is_sdf = (is_robot || kind == "SDF") && (name == "sdf" || name == "gazebo");
  if (kind != "MuJoCo" && name != expected && !is_sdf && !(is_robot && name == "mujoco"))
    fail(root(), "the root element is <" + name + ">; a " + kind + " file has <" + expected + ">" +
                     (is_robot ? ", an MJCF file <mujoco>, an SDF file <sdf>" : ""));
  // TinyXML2 accepts more elements after the root.
  if (const XMLElement* second = root().NextSiblingElement())
    fail(*second, "a second root element, <" + std::string(second->Name()) + ">; a " + kind +
                      " file has one <" + name + ">");
  if (const XMLElement* found = findPlaceholder(root())) {
    const std::string tag = "<" + std::string(found->Name()) + ">";
    fail(*found, isXacroMacro(*found)
                     ? tag + " is a xacro macro, which a " + kind +
                           " cannot hold; expand it first: " + expandCommand(path, kind)
                     : tag + " brings in what is not in this file; a " + kind +
                           " file that holds all of it would be accepted");
  }
}

void XmlFile::fail(const XMLElement& at, const std::string& message) const {
  throw InputError(path_, at.GetLineNum(), message);
}

void XmlFile::warn(const XMLElement& at, const std::string& message) {
  warnings_.emplace_back(InputError(path_, at.GetLineNum(), message).what());
}

void XmlFile::leaveOut(const InputError& error, const std::string& consequence) {
  if (errors_ != nullptr) {
    if (!errors_->note(error)) throw InputError(error);
    return;
  }
  const std::string warning = error.what() + consequence;
  const std::string place = path_ + ":" + std::to_string(error.line()) + ": ";
  const std::string text = warning.starts_with(place) ? warning.substr(place.size()) : warning;
  const auto [entry, is_new] = left_out_.try_emplace(text, Seen{warnings_.size()});
  if (is_new)
    warnings_.push_back(warning);
  else
    ++entry->second.more;
}

void XmlFile::leaveOut(const XMLElement& at, const std::string& message) {
  named_.insert(&at);
  leaveOut(InputError(path_, at.GetLineNum(), message), "");
}

std::vector<std::string> XmlFile::takeWarnings() {
  for (const auto& [text, seen] : left_out_)
    if (seen.more > 0)
      warnings_[seen.place] += " (and in " + std::to_string(seen.more) +
                               (seen.more == 1 ? " more place)" : " more places)");
  left_out_.clear();
  return std::exchange(warnings_, {});
}

std::string XmlFile::attribute(const XMLElement& element, const char* name) const {
  const char* text = element.Attribute(name);
  if (text == nullptr || *text == '\0')
    fail(element, "<" + std::string(element.Name()) + "> has no " + name + "; " + name +
                      "=\"...\" is needed");
  return text;
}

std::vector<double> XmlFile::numbers(const XMLElement& element, const char* name) const {
  return parsed(element, std::string(name) + " of ", attribute(element, name));
}

std::vector<double> XmlFile::numbersOfText(const XMLElement& element) const {
  return parsed(element, "", text(element));
}

std::string XmlFile::text(const XMLElement& element) const {
  std::string text;
  for (const tinyxml2::XMLNode* child = element.FirstChild(); child != nullptr;
       child = child->NextSibling())
    if (child->ToText() != nullptr) text += child->Value();
  text.erase(text.find_last_not_of(kSpace) + 1);
  text.erase(0, std::min(text.find_first_not_of(kSpace), text.size()));
  return text;
}

std::vector<double> XmlFile::parsed(const XMLElement& element, const std::string& what,
                                    const std::string& text) const {
  std::vector<double> values;
  for (std::size_t begin = text.find_first_not_of(kSpace); begin != std::string::npos;
       begin = text.find_first_not_of(kSpace, begin)) {
    const std::size_t end = std::min(text.find_first_of(kSpace, begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const std::optional<double> value = parseFinite(word);
    if (!value)
      fail(element, what + "<" + element.Name() + "> holds " + inQuotes(word) +
                        "; a finite number would be accepted");
    values.push_back(*value);
    begin = end;
  }
  return values;
}

std::optional<double> XmlFile::number(const XMLElement& element, const char* name) const {
  if (element.Attribute(name) == nullptr) return std::nullopt;
  const std::vector<double> values = numbers(element, name);
  if (values.size() != 1)
    fail(element, std::string(name) + " of <" + element.Name() + "> is " +
                      inQuotes(element.Attribute(name)) + "; one number would be accepted");
  return values.front();
}

double XmlFile::requiredNumber(const XMLElement& element, const char* name) const {
  attribute(element, name);
  return *number(element, name);
}

std::optional<Eigen::Vector3d> XmlFile::vector(const XMLElement& element, const char* name) const {
  if (element.Attribute(name) == nullptr) return std::nullopt;
  const std::vector<double> values = numbers(element, name);
  if (values.size() != 3)
    fail(element, std::string(name) + " of <" + element.Name() + "> is " +
                      inQuotes(element.Attribute(name)) + ", " + std::to_string(values.size()) +
                      " numbers; three would be accepted");
  return Eigen::Vector3d(values[0], values[1], values[2]);
}

const XMLElement* XmlFile::onlyChild(const XMLElement& parent, const char* name) const {
  const XMLElement* child = parent.FirstChildElement(name);
  if (child != nullptr)
    if (const XMLElement* second = child->NextSiblingElement(name))
      fail(*second, "a second <" + std::string(name) + "> in <" + parent.Name() +
                        ">, the first is in line " + std::to_string(child->GetLineNum()) +
                        "; one would be accepted");
  return child;
}

const XMLElement& XmlFile::requiredChild(const XMLElement& parent, const char* name) const {
  const XMLElement* child = onlyChild(parent, name);
  if (child == nullptr)
    fail(parent,
         "<" + std::string(parent.Name()) + "> has no <" + name + ">; exactly one is needed");
  return *child;
}

void XmlFile::knownAttributes(const XMLElement& element, const std::vector<std::string>& known,
                              Misspelt misspelt) {
  std::string list;
  for (const std::string& name : known) list += (list.empty() ? "" : ", ") + name;
  for (const tinyxml2::XMLAttribute* a = element.FirstAttribute(); a != nullptr; a = a->Next()) {
    const std::string name = a->Name();
    if (std::find(known.begin(), known.end(), name) != known.end() || name.starts_with("xmlns"))
      continue;
    const std::string message =
        "<" + std::string(element.Name()) + "> has the unknown attribute " + inQuotes(name);
    // Where the nearest name is given, too, this one is hardly meant for it.
    const std::string* meant =
        isExtension(name) || misspelt == Misspelt::kLeftOut ? nullptr : nearestName(name, known);
    if (meant != nullptr && element.Attribute(meant->c_str()) == nullptr)
      throwOrKeep(
          InputError(path_, a->GetLineNum(),
                     message + "; did you mean " + inQuotes(*meant) + "? Known are: " + list),
          errors_);
    else
      leaveOut(InputError(path_, a->GetLineNum(), message + ", which is left out"), "");
  }
}

void XmlFile::allowAttributes(const XMLElement& element, const std::vector<std::string>& known,
                              Misspelt misspelt) {
  knownAttributes(element, known, misspelt);
  for (const tinyxml2::XMLNode* child = element.FirstChild(); child != nullptr;
       child = child->NextSibling()) {
    if (child->ToText() == nullptr) continue;
    const std::string_view text = child->Value();
    const std::size_t first = text.find_first_not_of(kSpace);
    if (first == std::string_view::npos) continue;
    constexpr std::size_t kShown = 40;
    leaveOut(InputError(path_, child->GetLineNum(),
                        "<" + std::string(element.Name()) + "> holds the text " +
                            inQuotes(text.substr(first, text.find_last_not_of(kSpace) + 1 - first)
                                         .substr(0, kShown)) +
                            ", which is left out"),
             "");
  }
}

void XmlFile::expectAttributes(const XMLElement& element, const std::vector<std::string>& known,
                               Misspelt misspelt) {
  allowAttributes(element, known, misspelt);
  for (const XMLElement* child = element.FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement()) {
    const std::string name = child->Name();
    const std::string message = "<" + name + "> in <" + element.Name() + "> is not known";
    if (misspelt == Misspelt::kRefused &&
        std::find(known.begin(), known.end(), name) != known.end())
      throwOrKeep(InputError(path_, child->GetLineNum(),
                             message + "; the attribute " + name + "=\"...\" would be accepted"),
                  errors_);
    else
      leaveOut(*child, message + " and is left out");
  }
}

void XmlFile::leaveOutUnknown(const XMLElement& parent,
                              std::initializer_list<std::string_view> used,
                              std::initializer_list<std::string_view> unused) {
  const std::vector<std::string> known(used.begin(), used.end());
  for (const XMLElement* child = parent.FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement()) {
    const std::string name = child->Name();
    if (std::find(known.begin(), known.end(), name) != known.end() ||
        std::find(unused.begin(), unused.end(), name) != unused.end())
      continue;
    const std::string message = "<" + name + "> in <" + parent.Name() + "> is not known";
    const std::string* meant = isExtension(name) ? nullptr : nearestName(name, known);
    if (meant != nullptr && (isList(*meant) || !parent.FirstChildElement(meant->c_str())))
      throwOrKeep(
          InputError(path_, child->GetLineNum(), message + "; did you mean <" + *meant + ">?"),
          errors_);
    else
      leaveOut(*child, message + " and is left out");
  }
}

void XmlFile::leaveOutShapesIn(const XMLElement& parent,
                               const std::vector<std::string_view>& around_links) {
  for (const XMLElement* child = parent.FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement()) {
    if (named_.contains(child)) continue;
    const std::string name = child->Name();
    const bool is_geometry = name == "geometry";
    if ((is_geometry || (name == "collision" && child->FirstChildElement("geometry"))) &&
        !isShapeOfLink(*child, around_links)) {
      const bool is_in_link = std::string_view(parent.Name()) == "link";  // a misplaced one
      const char* in = (is_in_link ? parent.Parent() : &parent)->Value();
      leaveOut(*child, "<" + name + "> in <" + in + "> is left out; one in a " +
                           (is_geometry ? "<collision>" : "<link>") + " would be read");
    } else {
      leaveOutShapesIn(*child, around_links);
    }
  }
}

bool isExtension(std::string_view name) { return name.find(':') != std::string_view::npos; }

}  // namespace leeway::robots
