#include <fmt/format.h>

#include <algorithm>

#include "tools/leeway/report/report.h"
#include "tools/leeway/report/rival_report.h"
#include "tools/leeway/support/terminal.h"
#include "tools/report/base/machine.h"
#include "tools/report/growth/growth_report.h"
#include "tools/report/growth/growth_worlds.h"

namespace leeway::tools {

int runReportGrowth(const ReportGrowthArguments& arguments) {
  RivalReport out(arguments.output);
  if (!arguments.no_rivals) out.loadRivals();
  const auto rivals =
      out.engines(std::vector<std::unique_ptr<report::StateEngine>>{}, &report::Rivals::states);
  report::GrowthReportOptions options;
  options.seed = arguments.seed;
  options.edges = arguments.edges;
  options.time = arguments.time;
  options.counts = {
      {"boxes", arguments.boxes}, {"triangles", arguments.triangles}, {"joints", arguments.joints}};
  std::size_t worlds = 0;
  for (const std::string& family : report::growthFamilies()) {
    const auto& asked = arguments.families;
    if (!asked.empty() && std::find(asked.begin(), asked.end(), family) == asked.end())
      options.counts.erase(family);
    else
      std::sort(options.counts[family].begin(), options.counts[family].end());
    if (options.counts.count(family) > 0) worlds += options.counts[family].size();
  }
  UnitProgress progress(worlds);
  options.progress = [&](const std::string& world) { progress.next(world); };
  options.on_rows = [&](const std::vector<report::GrowthRow>& added) {
    out.addRows("growth.csv", report::growthCsv(added));
  };
  RivalReport::End end{arguments.seed};
  end.processor = report::pinToOneProcessor();
  const std::vector<report::GrowthRow> rows = report::measureGrowth(rivals, options);
  endProgress();
  const std::string note = fmt::format(
      "{}; seed {}; one pinned core; an edge: ours certified, the others in steps of 1/32 rad",
      report::machineName(), arguments.seed);
  out.write("growth.csv", report::growthCsv(rows));
  out.write("growth.svg", report::toSvg(report::growthFigure(rows, note)));
  for (const report::GrowthRow& row : rows)
    if (row.engine == "Leeway") end.own_errors += row.status == "solved" ? 0 : 1;
  end.text = fmt::format("{}\n{}", note, report::growthTable(rows));
  end.count = rows.size();
  return out.end(arguments.json, end);
}

}  // namespace leeway::tools
