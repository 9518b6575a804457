// leeway-report: what `leeway report` starts.

#include "tools/lab/report/report.h"
#include "tools/leeway/support/command_line.h"

int main(int argc, char** argv) {
  using namespace leeway::tools;
  return runCommandLine(argc, argv,
                        [](CLI::App& app) { return std::vector<Verb>{addReport(app)}; });
}
