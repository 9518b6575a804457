#pragma once

#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "tools/leeway/batch/batch_list.h"
#include "tools/leeway/support/json_result.h"

namespace leeway::tools {

/// Where a batch's lines go: stdout, or FILE by way of FILE.partial, which grows line by line and
/// is what --resume continues from. FILE itself appears, in the order of the problems, when all are
/// done.
class BatchOutput {
 public:
  /// `path` empty: stdout. With `resume`, lines of an interrupted (or finished) run are kept; lines
  /// that report bad input are not, so that these problems are tried again. Throws
  /// robots::InputError when a kept line is no line of this batch or was made with other `options`
  /// than this run's, which its key `options` tells.
  BatchOutput(std::string path, const std::vector<BatchItem>& items, bool resume,
              const Json& options);
  ~BatchOutput();
  BatchOutput(const BatchOutput&) = delete;
  BatchOutput& operator=(const BatchOutput&) = delete;

  bool has(const std::string& problem) const { return lines_.count(problem) != 0; }
  /// The line of a problem that has one.
  const std::string& line(const std::string& problem) const { return lines_.at(problem); }
  std::size_t keptCount() const { return kept_; }
  /// Throws robots::InputError when the line cannot be written.
  void add(const std::string& problem, const std::string& line);
  /// All done: FILE.partial becomes FILE.
  void finish();
  std::string partialPath() const { return path_ + ".partial"; }

 private:
  void keepLinesOf(const std::string& file, const Json& options);
  std::string linesInOrder() const;

  std::string path_;
  std::vector<std::string> order_;
  std::map<std::string, std::string> lines_;
  std::size_t kept_ = 0;
  std::FILE* partial_ = nullptr;
};

}  // namespace leeway::tools
