#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>

#include "collision/base/numbers.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/path_io.h"
#include "leeway/robots/input_error.h"
#include "planner/constraint/constraint_proof.h"
#include "planner/edge/why_undecided.h"
#include "planner/execute/unchecked_json.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/path_ends.h"
#include "tools/leeway/support/plan_overrides.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/robot_state.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"
#include "tools/leeway/view/page_options.h"
#include "tools/leeway/view/profile_svg.h"
#include "tools/view/base/figures.h"
#include "tools/view/base/output_file.h"
#include "tools/view/base/scene_names.h"
#include "tools/view/least_clearance.h"
#include "tools/view/stages.h"

namespace leeway::tools {
namespace {

constexpr double kJsonTolerance = 1e-4;  // [m]
constexpr std::string_view kPictureEndings[] = {".svg"};
constexpr std::string_view kTableEndings[] = {".csv"};

struct ClearanceArguments {
  ProblemSource source;
  PlanOverrides limits;
  std::vector<std::string> files;
  std::optional<double> tolerance;  ///< [m]; not given: what the shown digits need
  int parts = 1;
  bool shortest = false;
  std::string svg, csv;
  view::PageChoice view;
  bool json = false;
};

/// The certified clearance of a stretch from the world or of the robot from itself.
struct Near {
  planner::Interval clearance;
  double t = 0;  ///< of the segment, at the place of the upper bound
  collision::DistanceResult closest;
  PairNames names;  ///< empty if nothing is near
};

/// A stretch of the path: a whole edge, or a part of it.
struct Stretch {
  int segment = 0;
  double t0 = 0, t1 = 1;  ///< of the segment
  std::string step;       ///< of a task; else empty
  Near world, self;
  Near all;  ///< the nearer of the two, with the lesser lower bound
  bool keeps_margins = false;
  std::string failure;  ///< where it does not, if that is refuted
};

/// The clearance of a whole path from the world or of the robot from itself.
struct Whole {
  planner::Interval clearance{kInfinity, kInfinity};
  int closest = -1;  ///< index of the stretch with the least upper bound; -1: nothing is near

  void add(const Near& near, int stretch) {
    clearance.lower = std::min(clearance.lower, near.clearance.lower);
    if (!(near.clearance.upper < clearance.upper)) return;
    clearance.upper = near.clearance.upper;
    closest = stretch;
  }
};

struct Profile {
  std::vector<Stretch> stretches;
  Whole all, world, self;
  bool certified = true;
  std::string nothing_checked;                         ///< why; else empty
  std::vector<planner::ConstraintResult> constraints;  ///< where all are proven
  std::string broken;  ///< the first that is not, or why an edge is not certified, and where
  std::set<planner::CompiledScene::Dropped> dropped;  ///< in some step

