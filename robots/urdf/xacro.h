#pragma once

// Private to robots/: xacro files, by the program that expands them.

#include <optional>
#include <string>

#include "leeway/robots/stopped.h"

namespace leeway::robots {

/// What `xacro PATH` writes to its output; nothing where no such program is installed (PATH). No
/// shell is involved. Throws InputError, naming the file, with the last line of its messages where
/// it fails, for more than kLongestText bytes, and where nothing comes for a minute;
/// Stopped, and the program is ended, where `stop` says so.
std::optional<std::string> expandXacro(const std::string& path, const Stop& stop = {});

}  // namespace leeway::robots
