#pragma once

#include <concepts>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <variant>
#include <vector>

namespace leeway::tools::report {

/// Rows below named columns, whose names contain their units. Writes CSV and JSON, and gives the
/// cells as text for people.
class Table {
 public:
  /// Empty, or a number that is NaN: an empty cell of CSV, a dash for people.
  class Cell {
   public:
    Cell() = default;
    Cell(std::string text) : value_(std::move(text)) {}
    Cell(const char* text) : value_(std::string(text)) {}
    Cell(double number);
    template <std::integral Integer>
    Cell(Integer number) : value_(static_cast<std::int64_t>(number)) {}
    /// The number, or empty where it does not apply.
    static Cell onlyIf(bool applies, int number) { return applies ? Cell(number) : Cell(); }

   private:
    friend class Table;
    std::variant<std::monostate, std::string, std::int64_t, double> value_;
  };
  struct Column {
    /// "NAME" or "NAME:DIGITS".
    Column(const char* text);
    Column(std::string column, std::string format)
        : name(std::move(column)), digits(std::move(format)) {}
    std::string name;
    std::string digits = ".4g";  ///< of numbers other than integers, as fmt::format() takes them
  };

  /// `keys`: how many of the first columns name a row; people see them in one column.
  explicit Table(std::vector<Column> columns, std::size_t keys = 1)
      : columns_(std::move(columns)), keys_(keys) {}
  /// Adds a row with one cell for each column.
  void add(std::vector<Cell> cells);

  /// A header and one line for each row. Text with a comma or a quote is quoted (RFC 4180).
  std::string csv() const;
  /// An array with an object for each row. Numbers have all their digits; an empty cell is null.
  nlohmann::ordered_json json() const;
  /// Names of the columns, cells, and the places of columns that contain text, as people see them.
  std::vector<std::string> heading() const;
  std::vector<std::vector<std::string>> rows() const;
  std::vector<std::size_t> textColumns() const;

 private:
  std::string textOf(std::size_t column, const Cell& cell) const;
  std::vector<std::string> joined(const std::vector<std::string>& cells) const;
  std::vector<Column> columns_;
  std::size_t keys_;
  std::vector<std::vector<Cell>> rows_;
};

}  // namespace leeway::tools::report
