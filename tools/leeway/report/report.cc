#include "tools/leeway/report/report.h"

#include <memory>

#include "tools/report/deform/deform_scenes.h"
#include "tools/report/growth/growth_worlds.h"
#include "tools/report/motion/motion_cases.h"

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

CLI::App* addDeform(CLI::App* app, const std::shared_ptr<ReportDeformArguments>& arguments) {
  CLI::App* deform = app->add_subcommand(
      "deform", "updates and queries of deforming meshes, with FCL, Bullet and Embree");
  deform->add_option("--output", arguments->output, "folder for CSV and pictures")
      ->type_name("DIR")
      ->capture_default_str();
  deform->add_option("--seed", arguments->seed, "of the motions")->capture_default_str();
  deform->add_option("--motion", arguments->motions, "only these")
      ->check(CLI::IsMember(report::deformMotions()));
  deform->add_option("--triangles", arguments->triangles, "sizes of the meshes")
      ->check(CLI::Range(2, 10'000'000))
      ->capture_default_str();
  deform->add_option("--frames", arguments->frames, "of each motion")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  auto* seconds = deform
                      ->add_option("--seconds", arguments->seconds,
                                   "for one engine on one mesh; slow ones measure fewer frames")
                      ->check(CLI::PositiveNumber)
                      ->capture_default_str();
  deform
      ->add_flag_callback(
          "--full",
          [arguments] {
            arguments->seconds = 10;
            arguments->triangles = {2000, 20000, 200000, 1000000};
          },
          "10 s, and updates of a million triangles, too")
      ->excludes(seconds);
  deform->add_flag("--no-rivals", arguments->no_rivals, "ours alone");
  deform->add_flag("--json", arguments->json, "one JSON document");
  deform->footer(
      "Example:\n  leeway report deform --motion wave --triangles 2000 --output /tmp/report");
  return deform;
}

CLI::App* addMotion(CLI::App* app, const std::shared_ptr<ReportMotionArguments>& arguments) {
  CLI::App* motion =
      app->add_subcommand("motion", "time of contact, cost and errors, with FCL and Bullet");
  motion->add_option("--output", arguments->output, "folder for CSV and pictures")
      ->type_name("DIR")
      ->capture_default_str();
  motion->add_option("--seed", arguments->seed, "of the cases")->capture_default_str();
  auto* count = motion->add_option("--cases", arguments->cases, "a family")
                    ->check(CLI::Range(1, 10'000'000))
                    ->capture_default_str();
  auto* passes =
      motion->add_option("--passes", arguments->passes, "timed passes, whose median is told")
          ->check(CLI::Range(0, 10000))
          ->capture_default_str();
  motion
      ->add_flag_callback(
          "--full",
          [arguments] {
            arguments->cases = 1000;
            arguments->passes = 15;
          },
          "1000 cases a family and 15 passes")
      ->excludes(count)
      ->excludes(passes);
  motion->add_option("--family", arguments->families, "only these")
      ->check(CLI::IsMember(report::contactFamilies()));
  motion
      ->add_option("--problem", arguments->problems,
                   "problem files whose edges are looked at, certified and in steps")
      ->type_name("FILE");
  auto* robot = motion
                    ->add_option("--robot", arguments->robot,
                                 "URDF: problems are MoveIt scenes, requests beside them")
                    ->type_name("URDF");
  motion->add_option("--srdf", arguments->srdf, "its SRDF")->type_name("SRDF")->needs(robot);
  motion->add_option("--edges", arguments->edges, "of each problem")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  motion->add_flag("--no-rivals", arguments->no_rivals, "ours alone");
  motion->add_flag("--json", arguments->json, "one JSON document");
  motion->footer("Example:\n  leeway report motion --family ordinary --output /tmp/report");
  return motion;
}

CLI::App* addIkReport(CLI::App* app, const std::shared_ptr<ReportIkArguments>& arguments) {
  CLI::App* ik = app->add_subcommand(
      "ik", "inverse kinematics: success, time, error, proofs of none, with KDL");
  ik->add_option("robots", arguments->robots, "a robot's file and the link that is placed")
      ->type_name("URDF:LINK")
      ->capture_default_str();
  ik->add_option("--output", arguments->output, "folder for CSV")
      ->type_name("DIR")
      ->capture_default_str();
  ik->add_option("--seed", arguments->seed, "of the poses")->capture_default_str();
  ik->add_option("--poses", arguments->poses, "of random configurations of each robot")
      ->check(CLI::Range(1, 10'000'000))
      ->capture_default_str();
  ik->add_option("--beyond", arguments->beyond,
                 "poses beyond reach of each robot; proofs are tried for ten times as many "
                 "reachable ones")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  ik->add_flag("--no-rivals", arguments->no_rivals, "ours alone");
  ik->add_flag("--json", arguments->json, "one JSON document");
  ik->footer("Example:\n  leeway report ik --poses 200 --output /tmp/report");
  return ik;
}

