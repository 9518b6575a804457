#include <fmt/format.h>

#include "tools/leeway/report/report_problems.h"
#include "tools/leeway/report/rival_report.h"
#include "tools/leeway/support/terminal.h"
#include "tools/report/base/machine.h"
#include "tools/report/clearance/clearance_report.h"

namespace leeway::tools {

int runReportClearance(const ReportClearanceArguments& arguments) {
  RivalReport out(arguments.output);
  const std::vector<report::PlanningProblem> problems = readProblems(arguments);
  if (!arguments.no_rivals) out.loadRivals();
  const auto rivals =
      out.engines(std::vector<std::unique_ptr<report::StateEngine>>{}, &report::Rivals::states);
  report::ClearanceReportOptions options;
  options.seed = arguments.seed;
  options.seeds = arguments.seeds;
  options.times = arguments.times;
  options.hinge = arguments.hinge;
  UnitProgress progress(2 * problems.size() * static_cast<std::size_t>(arguments.seeds) *
                        arguments.times.size());
  options.progress = [&](const std::string& run) { progress.next(run); };
  options.on_rows = [&](const std::vector<report::ClearanceRow>& added) {
    out.addRows("clearance.csv", report::clearanceCsv(added));
  };
  RivalReport::End end{arguments.seed};
  end.processor = report::pinToOneProcessor();
  const std::vector<report::ClearanceRow> rows =
      report::measureClearance(problems, rivals, options);
  endProgress();
  const std::string note = fmt::format(
      "{}; {} problems, seeds {} to {}; one pinned core; hinge {:g} m; clearances and integrals by "
      "dense samples",
      report::machineName(), problems.size(), arguments.seed,
      arguments.seed + static_cast<std::uint64_t>(arguments.seeds) - 1, arguments.hinge);
  out.write("clearance.csv", report::clearanceCsv(rows));
  out.write("clearance.svg", report::toSvg(report::clearanceFigure(rows, note)));
  for (const report::ClearanceRow& row : rows) end.own_errors += row.unsound ? 1 : 0;
  end.text = note + "\n" + report::clearanceTable(rows);
  end.count = rows.size();
  return out.end(arguments.json, end);
}

}  // namespace leeway::tools
