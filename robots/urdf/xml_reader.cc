#include "robots/urdf/xml_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "leeway/robots/text.h"
#include "robots/base/read_file.h"
#include "robots/urdf/xacro.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

constexpr std::string_view kSpace = " \t\r\n";

std::string expandCommand(const std::string& path, const std::string& kind) {
  const std::filesystem::path source(path);
  const std::string extension = kind == "SRDF" ? ".srdf" : ".urdf";
  std::filesystem::path target = source;
  if (target.extension() == ".xacro") target.replace_extension();
  if (target.extension() != extension || target == source)
    target.replace_extension(".expanded" + extension);
  return "expand it first: xacro " + path + " > " + target.string();
}

const XMLElement* findXacro(const XMLElement& element) {
  if (std::strncmp(element.Name(), "xacro:", 6) == 0) return &element;
  for (const XMLElement* child = element.FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement())
    if (const XMLElement* found = findXacro(*child)) return found;
  return nullptr;
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
  if (std::filesystem::path(path).extension() == ".xacro") {
    std::optional<std::string> expanded = expandXacro(path, options.stop);
    if (!expanded)
      throw InputError(path, 0,
                       "is a xacro file, which holds macros and no " + kind +
                           ", and no xacro is installed; " + expandCommand(path, kind));
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
    throw InputError(path, 0, "holds no element; a " + kind + " file has <robot>");
  if (std::strcmp(root().Name(), "robot") != 0)
    fail(root(), "the root element is <" + std::string(root().Name()) + ">; a " + kind +
                     " file has <robot>");
  // TinyXML2 accepts more elements after the root.
  if (const XMLElement* second = root().NextSiblingElement())
    fail(*second, "a second root element, <" + std::string(second->Name()) + ">; a " + kind +
                      " file has one <robot>");
  if (const XMLElement* xacro = findXacro(root()))
    fail(*xacro, "<" + std::string(xacro->Name()) + "> is a xacro macro, which a " + kind +
                     " cannot hold; " + expandCommand(path, kind));
}

void XmlFile::fail(const XMLElement& at, const std::string& message) const {
  throw InputError(path_, at.GetLineNum(), message);
}

std::string XmlFile::locate(const XMLElement& at, const std::string& message) const {
  return path_ + ":" + std::to_string(at.GetLineNum()) + ": " + message;
}

std::string XmlFile::attribute(const XMLElement& element, const char* name) const {
  const char* text = element.Attribute(name);
  if (text == nullptr || *text == '\0')
    fail(element, "<" + std::string(element.Name()) + "> has no " + name + "; " + name +
                      "=\"...\" is needed");
  return text;
}

std::vector<double> XmlFile::numbers(const XMLElement& element, const char* name) const {
  const std::string text = attribute(element, name);
  std::vector<double> values;
  for (std::size_t begin = text.find_first_not_of(kSpace); begin != std::string::npos;
       begin = text.find_first_not_of(kSpace, begin)) {
    const std::size_t end = std::min(text.find_first_of(kSpace, begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const std::optional<double> value = parseFinite(word);
    if (!value)
      fail(element, std::string(name) + " of <" + element.Name() + "> holds " + inQuotes(word) +
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

void XmlFile::allowAttributes(const XMLElement& element,
                              std::initializer_list<const char*> names) const {
  for (const tinyxml2::XMLAttribute* a = element.FirstAttribute(); a != nullptr; a = a->Next()) {
    const auto known = [&](const char* name) { return std::strcmp(name, a->Name()) == 0; };
    if (std::any_of(names.begin(), names.end(), known) || std::strncmp(a->Name(), "xmlns", 5) == 0)
      continue;
    std::string list;
    for (const char* name : names) list += (list.empty() ? "" : ", ") + std::string(name);
    throwOrKeep(InputError(path_, a->GetLineNum(),
                           "<" + std::string(element.Name()) + "> has the unknown attribute " +
                               inQuotes(a->Name()) + "; known are: " + list),
                errors_);
  }
}

}  // namespace leeway::robots
