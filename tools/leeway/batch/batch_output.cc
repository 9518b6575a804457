#include "tools/leeway/batch/batch_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "leeway/planner/path_io.h"
#include "leeway/robots/input_error.h"
#include "robots/base/read_file.h"
#include "tools/leeway/support/terminal.h"

namespace leeway::tools {

BatchOutput::BatchOutput(std::string path, const std::vector<BatchItem>& items, bool resume,
                         const Json& options, FileDigests& digests)
    : path_(std::move(path)) {
  for (const BatchItem& item : items) {
    order_.push_back(item.problem);
  }
  if (path_.empty()) {
    return;
  }
  if (resume) {
    for (const std::string& file : {partialPath(), path_}) {
      if (!std::filesystem::exists(file)) continue;
      keepLinesOf(file, options, digests);
      break;
    }
    kept_ = lines_.size();
  }
  planner::writeFileWhole(partialPath(), linesInOrder());
  partial_ = std::fopen(partialPath().c_str(), "ab");
  if (partial_ == nullptr) {
    throw robots::InputError(partialPath(), 0,
                             fmt::format("cannot be written: {}", std::strerror(errno)));
  }
}

BatchOutput::~BatchOutput() {
  if (partial_ != nullptr) {
    std::fclose(partial_);
  }
}

namespace {

/// Whether the files that a line was made from are still the same.
bool isCurrent(const Json& document, FileDigests& digests) {
  const auto files = document.find("files"), found = document.find("found");
  if (files == document.end() || !files->is_object()) return false;
  if (found == document.end() || !digests.areStillFound(*found)) return false;
  for (const auto& [path, digest] : files->items())
    if (digest != digests.of(path)) return false;
  return true;
}

}  // namespace

void BatchOutput::keepLinesOf(const std::string& file, const Json& options, FileDigests& digests) {
  std::set<std::string> expanded;
  std::ifstream in(file, std::ios::binary);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (in.eof()) {
      return;  // no line break: the run was cut off while it wrote this line
    }
    const Json document = Json::parse(line, nullptr, false);
    if (!document.is_object() || !document.contains("problem") ||
        !document["problem"].is_string() || !document.contains("status")) {
      throw robots::InputError(
          file, number, "is not a line of a batch; without --resume the file is written anew");
    }
    const std::string problem = document["problem"];
    if (std::find(order_.begin(), order_.end(), problem) == order_.end()) {
      throw robots::InputError(
          file, number,
          fmt::format(
              "'{}' is not a problem of this batch; resume with the arguments of the first run",
              problem));
    }
    const Json made_with = document.value("options", Json::object());
    if (made_with != options) {
      throw robots::InputError(
          file, number,
          fmt::format("was made with the options {}, not {}; resume with those of the first run",
                      jsonText(made_with), jsonText(options)));
    }
    if (document["status"] == "error" || document["status"] == "internal_error" ||
        !isCurrent(document, digests))
      continue;
    lines_[problem] = line;
    for (const auto& [path, digest] : document["files"].items())
      if (robots::endingOf(path) == ".xacro") expanded.insert(path);
  }
  for (const std::string& path : expanded)
    printMessage(path +
                 ": whether files that it includes have changed is not known; without "
                 "--resume all problems are planned again");
}

std::string BatchOutput::linesInOrder() const {
  std::string text;
  for (const std::string& problem : order_) {
    const auto line = lines_.find(problem);
    if (line != lines_.end()) {
      text += line->second + "\n";
    }
  }
  return text;
}

void BatchOutput::add(const std::string& problem, const std::string& line) {
  std::FILE* file = partial_ != nullptr ? partial_ : stdout;
  if (file == stdout) endProgress();  // both may be the same terminal
  const std::string text = line + "\n";
  if (std::fwrite(text.data(), 1, text.size(), file) != text.size() || std::fflush(file) != 0) {
    throw robots::InputError(path_.empty() ? "standard output" : partialPath(), 0,
                             fmt::format("cannot be written: {}", std::strerror(errno)));
  }
  if (partial_ != nullptr) {
    lines_[problem] = line;
  }
}

void BatchOutput::finish() {
  if (partial_ == nullptr) {
    return;
  }
  planner::writeFileWhole(path_, linesInOrder());
  std::fclose(partial_);
  partial_ = nullptr;
  std::filesystem::remove(partialPath());
}

}  // namespace leeway::tools
