#pragma once

#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "tools/leeway/batch/batch_list.h"
#include "tools/leeway/batch/file_digests.h"
#include "tools/leeway/support/json_result.h"

namespace leeway::tools {

/// Writes the lines of a batch to stdout, or to FILE. With FILE, lines are appended to
/// FILE.partial, from which --resume continues. FILE itself is written when all problems are done,
/// in their order.
class BatchOutput {
 public:
  /// `path` empty: stdout. With `resume`, keeps the lines of an interrupted (or finished) run,
  /// except lines that report bad input and lines whose `files` have other digests now, so that
  /// these problems are tried again. Throws robots::InputError if a kept line does not belong to
  /// this batch, or if its key `options` differs from `options`.
  BatchOutput(std::string path, const std::vector<BatchItem>& items, bool resume,
              const Json& options, FileDigests& digests);
  ~BatchOutput();
  BatchOutput(const BatchOutput&) = delete;
  BatchOutput& operator=(const BatchOutput&) = delete;

  bool has(const std::string& problem) const { return lines_.count(problem) != 0; }
  /// The line of a problem, which must have one.
  const std::string& line(const std::string& problem) const { return lines_.at(problem); }
  std::size_t keptCount() const { return kept_; }
  /// Throws robots::InputError if the line cannot be written.
  void add(const std::string& problem, const std::string& line);
  /// Call it when all problems are done. FILE.partial becomes FILE.
  void finish();
  std::string partialPath() const { return path_ + ".partial"; }

 private:
  void keepLinesOf(const std::string& file, const Json& options, FileDigests& digests);
  std::string linesInOrder() const;

  std::string path_;
  std::vector<std::string> order_;
  std::map<std::string, std::string> lines_;
  std::size_t kept_ = 0;
  std::FILE* partial_ = nullptr;
};

}  // namespace leeway::tools
