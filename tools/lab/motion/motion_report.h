#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tools/lab/base/motion_engine.h"
#include "tools/lab/base/report_options.h"
#include "tools/lab/base/table.h"

namespace leeway::tools::report {
struct MotionRow;

struct MotionReportOptions : ReportOptions {
  std::vector<std::string> families;  ///< of contactFamilies()
  int cases = 100;                    ///< for each family
  int passes = 5;                     ///< timed passes over a family's cases
  double query_seconds = 0.25;        ///< processor time [s] after which a query counts as endless
  /// Called with the rows of each family when they are complete.
  std::function<void(const std::vector<MotionRow>&)> on_rows;
};

/// A start counts as wrong if either the truth or the answer is contact at 0 and the other is later
/// than this [of the motion].
inline constexpr double kStartTime = 1e-3;

/// One engine over one family.
struct MotionRow {
  std::string family, engine;
  bool claims_bounds = false;
  int cases = 0, hits = 0;               ///< hits: truth is contact
  int threw = 0, died = 0, endless = 0;  ///< failures, by kind
  int undecided = 0;                     ///< a limit was reached, or rounding left it open
  int misses = 0;                        ///< judged free, but is not
  int false_hits = 0;                    ///< judged contact, but is free
  int wrong_starts = 0;                  ///< see kStartTime
  int unsafe = 0;                        ///< interval excludes the time of contact
  /// Error of the time of contact, if truth and answer both have contact.
  double error_median = std::numeric_limits<double>::quiet_NaN(), error_max = error_median;
  /// Time of a query [ns]: the median over passes for each case; over these, median, 95 % and
  /// maximum.
  double ns_median = error_median, ns_95 = error_median, ns_max = error_median;

  int failures() const { return threw + died + endless; }
  int wrong() const { return misses + false_hits + wrong_starts + unsafe; }
};

/// Queries every engine for every case. Round one runs in child processes, which count aborts and
/// endless loops without ending the report. Round two times the answered cases, with engines
/// interleaved case by case. There is no row if an engine lacks a family's shapes or motions. Pin
/// the process first. Throws std::system_error if no child process can be made.
std::vector<MotionRow> measureMotion(const std::vector<const ContactEngine*>& engines,
                                     const MotionReportOptions& options);

/// The rows as they are.
Table motionRows(const std::vector<MotionRow>& rows);
/// For people, by family.
Table motionTable(const std::vector<MotionRow>& rows);

}  // namespace leeway::tools::report
