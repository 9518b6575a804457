#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tools/report/accuracy/accuracy_cases.h"
#include "tools/report/base/engine.h"
#include "tools/report/base/plot.h"

namespace leeway::tools::report {

/// An answer is wrong when it is off by more than this share of the sizes involved.
inline constexpr double kWrong = 1e-6;
/// A verdict counts as wrong where the truth is farther from 0 than this share of the largest
/// coordinate: ten times the rounding of the input itself.
inline constexpr double kDecided = 1e-15;

struct AccuracyOptions {
  /// Relative to the sizes; NaN: what the engine does by default.
  std::vector<double> tolerances;
  int passes = 15;              ///< timed passes over a family's cases
  double query_seconds = 0.25;  ///< processor time after which a query counts as endless
  std::function<void(const std::string&)> progress;  ///< told each family's name
};

/// By default, then from 1e-1 to 1e-15 by decades.
std::vector<double> accuracyTolerances();

/// One engine at one tolerance over one family. Times and errors are of the cases that were
/// answered with a number.
struct AccuracyRow {
  std::string family;
  FamilyKind kind = FamilyKind::kOrdinary;
  std::string engine;
  bool tells_distance = true;  ///< false: errors and `wrong` do not apply
  bool claims_bounds = false;  ///< false: `unsafe` does not apply
  double tolerance = std::numeric_limits<double>::quiet_NaN();  ///< relative; NaN: default
  int cases = 0, answered = 0;
  int threw = 0, died = 0, endless = 0, not_a_number = 0;  ///< failures, by kind
  int wrong = 0;          ///< answered, and off by more than kWrong
  int wrong_verdict = 0;  ///< says apart where it overlaps, or the reverse
  int unsafe = 0;         ///< the interval does not hold the truth
  /// A query's nanoseconds, the mean over the cases: median and quartiles over the passes. NaN:
  /// nothing was answered.
  double ns = std::numeric_limits<double>::quiet_NaN(), ns_low = ns, ns_high = ns;
  /// True error relative to the sizes; for an interval that of its farther end. NaN as above.
  double error_median = ns, error_95 = ns, error_max = ns;

  int failures() const { return threw + died + endless + not_a_number; }
};

/// Asks every engine for every case at every tolerance: first once each in child processes, where
/// an abort or an endless loop does no harm and is counted, then again on the clock, engines and
/// tolerances interleaved within each pass, for what was answered. Pairs of types that an engine
/// does not have yield no row. Pin the process first. Throws std::system_error when no child
/// process can be made.
std::vector<AccuracyRow> measureAccuracy(const AccuracySet& set,
                                         const std::vector<const PairEngine*>& engines,
                                         const AccuracyOptions& options);

/// One line a row, with a header.
std::string accuracyCsv(const std::vector<AccuracyRow>& rows);

/// Failures of each engine by family, at default tolerance and at the tightest asked.
std::string hardCasesCsv(const std::vector<AccuracyRow>& rows);

/// For people: times at default tolerance by family with ratios to FCL's, then what went wrong.
std::string accuracyTable(const std::vector<AccuracyRow>& rows);

/// Time against error, a panel a family of the given kinds.
Figure accuracyFigure(const std::vector<AccuracyRow>& rows, const std::vector<FamilyKind>& kinds,
                      const std::string& title, const std::string& note);

}  // namespace leeway::tools::report
