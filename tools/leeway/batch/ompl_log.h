#pragma once

#include <string>
#include <vector>

#include "tools/leeway/support/json_result.h"

namespace leeway::tools {

/// What a benchmark log says besides its runs.
struct OmplLogHead {
  std::string experiment;  ///< one word: of several OMPL's script reads the last
  std::string started;     ///< ISO 8601
  std::string setup;       ///< lines of text
  double time_limit = 0;   ///< of a run [s]; 0: none
  double total_s = 0;      ///< that collecting the runs took [s]
};

/// The lines of a batch as OMPL's benchmark log, which ompl_benchmark_statistics.py and Planner
/// Arena read (https://ompl.kavrakilab.org/benchmark.html, "The benchmark log file format"): one
/// experiment, in which each planner has a run for each of its problems, in their order. Lines of
/// bad input, which no planner saw, are left out.
std::string omplLog(const OmplLogHead& head, const std::vector<Json>& lines);

}  // namespace leeway::tools
