#include "tools/leeway/report_common.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <system_error>

#include "leeway/planner/path_io.h"

namespace leeway::tools {

std::vector<report::RivalModule> loadRivals(bool none, std::vector<std::string>& missing) {
  if (none) return {};
  std::vector<report::RivalModule> modules = report::loadRivals();
  for (const report::RivalModule& module : modules) {
    if (module.problem.empty()) continue;
    fmt::print(stderr, "without {}: {}\n", module.library, module.problem);
    missing.push_back(module.library);
  }
  return modules;
}

std::string writeReportFile(const std::string& folder, const std::string& name,
                            const std::string& text) {
  std::error_code error;  // what is wrong shows when the file is written
  std::filesystem::create_directories(folder, error);
  const std::string file = std::filesystem::path(folder) / name;
  planner::writeFileWhole(file, text);
  return file;
}

}  // namespace leeway::tools
