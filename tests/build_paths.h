#pragma once

#include <string>

namespace leeway {

/// The source tree's root. A function in its own file: only that file depends on the checkout's
/// path, so a compiler cache serves all others.
std::string sourceFolder();
/// This build's leeway command; empty if it is not built.
std::string commandFile();

}  // namespace leeway
