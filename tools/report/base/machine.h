#pragma once

#include <string>

namespace leeway::tools::report {

/// The processor's name as the system tells it, "unknown processor" where it does not.
std::string machineName();

/// Keeps this process and its children on the processor that it runs on; returns that, or -1 where
/// the system refuses.
int pinToOneProcessor();

}  // namespace leeway::tools::report
