#pragma once

#include <span>
#include <string>
#include <string_view>

namespace leeway::tools {

/// Throws robots::InputError unless the name has one of `endings` (".csv", ...) and its folder
/// exists and may be written. Verbs call it before their work, so that no work is lost.
void checkOutputFile(const std::string& file, std::span<const std::string_view> endings);

/// Throws robots::InputError if an output is the same file as an input or another output, even
/// under another name, because it would be overwritten. Ignores empty names.
void expectApart(std::span<const std::string> outputs, std::span<const std::string> inputs);

}  // namespace leeway::tools
