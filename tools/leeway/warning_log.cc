#include "tools/leeway/warning_log.h"

#include <fmt/format.h>

#include <cstdio>
#include <regex>

namespace leeway::tools {

void WarningLog::print(const std::vector<std::string>& warnings) {
  // The shortest start that ends in ":line: "; warnings without one are texts whole.
  static const std::regex place_and_text(R"(^([^\n]*?:\d+): ([^]*)$)");
  for (const std::string& warning : warnings) {
    std::smatch match;
    const bool placed = std::regex_match(warning, match, place_and_text);
    const std::string place = placed ? match.str(1) : std::string();
    const auto [entry, first] = texts_.try_emplace(placed ? match.str(2) : warning);
    if (entry->second.places.insert(place).second) entry->second.last = place;
    if (first) fmt::print(stderr, "warning: {}\n", warning);
  }
}

void WarningLog::printCounts() const {
  for (const auto& [text, followers] : texts_) {
    const std::size_t more = followers.places.size() - 1;
    if (more > 0) {
      fmt::print(stderr, "warning: in {} more {}, last {}: {}\n", more,
                 more == 1 ? "place" : "places", followers.last, text);
    }
  }
}

}  // namespace leeway::tools
