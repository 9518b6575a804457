#pragma once

// Private to robots/sdf: SDF files, and their elements that hold a value as text.

#include <tinyxml2.h>

#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/robots/model.h"
#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

using collision::Pose;

/// A file, and its version: `minor` is 7 for SDF 1.7.
struct SdfSource {
  XmlFile* file = nullptr;
  int minor = 0;
};

/// An SDF file with the files that its <include> elements name.
class SdfFiles {
 public:
  /// `main` and `options` must outlive this. Throws InputError for a version that is not known.
  SdfFiles(XmlFile& main, const LoadOptions& options);

  const SdfSource& main() const { return main_; }
  const LoadOptions& options() const { return options_; }
  /// The file that the <uri> of an <include> in `from` names, or the newest one that the
  /// model.config of that folder names. A file is read once. Throws InputError.
  const SdfSource& include(const SdfSource& from, const tinyxml2::XMLElement& uri);
  /// XmlFile::leaveOutShapesBeyond() for the links of models, in all files.
  void leaveOutShapesBeyondLinks();
  /// The warnings of all files, those of the main file first.
  std::vector<std::string> takeWarnings();

 private:
  std::string fileIn(const std::string& config) const;

  const LoadOptions& options_;
  SdfSource main_;
  std::map<std::string, SdfSource> sources_;    // included ones, by their paths
  std::vector<std::unique_ptr<XmlFile>> read_;  // in their order
  std::vector<std::string> warnings_;           // about the places of models
};

/// A <pose> as written: in the frame `relative_to`; empty: in the one that the format says.
struct SdfPose {
  Pose X;
  std::string relative_to;
  const tinyxml2::XMLElement* element = nullptr;  ///< null: there is none, X is the identity
};
/// The only <pose> of `parent`. Throws InputError.
SdfPose poseIn(const SdfSource& source, const tinyxml2::XMLElement& parent);

/// Leaves out attributes, text and children that are in none of the lists, as XmlFile does. Throws
/// InputError for an attribute that should be one of the children `used`.
void expectOnly(XmlFile& file, const tinyxml2::XMLElement& element,
                const std::vector<std::string>& attributes,
                std::initializer_list<std::string_view> used,
                std::initializer_list<std::string_view> unused = {});
/// Leaves out the children of that name with a warning that ends in `consequence`.
void leaveOutChildren(XmlFile& file, const tinyxml2::XMLElement& parent, const char* name,
                      const std::string& consequence);

/// The only child of that name, which holds text alone; null if there is none.
const tinyxml2::XMLElement* leafIn(XmlFile& file, const tinyxml2::XMLElement& parent,
                                   const char* name,
                                   const std::vector<std::string>& attributes = {});
/// The text of the only child of that name; empty if there is none.
std::string textIn(XmlFile& file, const tinyxml2::XMLElement& parent, const char* name);
/// Exactly `count` numbers from -1e9 to 1e9; nothing without a child of that name.
std::optional<std::vector<double>> numbersIn(XmlFile& file, const tinyxml2::XMLElement& parent,
                                             const char* name, std::size_t count);
/// Exactly three such numbers of an element.
Eigen::Vector3d vectorOf(const XmlFile& file, const tinyxml2::XMLElement& element);
/// The same of the only child of that name, or `otherwise`.
Eigen::Vector3d vectorIn(XmlFile& file, const tinyxml2::XMLElement& parent, const char* name,
                         const Eigen::Vector3d& otherwise);
double numberIn(XmlFile& file, const tinyxml2::XMLElement& parent, const char* name,
                double otherwise);
/// One number of 0 or more, which must be there.
double sizeIn(XmlFile& file, const tinyxml2::XMLElement& parent, const char* name);
/// true, false, 1 or 0, as a text of `at`.
bool flagOf(const XmlFile& file, const tinyxml2::XMLElement& at, const std::string& text);
/// The same of the only child of that name, or `otherwise`.
bool flagIn(XmlFile& file, const tinyxml2::XMLElement& parent, const char* name, bool otherwise);

}  // namespace leeway::robots
