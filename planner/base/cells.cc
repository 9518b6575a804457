#include "planner/base/cells.h"

#include <algorithm>

#include "robots/mesh/scan.h"

namespace leeway::planner {

std::string_view withoutBlanks(std::string_view text) {
  const std::size_t first = std::min(text.find_first_not_of(" \t"), text.size());
  return text.substr(first, text.find_last_not_of(" \t") + 1 - first);
}

std::vector<std::string_view> wordsOf(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t i = 0; i < line.size();) {
    while (i < line.size() && robots::isBlank(line[i])) ++i;
    const std::size_t begin = i;
    while (i < line.size() && !robots::isBlank(line[i])) ++i;
    if (i > begin) words.push_back(line.substr(begin, i - begin));
  }
  return words;
}

std::vector<std::string_view> cellsBetween(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t end = line.find(separator);
    cells.push_back(withoutBlanks(line.substr(0, end)));
    if (end == std::string_view::npos) return cells;
    line.remove_prefix(end + 1);
  }
}

bool hasTabs(std::string_view line) {
  if (line.find('\t') == std::string_view::npos) return false;
  const std::vector<std::string_view> cells = cellsBetween(line, '\t');
  return std::none_of(cells.begin(), cells.end(), [](std::string_view cell) {
    return cell.find(' ') != std::string_view::npos;
  });
}

std::vector<std::string_view> blankCells(std::string_view line) {
  return hasTabs(line) ? cellsBetween(line, '\t') : wordsOf(line);
}

}  // namespace leeway::planner
