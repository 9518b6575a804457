#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace leeway::tools::report {

/// The smallest element that at least the given share of all elements do not exceed, never
/// interpolated; NaN when there is none. 0.5: the upper median. O(n log n).
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const auto index = static_cast<std::size_t>(share * static_cast<double>(values.size()));
  return values[std::min(values.size() - 1, index)];
}

}  // namespace leeway::tools::report
