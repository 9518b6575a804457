#pragma once

#include <string>
#include <string_view>

namespace leeway::tools {

/// Writes `text` to `path` whole or not at all: a temporary file beside it, then rename. Throws
/// robots::InputError when it cannot; a file that was there is then as it was.
void writeWhole(const std::string& path, std::string_view text);

}  // namespace leeway::tools
