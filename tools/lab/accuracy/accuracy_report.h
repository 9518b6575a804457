#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tools/lab/accuracy/accuracy_cases.h"
#include "tools/lab/base/engine.h"
#include "tools/lab/base/report_options.h"
#include "tools/lab/base/table.h"

namespace leeway::tools::report {

/// An answer counts as wrong above this error, relative to the sizes involved.
inline constexpr double kWrong = 1e-6;
/// A verdict counts as wrong only where |truth| exceeds this share of the largest coordinate: ten
/// times the rounding of the input.
inline constexpr double kDecided = 1e-15;
struct AccuracyRow;

/// The default (NaN), then 1e-1 to 1e-15 by decades.
std::vector<double> accuracyTolerances();

struct AccuracyOptions : ReportOptions {
  int per_family = 40;                ///< cases of each family
  std::string cases, reference;       ///< both or none: cases of a file, and their truth, instead
  std::vector<std::string> families;  ///< parts of names; none: all
  /// Relative to the sizes involved; NaN: the engine's default.
  std::vector<double> tolerances = accuracyTolerances();
  int passes = 15;              ///< timed passes over a family's cases
  double query_seconds = 0.25;  ///< processor time [s] after which a query counts as endless
  /// Called with the rows of each family when they are complete.
  std::function<void(const std::vector<AccuracyRow>&)> on_rows;
};

/// One engine at one tolerance over one family. Times and errors cover the cases with a number as
/// the answer.
struct AccuracyRow {
  std::string family;
  FamilyKind kind = FamilyKind::kOrdinary;
  std::string engine;
  bool tells_distance = true;  ///< false: errors and `wrong` do not apply
  bool claims_bounds = false;  ///< false: `unsafe` does not apply
  double tolerance = std::numeric_limits<double>::quiet_NaN();  ///< relative; NaN: default
  int cases = 0, answered = 0;
  int threw = 0, died = 0, endless = 0, not_a_number = 0;  ///< failures, by kind
  int wrong = 0;          ///< answered, but off by more than kWrong
  int wrong_verdict = 0;  ///< apart although it overlaps, or the reverse
  int unsafe = 0;         ///< interval excludes the truth
  /// Time of a query [ns], mean over the cases: median and quartiles over the passes. NaN if no
  /// case was answered.
  double ns = std::numeric_limits<double>::quiet_NaN(), ns_low = ns, ns_high = ns;
  /// Error of an interval's farther end, relative to the sizes. NaN if no case was answered.
  double error_median = ns, error_95 = ns, error_max = ns;

  int failures() const { return threw + died + endless + not_a_number; }
};

/// Queries every engine for every case at every tolerance. Round one runs in child processes, which
/// count aborts and endless loops without ending the report. Round two times the answered cases;
/// engines and tolerances are interleaved within each pass. There is no row if an engine lacks the
/// pair of types. Pin the process first. Throws std::system_error if no child process can be made.
std::vector<AccuracyRow> measureAccuracy(const AccuracySet& set,
                                         const std::vector<const PairEngine*>& engines,
                                         const AccuracyOptions& options);

/// The rows as they are.
Table accuracyRows(const std::vector<AccuracyRow>& rows);

/// Failures of each engine by family, at default tolerance and at the tightest tolerance of the
/// run.
Table hardCaseRows(const std::vector<AccuracyRow>& rows);

/// For people: times at default tolerance by family with ratios to FCL's, and failures of the hard
/// cases and of all others.
std::vector<Table> accuracyTables(const std::vector<AccuracyRow>& rows);

}  // namespace leeway::tools::report
