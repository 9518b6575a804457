#pragma once

#include <tinyxml2.h>

#include <Eigen/Core>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/robots/input_error.h"
#include "leeway/robots/model.h"
#include "robots/base/read_on.h"

namespace leeway::robots {

/// An XML file in memory, with readers for robot descriptions. All throw InputError with file and
/// line.
class XmlFile {
 public:
  /// Reads and parses; `kind` ("URDF", "SRDF") and the root element's name are for messages.
  /// What ends in .xacro is expanded by `xacro`, and lines are those of its output; without that
  /// program, and for macros in other files, it is refused with the command that expands it.
  /// `options`: stop and errors.
  XmlFile(const std::string& path, const std::string& kind, const LoadOptions& options);

  const std::string& path() const { return path_; }
  const tinyxml2::XMLElement& root() const { return *document_.RootElement(); }
  tinyxml2::XMLDocument& document() { return document_; }

  [[noreturn]] void fail(const tinyxml2::XMLElement& at, const std::string& message) const;
  /// "FILE:LINE: message", for warnings.
  std::string locate(const tinyxml2::XMLElement& at, const std::string& message) const;
  /// Calls visit(child) for every child element of that name; after an error with the next one
  /// where errors are gathered.
  template <typename Visit>
  void eachChild(const tinyxml2::XMLElement& parent, const char* name, const Visit& visit) const {
    for (const tinyxml2::XMLElement* child = parent.FirstChildElement(name); child != nullptr;
         child = child->NextSiblingElement(name))
      readOn(errors_, [&] { visit(*child); });
  }

  /// The attribute's text; must be there and not empty.
  std::string attribute(const tinyxml2::XMLElement& element, const char* name) const;
  /// The attribute as one finite number; nothing when it is not there.
  std::optional<double> number(const tinyxml2::XMLElement& element, const char* name) const;
  double requiredNumber(const tinyxml2::XMLElement& element, const char* name) const;
  /// The attribute as exactly three finite numbers.
  std::optional<Eigen::Vector3d> vector(const tinyxml2::XMLElement& element,
                                        const char* name) const;
  /// Numbers separated by white space, all finite.
  std::vector<double> numbers(const tinyxml2::XMLElement& element, const char* name) const;

  /// The only child of that name, null when there is none; a second one is an error.
  const tinyxml2::XMLElement* onlyChild(const tinyxml2::XMLElement& parent, const char* name) const;
  const tinyxml2::XMLElement& requiredChild(const tinyxml2::XMLElement& parent,
                                            const char* name) const;
  /// An attribute that is not among the given names is an error that lists them.
  void allowAttributes(const tinyxml2::XMLElement& element,
                       std::initializer_list<const char*> names) const;

 private:
  std::string path_;
  InputErrors* errors_;
  tinyxml2::XMLDocument document_;
};

/// "text", quotes included.
std::string inQuotes(std::string_view text);

/// `Did you mean "..."?` for the candidate nearest to `wanted` in edit distance, or the empty
/// string when none is near.
std::string suggestion(std::string_view wanted, std::span<const std::string> candidates);

}  // namespace leeway::robots
