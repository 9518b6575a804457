#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace leeway::robots {

/// The number that the whole text is, in decimal notation ("inf" and "nan" are), a plus sign before
/// it allowed; nothing otherwise. Does not depend on the locale.
std::optional<double> parseNumber(std::string_view text);

/// The same for finite numbers alone.
std::optional<double> parseFinite(std::string_view text);

/// Which of the candidates `name` was probably meant to be: fewest insertions, deletions,
/// substitutions and swaps of neighbours, case ignored (optimal string alignment); null when all
/// are so far that a hint would mislead. O(candidates x length^2).
const std::string* nearestName(std::string_view name, std::span<const std::string> candidates);

}  // namespace leeway::robots
