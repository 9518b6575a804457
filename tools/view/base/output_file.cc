#include "tools/view/base/output_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "leeway/robots/input_error.h"
#include "robots/base/read_file.h"

namespace leeway::tools {
namespace {

/// The place where a file is or would be, with links resolved. Makes the name absolute first,
/// because weakly_canonical() leaves names of missing files relative.
std::filesystem::path placeOf(const std::string& file) {
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::absolute(file, error);
  const std::filesystem::path place = std::filesystem::weakly_canonical(absolute, error);
  return error ? std::filesystem::path(file) : place;
}

}  // namespace

void checkOutputFile(const std::string& file, std::span<const std::string_view> endings) {
  const std::filesystem::path path(file);
  const std::string ending = robots::endingOf(file);
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
  std::error_code error;
  const bool is_new =
      !std::filesystem::exists(path, error) || std::filesystem::is_regular_file(path, error);
  const std::filesystem::path place = placeOf(file).parent_path();
  if (is_new && !place.empty() && ::access(place.c_str(), W_OK | X_OK) != 0) {
    throw robots::InputError(file, 0,
                             fmt::format("cannot be written: {}; a folder that may be written is "
                                         "expected",
                                         std::strerror(errno)));
  }
}

void expectApart(std::span<const std::string> outputs, std::span<const std::string> inputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    if (outputs[i].empty()) continue;
    std::error_code none;  // a missing file is a different file
    for (const std::string& input : inputs)
      if (!input.empty() && std::filesystem::equivalent(outputs[i], input, none))
        throw robots::InputError(outputs[i], 0,
                                 "is read, and would be overwritten; another name for what is "
                                 "written is expected");
    for (std::size_t k = 0; k < i; ++k)
      if (!outputs[k].empty() && placeOf(outputs[i]) == placeOf(outputs[k]))
        throw robots::InputError(outputs[i], 0,
                                 "is to be written twice; a name for each output is expected");
  }
}

}  // namespace leeway::tools
