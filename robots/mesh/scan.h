#pragma once

// Private to the layers above collision/: words, lines and numbers of text and binary data.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "leeway/robots/text.h"
#include "robots/mesh/mesh_source.h"

namespace leeway::robots {

/// Larger magnitudes are rejected by readers: no shape is that large in any unit, and the exact
/// predicates have room up to 1e90.
inline constexpr double kGreatestCoordinate = 1e60;

constexpr bool isBlank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v';
}

/// The words of a text, one after the other, with their lines.
class Words {
 public:
  /// Lines end with LF, CRLF or CR.
  explicit Words(std::string_view text, std::int64_t line = 1)
      : at_(text.data()), end_(text.data() + text.size()), line_(line) {}

  /// The next word; empty at the end.
  std::string_view next() {
    for (; at_ != end_ && isBlank(*at_); ++at_)
      if (*at_ == '\n' || (*at_ == '\r' && (at_ + 1 == end_ || at_[1] != '\n'))) ++line_;
    const char* const begin = at_;
    while (at_ != end_ && !isBlank(*at_)) ++at_;
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }
  /// The rest of the line after the last word.
  std::string_view restOfLine() {
    const char* const begin = at_;
    at_ = std::find_if(at_, end_, [](char c) { return c == '\n' || c == '\r'; });
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }
  /// Whether only blanks are left.
  bool atEnd() const { return std::all_of(at_, end_, isBlank); }
  /// The place of the last word.
  FilePlace place() const { return FilePlace::line(line_); }
  std::int64_t line() const { return line_; }

 private:
  const char* at_;
  const char* end_;
  std::int64_t line_;
};

/// Parses a whole word as a coordinate. Fails unless it is a finite number.
inline double coordinate(const MeshSource& source, std::string_view word, FilePlace place) {
  const std::optional<double> value = parseNumber(word);
  if (value && std::abs(*value) <= kGreatestCoordinate) return *value;
  source.failAt(place, word.empty()
                           ? "ends where a coordinate is expected; a finite number would be "
                             "accepted"
                       : !value ? shown(word) +
                                      " stands where a coordinate is expected; a finite number "
                                      "would be accepted"
                                : "the coordinate " + shown(word) +
                                      (std::isfinite(*value)
                                           ? " is too large; up to 1e60 would be accepted"
                                           : " is not finite; a finite number would be accepted"));
}

/// A number in binary data, little-endian or big-endian.
template <class T>
T loadNumber(const std::byte* from, std::endian order = std::endian::little) {
  std::byte bytes[sizeof(T)];
  std::memcpy(bytes, from, sizeof(T));
  if (order != std::endian::native) std::reverse(bytes, bytes + sizeof(T));
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

/// Fails unless `count`, of vertices or corners, fits into their 32-bit numbers.
inline void requireCountable(const MeshSource& source, std::size_t count, FilePlace place) {
  if (count > std::size_t{0x7FFFFFFF})
    source.failAt(place, "holds more than 2147483647 vertices or corners, the most that is read");
}

}  // namespace leeway::robots
