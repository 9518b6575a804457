#include "tools/lab/report/report.h"

#include <algorithm>
#include <memory>

#include "tools/lab/deform/deform_scenes.h"
#include "tools/lab/growth/growth_worlds.h"
#include "tools/lab/motion/motion_cases.h"

namespace leeway::tools {
namespace {

/// A report, with the options that all have. `seed`: what the seed is of.
CLI::App* addOne(CLI::App* app, const char* name, const char* what, const char* example,
                 report::ReportOptions& options, const char* seed) {
  CLI::App* one = app->add_subcommand(name, what);
  one->add_option("--output", options.output, "folder for CSV and pictures")
      ->type_name("DIR")
      ->capture_default_str();
  one->add_option("--seed", options.seed, seed)->capture_default_str();
  one->add_flag("--no-rivals", options.no_rivals, "ours alone");
  one->add_flag("--json", options.json, "one JSON document");
  one->footer(std::string("Example:\n  leeway report ") + name + " " + example +
              " --output /tmp/report");
  return one;
}

template <class Number, class Least>
CLI::Option* addNumber(CLI::App* app, const char* name, Number& number, Least least, Least most,
                       const char* what) {
  return app->add_option(name, number, what)->check(CLI::Range(least, most))->capture_default_str();
}

CLI::Option* addSeconds(CLI::App* app, const char* name, double& seconds, const char* what) {
  return app->add_option(name, seconds, what)->check(CLI::PositiveNumber)->capture_default_str();
}

void addRobot(CLI::App* app, std::string& robot, std::string& srdf) {
  auto* urdf =
      app->add_option("--robot", robot, "URDF: problems are MoveIt scenes, requests beside them")
          ->type_name("URDF");
  app->add_option("--srdf", srdf, "its SRDF")->type_name("SRDF")->needs(urdf);
}

Verb addAccuracy(CLI::App* app) {
  auto options = std::make_shared<report::AccuracyOptions>();
  CLI::App* one = addOne(app, "accuracy",
                         "time a query against true error, with FCL and Bullet in the same run",
                         "--family box", *options, "of the cases");
  auto* count =
      addNumber(one, "--per-family", options->per_family, 1, 100'000, "cases of each family");
  addNumber(one, "--passes", options->passes, 1, 10'000, "timed passes; their median is shown");
  one->add_flag_callback(
         "--full", [options] { options->per_family = 200, options->passes = 31; },
         "200 cases of each family and 31 passes")
      ->excludes(count);
  one->add_option("--family", options->families, "only families with this in their name")
      ->type_name("TEXT");
  auto* cases = one->add_option("--cases", options->cases, "the cases of this file instead")
                    ->type_name("FILE");
  auto* reference =
      one->add_option("--reference", options->reference, "and their truth")->type_name("FILE");
  cases->needs(reference)->excludes(count);
  reference->needs(cases);
  return {one, [options] { return runReportAccuracy(*options); }};
}

Verb addDeform(CLI::App* app) {
  auto options = std::make_shared<report::DeformReportOptions>();
  CLI::App* one =
      addOne(app, "deform", "updates and queries of deforming meshes, with FCL, Bullet and Embree",
             "--motion wave --triangles 2000", *options, "of the motions");
  one->add_option("--motion", options->motions, "only these")
      ->check(CLI::IsMember(report::deformMotions()));
  addNumber(one, "--triangles", options->triangles, 2, 10'000'000, "sizes of the meshes");
  addNumber(one, "--frames", options->frames, 1, 100'000, "of each motion");
  auto* seconds = addSeconds(one, "--seconds", options->engine_seconds,
                             "for one engine on one mesh; slow ones measure fewer frames");
  one->add_flag_callback(
         "--full",
         [options] {
           options->engine_seconds = 10;
           options->triangles = {2000, 20000, 200000, 1000000};
         },
         "10 s, and updates of a million triangles, too")
      ->excludes(seconds);
  return {one, [options] { return runReportDeform(*options); }};
}

Verb addMotion(CLI::App* app) {
  auto options = std::make_shared<report::MotionReportOptions>();
  auto problems = std::make_shared<MotionProblems>();
  CLI::App* one = addOne(app, "motion", "time of contact, cost and errors, with FCL and Bullet",
                         "--family ordinary", *options, "of the cases");
  auto* count = addNumber(one, "--cases", options->cases, 1, 10'000'000, "of each family");
  auto* passes =
      addNumber(one, "--passes", options->passes, 0, 10'000, "timed passes; their median is shown");
  one->add_flag_callback(
         "--full", [options] { options->cases = 1000, options->passes = 15; },
         "1000 cases of each family and 15 passes")
      ->excludes(count)
      ->excludes(passes);
  one->add_option("--family", options->families, "only these")
      ->check(CLI::IsMember(report::contactFamilies()));
  one->add_option("--problem", problems->files,
                  "problem files whose edges are measured, certified and in steps")
      ->type_name("FILE");
  addRobot(one, problems->robot, problems->srdf);
  addNumber(one, "--edges", problems->edges, 1, 1'000'000, "of each problem");
  return {one, [options, problems] { return runReportMotion(*options, *problems); }};
}

Verb addIkReport(CLI::App* app) {
  auto options = std::make_shared<report::IkReportOptions>();
  CLI::App* one =
      addOne(app, "ik", "inverse kinematics: success, time, error, proofs of none, with KDL",
             "--poses 200", *options, "of the poses");
  one->add_option("robots", options->robots, "a robot's file and the link that is placed")
      ->type_name("URDF:LINK")
      ->capture_default_str();
  addNumber(one, "--poses", options->poses, 1, 10'000'000,
            "of random configurations of each robot");
  addNumber(one, "--beyond", options->beyond, 0, 1'000'000,
            "poses beyond reach of each robot; proofs are tried for ten times as many reachable "
            "ones");
  return {one, [options] { return runReportIk(*options); }};
}

/// A report on plans of problems, with the options that these have.
CLI::App* addPlans(CLI::App* app, const char* name, const char* what, const char* example,
                   report::ProblemReportOptions& options) {
  CLI::App* one = addOne(app, name, what, example, options, "the first");
  one->add_option("inputs", options.inputs, "problem files or folders of them")
      ->type_name("FILE|FOLDER ...")
      ->required();
  addRobot(one, options.robot, options.srdf);
  addNumber(one, "--seeds", options.seeds, 1, 10'000,
            "runs of each problem, each with its own seed");
  return one;
}

Verb addPlanning(CLI::App* app) {
  auto options = std::make_shared<report::PlanningReportOptions>();
  CLI::App* one = addPlans(app, "planning",
                           "times, lengths and tails of plans, with OMPL's RRTConnect over FCL",
                           "problems/bodies --time 2", *options);
  addSeconds(one, "--time", options->time, "limit of a run [s]");
  return {one, [options] { return runReportPlanning(*options); }};
}

Verb addGrowth(CLI::App* app) {
  auto options = std::make_shared<report::GrowthReportOptions>();
  auto families = std::make_shared<std::vector<std::string>>();
  CLI::App* one =
      addOne(app, "growth", "worlds, edges and plans as boxes, triangles and joints grow, with FCL",
             "--family joints", *options, "of the plans");
  one->add_option("--family", *families, "only these")
      ->delimiter(',')
      ->check(CLI::IsMember(report::growthFamilies()));
  for (auto& [family, counts] : options->counts) {
    const auto [least, most] = report::growthRange(family);
    addNumber(one, ("--" + family).c_str(), counts, least, most, "sizes of the worlds or robots")
        ->delimiter(',')
        ->type_name("N ...");
  }
  addNumber(one, "--edges", options->edges, 1, 100'000,
            "edges that planning asks for, in each world");
  addSeconds(one, "--time", options->time, "limit of a plan [s]");
  return {one, [options, families] {
            if (!families->empty())
              std::erase_if(options->counts, [&](const auto& counts) {
                return std::find(families->begin(), families->end(), counts.first) ==
                       families->end();
              });
            return runReportGrowth(*options);
          }};
}

Verb addSensed(CLI::App* app) {
  auto options = std::make_shared<report::GrowthReportOptions>();
  options->counts = {{"points", {1000, 10000, 100000, 1000000}}};
  CLI::App* one = addOne(app, "sensed",
                         "clouds, edges and plans as points grow, with FCL's octree and nanoflann",
                         "--points 1000,10000", *options, "of the plans");
  const auto [least, most] = report::growthRange("points");
  addNumber(one, "--points", options->counts.at("points"), least, most, "sizes of the clouds")
      ->delimiter(',')
      ->type_name("N ...");
  addNumber(one, "--edges", options->edges, 1, 100'000,
            "edges that planning asks for, whose middles are compared with the truth");
  addSeconds(one, "--time", options->time, "limit of a plan [s]");
  return {one, [options] { return runReportSensed(*options); }};
}

Verb addClearance(CLI::App* app) {
  auto options = std::make_shared<report::ClearanceReportOptions>();
  CLI::App* one =
      addPlans(app, "clearance",
               "clearance from the world against time, with OMPL's objectives over FCL's distance",
               "problems/bodies --times .1,1", *options);
  one->add_option("--times", options->times, "limits of runs, separated by commas [s]")
      ->type_name("S,S ...")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  one->add_option("--hinge", options->hinge, "of the integral: 1 - clearance / M below M")
      ->type_name("M")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  return {one, [options] { return runReportClearance(*options); }};
}

constexpr const char* kExample = "Example:\n  leeway report cases tests/data/cases.txt --raw -";

Verb addCases(CLI::App* app) {
  struct Arguments {
    std::string file, raw = "-", reference;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* one = app->add_subcommand("cases", "answers every pair of shapes of a case file");
  one->add_option("file", arguments->file, "case file (tests/data/README.md)")
      ->type_name("FILE")
      ->required();
  one->add_option("--raw", arguments->raw, "one line a case: ID STATUS LOWER UPPER NS; - is stdout")
      ->type_name("OUT");
  one->add_option("--reference", arguments->reference,
                  "known truth, ID VERDICT D GAP HASVALUE L a line: a table by family instead")
      ->type_name("REF")
      ->excludes("--raw");
  one->footer(kExample);
  return {one, [arguments] {
            return arguments->reference.empty()
                       ? runReportCases(arguments->file, arguments->raw)
                       : runReportCasesAgainst(arguments->file, arguments->reference);
          }};
}

}  // namespace

Verb addReport(CLI::App& command) {
  CLI::App* app = command.add_subcommand("report", "measurements of the engine");
  const std::vector<Verb> reports = {addAccuracy(app), addDeform(app),    addMotion(app),
                                     addIkReport(app), addPlanning(app),  addGrowth(app),
                                     addSensed(app),   addClearance(app), addCases(app)};
  app->require_subcommand(1);
  app->footer(kExample);
  return {app, [reports] {
            return std::find_if(reports.begin(), reports.end(),
                                [](const Verb& report) { return report.app->parsed(); })
                ->run();
          }};
}

}  // namespace leeway::tools
