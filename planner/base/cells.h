#pragma once

#include <string_view>
#include <vector>

namespace leeway::planner {

/// Returns the text without spaces and tabs at its ends.
std::string_view withoutBlanks(std::string_view text);

/// Returns the words of a line: what white space parts.
std::vector<std::string_view> wordsOf(std::string_view line);

/// Returns whether single tabs part the cells of a line: it has a tab, and no cell has blanks
/// inside. Two tabs then have an empty cell between them, and so do a tab and an end of the line.
bool hasTabs(std::string_view line);

/// Returns the cells of a line without commas: by tabs if hasTabs(), else its words.
std::vector<std::string_view> blankCells(std::string_view line);

/// Returns the cells of a line, without blanks at their ends. Empty ones count.
std::vector<std::string_view> cellsBetween(std::string_view line, char separator);

}  // namespace leeway::planner
