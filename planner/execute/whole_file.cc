#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "leeway/planner/path_io.h"
#include "leeway/robots/input_error.h"

namespace leeway::planner {
namespace {

[[noreturn]] void failWriting(const std::string& file, int error) {
  throw robots::InputError(
      file, 0,
      fmt::format("cannot be written: {}; a writable path is expected", std::strerror(error)));
}

/// Writes all of `text`; returns 0 or the error number.
int writeText(int descriptor, const std::string& text) {
  std::size_t written = 0;
  while (written < text.size()) {
    const ssize_t count = ::write(descriptor, text.data() + written, text.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    written += static_cast<std::size_t>(count);
  }
  return 0;
}

/// Writes all of `text` and flushes it to the disk; returns 0 or the error number.
int writeAll(int descriptor, const std::string& text) {
  if (const int error = writeText(descriptor, text); error != 0) return error;
  // A full disk may be reported only here.
  return ::fsync(descriptor) == 0 ? 0 : errno;
}

/// Writes into an existing device or pipe, such as /dev/stdout; returns 0 or the error number.
int writeThrough(const std::string& file, const std::string& text) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) return errno;
  int error = writeText(descriptor, text);
  if (::close(descriptor) != 0 && error == 0) error = errno;
  return error;
}

/// Returns the target of a chain of symbolic links, which need not exist.
std::string linkTarget(const std::string& name) {
  constexpr int kLongestChain = 40;  // as Linux
  std::filesystem::path path = name;
  std::error_code error;
  for (int i = 0; i < kLongestChain && std::filesystem::is_symlink(path, error); ++i) {
    // Links in /proc to pipes and sockets have no path as target. Only the link itself can be
    // opened.
    if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error))
      break;
    const std::filesystem::path target = std::filesystem::read_symlink(path, error);
    path = target.is_absolute() ? target : path.parent_path() / target;
  }
  return path.string();
}

}  // namespace

void writeFileWhole(const std::string& name, const std::string& text) {
  // Renaming onto a symbolic link, a device or a pipe would replace it.
  const std::string file = linkTarget(name);
  struct stat existing {};
  const bool exists = ::stat(file.c_str(), &existing) == 0;
  if (exists && !S_ISREG(existing.st_mode) && !S_ISDIR(existing.st_mode)) {
    if (const int error = writeThrough(file, text); error != 0) failWriting(file, error);
    return;
  }
  if (std::error_code ignored; std::filesystem::is_directory(file, ignored))
    failWriting(file, EISDIR);
  std::string temporary;
  int descriptor = -1;
  // Another run may use the name: one that writes this file now, or one that died while it did.
  for (int attempt = 0; descriptor < 0 && attempt < 100; ++attempt) {
    temporary = fmt::format("{}.{}.{}.tmp", file, ::getpid(), attempt);
    descriptor = ::open(temporary.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    if (descriptor < 0 && errno != EEXIST) break;
  }
  if (descriptor < 0) failWriting(file, errno);
  int error = writeAll(descriptor, text);
  if (error == 0 && exists && ::fchmod(descriptor, existing.st_mode & 0777U) != 0) error = errno;
  if (::close(descriptor) != 0 && error == 0) error = errno;
  if (error == 0 && ::rename(temporary.c_str(), file.c_str()) != 0) error = errno;
  if (error == 0) return;
  ::unlink(temporary.c_str());
  failWriting(file, error);
}

}  // namespace leeway::planner