  std::vector<planner::UncheckedPairs> unchecked() const {
    return planner::countUnchecked(std::vector(dropped.begin(), dropped.end()));
  }
};

/// RFC 4180: a field with a comma, a quote or a line end is quoted, and its quotes are doubled.
std::string csvField(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + "\"";
}

double leastMargin(const planner::CompiledScene& scene) {
  return scene.scene().pairs().leastMargin();
}

/// Measures part `part` of `parts` of a segment, with the first of the widths that gives a figure.
Stretch measure(planner::EdgeCertifier& certifier, const planner::Path& path, int segment, int part,
                int parts, std::span<const double> widths) {
  const auto& space = certifier.scene().space();
  const auto& a = path.positions[static_cast<std::size_t>(segment)];
  const auto& b = path.positions[static_cast<std::size_t>(segment) + 1];
  Stretch stretch;
  stretch.segment = segment;
  stretch.t0 = static_cast<double>(part) / parts;
  stretch.t1 = static_cast<double>(part + 1) / parts;
  std::vector<double> from(a.size());
  std::vector<double> to(a.size());
  space.alongLine(a, b, stretch.t0, from);
  space.alongLine(a, b, stretch.t1, to);
  const planner::EdgeCheck check = certifier.certify(from, to, planner::EdgeRequest::persistent());
  stretch.keeps_margins = check.verdict == planner::Verdict::kFree;
  if (check.verdict == planner::Verdict::kNotFree && check.pair >= 0) {
    const PairNames names = pairNames(certifier.scene(), check.pair);
    stretch.failure = fmt::format(
        "{} and {} do not keep their margin of {:g} mm on edge {} at t = {:.3f}", names.a, names.b,
        certifier.scene().scene().pairs()[at(check.pair)].margin * 1e3, segment,
        stretch.t0 + check.t * (stretch.t1 - stretch.t0));
  }
  const auto measured = [&](planner::Pairs pairs) {
    planner::EdgeClearance found;
    for (const double width : widths) {
      const planner::EdgeClearance finer =
          certifier.edgeClearance(from, to,
                                  {.tolerance = width,
                                   .work_limit = width == widths.front() ? 0 : view::kFigureWork,
                                   .pairs = pairs});
      if (width == widths.front() || finer.clearance.width() < found.clearance.width())
        found = finer;
      if (figureOf(found.clearance) || !std::isfinite(found.clearance.upper)) break;
    }
    Near near{found.clearance, stretch.t0 + found.t * (stretch.t1 - stretch.t0), found.closest,
              pairNames(certifier.scene(), found.pair)};
    if (stretch.keeps_margins) {
      // Every pair is proven to keep its margin, which may be a better bound than an interval of
      // that tolerance.
      near.clearance.lower = std::max(near.clearance.lower, leastMargin(certifier.scene()));
    }
    return near;
  };
  stretch.world = measured(planner::Pairs::kWorld);
  stretch.self = measured(planner::Pairs::kSelf);
  stretch.all =
      stretch.self.clearance.upper < stretch.world.clearance.upper ? stretch.self : stretch.world;
  stretch.all.clearance.lower =
      std::min(stretch.world.clearance.lower, stretch.self.clearance.lower);
  return stretch;
}

/// Why nothing is proven of an edge, wherever bodies are; else empty.
std::string whyNotCertified(const planner::CompiledScene& scene, const planner::Path& path,
                            std::size_t edge) {
  std::string why;
  for (const auto* end : {&path.positions[edge], &path.positions[edge + 1]}) {
    if (why.empty()) why = planner::whyUndecided(scene, *end);
    if (why.empty()) why = brokenLimit(scene.space(), *end);
  }
  return why;
}

/// Measures every stretch of a path in the world of its step. Without steps there is one world.
Profile measure(const std::vector<view::Stage>& stages, const planner::Path& path,
                const ClearanceArguments& arguments, const planner::PlanOptions& options) {
  Profile profile;
  const double given = arguments.tolerance.value_or(kJsonTolerance);
  const std::span<const double> widths = arguments.json || arguments.tolerance
                                             ? std::span(&given, 1)
                                             : std::span<const double>(view::kFigureWidths);
  UnitProgress progress(path.positions.size() - 1);
  for (const view::Stage& stage : stages) {
    if (stage.last == stage.first) continue;  // an object is attached or detached
    profile.dropped.insert(stage.scene->dropped().begin(), stage.scene->dropped().end());
    if (profile.nothing_checked.empty()) profile.nothing_checked = stage.scene->nothingChecked();
    planner::EdgeCertifier certifier(stage.scene);
    for (int segment = stage.first; segment < stage.last; ++segment) {
      progress.next("edge");
      // A line with more than half a turn of a continuous joint is measured in more parts.
      const auto i = static_cast<std::size_t>(segment);
      const int parts = arguments.parts * stage.scene->space().edgesAlongLine(
                                              path.positions[i], path.positions[i + 1]);
      for (int part = 0; part < parts; ++part) {
        if (options.stop()) {
          // The clearance of the rest is unknown.
          for (Whole* whole : {&profile.all, &profile.world, &profile.self}) {
            whole->clearance.lower = -kInfinity;
          }
          profile.certified = false;
          return profile;
        }
        Stretch stretch = measure(certifier, path, segment, part, parts, widths);
        stretch.step = stage.name;
        const auto index = static_cast<int>(profile.stretches.size());
        profile.all.add(stretch.all, index);
        profile.world.add(stretch.world, index);
        profile.self.add(stretch.self, index);
        const std::string why = whyNotCertified(*stage.scene, path, i);
        stretch.keeps_margins = stretch.keeps_margins && why.empty();
        profile.certified = profile.certified && stretch.keeps_margins;
        if (!why.empty() && profile.broken.empty())
          profile.broken = fmt::format("edge {} is not certified: {}", segment, why);
        profile.stretches.push_back(std::move(stretch));
      }
    }
  }
  return profile;
}

Json nearJson(const Near& near) {
  Json closest;
  if (!near.names.a.empty()) {
    closest = {{"a", near.names.a},
               {"b", near.names.b},
               {"t", near.t},
               {"point_a", jsonVector(near.closest.point_a)},
               {"point_b", jsonVector(near.closest.point_b)}};
  }
  return {{"clearance_lower", jsonNumber(near.clearance.lower)},
          {"clearance_upper", jsonNumber(near.clearance.upper)},
          {"closest", closest}};
}

Json stretchJson(const Stretch& stretch) {
  Json document = nearJson(stretch.all);
  document["segment"] = stretch.segment;
  document["t0"] = stretch.t0;
  document["t1"] = stretch.t1;
  document["certified"] = stretch.keeps_margins;
  if (!stretch.step.empty()) document["step"] = stretch.step;
  document["world"] = nearJson(stretch.world);
  document["self"] = nearJson(stretch.self);
  return document;
}

Json wholeJson(const Profile& profile, const Whole& whole, Near Stretch::*near) {
  Json closest;
  if (whole.closest >= 0) {
    const Stretch& stretch = profile.stretches[static_cast<std::size_t>(whole.closest)];
    closest = {{"a", (stretch.*near).names.a},
               {"b", (stretch.*near).names.b},
               {"segment", stretch.segment},
               {"t", (stretch.*near).t}};
  }
  return {{"clearance_lower", jsonNumber(whole.clearance.lower)},
          {"clearance_upper", jsonNumber(whole.clearance.upper)},
          {"closest", closest}};
}

Json profileJson(const planner::Problem& problem, const Profile& profile) {
  Json stretches = Json::array();
  for (const Stretch& stretch : profile.stretches) {
    stretches.push_back(stretchJson(stretch));
  }
  Json document = wholeJson(profile, profile.all, &Stretch::all);
  document["status"] = !profile.nothing_checked.empty() ? "nothing_checked"
                       : profile.certified              ? "certified"
                                                        : "not_certified";
  const std::string& reason =
      profile.nothing_checked.empty() ? profile.broken : profile.nothing_checked;
  document["reason"] = reason.empty() ? Json() : Json(reason);
  document["not_checked"] = planner::uncheckedJson(profile.unchecked());
  document["clouds"] = planner::cloudsJson(problem);
  document["seed"] = problem.seed;
  document["world"] = wholeJson(profile, profile.world, &Stretch::world);
  document["self"] = wholeJson(profile, profile.self, &Stretch::self);
  document["segments"] = stretches;
  document["constraints"] = constraintsJson(profile.constraints);
  return document;
}

/// Writes one row per stretch. Fields are empty if nothing is near. For a task, the last column
/// names the step.
void writeCsv(const std::string& file, const Profile& profile, bool steps) {
  std::string text = "segment,t0,t1";
  for (const char* part : {"world", "self"}) {
    for (const char* column : {"lower", "upper", "t", "a", "b"}) {
      text += fmt::format(",{}_{}", part, column);
    }
  }
  text += steps ? ",certified,step\n" : ",certified\n";
  const auto number = [](double x) {
    return std::isfinite(x) ? fmt::format("{:.17g}", x) : std::string();
  };
  for (const Stretch& stretch : profile.stretches) {
    text += fmt::format("{},{},{}", stretch.segment, number(stretch.t0), number(stretch.t1));
    for (const Near* near : {&stretch.world, &stretch.self}) {
      text += fmt::format(",{},{},{}", number(near->clearance.lower), number(near->clearance.upper),
                          near->names.a.empty() ? "" : number(near->t));
      for (const std::string* name : {&near->names.a, &near->names.b})
        text += "," + csvField(*name);
    }
    text += stretch.keeps_margins ? ",yes" : ",no";
    text += steps ? "," + csvField(stretch.step) + "\n" : "\n";
  }
  planner::writeFileWhole(file, text);
}

void writeSvg(const std::string& file, const planner::Problem& problem, const Profile& profile,
              const view::Timeline& timeline, const std::set<double>& margins) {
  const std::string note = !profile.nothing_checked.empty() ? "nothing was checked"
                           : profile.certified ? "every edge is certified to keep its margins"
                                               : "not every edge is certified";
  planner::writeFileWhole(
      file, profileSvg(problem.name, note + obstaclesText(problem), timeline, margins));
}

/// The clearance of a whole path, with the place where it is least.
planner::PathClearance placed(const Profile& profile, const Whole& whole, Near Stretch::*near) {
  planner::PathClearance placed;
  placed.clearance = whole.clearance;
  if (whole.closest < 0) return placed;
  const Stretch& stretch = profile.stretches[at(whole.closest)];
  placed.closest_a = (stretch.*near).names.a;
  placed.closest_b = (stretch.*near).names.b;
  placed.closest_segment = stretch.segment;
  placed.closest_t = (stretch.*near).t;
  return placed;
}

/// Gives the rows what is proven of the whole path: each keeps its least clearance, and the row at
/// its place has no more.
void narrowRows(const planner::PathClearance& least, Near Stretch::*near, Profile& profile) {
  for (Stretch& stretch : profile.stretches) {
    planner::Interval& row = (stretch.*near).clearance;
    row.lower = std::max(row.lower, least.clearance.lower);
    if (stretch.segment == least.closest_segment && stretch.t0 <= least.closest_t &&
        least.closest_t <= stretch.t1)
      row.upper = std::min(row.upper, least.clearance.upper);
  }
}

/// One row for each stretch, for the world and for the robot itself. Parts of edges have their t.
std::string stretchTable(const Profile& profile, bool steps, bool parts) {
  std::vector<std::string> heading = {"edge"};
  if (parts) heading.insert(heading.end(), {"from t", "to t"});
  if (steps) heading.emplace_back("step");
  heading.insert(heading.end(), {"from", "clearance", "at t", "proven", "between"});
  std::vector<std::vector<std::string>> rows;
  for (const Stretch& stretch : profile.stretches) {
    for (const Near* near : {&stretch.world, &stretch.self}) {
      if (near->names.a.empty()) continue;
      std::vector<std::string> row = {fmt::format("{}", stretch.segment)};
      if (parts)
        row.insert(row.end(),
                   {fmt::format("{:.3f}", stretch.t0), fmt::format("{:.3f}", stretch.t1)});
      if (steps) row.push_back(stretch.step);
      row.insert(row.end(),
                 {near == &stretch.world ? "world" : "self", clearanceText(near->clearance),
                  fmt::format("{:.3f}", near->t), stretch.keeps_margins ? "yes" : "no",
                  fmt::format("{} - {}", near->names.a, near->names.b)});
      rows.push_back(std::move(row));
    }
  }
  if (rows.empty()) return "";
  const std::size_t from = (parts ? 3U : 1U) + (steps ? 1U : 0U);
  return formatTable(heading, rows, {from - (steps ? 1U : 0U), from, from + 3, from + 4});
}

/// Sentences: the first stretches that do not keep their margins, which other pairs may be below.
std::string failuresText(const Profile& profile) {
  constexpr int kShown = 3;
  std::string text;
  int count = 0;
  for (const Stretch& stretch : profile.stretches)
    if (!stretch.failure.empty() && ++count <= kShown) text += stretch.failure + ".\n";
  if (count == kShown + 1) text += "1 more stretch does not keep its margins.\n";
  if (count > kShown + 1)
    text += fmt::format("{} more stretches do not keep their margins.\n", count - kShown);
  return text;
}

void printText(const planner::Problem& problem, const Profile& profile,
               const view::LeastClearance& least, bool parts) {
  if (!profile.nothing_checked.empty()) {
    fmt::print(
        "{}", wrapped(fmt::format("{}: {}: {}.\n", problem.name,
                                  verdictText("nothing checked", false), profile.nothing_checked)));
    return;
  }
  const std::string verdict =
      verdictText(profile.certified ? "certified" : "not certified", profile.certified);
  const std::string table = stretchTable(profile, !problem.steps.empty(), parts);
  fmt::print("{}{}{}{}{}",
             wrapped(fmt::format("{}: {}, {}{}\n", problem.name, verdict, view::leastText(least),
                                 obstaclesText(problem))),
             table.empty() ? "" : "\n", table, table.empty() ? "" : "\n",
             wrapped(view::nearestText(least) + failuresText(profile) +
                     planner::toString(profile.unchecked()) + ".\n" +
                     (profile.broken.empty() ? constraintsText(problem, profile.constraints)
                                             : fmt::format("The {}.\n", profile.broken))));
}

/// Adds what is proven about the constraints. Where one is not proven, no stretch from there on is
/// certified.
void proveConstraints(const planner::CompiledScene& scene, const planner::Problem& problem,
                      const planner::Path& path, Profile& profile) {
  const planner::PathEdges edges = planner::edgesOf(scene.space(), path);
  planner::ConstraintProof::Broken broken;
  if (auto proven = planner::ConstraintProof(scene, problem).prove(edges.path.positions, &broken)) {
    profile.constraints = std::move(*proven);
    return;
  }
  const int segment = edges.places[broken.edge].segment;
  profile.certified = false;
  if (profile.broken.empty()) profile.broken = fmt::format("{} on edge {}", broken.what, segment);
  for (Stretch& stretch : profile.stretches)
    stretch.keeps_margins = stretch.keeps_margins && stretch.segment < segment;
}

int runClearance(ClearanceArguments& arguments) {
  const std::string path_file = takePathFile(arguments.source, arguments.files);
  if (!arguments.svg.empty()) {
    checkOutputFile(arguments.svg, kPictureEndings);
  }
  view::expectPage(arguments.view);
  if (!arguments.csv.empty()) {
    checkOutputFile(arguments.csv, kTableEndings);
  }
  std::vector<std::string> inputs = filesOf(arguments.source);
  inputs.push_back(path_file);
  expectApart(std::array{arguments.svg, arguments.csv, arguments.view.file}, inputs);
  planner::Problem problem = loadProblem(arguments.source, arguments.limits);
  std::vector<std::string> warnings;
  planner::Path path = planner::readPath(path_file, problem,
                                         {.shortest = arguments.shortest, .warnings = &warnings});
  // A path that stays where it begins has an edge without length.
  if (path.positions.size() == 1 && problem.steps.empty())
    path.positions.push_back(path.positions.front());
  if (path.positions.size() < 2) {
    throw robots::InputError(path_file, 0,
                             "has fewer than two waypoints: there is no edge to measure");
  }
  for (const std::string& end : strayEnds(path, problem))
    warnings.push_back(path_file + ": " + end);
  printWarnings(warnings);
  const std::vector<view::Stage> stages = view::stagesOf(
      problem,
      problem.steps.empty() ? std::make_shared<const planner::CompiledScene>(problem) : nullptr,
      path);
  const bool steps = !problem.steps.empty();
  if (!steps) printWarnings(stages.front().scene->warnings());
  Profile profile =
      measure(stages, path, arguments, interactivePlanOptions(arguments.limits.timeLimit()));
  if (!steps) proveConstraints(*stages.front().scene, problem, path, profile);
  endProgress();
  std::optional<view::Subject> subject;
  if (!arguments.view.file.empty() || !arguments.svg.empty()) {
    subject.emplace(
        view::subjectOfPath(problem, arguments.source.problem, path, nullptr, interrupted));
    subject->path_file = path_file;
  }
  if (!arguments.view.file.empty()) view::writePage(arguments.view, *subject);
  if (!arguments.svg.empty()) {
    std::set<double> margins;
    for (const view::Stage& stage : stages)
      if (stage.scene)
        for (const collision::ScenePair& pair : stage.scene->scene().pairs())
          margins.insert(pair.margin);
    writeSvg(arguments.svg, problem, profile, subject->timeline, margins);
  }
  if (!arguments.csv.empty()) {
    writeCsv(arguments.csv, profile, steps);
  }
  if (arguments.json) {
    Json document = profileJson(problem, profile);
    document["interrupted"] = interrupted();
    std::vector<std::string> all = planner::problemWarnings(problem);
    all.insert(all.end(), warnings.begin(), warnings.end());
    document["warnings"] = all;
    printJson(document);
  } else {
    if (interrupted()) fmt::print("Interrupted: what is not measured yet is open.\n");
    view::LeastClearance least = view::leastClearance(problem, path, interrupted);
    view::narrow(least, placed(profile, profile.all, &Stretch::all),
                 placed(profile, profile.world, &Stretch::world),
                 placed(profile, profile.self, &Stretch::self));
    narrowRows(least.world, &Stretch::world, profile);
    narrowRows(least.self, &Stretch::self, profile);
    const bool parts = std::any_of(profile.stretches.begin(), profile.stretches.end(),
                                   [](const Stretch& s) { return s.t1 - s.t0 < 1; });
    printText(problem, profile, least, parts);
  }
  return profile.certified && profile.nothing_checked.empty() ? kYes : kNo;
}

}  // namespace

Verb addClearance(CLI::App& command) {
  auto arguments = std::make_shared<ClearanceArguments>();
  CLI::App* app = command.add_subcommand(
      "clearance", "clearance along a path as certified intervals, with the closest pair");
  addProblemAndPathArguments(*app, arguments->source, arguments->files);
  addRunLimits(*app, arguments->limits);
  addTerms(*app, arguments->limits);
  app->add_option(
         "--tolerance", arguments->tolerance,
         "width of the intervals [m]; default: enough for the digits shown; with --json 1e-4")
      ->type_name("METRES")
      ->check(numberFrom(1e-12, 1e9));
  app->add_option("--parts", arguments->parts, "stretches that every edge is cut into")
      ->type_name("N")
      ->check(countFrom(1, 100000))
      ->capture_default_str();
  addShortest(*app, arguments->shortest);
  view::addPageOptions(*app, arguments->view);
  app->add_option("--csv", arguments->csv, "also write it as a table")->type_name("FILE.csv");
  app->add_option("--svg", arguments->svg, "also draw it over the time of the motion")
      ->type_name("FILE.svg");
  app->add_flag("--json", arguments->json, "print one JSON document");
  app->footer(
      "Example:\n"
      "  leeway plan problems/shelf/reach.yaml --output path.json && leeway clearance "
      "problems/shelf/reach.yaml path.json --parts 4");
  return {app, [arguments] { return runClearance(*arguments); }};
}

}  // namespace leeway::tools
