#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tools/report/base/motion_engine.h"
#include "tools/report/base/plot.h"

namespace leeway::tools::report {

struct MotionReportOptions {
  std::vector<std::string> families;  ///< of contactFamilies()
  int cases = 100;                    ///< a family
  std::uint64_t seed = 1;
  int passes = 5;               ///< timed passes over a family's cases
  double query_seconds = 0.25;  ///< processor time after which a query counts as endless
  std::function<void(const std::string&)> progress;
};

/// An engine that says contact at 0 where contact is later than this, or later than this where it
/// is at 0, has a start wrong [of the motion].
inline constexpr double kStartTime = 1e-3;

/// One engine over one family.
struct MotionRow {
  std::string family, engine;
  bool claims_bounds = false;
  int cases = 0, hits = 0;               ///< hits: there is contact
  int threw = 0, died = 0, endless = 0;  ///< failures, by kind
  int undecided = 0;                     ///< a limit was reached, or rounding
  int misses = 0;                        ///< said free, was not
  int false_hits = 0;                    ///< said contact, there is none
  int wrong_starts = 0;                  ///< see kStartTime
  int unsafe = 0;  ///< an interval that claims to hold the time of contact, and does not
  /// Of the time of contact, where there is contact and it was said so.
  double error_median = std::numeric_limits<double>::quiet_NaN(), error_max = error_median;
  /// A query's nanoseconds: of each case the median of the passes, of those these.
  double ns_median = error_median, ns_95 = error_median, ns_max = error_median;

  int failures() const { return threw + died + endless; }
  int wrong() const { return misses + false_hits + wrong_starts + unsafe; }
};

/// Asks every engine for every case: first once each in child processes, where an abort or an
/// endless loop does no harm and is counted, then again on the clock, engines interleaved case by
/// case. Engines that do not have a family's shapes or motions yield no row. Pin the process first.
/// Throws std::system_error when no child process can be made.
std::vector<MotionRow> measureMotion(const std::vector<const ContactEngine*>& engines,
                                     const MotionReportOptions& options);

/// One line a row, with a header.
std::string motionCsv(const std::vector<MotionRow>& rows);
/// For people, by family.
std::string motionTable(const std::vector<MotionRow>& rows);
/// Median and 95 % of the times by family, in one panel; shares of misses and false hits in
/// another.
Figure motionFigure(const std::vector<MotionRow>& rows, const std::string& note);

}  // namespace leeway::tools::report
