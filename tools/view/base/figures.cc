#include "tools/view/base/figures.h"

#include <fmt/format.h>

#include <cmath>

namespace leeway::tools {
namespace {

std::string formatRounded(double value, int digits, double (*round)(double)) {
  if (!std::isfinite(value)) {
    return "-";
  }
  const double scale = std::pow(10.0, digits);
  // + 0.0 turns -0 into 0.
  return fmt::format("{:.{}f}", round(value * scale) / scale + 0.0, digits);
}

}  // namespace

std::string formatLower(double value, int digits) {
  return formatRounded(value, digits, std::floor);
}
std::string formatUpper(double value, int digits) {
  return formatRounded(value, digits, std::ceil);
}

std::string formatNear(double value, int digits) {
  return formatRounded(value, digits, std::round);
}

std::optional<std::string> figureOf(const collision::Interval& clearance) {
  constexpr double kOneNumber = 1e-8;  // [m]
  const auto rounded = [](double metres) { return std::round(metres * 1e5) / 100 + 0.0; };
  const double figure = rounded(clearance.lower);
  if (!std::isfinite(clearance.lower) || !std::isfinite(clearance.upper)) return {};
  if (rounded(clearance.upper) != figure && !(clearance.width() <= kOneNumber)) return {};
  return fmt::format("{:.2f}", figure);
}

std::string clearanceText(const collision::Interval& clearance) {
  if (clearance.upper < 0) return clearanceText({-clearance.upper, -clearance.lower}) + " deep";
  constexpr double kNarrow = 2e-6;  // less than the last shown digit [m]
  if (const auto figure = figureOf(
          {clearance.lower, clearance.width() <= kNarrow ? clearance.lower : clearance.upper}))
    return *figure + " mm";
  const std::string lower = formatLower(clearance.lower * 1e3, 2),
                    upper = formatUpper(clearance.upper * 1e3, 2);
  if (std::isfinite(clearance.upper))
    return std::isfinite(clearance.lower) ? fmt::format("between {} and {} mm", lower, upper)
                                          : fmt::format("at most {} mm", upper);
  return std::isfinite(clearance.lower) ? fmt::format("at least {} mm", lower)
         : clearance.lower > 0          ? "nothing near"
                                        : "not known";
}

std::string counted(std::size_t count, const std::string& what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

}  // namespace leeway::tools
