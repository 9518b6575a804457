#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <utility>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "leeway/robots/input_error.h"
#include "planner/constraint/constraint_proof.h"
#include "planner/search/goal_sampler.h"
#include "robots/base/read_file.h"
#include "tools/leeway/info/input.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"
#include "tools/view/base/figures.h"
#include "tools/view/base/scene_names.h"

namespace leeway::tools {
namespace {

struct LintArguments {
  ProblemSource source;  ///< robot, srdf and packages only
  std::vector<std::string> files;
  std::string format = "text";
  bool json = false;
};

struct Finding {
  std::string file;
  int line = 0;  ///< 0 without one
  bool error = false;
  std::string message;
};

/// A warning is "FILE:LINE: text", or "FILE: text" about a file as a whole; else it concerns
/// `file`.
Finding findingOf(const std::string& warning, const std::string& file) {
  for (std::size_t end = warning.find(": "); end != std::string::npos;
       end = warning.find(": ", end + 1)) {
    std::size_t digits = end;
    while (digits > 0 && std::isdigit(static_cast<unsigned char>(warning[digits - 1])) != 0)
      --digits;
    // Nine digits fit an int.
    if (digits == end || end - digits > 9 || digits == 0 || warning[digits - 1] != ':') continue;
    return {warning.substr(0, digits - 1), std::stoi(warning.substr(digits, end - digits)), false,
            warning.substr(end + 2)};
  }
  const std::size_t end = warning.find(": ");
  std::error_code error;
  if (end != std::string::npos && std::filesystem::is_regular_file(warning.substr(0, end), error))
    return {warning.substr(0, end), 0, false, warning.substr(end + 2)};
  return {file, 0, false, warning};
}

Finding findingOf(const robots::InputError& error, const std::string& file) {
  const std::string place =
      error.line() > 0 ? fmt::format("{}:{}: ", error.file(), error.line()) : error.file() + ": ";
  const std::string what = error.what();
  return {error.file().empty() ? file : error.file(), error.line(), true,
          what.starts_with(place) ? what.substr(place.size()) : what};
}

class Findings {
 public:
  /// Adds a finding once, because files that share a robot have the same findings about it.
  void add(const Finding& finding) {
    const auto isSame = [&](const Finding& other) {
      return other.line == finding.line && other.error == finding.error &&
             other.message == finding.message && isSameFile(other.file, finding.file);
    };
    if (std::none_of(list_.begin(), list_.end(), isSame)) list_.push_back(finding);
  }
  void addWarnings(const std::vector<std::string>& warnings, const std::string& file) {
    for (const std::string& warning : warnings) add(findingOf(warning, file));
  }
  const std::vector<Finding>& list() const { return list_; }

 private:
  /// Whether two paths, however spelled, are those of one file.
  static bool isSameFile(const std::string& a, const std::string& b) {
    std::error_code error;
    return a == b || std::filesystem::equivalent(a, b, error);
  }

