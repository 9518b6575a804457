#include "robots/mesh/mesh_path.h"

#include <tinyxml2.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "leeway/robots/input_error.h"
#include "robots/base/files_read.h"

namespace leeway::robots {

namespace {

using std::filesystem::path;

std::string trimmed(std::string text) {
  constexpr std::string_view kSpace = " \t\r\n";
  text.erase(std::min(text.find_last_not_of(kSpace) + 1, text.size()));
  text.erase(0, std::min(text.find_first_not_of(kSpace), text.size()));
  return text;
}

/// Decodes RFC 3986 escapes: %20 is a space.
std::string percentDecoded(const std::string& text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto isHex = [&](std::size_t k) {
      return k < text.size() && std::isxdigit(static_cast<unsigned char>(text[k])) != 0;
    };
    if (text[i] == '%' && isHex(i + 1) && isHex(i + 2)) {
      decoded += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      decoded += text[i];
    }
  }
  return decoded;
}

/// The possible spellings of a file's name: as written, then with decoded escapes such as %20.
std::vector<std::string> spellings(const std::string& text) {
  std::vector<std::string> all = {text};
  if (std::string decoded = percentDecoded(trimmed(text)); decoded != text)
    all.push_back(std::move(decoded));
  return all;
}

/// The package's name in the folder's package.xml.
std::optional<std::string> packageName(const path& folder) {
  std::error_code error;
  const path file = folder / "package.xml";
  tinyxml2::XMLDocument document;
  if (!std::filesystem::is_regular_file(file, error) ||
      document.LoadFile(file.c_str()) != tinyxml2::XML_SUCCESS || document.RootElement() == nullptr)
    return std::nullopt;
  const tinyxml2::XMLElement* element = document.RootElement()->FirstChildElement("name");
  if (element == nullptr || element->GetText() == nullptr) return std::nullopt;
  return trimmed(element->GetText());
}

/// Whether two paths lead to one folder, also by links.
bool isSameFolder(const path& a, const path& b) {
  std::error_code error;
  return a == b || std::filesystem::equivalent(a, b, error);
}

/// Searches a file in folders of one package, in the order in which they are added.
class PackageSearch {
 public:
  PackageSearch(std::string name, const std::string& rest)
      : name_(std::move(name)), rests_(spellings(rest)) {}

  /// Tests a folder of the package, if it exists.
  void look(const path& folder) {
    std::error_code error;
    if (std::filesystem::is_directory(folder, error)) lookAt(folder);
  }
  /// Tests a folder of the package.
  void lookAt(const path& folder) {
    if (found_) return;
    const path normal = folder.lexically_normal();
    if (std::any_of(folders_.begin(), folders_.end(),
                    [&](const path& known) { return isSameFolder(known, normal); }))
      return;
    folders_.push_back(normal);
    found_ = fileIn(folder);
  }
  /// Tests a folder that may be the package, or contain it.
  void lookIn(const path& folder) {
    for (const path& place : {folder / name_, folder}) {
      if (found_) return;
      const std::optional<std::string> name = packageName(place);
      if (name ? *name == name_ : place.filename() == name_)
        look(place);
      else if (place.filename() == name_)
        of_other_name_.emplace_back(place, *name);
    }
  }
  /// Tests the folders of that name whose package.xml has another.
  void lookInOthers() {
    for (const auto& [folder, other] : of_other_name_) {
      if (found_) return;
      look(folder);
      if (found_)
        doubt_ = "the package \"" + name_ + "\" is taken from the folder of that name, but " +
                 (folder / "package.xml").lexically_normal().string() + " calls it \"" + other +
                 "\"; --package " + name_ + "=FOLDER says which is meant";
    }
  }
  /// Tests a folder that may contain the package under another name.
  void lookAmongChildren(const path& folder) {
    if (found_) return;
    std::error_code error;
    std::vector<path> packages;  // sorted by name, because the order on disk is arbitrary
    for (std::filesystem::directory_iterator child(folder, error), end; !error && child != end;
         child.increment(error))
      if (packageName(child->path()) == name_) packages.push_back(child->path());
    std::sort(packages.begin(), packages.end());
    std::vector<std::string> holders;
    for (const path& package : packages) {
      if (fileIn(package) &&
          std::none_of(holders.begin(), holders.end(),
                       [&](const std::string& known) { return isSameFolder(known, package); }))
        holders.push_back(package.lexically_normal().string());
      look(package);
    }
    if (holders.size() > 1)
      doubt_ = "the package \"" + name_ + "\" is " + holders[0] + ", and also " + holders[1] +
               "; the first is taken, --package " + name_ + "=FOLDER says which is meant";
  }

  const std::optional<std::string>& found() const { return found_; }
  /// The warning if two folders are the package, or its package.xml has another name; empty
  /// otherwise.
  const std::string& doubt() const { return doubt_; }
  /// Folders of the package in which the file is missing.
  const std::vector<path>& folders() const { return folders_; }

 private:
  std::optional<std::string> fileIn(const path& folder) const {
    std::error_code error;
    for (const std::string& rest : rests_)
      if (path file = (folder / rest).lexically_normal();
          std::filesystem::is_regular_file(file, error))
        return file.string();
    return std::nullopt;
  }

