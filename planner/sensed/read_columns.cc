#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "leeway/robots/text.h"
#include "planner/sensed/cloud_source.h"
#include "robots/base/read_file.h"
#include "robots/mesh/mesh_source.h"
#include "robots/mesh/scan.h"

namespace leeway::planner {
namespace {

char separatorOf(std::string_view line) {
  return line.find(';') != std::string_view::npos   ? ';'
         : line.find(',') != std::string_view::npos ? ','
         : hasTabs(line)                            ? '\t'
                                                    : ' ';
}

std::vector<std::string_view> cellsOf(std::string_view line, char separator) {
  std::vector<std::string_view> cells =
      separator == ' ' ? blankCells(line) : cellsBetween(line, separator);
  for (std::string_view& cell : cells)
    if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"')
      cell = cell.substr(1, cell.size() - 2);
  return cells;
}

bool isAxis(std::string_view cell, std::size_t axis) {
  return cell.size() == 1 && (cell[0] == "xyz"[axis] || cell[0] == "XYZ"[axis]);
}

bool namesAxes(const std::vector<std::string_view>& names) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (std::count_if(names.begin(), names.end(),
                      [&](std::string_view name) { return isAxis(name, axis); }) != 1)
      return false;
  return true;
}

/// The columns that a comment above the rows names x, y and z; else the first three.
std::array<std::size_t, 3> columnsOfComment(const std::vector<std::string_view>& names) {
  std::array<std::size_t, 3> columns{0, 1, 2};
  for (std::size_t i = 0; i < names.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (isAxis(names[i], axis)) columns[axis] = i;
  return columns;
}

/// Whether a comment has the word qw, or x, y and z once each, beside each other in another order.
bool isUnclear(std::string_view comment) {
  std::vector<std::string_view> words;
  const auto isPart = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  for (std::size_t i = 0, begin = 0; i <= comment.size(); ++i) {
    if (i < comment.size() && isPart(comment[i])) continue;
    if (i > begin) words.push_back(comment.substr(begin, i - begin));
    begin = i + 1;
  }
  if (std::find(words.begin(), words.end(), "qw") != words.end()) return true;
  const std::array<std::size_t, 3> columns = columnsOfComment(words);
  const auto [first, last] = std::minmax_element(columns.begin(), columns.end());
  return namesAxes(words) && *last - *first == 2 && !std::is_sorted(columns.begin(), columns.end());
}

/// The columns of x, y and z by name, or those of the comment where the line has numbers.
std::array<std::size_t, 3> findColumns(const CloudSource& source, const ColumnRow& row,
                                       bool& is_header) {
  const std::vector<std::string_view>& cells = row.cells;
  is_header = std::none_of(cells.begin(), cells.end(), [](std::string_view cell) {
    return robots::parseNumber(cell).has_value();
  });
  if (!is_header) {
    refuseUnclearNames(source, row);
    return columnsOfComment(row.names);
  }
  std::array<std::size_t, 3> columns{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const char small = "xyz"[axis];
    const auto is_it = [axis](std::string_view cell) { return isAxis(cell, axis); };
    const auto found = std::find_if(cells.begin(), cells.end(), is_it);
    if (std::count_if(cells.begin(), cells.end(), is_it) > 1)
      source.fail({row.line, 0},
                  fmt::format("two columns are named '{}'; one of each is expected", small));
    if (found == cells.end())
      source.fail({row.line, 0},
                  fmt::format("begins with {}, and no column is named '{}'; numbers, or the names "
                              "of columns with x, y and z, are expected",
                              robots::shown(cells.empty() ? std::string_view() : cells[0]), small));
    columns[axis] = static_cast<std::size_t>(found - cells.begin());
  }
  return columns;
}

}  // namespace

void eachRow(const CloudSource& source, const std::function<void(const ColumnRow&)>& visit) {
  std::string_view rest = source.text();
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  if (const std::size_t zero = rest.find('\0'); zero != std::string_view::npos)
    source.fail({0, source.text().size() - rest.size() + zero},
                "a byte of value 0, which no text has; a text with numbers in columns is expected");
  std::size_t width = 0;
  char separator = ' ';
  std::vector<std::pair<std::size_t, std::string_view>> comments;  // with their lines
  for (std::size_t line = 1; !rest.empty(); ++line) {
    source.pause(line);
    const std::string_view text = robots::takeLine(rest), shown = withoutBlanks(text);
    if (shown.starts_with('#') || shown.starts_with("//")) {
      if (width == 0)
        comments.emplace_back(line,
                              shown.substr(std::min(shown.find_first_not_of("#/"), shown.size())));
      continue;
    }
    const auto tabs = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\t'));
    const bool is_row_of_tabs = separator == '\t' && tabs + 1 == width;
    const bool is_blank = std::all_of(shown.begin(), shown.end(), robots::isBlank);
    if (is_blank && !is_row_of_tabs) continue;
    if (width == 0) separator = separatorOf(text);
    ColumnRow row{line, cellsOf(text, separator)};
    if (width == 0) {
      width = row.cells.size();
      for (const auto& [at, comment] : comments) {
        std::vector<std::string_view> names = cellsOf(comment, separatorOf(comment));
        if (names.size() == width && namesAxes(names))
          row.names = std::move(names);
        else if (isUnclear(comment))
          row.unclear_names = at;
      }
      if (!row.names.empty()) row.unclear_names.reset();
    }
    if (row.cells.size() != width)
      source.fail({line, 0}, fmt::format("the line has {} columns; {}, as the first, are expected",
                                         row.cells.size(), width));
    visit(row);
  }
}

void refuseUnclearNames(const CloudSource& source, const ColumnRow& first) {
  if (first.unclear_names)
    source.fail({*first.unclear_names, 0},
                "the comment seems to name columns, but has not one word for each; a line of names "
                "alone, with or without '#', is expected");
}

void readColumns(const CloudSource& source, PointSink& sink) {
  std::array<std::size_t, 3> columns{};
  bool is_first = true;
  eachRow(source, [&](const ColumnRow& row) {
    if (std::exchange(is_first, false)) {
      bool is_header = false;
      columns = findColumns(source, row, is_header);
      if (row.cells.size() < 3)
        source.fail({row.line, 0}, fmt::format("the line has {} of x, y and z; all three are "
                                               "expected",
                                               row.cells.size()));
      if (is_header) return;
    }
    double p[3];
    for (std::size_t axis = 0; axis < 3; ++axis)
      p[axis] = readCoordinate(source, row.cells[columns[axis]], {row.line, 0});
    sink.add(p, {row.line, 0});
  });
}

}  // namespace leeway::planner
