#pragma once

// Private: how the lines of a log begin and end.

#include <cstdint>
#include <string_view>

namespace leeway::planner {

/// The version of the documents, as of all that the command prints (docs/json.md).
inline constexpr int kLogVersion = 1;

/// The sum of a line: FNV-1a, 64 bits, of its text before the key `sum`. It shows accidental
/// changes. It is not a signature, because whoever changes a line can compute its sum.
inline std::uint64_t lineSum(std::string_view text) {
  std::uint64_t sum = 0xcbf29ce484222325;
  for (const char c : text) sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return sum;
}

/// A line ends with this, the sum as 16 hexadecimal digits, and kAfterSum.
inline constexpr std::string_view kBeforeSum = ",\"sum\":\"", kAfterSum = "\"}";

}  // namespace leeway::planner
