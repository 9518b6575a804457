#pragma once

// Private to robots/.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "collision/base/large_pages.h"

namespace leeway::robots {

/// A folder with a file for each thing that is kept, named by its key (ContentKey::finish()). It
/// saves time and promises nothing: what cannot be read or written is as if it were not there, and
/// nothing ever throws but for memory. Any number of processes may use one folder: files are
/// written under another name and renamed, and never changed.
class DiskCache {
 public:
  /// Bytes of all files [B]; the ones that are not used for longest go. A file that is larger is
  /// not written.
  static constexpr std::uintmax_t kMostBytes = std::uintmax_t{2} << 30;

  /// An empty folder: nothing is kept. It is made when something is.
  explicit DiskCache(std::filesystem::path folder, std::uintmax_t most_bytes = kMostBytes)
      : folder_(std::move(folder)), most_bytes_(most_bytes) {}

  bool isOn() const { return !folder_.empty(); }
  /// What was written under a key. Nothing for a file whose length, key or checksum is not right.
  std::optional<collision::LargeBuffer> read(const std::string& key) const;
  void write(const std::string& key, std::span<const std::byte> bytes) const;

 private:
  std::filesystem::path fileOf(const std::string& key) const;
  void removeOldest() const;

  std::filesystem::path folder_;
  std::uintmax_t most_bytes_;
};

}  // namespace leeway::robots
