#include <algorithm>
#include <string>
#include <vector>

#include "tools/lab/growth/growth_report.h"
#include "tools/lab/report/report.h"
#include "tools/lab/report/rival_report.h"

namespace leeway::tools {

namespace {

int runGrowth(report::GrowthReportOptions& options, const char* name, const char* note,
              report::Table (*rows_of)(const std::vector<report::GrowthRow>&),
              report::Table (*table_of)(const std::vector<report::GrowthRow>&)) {
  RivalReport out(options);
  const auto rivals = out.rivals(&report::Rivals::states);
  std::size_t worlds = 0;
  for (auto& [family, counts] : options.counts) {
    std::sort(counts.begin(), counts.end());
    worlds += counts.size();
  }
  options.progress = out.begin(worlds);
  options.on_rows = out.keep(name, rows_of);
  const std::vector<report::GrowthRow> rows = report::measureGrowth(rivals, options);
  out.note(note);
  out.write(name, rows_of(rows));
  out.draw({std::string(name) + ".svg"});
  RivalReport::End end{{table_of(rows)}};
  for (const report::GrowthRow& row : rows)
    if (row.engine == "Leeway")
      end.own_errors += (row.status == "solved" ? 0 : 1) + row.too_high + row.too_low;
  end.count = rows.size();
  return out.end(end);
}

}  // namespace

int runReportGrowth(report::GrowthReportOptions options) {
  return runGrowth(options, "growth",
                   "one pinned core; an edge: ours certified, the others in steps of 1/32 rad",
                   report::growthRows, report::growthTable);
}

int runReportSensed(report::GrowthReportOptions options) {
  return runGrowth(options, "sensed",
                   "one pinned core; an edge: ours certified, the others in steps of 1/32 rad; too "
                   "high, too low: answers about states that the distances of all balls refute",
                   report::sensedRows, report::sensedTable);
}

}  // namespace leeway::tools
