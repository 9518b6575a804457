#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "leeway/robots/input_error.h"
#include "tools/leeway/exit_status.h"
#include "tools/leeway/report.h"
#include "tools/leeway/report_common.h"
#include "tools/leeway/terminal.h"
#include "tools/report/deform.h"
#include "tools/report/deform_scenes.h"
#include "tools/report/machine.h"
#include "tools/report/own_mesh_engine.h"

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
  options.progress = showProgress;
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
  const auto begin = std::chrono::steady_clock::now();
  const auto own = report::makeOwnMeshEngines();
  std::vector<const report::MeshEngine*> engines;
  for (const auto& engine : own) engines.push_back(engine.get());
  std::vector<std::string> missing;
  const auto modules = loadRivals(arguments.no_rivals, missing);
  for (const report::RivalModule& module : modules)
    if (module.rivals)
      for (const auto& engine : module.rivals->meshes) engines.push_back(engine.get());

  const int processor = report::pinToOneProcessor();
  const std::vector<DeformRow> rows = report::measureDeform(engines, optionsOf(arguments));
  endProgress();
  const std::string note =
      fmt::format("{}; seed {}; {} frames; one pinned core, medians over the frames",
                  report::machineName(), arguments.seed, arguments.frames);
  const std::string& folder = arguments.output;
  const std::vector<std::string> files = {
      writeReportFile(folder, "deform.csv", report::deformCsv(rows)),
      writeReportFile(folder, "deform_frames.csv", report::deformFramesCsv(rows)),
      writeReportFile(folder, "deform_update.svg",
                      report::toSvg(report::deformUpdateFigure(rows, note))),
      writeReportFile(folder, "deform_decay.svg",
                      report::toSvg(report::deformDecayFigure(rows, note)))};
  const int errors = ownErrors(rows);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (arguments.json) {
    fmt::print("{}\n", nlohmann::json{{"seed", arguments.seed},
                                      {"rows", rows.size()},
                                      {"missing", missing},
                                      {"own_errors", errors},
                                      {"processor", processor},
                                      {"time_s", seconds},
                                      {"files", files}}
                           .dump());
  } else {
    fmt::print(
        "{}\n{}\n{}\nmicroseconds; seed {}, {:.0f} s; in {}: deform.csv, deform_frames.csv, "
        "deform_update.svg, deform_decay.svg\n",
        note, report::deformTable(rows), report::deformWords(rows), arguments.seed, seconds,
        folder);
  }
  return errors == 0 ? kYes : kNo;
}

}  // namespace leeway::tools
