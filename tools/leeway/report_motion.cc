#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "leeway/robots/input_error.h"
#include "tools/leeway/exit_status.h"
#include "tools/leeway/report.h"
#include "tools/leeway/report_common.h"
#include "tools/leeway/terminal.h"
#include "tools/report/machine.h"
#include "tools/report/motion.h"
#include "tools/report/motion_cases.h"
#include "tools/report/own_motion_engine.h"

namespace leeway::tools {
namespace {

using report::MotionRow;

/// Wrong, unsafe or open answers of ours, and failures: what the exit status is about.
int ownErrors(const std::vector<MotionRow>& rows) {
  int errors = 0;
  for (const MotionRow& r : rows)
    if (r.claims_bounds) errors += r.wrong() + r.undecided + r.failures();
  return errors;
}

}  // namespace

int runReportMotion(const ReportMotionArguments& arguments) {
  const auto begin = std::chrono::steady_clock::now();
  const auto own = report::makeOwnMotionEngines();
  std::vector<const report::ContactEngine*> engines;
  for (const auto& engine : own) engines.push_back(engine.get());
  std::vector<std::string> missing;
  const auto modules = loadRivals(arguments.no_rivals, missing);
  for (const report::RivalModule& module : modules)
    if (module.rivals)
      for (const auto& engine : module.rivals->motions) engines.push_back(engine.get());

  report::MotionReportOptions options;
  options.families = arguments.families.empty() ? report::contactFamilies() : arguments.families;
  options.cases = arguments.cases;
  options.passes = arguments.passes;
  options.seed = arguments.seed;
  options.progress = showProgress;
  const int processor = report::pinToOneProcessor();
  const std::vector<MotionRow> rows = report::measureMotion(engines, options);
  endProgress();
  const std::string note = fmt::format(
      "{}; seed {}; {} cases a family; one pinned core, of each case the median of {} passes",
      report::machineName(), arguments.seed, arguments.cases, arguments.passes);
  const std::vector<std::string> files = {
      writeReportFile(arguments.output, "motion.csv", report::motionCsv(rows)),
      writeReportFile(arguments.output, "motion.svg",
                      report::toSvg(report::motionFigure(rows, note)))};
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
    fmt::print("{}\n{}\nseed {}, {:.0f} s; in {}: motion.csv, motion.svg\n", note,
               report::motionTable(rows), arguments.seed, seconds, arguments.output);
  }
  return errors == 0 ? kYes : kNo;
}

}  // namespace leeway::tools
