#pragma once

#include <functional>
#include <vector>

#include "tools/leeway/support/verb.h"

namespace leeway::tools {

constexpr const char* kHelp = "help";  ///< `leeway help VERB` is `leeway VERB --help`

/// Parses the command line with the verbs that `add_verbs` declares, and runs the chosen verb.
/// Faults go to stderr. Returns the ExitStatus; kBadInput also if stdout cannot be written.
int runCommandLine(int argc, char** argv,
                   const std::function<std::vector<Verb>(CLI::App&)>& add_verbs);

}  // namespace leeway::tools
