#pragma once

#include <filesystem>
#include <string>

namespace leeway {

/// The source tree's root. The function is in its own file, because only that file depends on the
/// checkout's path, so that a compiler cache serves all others.
std::string sourceFolder();
/// Third-party robots and problems, next to the project; LEEWAY_DATA overrides the folder. May be
/// absent.
std::string dataFolder();

/// This build's leeway command; empty if it is not built.
std::string commandFile();

/// Skips a test that needs this file or folder of dataFolder().
#define LEEWAY_NEEDS_DATA(file)                                        \
  if (!std::filesystem::exists(::leeway::dataFolder() + "/" + (file))) \
  GTEST_SKIP() << "needs " << ::leeway::dataFolder() << "/" << (file) << " (set LEEWAY_DATA)"

}  // namespace leeway
