#include "tools/leeway/support/json_result.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "leeway/robots/input_error.h"
#include "planner/execute/unchecked_json.h"
#include "planner/validate/checks.h"
#include "tools/leeway/support/pair_samples.h"
#include "tools/leeway/support/terminal.h"
#include "tools/view/base/scene_names.h"

namespace leeway::tools {
namespace {

Json closestJson(const planner::PathClearance& clearance,
                 const std::optional<planner::Trajectory>& trajectory) {
  if (clearance.closest_segment < 0) return {};  // nothing is near
  Json closest = {{"a", clearance.closest_a},
                  {"b", clearance.closest_b},
                  {"segment", clearance.closest_segment},
                  {"t", jsonNumber(clearance.closest_t)},
                  {"point_a", jsonVector(clearance.closest_point_a)},
                  {"point_b", jsonVector(clearance.closest_point_b)}};
  if (trajectory) {
    const auto time = trajectory->passes(clearance.closest_segment, clearance.closest_t);
    closest["time"] = time ? jsonNumber(*time) : Json();  // null: cut off by a blend
  }
  return closest;
}

Json clearanceJson(const planner::PathClearance& clearance,
                   const std::optional<planner::Trajectory>& trajectory) {
  return {{"clearance_lower", jsonNumber(clearance.clearance.lower)},
          {"clearance_upper", jsonNumber(clearance.clearance.upper)},
          {"closest", closestJson(clearance, trajectory)}};
}

Json certificateJson(const planner::Problem& problem, const planner::Certificate& certificate,
                     const std::optional<planner::Trajectory>& trajectory) {
  Json segments = Json::array();
  for (const auto& segment : certificate.segments) {
    segments.push_back({{"clearance_lower", jsonNumber(segment.lower)},
                        {"clearance_upper", jsonNumber(segment.upper)}});
  }
  Json document = clearanceJson(certificate, trajectory);
  document["certified"] = certificate.certified;
  document["world"] = clearanceJson(certificate.world, trajectory);
  document["self"] = clearanceJson(certificate.self, trajectory);
  document["segments"] = segments;
  document["interpolation"] =
      planner::ConfigurationSpace(problem.robot.model, problem.robot.variables).interpolation();
  document["not_checked"] = planner::uncheckedJson(certificate.unchecked);
  document["clouds"] = planner::cloudsJson(problem);
  document["constraints"] = constraintsJson(certificate.constraints);
  return document;
}

Json offendingJson(const planner::Problem& problem, const planner::PlanResult& result) {
  const auto& check = result.offending;
  Json pairs = Json::array();
  for (const PairNames& pair : pairsTooNear(problem, result))
    pairs.push_back(Json::array({pair.a, pair.b}));
  const bool overlapping = check.clearance.upper <= 0;
  return {{"a", result.offending_a},
          {"b", result.offending_b},
          {"clearance_lower", jsonNumber(check.clearance.lower)},
          {"clearance_upper", jsonNumber(check.clearance.upper)},
          {"margin", result.offending_a.empty() ? Json() : Json(offendingMargin(problem, result))},
          {"depth", overlapping ? jsonNumber(-check.clearance.upper) : Json()},
          {"point_a", jsonVector(check.closest.point_a)},
          {"point_b", jsonVector(check.closest.point_b)},
          {"normal", jsonVector(check.closest.normal)},
          {"pairs", pairs}};
}

Json trajectoryJson(const planner::Trajectory& trajectory) {
  Json corners = Json::array();
  for (const int corner : trajectory.cutCorners()) corners.push_back(corner);
  return {{"duration", trajectory.duration()}, {"blended_corners", corners}};
}

Json costJson(const planner::Interval& cost) {
  return std::isfinite(cost.upper) ? Json({{"lower", cost.lower}, {"upper", cost.upper}}) : Json();
}

Json wishesJson(const planner::Problem& problem, const planner::PlanResult& result) {
  Json wishes = Json::array();
  for (std::size_t i = 0; i < result.wishes.size(); ++i) {
    const planner::WishResult& of = result.wishes[i];
    const planner::Wish& wish = problem.margins.wishes[i];
    wishes.push_back({{"between", wish.name},
                      {"wish", wish.clearance},
                      {"weight", wish.weight},
                      {"kept", of.kept ? Json(*of.kept) : Json()},
                      {"clearance_lower", jsonNumber(of.clearance.lower)},
                      {"clearance_upper", jsonNumber(of.clearance.upper)},
                      {"cost", costJson(of.cost)}});
  }
  return wishes;
}

}  // namespace

Json constraintsJson(const std::vector<planner::ConstraintResult>& results) {
  Json constraints = Json::array();
  for (const planner::ConstraintResult& result : results)
    constraints.push_back(
        {{"name", result.name}, {"deviation", result.deviation}, {"angle", result.angle}});
  return constraints;
}

Json toJson(const planner::Problem& problem, const planner::PlanResult& result,
            const std::optional<planner::Trajectory>& trajectory, double load_s) {
  const bool solved = result.status == planner::PlanStatus::kSolved;
  const bool has_path = solved || result.status == planner::PlanStatus::kPartial;
  const bool invalid = result.status == planner::PlanStatus::kInvalidStart ||
                       result.status == planner::PlanStatus::kInvalidGoal;
  Json document = {{"status", planner::toString(result.status)},
                   {"seed", result.seed},
                   {"planner", result.planner},
                   {"objective", planner::toString(problem.objective)},
                   {"deterministic", result.deterministic},
                   {"time_s",
                    {{"load", load_s},
                     {"compile", result.compile_s},
                     {"plan", result.plan_s},
                     {"simplify", result.simplify_s},
                     {"improve", result.improve_s},
                     {"push", result.push_s},
                     {"certify", result.certify_s}}},
                   {"counts",
                    {{"iterations", result.iterations},
                     {"states", result.states},
                     {"edges", result.edges},
                     {"distance_queries", result.distance_queries},
                     {"undecided_edges", result.undecided_edges}}}};
  document["interrupted"] = interrupted();
  document["warnings"] = result.warnings;
  document["goal"] =
      result.goal >= 0 ? Json(problem.goals[static_cast<std::size_t>(result.goal)].name) : Json();
  document["path"] = Json();
  document["length"] = Json();
  document["shortest_length"] = jsonNumber(result.shortest_length);
  const auto obstacles_at = planner::obstaclesAt(problem);
  document["obstacles_at"] = obstacles_at ? Json(*obstacles_at) : Json();
  document["clearance_bound"] = jsonNumber(result.clearance_bound);
  document["cost"] = costJson(result.cost);
  document["wishes"] = wishesJson(problem, result);
  document["certificate"] = Json();
  document["trajectory"] = Json();
  if (has_path) {
    document["path"] = {{"joint_names", result.path.names}, {"positions", result.path.positions}};
    for (const planner::PathStep& step : result.path.steps)
      document["path"]["steps"].push_back({{"name", step.name},
                                           {"first", step.first},
                                           {"last", step.last},
                                           {"deviation", step.deviation},
                                           {"turn", step.turn},
                                           {"places", step.places}});
    document["length"] = jsonNumber(result.length);
    document["certificate"] = certificateJson(problem, result.certificate, trajectory);
    if (trajectory) document["trajectory"] = trajectoryJson(*trajectory);
  } else {
    document["clouds"] = planner::cloudsJson(problem);
  }
  if (invalid) {
    document["offending"] = result.reason.empty() ? offendingJson(problem, result) : Json();
    document["unreachable"] = result.unreachable;
  }
  if (const auto& end = result.line_end)
    document["line_end"] = {{"step", problem.steps[static_cast<std::size_t>(end->step)].name},
                            {"waypoint", end->waypoint},
                            {"share", end->share},
                            {"why", planner::toString(end->why)}};
  if (result.status == planner::PlanStatus::kUnsolved) {
    document["blocked"] = Json::array();
    for (const planner::BlockedPair& pair : result.blocked)
      document["blocked"].push_back({{"a", pair.a}, {"b", pair.b}, {"edges", pair.edges}});
    const planner::SearchGap& gap = result.gap;
    document["gap"] =
        gap.from.empty()
            ? Json()
            : Json({{"distance", jsonNumber(gap.distance)}, {"from", gap.from}, {"to", gap.to}});
    document["long_turns"] = result.long_turns;
  }
  if (!solved) document["reason"] = result.reason.empty() ? Json() : Json(result.reason);
  return document;
}

Json toJson(const planner::VerifyResult& result) {
  const bool certified = result.status == planner::VerifyStatus::kCertified;
  Json document = {{"status", toString(result.status)},
                   {"clearance_lower", certified ? jsonNumber(result.clearance_lower) : Json()}};
  Json where;  // null: certified, or the failure has no place on the path
  if (!certified && result.status != planner::VerifyStatus::kNothingChecked &&
      (result.segment >= 0 || result.line > 0)) {
    where = result.line > 0 ? Json({{"line", result.line}}) : Json({{"segment", result.segment}});
    where["t0"] = result.t0;
    where["t1"] = result.t1;
    where["a"] = result.a.empty() ? Json() : Json(result.a);
    where["b"] = result.b.empty() ? Json() : Json(result.b);
  }
  document["where"] = where;
  document["reason"] = result.reason.empty() ? Json() : Json(result.reason);
  document["not_checked"] = planner::uncheckedJson(result.unchecked);
  return document;
}

const char* toString(planner::VerifyStatus status) {
  switch (status) {
    case planner::VerifyStatus::kCertified:
      return "certified";
    case planner::VerifyStatus::kRefuted:
      return "refuted";
    case planner::VerifyStatus::kNothingChecked:
      return "nothing_checked";
    case planner::VerifyStatus::kExposed:
      return "exposed";
    case planner::VerifyStatus::kUndecided:
      break;
  }
  return "undecided";
}

Json versioned(const Json& document) {
  Json answer = {{"version", kJsonVersion}};
  answer.update(document);
  return answer;
}

void printJson(const Json& document) {
  endProgress();
  const bool terminal = isatty(STDOUT_FILENO) == 1;
  fmt::print("{}\n", jsonText(versioned(document), terminal ? 2 : -1));
}

}  // namespace leeway::tools
