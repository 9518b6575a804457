#pragma once

#include <cmath>

namespace leeway::collision {

/// The greater of two numbers; NaN where one is: a margin of NaN is never kept, and must not drop
/// out as in std::max.
inline double greatest(double x, double y) { return std::isnan(x) || x >= y ? x : y; }

}  // namespace leeway::collision
