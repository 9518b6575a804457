#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "leeway/collision/interval.h"

namespace leeway::tools {

/// Decimal numbers that stay true bounds: rounded down, or up, at `digits` decimals. Infinity is
/// "-".
std::string formatLower(double value, int digits);
std::string formatUpper(double value, int digits);
/// The same rounded to the nearest one, for values that are not bounds. Never "-0.00".
std::string formatNear(double value, int digits);

/// The number of millimetres that both ends of an interval [m] round to, at two decimals; nothing
/// if they differ. Ends within 1e-8 m count as the same number, the lower one.
std::optional<std::string> figureOf(const collision::Interval& clearance);
/// A clearance for people, with its unit. It is the interval's figure. If the interval has none and
/// is at most 2e-6 m wide, it is the figure of the lower end, which is within 0.01 mm of the true
/// value. Wider intervals give "between", "at least" and "at most", rounded outwards. Overlaps are
/// "deep". (inf, inf) is "nothing near".
std::string clearanceText(const collision::Interval& clearance);
std::string counted(std::size_t count, const std::string& what);  ///< "1 edge", "2 edges"

}  // namespace leeway::tools
