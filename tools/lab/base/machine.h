#pragma once

#include <string>

namespace leeway::tools::report {

/// The processor's name from /proc/cpuinfo; "unknown processor" if the file has none.
std::string machineName();

/// Pins this process and its future children to the current processor; returns its number, -1 on
/// failure.
int pinToOneProcessor();

}  // namespace leeway::tools::report
