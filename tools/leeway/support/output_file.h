#pragma once

#include <span>
#include <string>
#include <string_view>

namespace leeway::tools {

/// Throws robots::InputError for a name whose ending is none of `endings` (".csv", ...) and for one
/// in a folder that is not there or may not be written: found out before the work is done rather
/// than after it.
void checkOutputFile(const std::string& file, std::span<const std::string_view> endings);

/// Throws robots::InputError where an output is the same file as an input or another output, by
/// whatever name: it would be lost. Empty names are none.
void expectApart(std::span<const std::string> outputs, std::span<const std::string> inputs);

}  // namespace leeway::tools
