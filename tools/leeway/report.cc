#include "tools/leeway/report.h"

#include <memory>

#include "tools/leeway/verb.h"

namespace leeway::tools {
namespace {

struct Arguments {
  std::string file;
  std::string raw = "-";
  std::string reference;
};

}  // namespace

Verb addReport(CLI::App& command) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app = command.add_subcommand("report", "measurements of the engine");
  CLI::App* cases = app->add_subcommand("cases", "answers every pair of shapes of a case file");
  cases->add_option("file", arguments->file, "case file (tests/data/README.md)")
      ->type_name("FILE")
      ->required();
  cases
      ->add_option("--raw", arguments->raw,
                   "one line a case: ID STATUS LOWER UPPER NS; - is stdout")
      ->type_name("OUT");
  cases
      ->add_option("--reference", arguments->reference,
                   "known truth, ID VERDICT D GAP HASVALUE L a line: a table by family instead")
      ->type_name("REF")
      ->excludes("--raw");
  app->require_subcommand(1);
  const char* example = "Example:\n  leeway report cases tests/data/cases.txt --raw -";
  app->footer(example);
  cases->footer(example);
  return {app, [arguments] {
            return arguments->reference.empty()
                       ? runReportCases(arguments->file, arguments->raw)
                       : runReportCasesAgainst(arguments->file, arguments->reference);
          }};
}

}  // namespace leeway::tools
