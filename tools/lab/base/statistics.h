#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

namespace leeway::tools::report {

/// The element at index share * n of the n sorted values, at most the last, never interpolated; NaN
/// if there is none. O(n log n).
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const auto index = static_cast<std::size_t>(share * static_cast<double>(values.size()));
  return values[std::min(values.size() - 1, index)];
}

/// The median; the upper one of two middle values.
inline double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

}  // namespace leeway::tools::report
