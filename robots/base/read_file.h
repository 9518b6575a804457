#pragma once

// Private to the layers above collision/: reads whole files.

#include <cstddef>
#include <string>
#include <string_view>

namespace leeway::robots {

/// Limit on the size of a text, and on the bytes that are read [B].
inline constexpr std::size_t kLongestText = std::size_t{256} << 20;

/// Returns the text of a file or pipe, without a byte order mark; each line ends with a line feed,
/// whether it is LF, CRLF or CR in the file. `kind` names the expected content
/// in messages ("a URDF file"). Throws InputError for files that cannot be read, folders, devices,
/// a pipe without data for 10 s, more than `limit` bytes, and bytes that do not occur in texts (0).
/// O(size).
std::string readTextFile(const std::string& path, std::string_view kind,
                         std::size_t limit = kLongestText);

/// Returns the bytes of a file or pipe with any content; otherwise as readTextFile().
std::string readBinaryFile(const std::string& path, std::string_view kind, std::size_t limit);

/// The last dot of a file's name and the text after it, in lower case: ".csv". Empty without one.
std::string endingOf(const std::string& path);

/// The next line of `rest`, without its end (LF, CRLF or CR), which is removed from `rest`, too.
std::string_view takeLine(std::string_view& rest);

/// Whether the last line of a text has an end (a line feed or carriage return), or nothing is in
/// it. If not, the file may have been cut within a number that still reads as one.
bool lastLineEnds(std::string_view text);
/// The text of a warning about such a line.
inline constexpr std::string_view kLastLineOpen =
    "the last line does not end; if the file was cut, a number may have lost digits, and lines may "
    "be missing";

}  // namespace leeway::robots
