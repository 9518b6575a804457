#include "tools/leeway/support/output_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "leeway/robots/input_error.h"

namespace leeway::tools {

void checkOutputFile(const std::string& file, std::span<const std::string_view> endings) {
  const std::filesystem::path path(file);
  const std::string ending = path.extension().string();
  if (std::find(endings.begin(), endings.end(), ending) == endings.end()) {
    throw robots::InputError(
        file, 0,
        fmt::format("unknown ending '{}'; {} can be written", ending, fmt::join(endings, ", ")));
  }
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (!std::filesystem::is_directory(folder)) {
    throw robots::InputError(
        file, 0, fmt::format("cannot be written: there is no folder '{}'", folder.string()));
  }
}

}  // namespace leeway::tools
