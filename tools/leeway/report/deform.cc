#include <fmt/format.h>

#include <string>

#include "tools/leeway/report/report.h"
#include "tools/leeway/report/rival_report.h"
#include "tools/leeway/support/terminal.h"
#include "tools/report/base/machine.h"
#include "tools/report/deform/deform_report.h"
#include "tools/report/deform/deform_scenes.h"
#include "tools/report/deform/own_mesh_engine.h"

namespace leeway::tools {
namespace {

using report::DeformRow;

report::DeformReportOptions optionsOf(const ReportDeformArguments& arguments) {
  report::DeformReportOptions options;
  options.motions = arguments.motions.empty() ? report::deformMotions() : arguments.motions;
  options.triangles = arguments.triangles;
  options.frames = arguments.frames;
  options.engine_seconds = arguments.seconds;
  options.seed = arguments.seed;
  return options;
}

/// Distances of ours that differ from those of our own rebuilt hierarchy, and engines of ours that
/// failed: what the exit status is about.
int ownErrors(const std::vector<DeformRow>& rows) {
  int errors = 0;
  for (const DeformRow& r : rows)
    if (r.engine.rfind("leeway", 0) == 0) errors += r.wrong + !r.done;
  return errors;
}

}  // namespace

int runReportDeform(const ReportDeformArguments& arguments) {
  RivalReport out(arguments.output);
  if (!arguments.no_rivals) out.loadRivals();
  const auto own = report::makeOwnMeshEngines();
  const auto engines = out.engines(own, &report::Rivals::meshes);

  const int processor = report::pinToOneProcessor();
  report::DeformReportOptions options = optionsOf(arguments);
  UnitProgress progress(options.motions.size() * options.triangles.size());
  options.progress = [&](const std::string& mesh) { progress.next(mesh); };
  options.on_rows = [&](const std::vector<DeformRow>& added) {
    out.addRows("deform.csv", report::deformCsv(added));
  };
  const std::vector<DeformRow> rows = report::measureDeform(engines, options);
  endProgress();
  const std::string note =
      fmt::format("{}; seed {}; {} frames; one pinned core, medians over the frames",
                  report::machineName(), arguments.seed, arguments.frames);
  out.write("deform.csv", report::deformCsv(rows));
  out.write("deform_frames.csv", report::deformFramesCsv(rows));
  out.write("deform_update.svg", report::toSvg(report::deformUpdateFigure(rows, note)));
  out.write("deform_decay.svg", report::toSvg(report::deformDecayFigure(rows, note)));
  RivalReport::End end{arguments.seed};
  end.text =
      fmt::format("{}\n{}\n{}\n", note, report::deformTable(rows), report::deformWords(rows));
  end.words = fmt::format("microseconds; seed {}", arguments.seed);
  end.count = rows.size();
  end.own_errors = ownErrors(rows);
  end.processor = processor;
  return out.end(arguments.json, end);
}

}  // namespace leeway::tools
