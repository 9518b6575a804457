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

/// Stop and progress for long work: an interrupt (Ctrl-C, SIGTERM) ends the run within its next
/// step, a second one ends the program; progress is the line of showProgress(). `time_limit` [s],
/// from this call on, ends the run too. `planning_limit` [s]: only shown, as what a plan may take;
/// 0 or infinity: no limit.
planner::PlanOptions interactivePlanOptions(std::optional<double> time_limit = {},
                                            double planning_limit = 0);
bool interrupted();
/// While it lives, an interrupt ends reading, which asks stop(); what was done before is left as it
/// was. Reading may take `time_limit` [s], and kLeastReading at least. From a second on, stop()
/// also shows for how long.
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
/// --quiet: stderr gets errors alone, no warnings, progress or counts.
void setQuiet();
bool isQuiet();
/// Shows `text` as the progress line: the last one of stderr, rewritten, cut at the terminal's
/// width. Only when stderr is a terminal, and not with --quiet.
void showProgress(const std::string& text);
/// Wipes the progress line, if there is one.
void endProgress();

/// Progress of work that consists of units: which of how many is in work, and how long the rest
/// takes at the pace so far.
class UnitProgress {
 public:
  /// `kept`: how many of the `total` an earlier run has done.
  explicit UnitProgress(std::size_t total, std::size_t kept = 0) : total_(total), kept_(kept) {}
  /// The next unit begins.
  void next(const std::string& unit);

 private:
  std::size_t total_, kept_, begun_ = 0;
  double shown_ = 0;  // when, since begin_ [s]
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// Columns of text: what an 80-column terminal shows.
inline constexpr std::size_t kColumns = 80;
/// Prose with its lines broken at spaces so that they fit kColumns; a longer word stays whole.
std::string wrapped(const std::string& text);
/// The words of a verdict, green or red where stdout is a terminal and NO_COLOR is not set.
std::string verdictText(const std::string& words, bool good);

/// A rule under the heading; the first column is left-aligned, the others right-aligned, and words
/// (`left`) left-aligned too. Fits kColumns: words in the last column wrap, and columns that find
/// no room follow in a further table, which begins with the first column again.
std::string formatTable(const std::vector<std::string>& heading,
                        const std::vector<std::vector<std::string>>& rows,
                        const std::vector<std::size_t>& left = {});

/// Decimal numbers that stay true bounds when printed short: rounded down, or up, at `digits`
/// decimals. Infinity is "-".
std::string formatLower(double value, int digits);
std::string formatUpper(double value, int digits);

/// The number of millimetres that both ends of an interval [m] round to, at two decimals; nothing
/// where they do not. Ends 1e-8 m apart count as one number, the lower.
std::optional<std::string> figureOf(const planner::Interval& clearance);
/// A clearance for people, with its unit: its figure, or the lower end's where the interval is at
/// most 2e-6 m wide: within 0.01 mm of the true value. Where it is wider, "between", "at least" and
/// "at most", rounded outwards. Overlaps are "deep". (inf, inf) is "nothing near".
std::string clearanceText(const planner::Interval& clearance);
std::string counted(std::size_t count, const std::string& what);  ///< "1 edge", "2 edges"
std::string formatBytes(std::size_t bytes);

}  // namespace leeway::tools
