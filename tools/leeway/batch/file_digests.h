#pragma once

#include <map>
#include <mutex>
#include <string>

#include "robots/base/files_read.h"
#include "tools/leeway/support/json_result.h"

namespace leeway::tools {

/// Digests of the contents of files. Thread-safe.
class FileDigests {
 public:
  /// The digest of a file's bytes in hexadecimal digits (64 bits of FNV-1a: it finds changes, not
  /// forgeries), with those of the .bin files beside a .gltf. Empty if the file does not exist.
  /// Reads a file again if its size or time has changed.
  std::string of(const std::string& path);
  /// Path and digest of each that is a file. Throws InputError for one that was changed since it
  /// was read.
  Json of(const robots::FilesRead& read);

 private:
  struct Known {
    robots::FileStamp stamp;
    std::string digest;
  };
  std::string ofBytes(const std::string& path);

  std::mutex mutex_;
  std::map<std::string, Known> known_;
};

}  // namespace leeway::tools
