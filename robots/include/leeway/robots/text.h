#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace leeway::robots {

/// The whole text as a decimal number, correctly rounded, "inf" and "nan" included; a plus sign may
/// precede it. Beyond the range of doubles it is infinite, below it 0. Nothing for any other text.
/// Independent of the locale.
std::optional<double> parseNumber(std::string_view text);

/// parseNumber() for finite numbers only.
std::optional<double> parseFinite(std::string_view text);

/// The candidate that `name` was probably meant to be: the nearest in optimal string alignment
/// (insertions, deletions, substitutions, swaps of neighbours), case ignored. Null when none is
/// near. O(candidates x length^2).
const std::string* nearestName(std::string_view name, std::span<const std::string> candidates);

}  // namespace leeway::robots
