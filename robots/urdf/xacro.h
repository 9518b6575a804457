#pragma once

// Private to robots/: xacro files, by the program that expands them.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "leeway/robots/stopped.h"

namespace leeway::robots {

/// Whether a file is one for xacro, by its ending.
bool isXacro(const std::string& path);

/// What `xacro PATH NAME:=VALUE...` writes to its output; nothing where no such program is
/// installed (PATH). No shell is involved. Throws InputError that names the file: with all messages
/// of the program where it fails, for more than kLongestText bytes, where nothing comes for a
/// minute, and for a name that xacro would not read as one. Throws Stopped, and ends the program,
/// once `stop` is true.
std::optional<std::string> expandXacro(
    const std::string& path, const std::vector<std::pair<std::string, std::string>>& arguments = {},
    const Stop& stop = {});

}  // namespace leeway::robots
