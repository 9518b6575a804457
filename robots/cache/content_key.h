#pragma once

// Private to robots/.

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace leeway::robots {

/// A digest (SHA-256) of all that an answer depends on; what is kept on disk is found by it.
/// Strong, because answers that certificates rest on are taken from the file of that name: nobody
/// can make two mesh files of one digest.
class ContentKey {
 public:
  /// Begins with what all keys depend on: this build of the library, its compiler, the mesh
  /// importer, the layout of numbers in memory. `kind`: what is kept.
  explicit ContentKey(std::string_view kind);
  ~ContentKey();

  /// Adds bytes, and how many they are, so that parts cannot run into each other. About 1 GB/s.
  void add(std::span<const std::byte> bytes);
  void add(std::string_view text) { add(std::as_bytes(std::span(text.data(), text.size()))); }
  void add(double number) { add(std::as_bytes(std::span(&number, 1))); }

  /// The digest in 64 hexadecimal digits; nothing can be added to it then. Empty where the program
  /// rounds in another way than to the nearest.
  std::string finish();

 private:
  struct Digest;
  std::unique_ptr<Digest> digest_;
};

}  // namespace leeway::robots
