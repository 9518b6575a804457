#pragma once

// Private to the layers above collision/: which files are read.

#include <set>
#include <string>

namespace leeway::robots {

/// While it exists, it gathers the paths of all files that its thread reads, or finds for others to
/// read. It lacks those that a xacro or glTF file includes. A thread has one at a time.
class FilesRead {
 public:
  FilesRead();
  ~FilesRead();
  FilesRead(const FilesRead&) = delete;
  FilesRead& operator=(const FilesRead&) = delete;

  const std::set<std::string>& paths() const { return paths_; }
  /// Adds a file to those of this thread.
  static void note(const std::string& path);

 private:
  static thread_local FilesRead* of_thread;
  std::set<std::string> paths_;
};

}  // namespace leeway::robots
