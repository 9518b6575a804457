#pragma once

#include <string>
#include <vector>

#include "tools/leeway/support/json_result.h"

namespace leeway::tools {

/// The head of a benchmark log, before its runs.
struct OmplLogHead {
  std::string experiment;  ///< one word, because OMPL's script reads only the last of several
  std::string started;     ///< ISO 8601
  std::string setup;       ///< lines of text
  double time_limit = 0;   ///< of a run [s]; 0 without one
  double total_s = 0;      ///< the time in which the runs were collected [s]
};

/// Returns the lines of a batch as OMPL's benchmark log, which ompl_benchmark_statistics.py and
/// Planner Arena read (https://ompl.kavrakilab.org/benchmark.html, "The benchmark log file
/// format"). It is one experiment, in which each planner has a run for each of its problems, in
/// their order. Skips lines of bad input, because no planner saw it.
std::string omplLog(const OmplLogHead& head, const std::vector<Json>& lines);

}  // namespace leeway::tools
