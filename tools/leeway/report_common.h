#pragma once

#include <string>
#include <vector>

#include "tools/report/rivals.h"

namespace leeway::tools {

/// The rivals' modules, unless `none`; tells on stderr which are not there. `missing` gets their
/// libraries' names.
std::vector<report::RivalModule> loadRivals(bool none, std::vector<std::string>& missing);

/// Writes a file of a report's folder, which is made when it is not there; returns its path. Throws
/// robots::InputError where that cannot be.
std::string writeReportFile(const std::string& folder, const std::string& name,
                            const std::string& text);

}  // namespace leeway::tools
