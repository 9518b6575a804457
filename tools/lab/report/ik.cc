#include <fmt/format.h>

#include <filesystem>

#include "leeway/robots/input_error.h"
#include "tools/lab/report/report.h"
#include "tools/lab/report/rival_report.h"
#include "tools/leeway/support/terminal.h"

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

int runReportIk(report::IkReportOptions options) {
  RivalReport out(options);
  std::vector<report::IkRobot> robots;
  for (const std::string& text : options.robots) robots.push_back(readRobot(text));
  const auto rivals = out.rivals(&report::Rivals::kinematics);
  out.begin(1);
  options.progress = showProgress;
  options.on_rows = out.keep("ik", report::ikRows);
  options.on_proof_rows = out.keep("ik_proofs", report::ikProofRows);
  const std::vector<report::IkRow> rows = report::measureIk(robots, rivals, options);
  const std::vector<report::IkProofRow> proofs = report::measureIkProofs(robots, options);
  out.note(
      "poses of random configurations, from random starts; proofs for poses beyond reach, and "
      "tried "
      "for reachable ones; one pinned core, processor time");
  out.write("ik", report::ikRows(rows));
  out.write("ik_proofs", report::ikProofRows(proofs));
  RivalReport::End end{{report::ikTable(rows), report::ikProofRows(proofs)}};
  for (const report::IkRow& row : rows)
    end.own_errors += row.engine == "Leeway" ? row.wrong + row.coarse : 0;
  for (const report::IkProofRow& row : proofs) end.own_errors += row.wrong;
  end.count = rows.size();
  return out.end(end);
}

}  // namespace leeway::tools
