#pragma once

#include <string>

namespace leeway::tools {

/// `leeway report cases FILE --raw OUT`: answers every case of FILE, one line each to OUT ("-":
/// stdout). Returns an ExitStatus.
int runReportCases(const std::string& file, const std::string& raw_output);

}  // namespace leeway::tools
