#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/placed_at.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/named_states.h"
#include "planner/constraint/constraint_proof.h"
#include "planner/edge/why_undecided.h"
#include "planner/execute/unchecked_json.h"
#include "planner/problem/read_states.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/pair_samples.h"
#include "tools/leeway/support/plan_overrides.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/robot_state.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"
#include "tools/view/base/figures.h"
#include "tools/view/base/scene_names.h"

namespace leeway::tools {
namespace {

struct CheckArguments {
  ProblemSource source;
  PlanOverrides limits;
  std::vector<std::string> states;
  double tolerance = 1e-6;
  bool depth = false;
  bool json = false;
};

struct NamedState {
  std::string name;
  std::vector<double> point;
  std::string fault = {};  ///< why there is none, in words
};

struct CheckedState {
  NamedState state;
  std::string limit;  ///< the first limit that it breaks, in words; else empty
  planner::StateCheck check;
  PairNames names;
  planner::EdgeClearance world, self;
  PairNames world_names, self_names;
  double margin = 0;
  PairNames too_near;  ///< if not free: a pair that breaks its margin; the closest pair may not
  std::vector<PairNames> all_too_near = {};  ///< if not free: all such pairs
  std::string nothing_checked = {};          ///< why; else empty
  PairNames overlapping = {};                ///< without clearances: a pair in collision

