#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace leeway::tools::report {

/// Options of every report.
struct ReportOptions {
  std::string output = "report";  ///< folder for files
  std::uint64_t seed = 1;         ///< of several runs, the first
  bool no_rivals = false;         ///< ours alone
  bool json = false;              ///< the answer is a JSON document
  /// Called with the name of each unit of work when it begins.
  std::function<void(const std::string&)> progress = {};
};

}  // namespace leeway::tools::report
