#pragma once

#include <span>
#include <string>
#include <string_view>

namespace leeway::tools {

/// Throws robots::InputError for a name whose ending is none of `endings` (".csv", ...) and for one
/// in a folder that is not there: found out before the work is done rather than after it.
void checkOutputFile(const std::string& file, std::span<const std::string_view> endings);

}  // namespace leeway::tools
