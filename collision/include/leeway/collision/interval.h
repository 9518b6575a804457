#pragma once

#include <limits>

namespace leeway::collision {

/// A guaranteed enclosure of a real number: lower <= value <= upper, rounding included.
struct Interval {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();

  double width() const { return upper - lower; }
};

}  // namespace leeway::collision
