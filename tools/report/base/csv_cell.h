#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace leeway::tools::report {

/// A number of a CSV file, in four digits; NaN is an empty cell.
inline std::string csvCell(double value) {
  return std::isnan(value) ? std::string() : fmt::format("{:.4g}", value);
}

}  // namespace leeway::tools::report