  std::string name_, doubt_;
  std::vector<std::string> rests_;
  std::vector<path> folders_;
  std::vector<std::pair<path, std::string>> of_other_name_;  // with the name in package.xml
  std::optional<std::string> found_;
};

/// The entries of an environment variable with a list of folders.
std::vector<path> listedFolders(const char* variable) {
  std::vector<path> folders;
  const char* list = std::getenv(variable);
  std::string_view rest = list == nullptr ? "" : list;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    if (end > 0) folders.emplace_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return folders;
}

PackageSearch searchPackage(const std::string& name, const std::string& rest,
                            const path& urdf_folder, const LoadOptions& options) {
  PackageSearch search(name, rest);
  for (const auto& [package, folder] : options.packages)
    if (package == name) search.lookAt(folder);
  std::vector<path> above;
  for (path folder = urdf_folder;; folder = folder.parent_path()) {
    above.push_back(folder);
    if (!folder.has_parent_path() || folder == folder.parent_path()) break;
  }
  const std::vector<path> workspaces = listedFolders("ROS_PACKAGE_PATH");
  for (const path& folder : workspaces) search.lookIn(folder);
  for (const path& folder : listedFolders("AMENT_PREFIX_PATH"))
    search.look(folder / "share" / name);
  for (const char* variable : {"GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH", "SDF_PATH"})
    for (const path& folder : listedFolders(variable)) search.lookIn(folder);
  for (const path& folder : above) search.lookIn(folder);
  for (const std::vector<path>& folders : {workspaces, above})
    for (const path& folder : folders) search.lookAmongChildren(folder);
  search.lookInOthers();
  return search;
}

/// The part of `uri` after one of these prefixes.
std::optional<std::string> behind(const std::string& uri,
                                  std::initializer_list<std::string_view> beginnings) {
  for (const std::string_view beginning : beginnings)
    if (uri.starts_with(beginning)) return uri.substr(beginning.size());
  return std::nullopt;
}

}  // namespace

std::string resolveMesh(const std::string& uri, const std::string& urdf_path, int line,
                        const LoadOptions& options, std::vector<std::string>* warnings) {
  return resolveFile(uri, "mesh", urdf_path, line, options, warnings);
}

std::string resolveFile(const std::string& uri, const std::string& what,
                        const std::string& urdf_path, int line, const LoadOptions& options,
                        std::vector<std::string>* warnings) {
  const auto fail = [&](const std::string& message) {
    throw InputError(urdf_path, line, "the " + what + " \"" + uri + "\" " + message);
  };
  const auto noted = [](std::string found) {
    FilesRead::note(found);
    return found;
  };
  std::error_code error;
  const path urdf_folder = std::filesystem::absolute(path(urdf_path), error).parent_path();
  if (const auto in_package = behind(uri, {"package://", "model://"})) {
    // Empty parts of a path are ignored: NAME//PATH is NAME/PATH.
    const std::size_t begin = std::min(in_package->find_first_not_of('/'), in_package->size());
    const std::size_t slash = std::min(in_package->find('/', begin), in_package->size());
    const std::size_t rest =
        std::min(in_package->find_first_not_of('/', slash), in_package->size());
    if (rest == in_package->size())
      fail("names no file in a package; package://NAME/PATH would be accepted");
    const std::string name = in_package->substr(begin, slash - begin);
    const PackageSearch search =
        searchPackage(name, in_package->substr(rest), urdf_folder, options);
    if (search.found()) {
      const std::string& doubt = search.doubt();
      const auto is_known = [&](const std::string& text) { return text.ends_with(doubt); };
      if (warnings != nullptr && !doubt.empty() &&
          std::none_of(warnings->begin(), warnings->end(), is_known))
        warnings->emplace_back(InputError(urdf_path, line, doubt).what());
      FilesRead::note({uri, urdf_path, options.packages, *search.found()});
      return *search.found();
    }
    const std::string advice = "; --package " + name + "=FOLDER says where the package is";
    if (search.folders().empty())
      fail("was not found: there is no package \"" + name +
           "\" in ROS_PACKAGE_PATH, AMENT_PREFIX_PATH, the paths of Gazebo, the folders from " +
           urdf_folder.string() + " up and those in them" + advice);
    std::string folders;
    for (const path& folder : search.folders())
      folders += (folders.empty() ? "" : ", ") + folder.string();
    fail("was not found: the package \"" + name + "\" is " + folders + ", without that file" +
         advice);
  }
  const auto in_file =
      behind(uri, {uri.starts_with("file://localhost/") ? "file://localhost" : "file://"});
  if (!in_file && uri.find("://") != std::string::npos)
    fail(
        "has a scheme that is not known; package://NAME/PATH, model://NAME/PATH, file:///PATH or a "
        "path would be accepted");
  std::string tried;
  for (const std::string& spelling : spellings(in_file ? *in_file : uri)) {
    const path place = (urdf_folder / spelling).lexically_normal();  // unless it is absolute
    if (std::filesystem::is_regular_file(place, error)) {
      if (uri.find('%') != std::string::npos)  // another spelling may come first later
        FilesRead::note({uri, urdf_path, options.packages, place.string()});
      return noted(place.string());
    }
    tried += (tried.empty() ? "" : ", ") + place.string();
  }
  fail("was not found, looked for " + tried + "; the path of a " + what +
       " file would be accepted");
  return {};  // not reached
}

}  // namespace leeway::robots