  std::vector<Finding> list_;
};

/// Reports limits of joints that turn by so much that they may be degrees.
void lintLimits(const robots::Model& model, const std::string& file, Findings& findings) {
  constexpr double kMost = 4 * std::numbers::pi;  // two turns either way [rad]
  for (const robots::Variable& v : model.variables) {
    const double far = std::max(std::abs(v.lower), std::abs(v.upper));
    if (model.joints[static_cast<std::size_t>(v.joint)].type != robots::JointType::kRevolute ||
        !(far > kMost + 1e-9 && std::isfinite(far)))
      continue;
    findings.add({file, 0, false,
                  fmt::format("joint '{}' has limits of {} to {} rad, more than two turns: they "
                              "look like degrees; radians are expected",
                              v.name, v.lower, v.upper)});
  }
}

/// Reports wishes for pairs that may touch, because these cost nothing.
void lintWishes(const planner::Problem& problem, const planner::CompiledScene& scene,
                const std::string& file, Findings& findings) {
  std::set<std::pair<std::string, std::string>> checked;
  const collision::ScenePairs& pairs = scene.scene().pairs();
  for (auto pair = pairs.begin(); pair != pairs.end(); ++pair) {
    const PairNames names = pairNames(scene, static_cast<int>(pair.number()));
    checked.emplace(names.a, names.b);
    checked.emplace(names.b, names.a);
  }
  for (const planner::Wish& wish : problem.margins.wishes)
    if (std::none_of(wish.pairs.begin(), wish.pairs.end(),
                     [&](const auto& pair) { return checked.count(pair) != 0; }))
      findings.add({file, 0, false,
                    fmt::format("wish of {} m between {}: none of its pairs is checked",
                                wish.clearance, wish.name)});
}

/// Reports goals of ranges or poses in which no point keeps the constraints.
void lintConstrainedGoals(planner::EdgeCertifier& certifier, planner::Problem problem,
                          const std::string& file, Findings& findings) {
  const auto isPoint = [](const planner::Goal& goal) {
    return goal.poses.empty() && std::all_of(goal.ranges.begin(), goal.ranges.end(),
                                             [](const auto& r) { return r.first == r.second; });
  };
  std::erase_if(problem.goals, isPoint);
  planner::GoalSampler sampler(certifier, problem, problem.seed);
  for (const std::string& warning : sampler.first(interrupted).warnings)
    findings.add({file, 0, false, warning});
}

/// Reports faults that only the compiled scene shows: a start or goal that breaks margins or
/// constraints, wishes without effect.
void lintScene(const planner::Problem& given, const std::string& file, Findings& findings) {
  const planner::Problem problem = planner::placeStart(given, interrupted);
  planner::EdgeCertifier certifier(std::make_shared<const planner::CompiledScene>(problem));
  lintWishes(problem, certifier.scene(), file, findings);
  if (const std::string nothing = certifier.scene().nothingChecked(); !nothing.empty())
    findings.add({file, 0, false, "nothing is checked: " + nothing});
  for (const std::string& warning : certifier.scene().warnings())
    findings.add({file, 0, false, warning});
  planner::ConstraintProof constraints(certifier.scene(), problem);
  const auto look = [&](const std::string& name, const std::vector<double>& point) {
    constexpr double kTolerance = 1e-6;
    if (const std::string fault = constraints.fault(point); !fault.empty())
      findings.add({file, 0, false, name + ": " + fault});
    const planner::StateCheck check = certifier.tooNear(point, kTolerance);
    if (check.verdict == planner::Verdict::kFree) return;
    const PairNames pair = pairNames(certifier.scene(), check.pair);
    findings.add({file, 0, false,
                  check.pair < 0
                      ? fmt::format("{}: its clearance cannot be decided", name)
                      : fmt::format("{}: {} and {} {}", name, pair.a, pair.b,
                                    check.clearance.upper <= 0 ? "collide" : "are too near")});
  };
  std::vector<double> start;
  for (const int v : problem.robot.variables)
    start.push_back(problem.start.at(static_cast<std::size_t>(v)));
  look("start", start);
  for (const planner::Goal& goal : problem.goals) {
    std::vector<double> point;
    for (const auto& [low, high] : goal.ranges)
      if (low == high) point.push_back(low);
    // A single point does not represent a range.
    if (point.size() == start.size()) look(goal.name, point);
  }
  if (!problem.constraints.empty()) lintConstrainedGoals(certifier, problem, file, findings);
}

/// The name requestNNNN.yaml for sceneNNNN.yaml.
std::string requestOf(const std::string& scene) {
  const std::filesystem::path path(scene);
  std::string name = path.filename().string();
  const std::size_t at = name.find("scene");
  if (at == std::string::npos)
    throw robots::InputError(scene, 0,
                             "with --robot, MoveIt scenes named sceneNNNN.yaml are expected, with "
                             "requestNNNN.yaml beside them");
  return (path.parent_path() / name.replace(at, 5, "request")).string();
}

void read(const std::string& file, const ProblemSource& source, Findings& findings) {
  if (robots::endingOf(file) == ".scene") {
    std::vector<std::string> warnings;
    planner::loadMoveitWorld(file, {.load = loadOptions(source)}, warnings);
    findings.addWarnings(warnings, file);
    return;
  }
  const info::FileKind kind = info::kindOf(file);
  planner::Problem problem;
  if (kind == info::FileKind::kProblem && !source.robot.empty()) {
    const auto model = loadRobotModel(source.robot, source.srdf, source);
    findings.addWarnings(model->warnings, source.robot);
    problem = planner::loadMoveit(model, file, requestOf(file), {.load = loadOptions(source)});
  } else {
    problem = info::loadFile(file, kind, source);
    findings.addWarnings(problem.robot.model->warnings, file);
  }
  findings.addWarnings(problem.warnings, file);
  if (problem.goals.empty() && problem.steps.empty())
    findings.add({file, 0, false,
                  "the file has no goal: `leeway plan` refuses it; goal, goals, steps or waypoints "
                  "would be one"});
  lintLimits(*problem.robot.model, file, findings);
  if (kind == info::FileKind::kProblem) lintScene(problem, file, findings);
}

void lint(const std::string& file, ProblemSource source, Findings& findings) {
  robots::InputErrors errors;
  source.errors = &errors;
  source.needs_goal = false;
  bool has_more = false;
  try {
    read(file, source, findings);
  } catch (const robots::InputError& error) {
    has_more = !errors.keep(error);  // usually the first of them
  }
  for (const robots::InputError& error : errors.list()) findings.add(findingOf(error, file));
  if (has_more) findings.add({file, 0, true, "has more errors than are told"});
}

/// RFC 3986: escapes the bytes of all characters except letters, digits and "-._~/".
std::string uriOf(const std::string& file) {
  std::string uri;
  for (const char c : file) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || std::string_view("-._~/").find(c) != std::string_view::npos)
      uri += c;
    else
      uri += fmt::format("%{:02X}", byte);
  }
  return uri;
}

