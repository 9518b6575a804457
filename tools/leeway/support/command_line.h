#pragma once

#include <functional>
#include <vector>

#include "tools/leeway/support/verb.h"

namespace leeway::tools {

constexpr const char* kHelp = "help";  ///< `leeway help VERB` is `leeway VERB --help`

/// Parses the command line against the verbs that `add_verbs` declares and runs the one that it
/// names. Faults go to stderr. Returns the ExitStatus; kBadInput, too, where stdout takes no more.
int runCommandLine(int argc, char** argv,
                   const std::function<std::vector<Verb>(CLI::App&)>& add_verbs);

}  // namespace leeway::tools
