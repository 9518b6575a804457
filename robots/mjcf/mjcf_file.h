#pragma once

// Private to robots/mjcf: an MJCF file with all that it includes.

#include <tinyxml2.h>

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/robots/model.h"
#include "robots/base/read_on.h"
#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

/// An MJCF file, in which <include> stands for the contents of the file that it names.
class MjcfFile {
 public:
  /// Reads the included files. `main` must outlive this. Throws InputError.
  MjcfFile(XmlFile& main, const LoadOptions& options);

  const XmlFile& main() const { return main_; }
  const LoadOptions& options() const { return options_; }
  /// The file that an element is in.
  XmlFile& of(const tinyxml2::XMLElement& element) const {
    return *files_.at(element.GetDocument());
  }
  [[noreturn]] void fail(const tinyxml2::XMLElement& at, const std::string& message) const {
    of(at).fail(at, message);
  }
  /// Fails: `at` names a `what` that is not among the `known` ones.
  [[noreturn]] void failUnknown(const tinyxml2::XMLElement& at, const std::string& what,
                                const std::string& name,
                                const std::vector<std::string>& known) const;
  std::string locate(const tinyxml2::XMLElement& at, const std::string& message) const {
    return of(at).path() + ":" + std::to_string(at.GetLineNum()) + ": " + message;
  }

  /// Calls visit(child) for the children of `parent` in their order, with the children of an
  /// included file in place of <include>. Where errors are gathered, an error ends one visit only.
  template <typename Visit>
  void eachChild(const tinyxml2::XMLElement& parent, const Visit& visit) const {
    for (const tinyxml2::XMLElement* child = parent.FirstChildElement(); child != nullptr;
         child = child->NextSiblingElement()) {
      const auto included = included_.find(child);
      if (included != included_.end())
        eachChild(included->second->root(), visit);
      else
        readOn(errors_, [&] { visit(*child); });
    }
  }
  /// Calls visit(child) for the children of all sections of that name, in the same way.
  template <typename Visit>
  void eachOf(std::string_view section, const Visit& visit) const {
    eachSection(section, [&](const tinyxml2::XMLElement& s) { eachChild(s, visit); });
  }
  /// Calls visit(element) for the sections of that name, in the same way.
  template <typename Visit>
  void eachSection(std::string_view section, const Visit& visit) const {
    eachChild(main_.root(), [&](const tinyxml2::XMLElement& s) {
      if (s.Name() == section) visit(s);
    });
  }

  /// Fails for the first <body>, and <geom> that collides, in `part`: in a file they are in
  /// <worldbody> and its bodies alone.
  void expectNoBodyIn(const tinyxml2::XMLElement& part) const;

  /// The warnings of all files, the main one first.
  std::vector<std::string> takeWarnings();

  /// The path of a file that `element` names. As in MuJoCo, it may be relative to the main file's
  /// folder, or else to the folder of the element's own file. The result is relative to the main
  /// file's folder if the file is there, or in neither folder.
  std::string place(const tinyxml2::XMLElement& element, const std::string& file) const;

 private:
  void include(XmlFile& file, const tinyxml2::XMLElement& element);

  XmlFile& main_;
  const LoadOptions& options_;
  InputErrors* errors_;
  std::map<const tinyxml2::XMLDocument*, XmlFile*> files_;
  std::map<const tinyxml2::XMLElement*, std::unique_ptr<XmlFile>> included_;
  std::set<std::filesystem::path> open_;  // the files around the one that is read, and itself
  std::vector<XmlFile*> in_order_;
};

}  // namespace leeway::robots
