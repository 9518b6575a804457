#pragma once

#include <string>

namespace leeway::robots {

/// The usual folder for LoadOptions::cache, which the command takes: $LEEWAY_CACHE_DIR; where that
/// is not set, `leeway` in $XDG_CACHE_HOME; else ~/.cache/leeway. Empty where the first is set and
/// empty, or there is no home. The folder need not be there.
std::string cacheFolder();

}  // namespace leeway::robots
