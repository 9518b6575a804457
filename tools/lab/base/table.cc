#include "tools/lab/base/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace leeway::tools::report {

Table::Cell::Cell(double number) {
  if (!std::isnan(number)) value_ = number;
}

Table::Column::Column(const char* text) : name(text) {
  const std::size_t colon = name.find(':');
  if (colon == std::string::npos) return;
  digits = name.substr(colon + 1);
  name.erase(colon);
}

void Table::add(std::vector<Cell> cells) {
  if (cells.size() != columns_.size())
    throw std::logic_error(
        fmt::format("a row of {} cells for {} columns", cells.size(), columns_.size()));
  rows_.push_back(std::move(cells));
}

std::string Table::textOf(std::size_t column, const Cell& cell) const {
  if (const auto* text = std::get_if<std::string>(&cell.value_)) return *text;
  if (const auto* count = std::get_if<std::int64_t>(&cell.value_)) return std::to_string(*count);
  if (const auto* number = std::get_if<double>(&cell.value_))
    return fmt::format(fmt::runtime("{:" + columns_[column].digits + "}"), *number);
  return "";
}

std::string Table::csv() const {
  const auto quoted = [](const std::string& text) {
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string result = "\"";
    for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
    return result + '"';
  };
  std::string text;
  for (std::size_t c = 0; c < columns_.size(); ++c)
    text += (c > 0 ? "," : "") + quoted(columns_[c].name);
  text += '\n';
  for (const std::vector<Cell>& row : rows_) {
    for (std::size_t c = 0; c < row.size(); ++c)
      text += (c > 0 ? "," : "") + quoted(textOf(c, row[c]));
    text += '\n';
  }
  return text;
}

nlohmann::ordered_json Table::json() const {
  auto all = nlohmann::ordered_json::array();
  for (const std::vector<Cell>& row : rows_) {
    nlohmann::ordered_json object;
    for (std::size_t c = 0; c < row.size(); ++c)
      std::visit(
          [&](const auto& value) {
            if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::monostate>)
              object[columns_[c].name] = nullptr;
            else
              object[columns_[c].name] = value;
          },
          row[c].value_);
    all.push_back(std::move(object));
  }
  return all;
}

std::vector<std::string> Table::joined(const std::vector<std::string>& cells) const {
  const auto first = cells.begin() + static_cast<std::ptrdiff_t>(keys_);
  std::vector<std::string> all = {fmt::format("{}", fmt::join(cells.begin(), first, ", "))};
  all.insert(all.end(), first, cells.end());
  return all;
}

std::vector<std::string> Table::heading() const {
  std::vector<std::string> names;
  for (const Column& column : columns_) names.push_back(column.name);
  return joined(names);
}

std::vector<std::vector<std::string>> Table::rows() const {
  std::vector<std::vector<std::string>> rows;
  for (const std::vector<Cell>& row : rows_) {
    std::vector<std::string> cells;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const bool is_empty = std::holds_alternative<std::monostate>(row[c].value_);
      cells.push_back(is_empty ? "-" : textOf(c, row[c]));
    }
    rows.push_back(joined(cells));
  }
  return rows;
}

std::vector<std::size_t> Table::textColumns() const {
  std::vector<std::size_t> places = {0};
  for (std::size_t c = keys_; c < columns_.size(); ++c)
    if (std::any_of(rows_.begin(), rows_.end(), [&](const std::vector<Cell>& row) {
          return std::holds_alternative<std::string>(row[c].value_);
        }))
      places.push_back(c - keys_ + 1);
  return places;
}

}  // namespace leeway::tools::report
