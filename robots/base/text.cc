#include "leeway/robots/text.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <vector>

namespace leeway::robots {
namespace {

char lowered(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

/// Insertions, deletions, substitutions and swaps of neighbours that turn a into b, case ignored
/// (optimal string alignment).
std::size_t editDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> two_back(b.size() + 1), previous(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) previous[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = lowered(a[i - 1]) == lowered(b[j - 1]);
      row[j] = std::min({previous[j] + 1, row[j - 1] + 1, previous[j - 1] + (same ? 0 : 1)});
      if (i > 1 && j > 1 && lowered(a[i - 1]) == lowered(b[j - 2]) &&
          lowered(a[i - 2]) == lowered(b[j - 1]))
        row[j] = std::min(row[j], two_back[j - 2] + 1);
    }
    two_back.swap(previous);
    previous.swap(row);
  }
  return previous[b.size()];
}

/// Rounds a decimal number outside the range of doubles: to 0 or infinity.
double outOfRange(std::string_view number) {
  const bool negative = number.front() == '-';
  const std::size_t mantissa_end = std::min(number.find_first_of("eE"), number.size());
  long power = 0;  // power of ten above the first digit that is not 0
  bool after_point = false, significant = false;
  for (const char c : number.substr(0, mantissa_end)) {
    if (c == '.') after_point = true;
    if (c < '0' || c > '9') continue;
    significant = significant || c != '0';
    if (significant && !after_point) ++power;
    if (!significant && after_point) --power;
  }
  std::string_view exponent = number.substr(std::min(mantissa_end + 1, number.size()));
  const bool small = exponent.starts_with('-');
  if (small || exponent.starts_with('+')) exponent.remove_prefix(1);
  long size = 0;
  for (const char c : exponent) size = std::min(10 * size + (c - '0'), 1L << 40);
  const double magnitude =
      power + (small ? -size : size) > 0 ? std::numeric_limits<double>::infinity() : 0;
  return negative ? -magnitude : magnitude;
}

}  // namespace

std::optional<double> parseNumber(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size()) return std::nullopt;
  if (error == std::errc::result_out_of_range) return outOfRange(text);
  if (error != std::errc()) return std::nullopt;
  return value;
}

std::optional<double> parseFinite(std::string_view text) {
  const std::optional<double> value = parseNumber(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

const std::string* nearestName(std::string_view name, std::span<const std::string> candidates) {
  std::size_t best = name.size() / 3 + 2;
  const std::string* nearest = nullptr;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = editDistance(name, candidate);
    if (distance < best) {
      best = distance;
      nearest = &candidate;
    }
  }
  return nearest;
}

}  // namespace leeway::robots
