// The `leeway` command. It runs one verb, prints the answer on stdout and everything else on
// stderr, and returns an exit status for scripts.

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "tools/leeway/support/command_line.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"

namespace leeway::tools {
namespace {

constexpr const char* kReport = "report";

std::vector<Verb> addVerbs(CLI::App& app) {
  std::vector<Verb> verbs = {addPlan(app),   addCheck(app), addVerify(app), addClearance(app),
                             addReplan(app), addGuard(app), addBatch(app),  addInfo(app),
                             addLint(app),   addSrdf(app),  addIk(app),     addFk(app),
                             addView(app),   addManual(app)};
  app.add_subcommand(kReport, "measurements of the engine");  // for --help: see startReport()
  return verbs;
}

/// Replaces this process by the program for reports, and returns only if that fails. Reports are a
/// separate program, so that the command builds and installs without their dependencies.
int startReport(char** argv) {
  std::error_code error;
  const std::string program =
      std::filesystem::read_symlink("/proc/self/exe", error).replace_filename("leeway-report");
  ::execv(program.c_str(), argv);
  printMessage(wrapped(fmt::format(
      "leeway report: {}: {}; reports are built by `tools/setup && cmake --preset release && cmake "
      "--build build --target reports`",
      program, std::strerror(errno))));
  return kBadInput;
}

}  // namespace
}  // namespace leeway::tools

int main(int argc, char** argv) {
  using namespace leeway::tools;
  if (argc > 1 && std::string_view(argv[1]) == kReport) return startReport(argv);
  if (argc > 2 && std::string_view(argv[1]) == kHelp && std::string_view(argv[2]) == kReport) {
    // `help report motion` means `report motion --help`.
    std::string help = "--help";
    std::vector<char*> report = {argv[0]};
    report.insert(report.end(), argv + 2, argv + argc);
    report.insert(report.end(), {help.data(), nullptr});
    return startReport(report.data());
  }
  return runCommandLine(argc, argv, addVerbs);
}
