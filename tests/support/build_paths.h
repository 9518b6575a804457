#pragma once

#include <filesystem>
#include <string>

namespace leeway {

/// The source tree's root. A function in its own file: only that file depends on the checkout's
/// path, so a compiler cache serves all others.
std::string sourceFolder();
/// Robots and problems of others, beside the project; LEEWAY_DATA overrides. May be absent.
std::string dataFolder();

/// This build's leeway command; empty if it is not built.
std::string commandFile();

/// Skips a test that needs this file or folder of dataFolder().
#define LEEWAY_NEEDS_DATA(file)                                        \
  if (!std::filesystem::exists(::leeway::dataFolder() + "/" + (file))) \
  GTEST_SKIP() << "needs " << ::leeway::dataFolder() << "/" << (file) << " (set LEEWAY_DATA)"

}  // namespace leeway
