#pragma once

#include <cmath>

namespace leeway::collision {

/// The greater of two numbers; NaN if one is NaN. A margin of NaN is never kept, so it must not be
/// dropped as std::max does.
inline double greatest(double x, double y) { return std::isnan(x) || x >= y ? x : y; }

}  // namespace leeway::collision
