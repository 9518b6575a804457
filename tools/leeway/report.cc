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

CLI::App* addAccuracy(CLI::App* app, const std::shared_ptr<ReportAccuracyArguments>& arguments) {
  CLI::App* accuracy = app->add_subcommand(
      "accuracy", "time a query against true error, with FCL and Bullet in the same run");
  accuracy->add_option("--output", arguments->output, "folder for CSV and pictures")
      ->type_name("DIR")
      ->capture_default_str();
  accuracy->add_option("--seed", arguments->seed, "of the cases")->capture_default_str();
  auto* count = accuracy->add_option("--per-family", arguments->per_family, "cases a family")
                    ->check(CLI::Range(1, 100000))
                    ->capture_default_str();
  accuracy->add_option("--passes", arguments->passes, "timed passes, whose median is told")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  accuracy
      ->add_flag_callback(
          "--full",
          [arguments] {
            arguments->per_family = 200;
            arguments->passes = 31;
          },
          "200 cases a family and 31 passes")
      ->excludes(count);
  accuracy->add_option("--family", arguments->families, "only families with this in their name")
      ->type_name("TEXT");
  auto* cases = accuracy->add_option("--cases", arguments->cases, "the cases of this file instead")
                    ->type_name("FILE");
  auto* reference = accuracy->add_option("--reference", arguments->reference, "and their truth")
                        ->type_name("FILE");
  cases->needs(reference)->excludes(count);
  reference->needs(cases);
  accuracy->add_flag("--no-rivals", arguments->no_rivals, "ours alone");
  accuracy->add_flag("--json", arguments->json, "one JSON document");
  accuracy->footer("Example:\n  leeway report accuracy --family box --output /tmp/report");
  return accuracy;
}

}  // namespace

Verb addReport(CLI::App& command) {
  auto arguments = std::make_shared<Arguments>();
  auto accuracy_arguments = std::make_shared<ReportAccuracyArguments>();
  CLI::App* app = command.add_subcommand("report", "measurements of the engine");
  CLI::App* accuracy = addAccuracy(app, accuracy_arguments);
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
  return {app, [arguments, accuracy_arguments, accuracy] {
            if (accuracy->parsed()) return runReportAccuracy(*accuracy_arguments);
            return arguments->reference.empty()
                       ? runReportCases(arguments->file, arguments->raw)
                       : runReportCasesAgainst(arguments->file, arguments->reference);
          }};
}

}  // namespace leeway::tools
