#pragma once

// Private to the layers above collision/: numbers in binary files whose types the file specifies.

#include <bit>
#include <cstddef>
#include <optional>
#include <string_view>

namespace leeway::robots {

struct NumberType {
  enum class Kind : unsigned char { kSigned, kUnsigned, kFloat };
  Kind kind = Kind::kFloat;
  std::size_t size = 4;  ///< 1, 2, 4 or 8 bytes; a float has 4 or 8
};

/// Returns the type for a name in PLY files, "uchar" or "float32"; nullopt for other words.
std::optional<NumberType> plyType(std::string_view word);

/// Reads type.size bytes. Whole numbers beyond 2^53 are rounded.
double loadNumber(const std::byte* from, NumberType type, std::endian order);

}  // namespace leeway::robots
