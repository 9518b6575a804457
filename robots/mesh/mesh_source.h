#pragma once

// Private to robots/: a mesh file in memory, and how readers report errors in it.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "collision/base/large_pages.h"
#include "leeway/robots/stopped.h"
#include "robots/mesh/file_mesh.h"

namespace leeway::robots {

/// A mesh file, read as a whole, and the line of another file that names it.
class MeshSource {
 public:
  /// Throws InputError for a path that is not a file or cannot be read, and for a file that clearly
  /// has other content: a Git LFS pointer, a web page. `stop` must outlive this object.
  MeshSource(std::string path, std::string referrer, int referrer_line, const Stop& stop);

  const std::string& path() const { return path_; }
  std::span<const std::byte> bytes() const { return {contents_.data(), contents_.size()}; }
  /// The same as text, without a byte order mark.
  std::string_view text() const;
  /// The last dot and the text after it, in lower case.
  std::string ending() const;

  /// Throws InputError: "REFERRER:7: mesh PATH MESSAGE", "REFERRER:7: mesh PATH:12: MESSAGE".
  [[noreturn]] void fail(const std::string& message) const;
  [[noreturn]] void failAt(FilePlace place, const std::string& message) const;
  /// The note as a warning, in the same form.
  std::string warning(const MeshNote& note) const;

  /// Throws Stopped if a stop was requested. Readers call it every kLinesBetweenStops lines.
  void pause() const;
  static constexpr std::size_t kLinesBetweenStops = std::size_t{1} << 16;

 private:
  std::string where(FilePlace place) const;

  std::string path_, referrer_;
  int referrer_line_;
  const Stop& stop_;
  collision::LargeBuffer contents_;
};

/// "'WORD'", truncated if it is long or binary.
std::string shown(std::string_view word);

}  // namespace leeway::robots
