#pragma once

#include <string>

namespace leeway {

/// Where this build comes from and what it made. Behind functions, so that only one small file
/// depends on the folder and a compiler cache serves all the others.
std::string sourceFolder();
/// The leeway command of this build; empty when it is not built.
std::string commandFile();

}  // namespace leeway
