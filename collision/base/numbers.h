#pragma once

#include <cstddef>
#include <limits>

namespace leeway {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Converts a number to an index, because interfaces count in int and containers in std::size_t.
constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace leeway
