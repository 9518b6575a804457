#include "robots/mesh/mesh_path.h"

#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <vector>

#include "leeway/robots/input_error.h"

namespace leeway::robots {

namespace {

using std::filesystem::path;

constexpr std::string_view kPackage = "package://";
constexpr std::string_view kFile = "file://";

/// A folder that is the package itself, or holds it.
void addPackage(const path& folder, const std::string& name, const std::string& rest,
                std::vector<path>& places) {
  places.push_back(folder / name / rest);
  if (folder.filename() == name) places.push_back(folder / rest);
}

std::vector<path> packagePlaces(const std::string& name, const std::string& rest,
                                const path& urdf_folder, const LoadOptions& options) {
  std::vector<path> places;
  for (const auto& [package, folder] : options.packages)
    if (package == name) places.push_back(path(folder) / rest);
  if (const char* list = std::getenv("ROS_PACKAGE_PATH")) {
    std::string_view rest_of_list = list;
    while (!rest_of_list.empty()) {
      const std::size_t end = std::min(rest_of_list.find(':'), rest_of_list.size());
      if (end > 0) addPackage(path(rest_of_list.substr(0, end)), name, rest, places);
      rest_of_list.remove_prefix(std::min(end + 1, rest_of_list.size()));
    }
  }
  for (path folder = urdf_folder;; folder = folder.parent_path()) {
    addPackage(folder, name, rest, places);
    if (!folder.has_parent_path() || folder == folder.parent_path()) break;
  }
  return places;
}

}  // namespace

std::string resolveMesh(const std::string& uri, const std::string& urdf_path, int line,
                        const LoadOptions& options) {
  std::error_code error;
  const path urdf_folder = std::filesystem::absolute(path(urdf_path), error).parent_path();
  std::vector<path> places;
  std::string advice = "the path of a mesh file would be accepted";
  if (uri.starts_with(kPackage)) {
    const std::string tail = uri.substr(kPackage.size());
    const std::size_t slash = tail.find('/');
    if (slash == 0 || slash == std::string::npos || slash + 1 == tail.size())
      throw InputError(urdf_path, line,
                       "the mesh \"" + uri +
                           "\" names no file in a package; package://NAME/PATH would be accepted");
    const std::string name = tail.substr(0, slash);
    places = packagePlaces(name, tail.substr(slash + 1), urdf_folder, options);
    advice = "--package " + name + "=FOLDER says where the package is";
  } else if (uri.starts_with(kFile)) {
    places = {path(uri.substr(kFile.size()))};
  } else if (uri.find("://") != std::string::npos) {
    throw InputError(urdf_path, line,
                     "the mesh \"" + uri +
                         "\" has a scheme that is not known; package://NAME/PATH, file:///PATH or "
                         "a path would be accepted");
  } else {
    places = {urdf_folder / uri};  // an absolute uri replaces the folder
  }
  std::string tried;
  for (const path& place : places) {
    if (std::filesystem::is_regular_file(place, error)) return place.lexically_normal().string();
    tried += (tried.empty() ? "" : ", ") + place.lexically_normal().string();
  }
  throw InputError(urdf_path, line,
                   "the mesh \"" + uri + "\" was not found, looked for " + tried + "; " + advice);
}

}  // namespace leeway::robots
