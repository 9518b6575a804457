#pragma once

#include <cstddef>
#include <limits>

namespace leeway {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Numbers of links, vertices and states are int in interfaces; containers want std::size_t.
constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace leeway
