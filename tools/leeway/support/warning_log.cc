#include "tools/leeway/support/warning_log.h"

#include <fmt/format.h>

#include <cstdio>

#include "tools/leeway/support/terminal.h"

namespace leeway::tools {
namespace {

bool isDigit(char c) { return c >= '0' && c <= '9'; }

// The position of the ": " after the first ":line"; npos if there is none. Searches by hand,
// because std::regex ends the process on long texts, and files may contain anything.
std::size_t endOfPlace(const std::string& warning) {
  for (std::size_t end = warning.find(": "); end != std::string::npos;
       end = warning.find(": ", end + 1)) {
    std::size_t digits = end;
    while (digits > 0 && isDigit(warning[digits - 1])) --digits;
    if (digits < end && digits > 0 && warning[digits - 1] == ':') return end;
  }
  return std::string::npos;
}

}  // namespace

void WarningLog::print(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) {
    const std::size_t end = endOfPlace(warning);
    const bool placed = end != std::string::npos;
    const std::string place = placed ? warning.substr(0, end) : std::string();
    const auto [entry, first] = texts_.try_emplace(placed ? warning.substr(end + 2) : warning);
    if (entry->second.places.insert(place).second) entry->second.last = place;
    if (!first || isQuiet()) continue;
    printMessage("warning: " + warning);
  }
}

void WarningLog::printCounts() const {
  for (const auto& [text, followers] : texts_) {
    const std::size_t more = followers.places.size() - 1;
    if (more > 0 && !isQuiet()) {
      printMessage(fmt::format("warning: in {} more {}, last {}: {}", more,
                               more == 1 ? "place" : "places", followers.last, text));
    }
  }
}

}  // namespace leeway::tools
