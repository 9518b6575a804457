#pragma once

// Private to the layers above collision/: files as a whole.

#include <cstddef>
#include <string>
#include <string_view>

namespace leeway::robots {

/// Texts are refused beyond this size, and no more than this is read [B].
inline constexpr std::size_t kLongestText = std::size_t{256} << 20;

/// The text of a file or pipe, without a byte order mark. `kind` says what is expected in its place
/// ("a URDF file"). Throws InputError for what cannot be read, folders, devices, a pipe to which
/// nobody writes within 10 s, more than `limit` bytes, and bytes that no text has (0). O(size).
std::string readTextFile(const std::string& path, std::string_view kind,
                         std::size_t limit = kLongestText);

/// The bytes of a file or pipe, whatever they are; otherwise as readTextFile().
std::string readBinaryFile(const std::string& path, std::string_view kind, std::size_t limit);

}  // namespace leeway::robots
