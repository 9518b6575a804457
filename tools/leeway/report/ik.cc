#include <fmt/format.h>

#include <filesystem>

#include "leeway/robots/input_error.h"
#include "tools/leeway/report/report.h"
#include "tools/leeway/report/rival_report.h"
#include "tools/leeway/support/terminal.h"
#include "tools/report/base/machine.h"
#include "tools/report/ik/ik_report.h"

namespace leeway::tools {
namespace {

report::IkRobot readRobot(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos)
    throw robots::InputError("command line", 0, fmt::format("'{}' is not URDF:LINK", text));
  const std::string file = text.substr(0, colon), link = text.substr(colon + 1);
  report::IkRobot robot{std::filesystem::path(file).stem(), robots::loadModel(file, ""), -1};
  robot.link = robot.model->findLink(link);
  if (robot.link < 0)
    throw robots::InputError("command line", 0, fmt::format("{} has no link '{}'", file, link));
  return robot;
}

}  // namespace

int runReportIk(const ReportIkArguments& arguments) {
  RivalReport out(arguments.output);
  std::vector<report::IkRobot> robots;
  for (const std::string& text : arguments.robots) robots.push_back(readRobot(text));
  if (!arguments.no_rivals) out.loadRivals();
  const auto rivals =
      out.engines(std::vector<std::unique_ptr<report::IkEngine>>{}, &report::Rivals::kinematics);

  report::IkReportOptions options;
  options.poses = arguments.poses;
  options.beyond = arguments.beyond;
  options.seed = arguments.seed;
  options.progress = showProgress;
  options.on_rows = [&](const std::vector<report::IkRow>& added) {
    out.addRows("ik.csv", report::ikCsv(added));
  };
  options.on_proof_rows = [&](const std::vector<report::IkProofRow>& added) {
    out.addRows("ik_proofs.csv", report::ikProofCsv(added));
  };
  RivalReport::End end{arguments.seed};
  end.processor = report::pinToOneProcessor();
  const std::vector<report::IkRow> rows = report::measureIk(robots, rivals, options);
  const std::vector<report::IkProofRow> proofs = report::measureIkProofs(robots, options);
  endProgress();
  out.write("ik.csv", report::ikCsv(rows));
  out.write("ik_proofs.csv", report::ikProofCsv(proofs));
  for (const report::IkRow& row : rows)
    end.own_errors += row.engine == "Leeway" ? row.wrong + row.coarse : 0;
  for (const report::IkProofRow& row : proofs) end.own_errors += row.wrong;
  end.text = fmt::format(
      "{}; seed {}; poses of random configurations, from random starts; one pinned core, processor "
      "time\n{}\nposes beyond reach, and proofs tried for reachable ones\n{}\n",
      report::machineName(), arguments.seed, report::ikTable(rows), report::ikProofTable(proofs));
  end.count = rows.size();
  return out.end(arguments.json, end);
}

}  // namespace leeway::tools
