#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "leeway/planner/plan.h"
#include "leeway/robots/stopped.h"

namespace leeway::tools {

/// Stop and progress for long work. An interrupt (Ctrl-C, SIGTERM) ends the run within its next
/// step; a second one ends the program. Progress is the line of showProgress(). The run also ends
/// `time_limit` [s] after this call. `planning_limit` [s] is only shown, as the most that a plan
/// may take; 0 or infinity: no limit.
planner::PlanOptions interactivePlanOptions(std::optional<double> time_limit = {},
                                            double planning_limit = 0);
bool interrupted();
/// During its lifetime, an interrupt ends reading, which calls stop(). Work done before stays as it
/// is. Reading may take `time_limit` [s], but at least kLeastReading. After one second, stop() also
/// shows the time so far.
class InterruptibleReading {
 public:
  explicit InterruptibleReading(std::optional<double> time_limit);
  ~InterruptibleReading();
  InterruptibleReading(const InterruptibleReading&) = delete;
  InterruptibleReading& operator=(const InterruptibleReading&) = delete;
  const robots::Stop& stop() const { return stop_; }

 private:
  struct Before;
  std::unique_ptr<Before> before_;
  robots::Stop stop_;
};
/// --quiet: only errors go to stderr, no warnings, progress or counts.
void setQuiet();
bool isQuiet();
/// Shows `text` as the progress line, which is the last line of stderr and is rewritten. Cuts it at
/// the terminal's width. Does nothing if stderr is not a terminal, and with --quiet.
void showProgress(const std::string& text);
/// Removes the progress line, if there is one. Call it before anything else is printed, so that no
/// output follows the line.
void endProgress();
/// Prints a message and a line break on stderr, without the progress line. On a terminal, breaks
/// lines at spaces. Elsewhere a message stays one line, for programs that read it.
void printMessage(const std::string& text);

/// Progress of work in units: the number of the current unit, and the time for the rest at the pace
/// so far.
class UnitProgress {
 public:
  /// `kept`: the number of units out of `total` that an earlier run has done.
  explicit UnitProgress(std::size_t total, std::size_t kept = 0) : total_(total), kept_(kept) {}
  /// Call it when the next unit begins.
  void next(const std::string& unit);
  /// Call it during work that follows the last unit and whose amount is not known.
  void after(const std::string& work);

 private:
  double elapsed() const;
  std::size_t total_, kept_, begun_ = 0;
  double shown_ = 0;  // when, since begin_ [s]
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// The width of text for an 80-column terminal.
inline constexpr std::size_t kColumns = 80;
/// Returns a text with control characters as \xNN, because names in files may contain those that
/// terminals obey. Newlines and the colours of verdictText() stay.
std::string printable(const std::string& text);
/// Breaks the lines of prose at spaces, but not before a unit, so that they fit kColumns. Further
/// lines of a broken line begin with `indent` blanks. Keeps longer words whole.
std::string wrapped(const std::string& text, std::size_t indent = 0);
/// Breaks the lines of CLI11's help so that they fit kColumns. Descriptions stay in their column;
/// lines that only continue one are joined to it first.
/// Examples, which begin with two blanks and `leeway`, continue after a backslash.
std::string wrappedHelp(const std::string& help);
/// The words of a verdict, green or red if stdout is a terminal and NO_COLOR is not set.
std::string verdictText(const std::string& words, bool good);

/// A table with a rule under its heading. The first column and columns of words (`left`) are
/// left-aligned, all others right-aligned. Fits kColumns: words in the last column wrap, and
/// columns without room go into a further table, which begins with the first column again. If
/// that column does not tell the rows apart, all tables begin with the number of the row.
std::string formatTable(const std::vector<std::string>& heading,
                        const std::vector<std::vector<std::string>>& rows,
                        const std::vector<std::size_t>& left = {});

}  // namespace leeway::tools
