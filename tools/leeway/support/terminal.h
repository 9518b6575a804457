#pragma once

#include <optional>
#include <string>
#include <vector>

#include "leeway/planner/plan.h"

namespace leeway::tools {

/// Stop and progress for long work: an interrupt (Ctrl-C, SIGTERM) ends the run within its next
/// step, a second one ends the program; progress is one line on stderr, rewritten, and only when
/// stderr is a terminal. `time_limit` [s], from this call on, ends the run too.
planner::PlanOptions interactivePlanOptions(std::optional<double> time_limit = {});
bool interrupted();
/// --quiet: stderr gets errors alone, no warnings, progress or counts.
void setQuiet();
bool isQuiet();
/// Wipes the progress line, if there is one.
void endProgress();
/// Shows `text` as the progress line, when stderr is a terminal.
void showProgress(const std::string& text);

/// A rule under the heading; the first column is left-aligned, the others right-aligned, and words
/// (`left`) left-aligned too.
std::string formatTable(const std::vector<std::string>& heading,
                        const std::vector<std::vector<std::string>>& rows,
                        const std::vector<std::size_t>& left = {});

/// Decimal numbers that stay true bounds when printed short: rounded down, or up, at `digits`
/// decimals. Infinity is "-".
std::string formatLower(double value, int digits);
std::string formatUpper(double value, int digits);
std::string formatBytes(std::size_t bytes);

}  // namespace leeway::tools
