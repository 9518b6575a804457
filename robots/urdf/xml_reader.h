#pragma once

#include <tinyxml2.h>

#include <Eigen/Core>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
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
  /// Reads and parses; `kind` is for messages, and says what the root element may be: "URDF"
  /// (<robot>, MuJoCo's <mujoco> or <sdf>), "SRDF" (<robot>), "SDF" (<sdf>), "model.config"
  /// (<model>), "MuJoCo" (any: of an included file).
  /// What ends in .xacro is expanded by `xacro`, and lines are those of its output; without that
  /// program, and for macros in other files, it is refused with the command that expands it.
  /// `options`: stop, errors and xacro.
  XmlFile(const std::string& path, const std::string& kind, const LoadOptions& options);

  const std::string& path() const { return path_; }
  bool gathersErrors() const { return errors_ != nullptr; }
  const tinyxml2::XMLElement& root() const { return *document_.RootElement(); }
  tinyxml2::XMLDocument& document() { return document_; }

  [[noreturn]] void fail(const tinyxml2::XMLElement& at, const std::string& message) const;
  /// Adds the warning "FILE:LINE: message".
  void warn(const tinyxml2::XMLElement& at, const std::string& message);
  /// Reports what is wrong with a part of the file that is left out because planning does not need
  /// it: an error that does not end the reading where errors are gathered, else a warning with
  /// `consequence` appended.
  void leaveOut(const InputError& error, const std::string& consequence);
  void leaveOut(const tinyxml2::XMLElement& at, const std::string& message);
  /// The warnings so far, in order; one that came again in other lines once, with their number.
  std::vector<std::string> takeWarnings();
  /// Calls visit(child) for every child element of that name; after an error with the next one
  /// where errors are gathered.
  template <typename Visit>
  void eachChild(const tinyxml2::XMLElement& parent, const char* name, const Visit& visit) const {
    for (const tinyxml2::XMLElement* child = parent.FirstChildElement(name); child != nullptr;
         child = child->NextSiblingElement(name))
      readOn(errors_, [&] { visit(*child); });
  }
  /// The same for the child elements of every name.
  template <typename Visit>
  void eachElement(const tinyxml2::XMLElement& parent, const Visit& visit) const {
    eachChild(parent, nullptr, visit);
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
  /// The text inside the element, without the white space around it.
  std::string text(const tinyxml2::XMLElement& element) const;
  /// The same as numbers separated by white space, all finite.
  std::vector<double> numbersOfText(const tinyxml2::XMLElement& element) const;

  /// The only child of that name, null when there is none; a second one is an error.
  const tinyxml2::XMLElement* onlyChild(const tinyxml2::XMLElement& parent, const char* name) const;
  const tinyxml2::XMLElement& requiredChild(const tinyxml2::XMLElement& parent,
                                            const char* name) const;
  enum class Misspelt { kRefused, kLeftOut };
  /// Leaves out attributes other than these. One that seems to be a misspelt name of these is an
  /// error, unless `misspelt` says otherwise.
  void knownAttributes(const tinyxml2::XMLElement& element, const std::vector<std::string>& names,
                       Misspelt misspelt = Misspelt::kRefused);
  /// The same, and leaves out text inside the element.
  void allowAttributes(const tinyxml2::XMLElement& element, const std::vector<std::string>& names,
                       Misspelt misspelt = Misspelt::kRefused);
  /// The same of an element that has attributes alone: leaves out its children, too. One with the
  /// name of an attribute is an error, unless `misspelt` says otherwise.
  void expectAttributes(const tinyxml2::XMLElement& element, const std::vector<std::string>& names,
                        Misspelt misspelt = Misspelt::kRefused);
  /// Leaves out the children of `parent` that are in neither list. One that seems to be a misspelt
  /// name of the first, which bear on motion and collision, is an error.
  void leaveOutUnknown(const tinyxml2::XMLElement& parent,
                       std::initializer_list<std::string_view> used,
                       std::initializer_list<std::string_view> unused);
  /// Names each shape that is not read: a <collision> with a <geometry>, or a <geometry> that is
  /// not a visual's, outside of links. A link counts if only elements of these names are around it.
  /// Shapes in parts that are already left out are not named again.
  void leaveOutShapesBeyond(const std::vector<std::string_view>& around_links) {
    leaveOutShapesIn(root(), around_links);
  }

 private:
  struct Seen {
    std::size_t place;  // in warnings_
    int more = 0;       // places that it came from again
  };
  std::vector<double> parsed(const tinyxml2::XMLElement& element, const std::string& what,
                             const std::string& text) const;
  void leaveOutShapesIn(const tinyxml2::XMLElement& parent,
                        const std::vector<std::string_view>& around_links);

  std::string path_;
  InputErrors* errors_;
  tinyxml2::XMLDocument document_;
  std::vector<std::string> warnings_;
  std::map<std::string, Seen> left_out_;         // by the warning's text, without its line
  std::set<const tinyxml2::XMLElement*> named_;  // in warnings that leave something out
};

/// Whether a name has the prefix of an XML namespace. URDF and SRDF have none: it is an extension.
bool isExtension(std::string_view name);

/// "text", quotes included.
std::string inQuotes(std::string_view text);

/// `Did you mean "..."?` for the candidate nearest to `wanted` in edit distance, or the empty
/// string when none is near.
std::string suggestion(std::string_view wanted, std::span<const std::string> candidates);

}  // namespace leeway::robots