/// What reports of plans of problems share.
void addProblems(CLI::App& app, ReportPlanningArguments& arguments) {
  app.add_option("inputs", arguments.inputs, "problem files or folders of them")
      ->type_name("FILE|FOLDER ...")
      ->required();
  auto* robot = app.add_option("--robot", arguments.robot,
                               "URDF: problems are MoveIt scenes, requests beside them")
                    ->type_name("URDF");
  app.add_option("--srdf", arguments.srdf, "its SRDF")->type_name("SRDF")->needs(robot);
  app.add_option("--output", arguments.output, "folder for CSV")
      ->type_name("DIR")
      ->capture_default_str();
  app.add_option("--seed", arguments.seed, "the first")->capture_default_str();
  app.add_option("--seeds", arguments.seeds, "runs of each problem, each with its own seed")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  app.add_flag("--no-rivals", arguments.no_rivals, "ours alone");
  app.add_flag("--json", arguments.json, "one JSON document");
}

CLI::App* addPlanning(CLI::App* app, const std::shared_ptr<ReportPlanningArguments>& arguments) {
  CLI::App* planning = app->add_subcommand(
      "planning", "times, lengths and tails of plans, with OMPL's RRTConnect over FCL");
  addProblems(*planning, *arguments);
  planning->add_option("--time", arguments->time, "limit of a run [s]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  planning->footer(
      "Example:\n  leeway report planning problems/bodies --time 2 --output /tmp/report");
  return planning;
}

CLI::App* addGrowth(CLI::App* app, const std::shared_ptr<ReportGrowthArguments>& arguments) {
  CLI::App* growth = app->add_subcommand(
      "growth", "worlds, edges and plans as boxes, triangles and joints grow, with FCL");
  growth->add_option("--output", arguments->output, "folder for CSV and pictures")
      ->type_name("DIR")
      ->capture_default_str();
  growth->add_option("--seed", arguments->seed, "of the plans")->capture_default_str();
  growth->add_option("--family", arguments->families, "only these")
      ->check(CLI::IsMember(report::growthFamilies()));
  const auto addCounts = [&](const char* name, const std::string& family,
                             std::vector<std::int64_t>& counts, const char* what) {
    const auto [least, most] = report::growthRange(family);
    growth->add_option(name, counts, what)
        ->type_name("N ...")
        ->check(CLI::Range(least, most))
        ->capture_default_str();
  };
  addCounts("--boxes", "boxes", arguments->boxes, "how many, most of them out of reach");
  addCounts("--triangles", "triangles", arguments->triangles, "of a ring around the arm");
  addCounts("--joints", "joints", arguments->joints, "of the arm");
  growth->add_option("--edges", arguments->edges, "that planning asks for, in each world")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  growth->add_option("--time", arguments->time, "limit of a plan [s]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  growth->add_flag("--no-rivals", arguments->no_rivals, "ours alone");
  growth->add_flag("--json", arguments->json, "one JSON document");
  growth->footer("Example:\n  leeway report growth --family joints --output /tmp/report");
  return growth;
}

CLI::App* addClearance(CLI::App* app, const std::shared_ptr<ReportClearanceArguments>& arguments) {
  CLI::App* clearance = app->add_subcommand(
      "clearance",
      "clearance from the world against time, with OMPL's objectives over FCL's distance");
  addProblems(*clearance, *arguments);
  clearance->add_option("--times", arguments->times, "limits of runs, with commas between [s]")
      ->type_name("S,S ...")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  clearance->add_option("--hinge", arguments->hinge, "of the integral: 1 - clearance / M below M")
      ->type_name("M")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  clearance->footer(
      "Example:\n  leeway report clearance problems/bodies --times .1,1 --output /tmp/report");
  return clearance;
}

}  // namespace

Verb addReport(CLI::App& command) {
  auto arguments = std::make_shared<Arguments>();
  auto accuracy_arguments = std::make_shared<ReportAccuracyArguments>();
  CLI::App* app = command.add_subcommand("report", "measurements of the engine");
  CLI::App* accuracy = addAccuracy(app, accuracy_arguments);
  auto deform_arguments = std::make_shared<ReportDeformArguments>();
  CLI::App* deform = addDeform(app, deform_arguments);
  auto motion_arguments = std::make_shared<ReportMotionArguments>();
  CLI::App* motion = addMotion(app, motion_arguments);
  auto ik_arguments = std::make_shared<ReportIkArguments>();
  CLI::App* ik = addIkReport(app, ik_arguments);
  auto planning_arguments = std::make_shared<ReportPlanningArguments>();
  CLI::App* planning = addPlanning(app, planning_arguments);
  auto growth_arguments = std::make_shared<ReportGrowthArguments>();
  CLI::App* growth = addGrowth(app, growth_arguments);
  auto clearance_arguments = std::make_shared<ReportClearanceArguments>();
  CLI::App* clearance = addClearance(app, clearance_arguments);
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
  return {app, [=] {
            if (accuracy->parsed()) return runReportAccuracy(*accuracy_arguments);
            if (deform->parsed()) return runReportDeform(*deform_arguments);
            if (motion->parsed()) return runReportMotion(*motion_arguments);
            if (ik->parsed()) return runReportIk(*ik_arguments);
            if (growth->parsed()) return runReportGrowth(*growth_arguments);
            if (planning->parsed()) return runReportPlanning(*planning_arguments);
            if (clearance->parsed()) return runReportClearance(*clearance_arguments);
            return arguments->reference.empty()
                       ? runReportCases(arguments->file, arguments->raw)
                       : runReportCasesAgainst(arguments->file, arguments->reference);
          }};
}

}  // namespace leeway::tools