  bool valid() const {
    return limit.empty() && nothing_checked.empty() && check.verdict == planner::Verdict::kFree;
  }
};

/// The configuration that planning would try first for a goal of poses.
NamedState solvedGoal(const planner::Problem& problem, const planner::Goal& goal) {
  try {
    const planner::Problem at_goal =
        planner::placedAt(problem, goal.poses, "goal '" + goal.name + "'");
    return {goal.name, startPoint(at_goal)};
  } catch (const robots::InputError& error) {
    return {goal.name, startPoint(problem), error.what()};
  }
}

/// The planned values of `--state TEXT`.
std::vector<double> parsePoint(const planner::Problem& problem, const std::string& text) {
  const std::vector<int>& planned = problem.robot.variables;
  const std::vector<double> q = parseConfiguration(problem, text, {"start", "goal"});
  if (const std::string others =
          robots::otherValues(*problem.robot.model, text, planned, problem.start);
      !others.empty())
    badState(text, others + ", where it would be checked");
  for (std::size_t v = 0; v < q.size() && !planner::namesState(text); ++v)
    if (q[v] != problem.start[v] &&
        std::find(planned.begin(), planned.end(), static_cast<int>(v)) == planned.end())
      badState(text, fmt::format("'{}' is not planned; values of planned joints are expected",
                                 problem.robot.model->variables[v].name));
  std::vector<double> point;
  for (const int v : planned) point.push_back(q[static_cast<std::size_t>(v)]);
  return point;
}

void appendGoals(const planner::Problem& problem, std::vector<NamedState>& states) {
  for (const auto& goal : problem.goals) {
    states.push_back(goal.poses.empty() ? NamedState{goal.name, goalPoint(problem, goal)}
                                        : solvedGoal(problem, goal));
  }
}

/// `has_start`: the source gives one.
std::vector<NamedState> collectStates(const planner::Problem& problem, bool has_start,
                                      const std::vector<std::string>& wanted) {
  std::vector<NamedState> states;
  for (const std::string& text : wanted) {
    if (text == "goal" && !problem.steps.empty())
      badState(text, "a task has a goal for each of its moves; start or a named state is expected");
    if ((text == "goal" && problem.goals.empty()) || (text == "start" && !has_start))
      badState(text,
               fmt::format("is given by --{0} or a problem file with one; or name a state", text));
    if (text == "start") {
      states.push_back({"start", startPoint(problem)});
    } else if (text == "goal") {
      appendGoals(problem, states);
    } else {
      states.push_back({text, parsePoint(problem, text)});
    }
  }
  if (wanted.empty()) {
    states.push_back({"start", startPoint(problem)});
    appendGoals(problem, states);
  }
  return states;
}

/// Returns whether bodies overlap, and names the pairs if they do. Does not measure clearances and
/// depths, because that takes ten times as long.
bool isInCollision(planner::EdgeCertifier& certifier, CheckedState& checked) {
  const std::vector<double>& point = checked.state.point;
  if (certifier.decide(point) != planner::Verdict::kNotFree) return false;
  checked.overlapping = overlappingPair(certifier.scene(), point);
  if (checked.overlapping.a.empty()) return false;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  checked.check.verdict = planner::Verdict::kNotFree;
  checked.check.clearance = {-kInfinity, kInfinity};  // not measured
  checked.world.clearance = checked.self.clearance = checked.check.clearance;
  checked.too_near = checked.overlapping;
  checked.all_too_near = pairsTooNear(certifier.scene(), point, checked.too_near);
  return true;
}

CheckedState checkState(planner::EdgeCertifier& certifier, const planner::Problem& problem,
                        const NamedState& state, const CheckArguments& arguments) {
  const double tolerance = arguments.tolerance;
  CheckedState checked;
  checked.state = state;
  if (!state.fault.empty()) {
    checked.limit = state.fault;
    return checked;
  }
  checked.limit = certifier.scene().space().brokenLimit(state.point);
  if (checked.limit.empty())
    checked.limit = planner::ConstraintProof(certifier.scene(), problem).fault(state.point);
  if (checked.limit.empty()) checked.limit = planner::whyUndecided(certifier.scene(), state.point);
  checked.nothing_checked = certifier.scene().nothingChecked();
  if (!arguments.depth && isInCollision(certifier, checked)) return checked;
  checked.check = certifier.clearance(state.point, tolerance);
  checked.names = pairNames(certifier.scene(), checked.check.pair);
  const auto partOf = [&](planner::Pairs pairs) {  // a state is an edge without length
    return certifier.edgeClearance(state.point, state.point,
                                   {.tolerance = tolerance, .pairs = pairs});
  };
  checked.world = partOf(planner::Pairs::kWorld);
  checked.self = partOf(planner::Pairs::kSelf);
  checked.world_names = pairNames(certifier.scene(), checked.world.pair);
  checked.self_names = pairNames(certifier.scene(), checked.self.pair);
  if (checked.check.pair >= 0) {
    checked.margin =
        certifier.scene().scene().pairs()[static_cast<std::size_t>(checked.check.pair)].margin;
  }
  if (checked.check.verdict == planner::Verdict::kNotFree) {
    checked.too_near = pairNames(certifier.scene(), certifier.tooNear(state.point, tolerance).pair);
    checked.all_too_near = pairsTooNear(certifier.scene(), state.point, checked.too_near);
  }
  return checked;
}

const char* verdictName(planner::Verdict verdict) {
  switch (verdict) {
    case planner::Verdict::kFree:
      return "free";
    case planner::Verdict::kNotFree:
      return "not_free";
    case planner::Verdict::kUndecided:
      break;
  }
  return "undecided";
}

Json partJson(const planner::EdgeClearance& part, const PairNames& names) {
  return {{"clearance_lower", jsonNumber(part.clearance.lower)},
          {"clearance_upper", jsonNumber(part.clearance.upper)},
          {"closest", part.pair < 0 ? Json() : Json({{"a", names.a}, {"b", names.b}})}};
}

/// Whether bodies overlap; null if this is undecided or not checked.
Json inCollision(const CheckedState& checked) {
  if (!checked.state.fault.empty() || !checked.nothing_checked.empty()) return {};
  if (!checked.overlapping.a.empty() || checked.check.clearance.upper <= 0) return true;
  return checked.check.clearance.lower > 0 ? Json(false) : Json();
}

Json stateJson(const CheckedState& checked) {
  const auto& check = checked.check;
  Json all_too_near = Json::array();
  for (const PairNames& pair : checked.all_too_near)
    all_too_near.push_back(Json::array({pair.a, pair.b}));
  Json closest;
  if (check.pair >= 0) {
    closest = {{"a", checked.names.a},
               {"b", checked.names.b},
               {"margin", checked.margin},
               {"point_a", jsonVector(check.closest.point_a)},
               {"point_b", jsonVector(check.closest.point_b)},
               {"normal", jsonVector(check.closest.normal)}};
  }
  Json penetration;
  if (check.pair >= 0 && check.clearance.upper <= 0) {
    penetration = {{"depth_lower", jsonNumber(-check.clearance.upper)},
                   {"depth_upper", jsonNumber(-check.clearance.lower)}};
  }
  return {
      {"name", checked.state.name},
      {"positions", checked.state.fault.empty() ? Json(checked.state.point) : Json()},
      {"valid", checked.valid()},
      {"verdict", checked.nothing_checked.empty() ? verdictName(check.verdict) : "nothing_checked"},
      {"limit", checked.limit.empty() ? Json() : Json(checked.limit)},
      {"clearance_lower", jsonNumber(check.clearance.lower)},
      {"clearance_upper", jsonNumber(check.clearance.upper)},
      {"closest", closest},
      {"world", partJson(checked.world, checked.world_names)},
      {"self", partJson(checked.self, checked.self_names)},
      {"penetration", penetration},
      {"in_collision", inCollision(checked)},
      {"too_near",
       checked.too_near.a.empty() ? Json() : Json({checked.too_near.a, checked.too_near.b})},
      {"all_too_near", all_too_near}};
}

std::string pointText(const Eigen::Vector3d& p) {
  return fmt::format("({}, {}, {})", formatNear(p.x(), 4), formatNear(p.y(), 4),
                     formatNear(p.z(), 4));
}

/// Lists all pairs that are too near, if there are several.
std::string allPairsText(const CheckedState& checked) {
  const std::vector<PairNames>& pairs = checked.all_too_near;
  return pairs.size() < 2 ? std::string()
                          : fmt::format("  all {} pairs that are too near: {}\n", pairs.size(),
                                        pairsText(pairs));
}

std::string stateText(const CheckedState& checked) {
  const auto& check = checked.check;
  std::string text =
      fmt::format("{}: {}", checked.state.name,
                  verdictText(checked.valid() ? "valid" : "not valid", checked.valid()));
  if (!checked.limit.empty()) {
    text += fmt::format(" ({})", checked.limit);
  }
  if (!checked.state.fault.empty()) {
    return text + "\n";
  }
  if (!checked.nothing_checked.empty()) return text + ", nothing was checked\n";
  if (!checked.overlapping.a.empty())
    return text + fmt::format(", {} and {} in collision (--depth measures how deep)\n{}",
                              checked.overlapping.a, checked.overlapping.b, allPairsText(checked));
  if (check.pair < 0) {
    return text + (check.verdict != planner::Verdict::kFree
                       ? ", its clearance could not be decided\n"
                   : std::isfinite(check.clearance.lower)
                       ? fmt::format(", nothing is nearer than {} mm\n",
                                     formatLower(check.clearance.lower * 1e3, 2))
                       : ", there is nothing else that it could touch\n");
  }
  const planner::Interval& clearance = check.clearance;
  if (clearance.upper <= 0) {
    text += fmt::format(", {} and {} in collision, {} deep\n", checked.names.a, checked.names.b,
                        clearanceText({-clearance.upper, -clearance.lower}));
    text +=
        fmt::format("  deepest points {} on {},\n    {} on {}\n", pointText(check.closest.point_a),
                    checked.names.a, pointText(check.closest.point_b), checked.names.b);
    text += fmt::format("  {} is clear once moved {} mm along {}\n", checked.names.b,
                        formatUpper(-clearance.lower * 1e3, 2), pointText(check.closest.normal));
    return text + allPairsText(checked);
  }
  text += fmt::format(", clearance {} between {} and {}", clearanceText(clearance), checked.names.a,
                      checked.names.b);
  if (checked.margin != 0) {
    text += fmt::format(" (margin {} mm)", checked.margin * 1e3);
  }
  text +=
      fmt::format("\n  closest points {} on {},\n    {} on {}\n", pointText(check.closest.point_a),
                  checked.names.a, pointText(check.closest.point_b), checked.names.b);
  if (check.verdict == planner::Verdict::kUndecided) {
    text += "  undecided: counts as not valid\n";
  } else if (check.verdict == planner::Verdict::kNotFree) {
    text += fmt::format("  {} and {} do not keep their margin\n", checked.too_near.a,
                        checked.too_near.b);
  }
  return text + allPairsText(checked);
}

int runCheck(const CheckArguments& arguments) {
  planner::Problem problem = arguments.states.empty()
                                 ? loadProblem(arguments.source, arguments.limits)
                                 : loadProblemOrRobot(arguments.source, [&](planner::Problem& p) {
                                     apply(arguments.limits, p);
                                   });
  const ProblemSource& source = arguments.source;
  const bool has_start = !(source.problem + source.start + source.request).empty();
  const std::vector<NamedState> states = collectStates(problem, has_start, arguments.states);
  planner::EdgeCertifier certifier(std::make_shared<const planner::CompiledScene>(problem));
  printWarnings(certifier.scene().warnings());
  const std::string nothing_checked = certifier.scene().nothingChecked();
  const std::vector<planner::UncheckedPairs> unchecked =
      planner::countUnchecked(certifier.scene().dropped());
  bool all_valid = true;
  Json list = Json::array();
  for (const NamedState& state : states) {
    const CheckedState checked = checkState(certifier, problem, state, arguments);
    all_valid = all_valid && checked.valid();
    if (arguments.json) {
      list.push_back(stateJson(checked));
    } else {
      fmt::print("{}", wrapped(stateText(checked), 4));
    }
  }
  if (arguments.json) {
    printJson({{"status", !nothing_checked.empty() ? "nothing_checked"
                          : all_valid              ? "valid"
                                                   : "invalid"},
               {"seed", problem.seed},
               {"reason", nothing_checked.empty() ? Json() : Json(nothing_checked)},
               {"states", list},
               {"not_checked", planner::uncheckedJson(unchecked)},
               {"clouds", planner::cloudsJson(problem)},
               {"warnings", planner::problemWarnings(problem)}});
  } else {
    fmt::print("{}", wrapped((nothing_checked.empty()
                                  ? planner::toString(unchecked) + obstaclesText(problem)
                                  : "Nothing was checked: " + nothing_checked) +
                             ".\n"));
  }
  return all_valid ? kYes : kNo;
}

}  // namespace

Verb addCheck(CLI::App& command) {
  auto arguments = std::make_shared<CheckArguments>();
  CLI::App* app =
      command.add_subcommand("check", "validity and clearance of start, goal or a given state");
  addProblemArguments(*app, arguments->source);
  arguments->source.needs_goal = false;
  addRunLimits(*app, arguments->limits);
  addUpright(*app, arguments->limits);
  app->add_option("--state", arguments->states,
                  "start, goal, a group state, all planned values (1,0,2) or some "
                  "(elbow=1,wrist=2); may be repeated; "
                  "default: start and goals, a goal's range by its middle, poses by their valid "
                  "solution nearest to the start")
      ->type_name("STATE")
      ->delimiter('\n');
  app->add_option("--tolerance", arguments->tolerance, "width of the clearance's interval [m]")
      ->type_name("METRES")
      ->check(numberFrom(1e-12, 1e9))
      ->capture_default_str();
  app->add_flag("--depth", arguments->depth,
                "measure how deep bodies in collision are, which takes longer");
  app->add_flag("--json", arguments->json, "print one JSON document");
  app->footer(
      "Examples:\n"
      "  leeway check problems/shelf/reach.yaml\n"
      "  leeway check problems/shelf/reach.yaml --state start --json\n"
      "  leeway check --robot robots/arm7/arm7.urdf --srdf robots/arm7/arm7.srdf --state ready");
  return {app, [arguments] { return runCheck(*arguments); }};
}

}  // namespace leeway::tools
