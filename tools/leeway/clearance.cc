#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/path_io.h"
#include "leeway/robots/input_error.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/output_file.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/scene_names.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"
#include "tools/leeway/view/page.h"
#include "tools/leeway/view/profile_svg.h"

namespace leeway::tools {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::string_view kPictureEndings[] = {".svg"};

struct Arguments {
  ProblemSource source;
  PlanOverrides limits;
  std::vector<std::string> files;
  double tolerance = 1e-4;
  int parts = 1;
  std::string svg;
  view::PageChoice view;
  bool json = false;
};

/// The certified clearance of a stretch of the path.
struct Stretch {
  int segment = 0;
  double t0 = 0, t1 = 1;  ///< of the segment
  planner::EdgeClearance found;
  double t = 0;  ///< of the segment, where the upper end was found
  PairNames names;
  bool keeps_margins = false;
};

struct Profile {
  std::vector<Stretch> stretches;
  planner::Interval clearance{kInfinity, kInfinity};
  int closest = -1;  ///< index of the stretch with the least upper end; -1: nothing is near
  bool certified = true;
};

double leastMargin(const planner::CompiledScene& scene) {
  double least = kInfinity;
  for (const auto& pair : scene.scene().pairs()) {
    least = std::min(least, pair.margin);
  }
  return least;
}

Stretch measure(planner::EdgeCertifier& certifier, const planner::Path& path, int segment, int part,
                const Arguments& arguments) {
  const auto& space = certifier.scene().space();
  const auto& a = path.positions[static_cast<std::size_t>(segment)];
  const auto& b = path.positions[static_cast<std::size_t>(segment) + 1];
  Stretch stretch;
  stretch.segment = segment;
  stretch.t0 = static_cast<double>(part) / arguments.parts;
  stretch.t1 = static_cast<double>(part + 1) / arguments.parts;
  std::vector<double> from(a.size());
  std::vector<double> to(a.size());
  space.interpolate(a, b, stretch.t0, from);
  space.interpolate(a, b, stretch.t1, to);
  stretch.found = certifier.edgeClearance(from, to, arguments.tolerance, -kInfinity);
  stretch.t = stretch.t0 + stretch.found.t * (stretch.t1 - stretch.t0);
  stretch.names = pairNames(certifier.scene(), stretch.found.pair);
  stretch.keeps_margins = certifier.certify(from, to, planner::EdgeRequest::persistent()).verdict ==
                          planner::Verdict::kFree;
  if (stretch.keeps_margins) {
    // Every pair is proven to keep its margin, which may say more than an interval of that
    // tolerance.
    stretch.found.clearance.lower =
        std::max(stretch.found.clearance.lower, leastMargin(certifier.scene()));
  }
  return stretch;
}

Profile measure(planner::EdgeCertifier& certifier, const planner::Path& path,
                const Arguments& arguments, const planner::PlanOptions& options) {
  Profile profile;
  const int segments = static_cast<int>(path.positions.size()) - 1;
  for (int segment = 0; segment < segments; ++segment) {
    for (int part = 0; part < arguments.parts; ++part) {
      if (options.stop()) {
        // What was not looked at may be anything.
        profile.clearance.lower = -kInfinity;
        profile.certified = false;
        return profile;
      }
      showProgress(fmt::format("edge {} of {}", segment + 1, segments));
      const Stretch stretch = measure(certifier, path, segment, part, arguments);
      profile.clearance.lower = std::min(profile.clearance.lower, stretch.found.clearance.lower);
      if (stretch.found.clearance.upper < profile.clearance.upper) {
        profile.clearance.upper = stretch.found.clearance.upper;
        profile.closest = static_cast<int>(profile.stretches.size());
      }
      profile.certified = profile.certified && stretch.keeps_margins;
      profile.stretches.push_back(stretch);
    }
  }
  return profile;
}

Json stretchJson(const Stretch& stretch) {
  Json closest;
  if (stretch.found.pair >= 0) {
    closest = {{"a", stretch.names.a},
               {"b", stretch.names.b},
               {"t", stretch.t},
               {"point_a", jsonVector(stretch.found.closest.point_a)},
               {"point_b", jsonVector(stretch.found.closest.point_b)}};
  }
  return {{"segment", stretch.segment},
          {"t0", stretch.t0},
          {"t1", stretch.t1},
          {"clearance_lower", jsonNumber(stretch.found.clearance.lower)},
          {"clearance_upper", jsonNumber(stretch.found.clearance.upper)},
          {"certified", stretch.keeps_margins},
          {"closest", closest}};
}

Json profileJson(const planner::Problem& problem, const Profile& profile) {
  Json stretches = Json::array();
  for (const Stretch& stretch : profile.stretches) {
    stretches.push_back(stretchJson(stretch));
  }
  Json closest;
  if (profile.closest >= 0) {
    const Stretch& stretch = profile.stretches[static_cast<std::size_t>(profile.closest)];
    closest = {{"a", stretch.names.a},
               {"b", stretch.names.b},
               {"segment", stretch.segment},
               {"t", stretch.t}};
  }
  return {{"status", profile.certified ? "certified" : "not_certified"},
          {"seed", problem.seed},
          {"clearance_lower", jsonNumber(profile.clearance.lower)},
          {"clearance_upper", jsonNumber(profile.clearance.upper)},
          {"closest", closest},
          {"segments", stretches}};
}

void writeSvg(const std::string& file, const planner::Problem& problem, const Profile& profile,
              double margin) {
  std::vector<ProfileStretch> stretches;
  for (const Stretch& stretch : profile.stretches) {
    stretches.push_back({stretch.segment + stretch.t0, stretch.segment + stretch.t1,
                         stretch.found.clearance.lower, stretch.found.clearance.upper});
  }
  const std::string note = profile.certified ? "every edge is certified to keep its margins"
                                             : "not every edge is certified";
  planner::writeFileWhole(file, profileSvg(problem.name, note, "edge", stretches, margin));
}

void printText(const Profile& profile) {
  std::vector<std::vector<std::string>> rows;
  for (const Stretch& stretch : profile.stretches) {
    rows.push_back(
        {fmt::format("{}", stretch.segment), fmt::format("{:.4f}", stretch.t0),
         fmt::format("{:.4f}", stretch.t1), formatLower(stretch.found.clearance.lower * 1e3, 3),
         formatUpper(stretch.found.clearance.upper * 1e3, 3), fmt::format("{:.4f}", stretch.t),
         stretch.found.pair >= 0 ? fmt::format("{} - {}", stretch.names.a, stretch.names.b)
                                 : "nothing near",
         stretch.keeps_margins ? "yes" : "no"});
  }
  fmt::print("{}", formatTable({"edge", "from t", "to t", "at least [mm]", "at most [mm]", "at t",
                                "between", "certified"},
                               rows));
  if (profile.closest >= 0) {
    fmt::print("The path's least clearance is between {} and {} mm.\n",
               formatLower(profile.clearance.lower * 1e3, 3),
               formatUpper(profile.clearance.upper * 1e3, 3));
  }
  fmt::print("{}\n", profile.certified ? "Every edge is certified to keep its margins."
                                       : "Not every edge is certified to keep its margins.");
}

int run(Arguments& arguments) {
  const std::string path_file = takePathFile(arguments.source, arguments.files);
  if (!arguments.svg.empty()) {
    checkOutputFile(arguments.svg, kPictureEndings);
  }
  view::expectPage(arguments.view);
  planner::Problem problem = loadProblem(arguments.source);
  apply(arguments.limits, problem);
  const planner::Path path = planner::readPath(path_file, problem);
  if (path.positions.size() < 2) {
    throw robots::InputError(path_file, 0,
                             "has fewer than two waypoints: there is no edge to measure");
  }
  planner::EdgeCertifier certifier(std::make_shared<const planner::CompiledScene>(problem));
  const Profile profile =
      measure(certifier, path, arguments, interactivePlanOptions(arguments.limits.time_limit));
  endProgress();
  if (!arguments.view.file.empty()) {
    view::writePage(arguments.view, view::subjectOfPath(problem, arguments.source.problem, path));
  }
  if (!arguments.svg.empty()) {
    writeSvg(arguments.svg, problem, profile, leastMargin(certifier.scene()));
  }
  if (arguments.json) {
    printJson(profileJson(problem, profile));
  } else {
    printText(profile);
  }
  return profile.certified ? kYes : kNo;
}

}  // namespace

Verb addClearance(CLI::App& command) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app = command.add_subcommand(
      "clearance", "clearance along a path as certified intervals, with the closest pair");
  addProblemAndPathArguments(*app, arguments->source, arguments->files);
  addRunLimits(*app, arguments->limits);
  app->add_option("--tolerance", arguments->tolerance, "width of the intervals [m]")
      ->type_name("METRES")
      ->check(numberFrom(1e-12, 1e9))
      ->capture_default_str();
  app->add_option("--parts", arguments->parts, "stretches that every edge is cut into")
      ->type_name("N")
      ->check(countFrom(1, 100000))
      ->capture_default_str();
  view::addPageOptions(*app, arguments->view);
  app->add_option("--svg", arguments->svg, "also draw it")->type_name("FILE.svg");
  app->add_flag("--json", arguments->json, "print one JSON document");
  app->footer(
      "Example:\n"
      "  leeway plan problems/shelf/reach.yaml --output path.json && leeway clearance "
      "problems/shelf/reach.yaml path.json --parts 4");
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace leeway::tools
