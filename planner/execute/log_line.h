#pragma once

// Private: how the lines of a log begin and end.

#include <cstdint>
#include <string_view>

#include "robots/base/fnv.h"

namespace leeway::planner {

/// The version of these documents (docs/json.md).
inline constexpr int kLogVersion = 2;

/// The sum of a line, of its text before the key `sum`.
inline std::uint64_t lineSum(std::string_view text) { return robots::fnv1a(text); }

/// A line ends with this, the sum as 16 hexadecimal digits, and kAfterSum.
inline constexpr std::string_view kBeforeSum = ",\"sum\":\"", kAfterSum = "\"}";

}  // namespace leeway::planner
