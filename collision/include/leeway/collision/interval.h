#pragma once

#include <limits>

namespace leeway::collision {

/// A guaranteed enclosure of a real number, rounding included: lower <= value <= upper.
struct Interval {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();

  double width() const { return upper - lower; }
};

}  // namespace leeway::collision