Json documentOf(const std::vector<Finding>& findings) {
  Json list = Json::array();
  for (const Finding& finding : findings)
    list.push_back({{"file", finding.file},
                    {"line", finding.line > 0 ? Json(finding.line) : Json()},
                    {"level", finding.error ? "error" : "warning"},
                    {"message", finding.message}});
  return {{"status", findings.empty() ? "clean" : "findings"}, {"findings", list}};
}

/// Static Analysis Results Interchange Format 2.1.0, which editors and code hosts read.
Json sarifOf(const std::vector<Finding>& findings) {
  Json results = Json::array();
  for (const Finding& finding : findings) {
    Json place = {{"artifactLocation", {{"uri", uriOf(finding.file)}}}};
    if (finding.line > 0) place["region"] = {{"startLine", finding.line}};
    Json location = {{"physicalLocation", place}};
    results.push_back({{"ruleId", finding.error ? "wrong" : "odd"},
                       {"level", finding.error ? "error" : "warning"},
                       {"message", {{"text", finding.message}}},
                       {"locations", Json::array({location})}});
  }
  Json rules = Json::array();
  rules.push_back({{"id", "wrong"},
                   {"shortDescription", {{"text", "the file is refused, or a part is left out"}}}});
  rules.push_back({{"id", "odd"}, {"shortDescription", {{"text", "read, with a warning"}}}});
  Json run = {{"tool", {{"driver", {{"name", "leeway lint"}, {"rules", rules}}}}},
              {"results", results}};
  return {{"$schema", "https://json.schemastore.org/sarif-2.1.0.json"},
          {"version", "2.1.0"},
          {"runs", Json::array({run})}};
}

int runLint(const LintArguments& arguments) {
  setQuiet();  // the warnings are the answer
  Findings findings;
  for (const std::string& file : arguments.files) lint(file, arguments.source, findings);
  const std::vector<Finding>& list = findings.list();
  if (arguments.format == "sarif") {
    fmt::print("{}\n", jsonText(sarifOf(list), 2));
  } else if (arguments.json || arguments.format == "json") {
    printJson(documentOf(list));
  } else {
    const bool is_terminal = isatty(STDOUT_FILENO) == 1;
    fmt::print("{}, {}\n", counted(arguments.files.size(), "file"),
               verdictText(counted(list.size(), "finding"), list.empty()));
    for (const Finding& finding : list) {
      const std::string text = fmt::format("{}{}: {}: {}\n", finding.file,
                                           finding.line > 0 ? fmt::format(":{}", finding.line) : "",
                                           finding.error ? "error" : "warning", finding.message);
      fmt::print("{}",
                 is_terminal ? wrapped(text) : printable(text));  // editors read one line each
    }
  }
  return list.empty() ? kYes : kNo;
}

}  // namespace

Verb addLint(CLI::App& command) {
  auto arguments = std::make_shared<LintArguments>();
  CLI::App* app =
      command.add_subcommand("lint", "list errors and warnings of files, by file and line");
  app->add_option(
         "files", arguments->files,
         "URDF (or MJCF, SDF), SRDF and problem files, MoveIt's .scene; with --robot MoveIt scenes "
         "sceneNNNN.yaml, with requestNNNN.yaml beside them")
      ->type_name("FILE")
      ->required();
  addRobotArguments(*app, arguments->source);
  auto* format = app->add_option("--format", arguments->format, "format of the answer")
                     ->check(CLI::IsMember({"text", "json", "sarif"}))
                     ->capture_default_str();
  app->add_flag("--json", arguments->json, "as --format json")->excludes(format);
  app->footer(
      "Up to a hundred errors of each file are listed. Some errors hide others: broken syntax ends "
      "reading; an SRDF is read only if its URDF has no errors; names are checked only if the "
      "elements that have them are right. Exit status 0: nothing found, 1: "
      "something.\n\nExample:\n  leeway lint robots/arm7/arm7.urdf problems/shelf/reach.yaml");
  return {app, [arguments] { return runLint(*arguments); }};
}

}  // namespace leeway::tools
