#include "tools/lab/motion/motion_report.h"

namespace leeway::tools::report {

Table motionRows(const std::vector<MotionRow>& rows) {
  Table table({"family", "engine", "cases", "hits", "misses", "false_hits", "wrong_starts",
               "unsafe", "undecided", "threw", "died", "endless", "time_error_median",
               "time_error_max", "ns_median", "ns_95", "ns_max"});
  for (const MotionRow& r : rows)
    table.add({r.family, r.engine, r.cases, r.hits, r.misses, r.false_hits, r.wrong_starts,
               Table::Cell::onlyIf(r.claims_bounds, r.unsafe), r.undecided, r.threw, r.died,
               r.endless, r.error_median, r.error_max, r.ns_median, r.ns_95, r.ns_max});
  return table;
}

Table motionTable(const std::vector<MotionRow>& rows) {
  Table table({"family", "engine", "cases", "hits", "misses", "false", "start", "unsafe", "open",
               "failed", "error 50 %:.3g", "max:.3g", "us 50 %:.3g", "95 %:.3g"},
              2);
  for (const MotionRow& r : rows)
    table.add({r.family, r.engine, r.cases, r.hits, r.misses, r.false_hits, r.wrong_starts,
               Table::Cell::onlyIf(r.claims_bounds, r.unsafe), r.undecided, r.failures(),
               r.error_median, r.error_max, r.ns_median / 1000, r.ns_95 / 1000});
  return table;
}

}  // namespace leeway::tools::report
