#include "tools/leeway/output_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "leeway/robots/input_error.h"

namespace leeway::tools {
namespace {

[[noreturn]] void cannotWrite(const std::string& path, const std::string& temporary, int error) {
  if (!temporary.empty()) {
    std::remove(temporary.c_str());
  }
  throw robots::InputError(path, 0, fmt::format("cannot be written: {}", std::strerror(error)));
}

}  // namespace

void writeWhole(const std::string& path, std::string_view text) {
  if (std::filesystem::is_directory(path)) {
    cannotWrite(path, "", EISDIR);
  }
  const std::string temporary = fmt::format("{}.tmp{}", path, getpid());
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (file == nullptr) {
    cannotWrite(path, "", errno);
  }
  // A full disk may show only when the buffers are emptied: both results count.
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  const int write_error = errno;
  if (std::fclose(file) != 0 || !written) {
    cannotWrite(path, temporary, written ? errno : write_error);
  }
  if (std::rename(temporary.c_str(), path.c_str()) != 0) {
    cannotWrite(path, temporary, errno);
  }
}

}  // namespace leeway::tools
