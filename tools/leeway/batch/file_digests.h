#pragma once

#include <map>
#include <mutex>
#include <string>

#include "robots/base/files_read.h"
#include "tools/leeway/support/json_result.h"

namespace leeway::tools {

/// Digests of the contents of files, and where URIs lead. Thread-safe.
class FileDigests {
 public:
  /// The digest of a file's bytes in hexadecimal digits (64 bits of FNV-1a: it finds changes, not
  /// forgeries), with those of the .bin files beside a .gltf. Empty if the file does not exist.
  /// Reads a file again if its size or time has changed.
  std::string of(const std::string& path);
  /// Path and digest of each that is a file. Throws InputError for one that was changed since it
  /// was read.
  Json of(const robots::FilesRead& read);
  /// Whether the files of packages, as foundJson() has them, are still those that are found.
  bool areStillFound(const Json& found);

 private:
  struct Known {
    robots::FileStamp stamp;
    std::string digest;
  };
  std::string ofBytes(const std::string& path);

  std::mutex mutex_;
  std::map<std::string, Known> known_;
  std::map<std::string, bool> found_;  ///< by the text of an entry of foundJson()
};

/// How the files of packages were found.
Json foundJson(const robots::FilesRead& read);

}  // namespace leeway::tools
