#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "tools/report/base/rivals.h"

namespace leeway::tools {

/// What all reports with rivals share: their modules, the folder of files, and how they end.
class RivalReport {
 public:
  /// Starts the clock. Throws robots::InputError where files cannot be written into `folder`, nor
  /// it be made: that is to be known before minutes are spent on measuring. Makes nothing yet.
  explicit RivalReport(std::string folder);

  /// The rivals' modules; tells on stderr which are not there.
  void loadRivals();

  /// Ours and, behind them, the rivals' of one kind: &report::Rivals::pairs, meshes or motions. Of
  /// use as long as `own` and this report are there.
  template <class Engine>
  std::vector<const Engine*> engines(
      const std::vector<std::unique_ptr<Engine>>& own,
      std::vector<std::unique_ptr<Engine>> report::Rivals::*kind) const {
    std::vector<const Engine*> all;
    all.reserve(own.size());
    for (const auto& engine : own) all.push_back(engine.get());
    for (const report::RivalModule& module : modules_) {
      if (!module.rivals) continue;
      for (const auto& engine : (*module.rivals).*kind) all.push_back(engine.get());
    }
    return all;
  }

  /// Adds rows of a CSV file, whose header `csv` begins with, to NAME.partial in the folder, which
  /// is made when it is not there: what an interrupted report leaves, up to the last whole row.
  /// Throws robots::InputError where that cannot be.
  void addRows(const std::string& name, const std::string& csv);

  /// Writes a file of the folder, in place of its rows in NAME.partial. Throws like addRows().
  void write(const std::string& name, const std::string& text);

  /// How the report ends.
  struct End {
    std::uint64_t seed;
    std::string text = {};         ///< what people read
    std::string words = {};        ///< the first of its last line; empty: the seed
    std::string counted = "rows";  ///< or "families"
    std::size_t count = 0;         ///< of these
    int own_errors = 0;            ///< what the exit status is about
    int processor = -1;            ///< that was measured on; -1: any
  };
  /// Prints it to stdout, or `json` one document, with the time and the files. Returns the exit
  /// status: kYes without errors of ours.
  int end(bool json, const End& end) const;

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::string folder_;
  std::vector<report::RivalModule> modules_;
  std::vector<std::string> missing_;  // libraries of rivals
  std::vector<std::string> names_;    // of files
  std::set<std::string> partial_;     // of files that addRows() began
};

}  // namespace leeway::tools
