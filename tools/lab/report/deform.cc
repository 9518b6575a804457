#include <fmt/format.h>

#include "tools/lab/deform/deform_scenes.h"
#include "tools/lab/deform/own_mesh_engine.h"
#include "tools/lab/report/report.h"
#include "tools/lab/report/rival_report.h"

namespace leeway::tools {
namespace {

using report::DeformRow;

/// Distances of ours that differ from those of our own rebuilt hierarchy, and engines of ours that
/// failed: what the exit status is about.
int ownErrors(const std::vector<DeformRow>& rows) {
  int errors = 0;
  for (const DeformRow& r : rows)
    if (r.engine.rfind("leeway", 0) == 0) errors += r.wrong + !r.done;
  return errors;
}

}  // namespace

int runReportDeform(report::DeformReportOptions options) {
  RivalReport out(options);
  const auto own = report::makeOwnMeshEngines();
  const auto engines = out.engines(own, &report::Rivals::meshes);
  if (options.motions.empty()) options.motions = report::deformMotions();
  options.progress = out.begin(options.motions.size() * options.triangles.size());
  options.on_rows = out.keep("deform", report::deformRows);
  const std::vector<DeformRow> rows = report::measureDeform(engines, options);
  out.note(fmt::format("{} frames; one pinned core, medians over the frames", options.frames));
  out.write("deform", report::deformRows(rows));
  out.write("deform_frames", report::deformFrameRows(rows));
  out.draw({"deform_update.svg", "deform_decay.svg"});
  RivalReport::End end{{report::deformTable(rows)}, report::deformWords(rows)};
  end.count = rows.size();
  end.own_errors = ownErrors(rows);
  return out.end(end);
}

}  // namespace leeway::tools
