#pragma once

// Private to the layers above collision/: sums of texts.

#include <cstdint>
#include <string_view>

namespace leeway::robots {

/// FNV-1a, 64 bits, of a text that follows one of the sum `sum`. It shows accidental changes. It is
/// not a signature, because whoever changes a text can compute its sum.
inline std::uint64_t fnv1a(std::string_view text, std::uint64_t sum = 0xcbf29ce484222325) {
  for (const char c : text) sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return sum;
}

}  // namespace leeway::robots
