#include <fmt/format.h>

#include "tools/lab/report/report.h"
#include "tools/lab/report/report_problems.h"
#include "tools/lab/report/rival_report.h"

namespace leeway::tools {

int runReportClearance(report::ClearanceReportOptions options) {
  RivalReport out(options);
  const std::vector<report::PlanningProblem> problems = readProblems(options);
  const auto rivals = out.rivals(&report::Rivals::states);
  options.progress = out.begin(2 * problems.size() * static_cast<std::size_t>(options.seeds) *
                               options.times.size());
  options.on_rows = out.keep("clearance", report::clearanceRows);
  const std::vector<report::ClearanceRow> rows =
      report::measureClearance(problems, rivals, options);
  out.note(
      fmt::format("{} problems, {} seeds; one pinned core; hinge {:g} m; clearances and "
                  "integrals by dense samples",
                  problems.size(), options.seeds, options.hinge));
  out.write("clearance", report::clearanceRows(rows));
  out.draw({"clearance.svg"});
  RivalReport::End end{{report::clearanceTable(rows)}};
  for (const report::ClearanceRow& row : rows) end.own_errors += row.unsound ? 1 : 0;
  end.count = rows.size();
  return out.end(end);
}

}  // namespace leeway::tools
