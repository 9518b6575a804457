#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace leeway::planner {

/// Levenshtein's distance of two words: the edits that turn one into the other. O(|a| |b|).
inline std::size_t editDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

/// Capitals to small letters, the star of RRT* to the word that OMPL's class names use.
inline std::string normalizedName(std::string_view name) {
  std::string result;
  for (const char c : name) {
    if (c == '*')
      result += "star";
    else
      result += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return result;
}

/// The candidate nearest to a misspelt name, the first of equals; empty without candidates.
inline std::string nearestName(std::string_view name, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t best_distance = static_cast<std::size_t>(-1);
  for (const std::string& candidate : candidates) {
    const std::size_t d = editDistance(normalizedName(name), normalizedName(candidate));
    if (d < best_distance) {
      best_distance = d;
      best = candidate;
    }
  }
  return best;
}

}  // namespace leeway::planner
