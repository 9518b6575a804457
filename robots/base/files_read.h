#pragma once

// Private to the layers above collision/: which files are read.

#include <compare>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace leeway::robots {

/// When a file was changed, and its size; those of a file that is not there are the same each time.
struct FileStamp {
  std::filesystem::file_time_type changed;
  std::uintmax_t size = 0;
  bool operator==(const FileStamp&) const = default;

  static FileStamp of(const std::string& path);
};

/// While it exists, it gathers the paths of all files that its thread reads, or finds for others to
/// read. It lacks those that a xacro or glTF file includes. A thread has one at a time.
class FilesRead {
 public:
  FilesRead();
  ~FilesRead();
  FilesRead(const FilesRead&) = delete;
  FilesRead& operator=(const FilesRead&) = delete;

  /// The paths, with the stamps before they were read.
  const std::map<std::string, FileStamp>& files() const { return files_; }
  /// Adds a file to those of this thread; before it is read.
  static void note(const std::string& path);

  /// How a file of a package was found: by this URI in the file `from`. Another one is found where
  /// packages, or the paths of the environment, change.
  struct Found {
    std::string uri, from;
    std::vector<std::pair<std::string, std::string>> packages;  ///< LoadOptions::packages
    std::string file;
    auto operator<=>(const Found&) const = default;
  };
  const std::set<Found>& found() const { return found_; }
  /// Adds a file that was found, before it is read.
  static void note(const Found& found);

 private:
  static thread_local FilesRead* of_thread;
  std::map<std::string, FileStamp> files_;
  std::set<Found> found_;
};

}  // namespace leeway::robots
