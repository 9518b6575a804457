#include <algorithm>

#include "tools/lab/growth/growth_report.h"
#include "tools/lab/report/report.h"
#include "tools/lab/report/rival_report.h"

namespace leeway::tools {

int runReportGrowth(report::GrowthReportOptions options) {
  RivalReport out(options);
  const auto rivals = out.rivals(&report::Rivals::states);
  std::size_t worlds = 0;
  for (auto& [family, counts] : options.counts) {
    std::sort(counts.begin(), counts.end());
    worlds += counts.size();
  }
  options.progress = out.begin(worlds);
  options.on_rows = out.keep("growth", report::growthRows);
  const std::vector<report::GrowthRow> rows = report::measureGrowth(rivals, options);
  out.note("one pinned core; an edge: ours certified, the others in steps of 1/32 rad");
  out.write("growth", report::growthRows(rows));
  out.draw({"growth.svg"});
  RivalReport::End end{{report::growthTable(rows)}};
  for (const report::GrowthRow& row : rows)
    if (row.engine == "Leeway") end.own_errors += row.status == "solved" ? 0 : 1;
  end.count = rows.size();
  return out.end(end);
}

}  // namespace leeway::tools
