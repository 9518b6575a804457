// The log of an execution: JSON documents, one a line. planner/verify/log_read.cc reads them.

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "collision/base/numbers.h"
#include "leeway/planner/replanner.h"
#include "planner/execute/log_line.h"
#include "planner/execute/unchecked_json.h"

namespace leeway::planner {
namespace {

using Json = nlohmann::ordered_json;

/// The document in one line, with its sum as the last key. Numbers have as many digits as they
/// need to read back to the bit; those that are not finite become null.
std::string summedLine(const Json& document) {
  std::string text = document.dump(-1, ' ', false, Json::error_handler_t::replace);
  text.pop_back();  // the brace
  const std::uint64_t sum = lineSum(text);
  return fmt::format("{}{}{:016x}{}", text, kBeforeSum, sum, kAfterSum);
}

Json namesJson(const std::string& a, const std::string& b) {
  return a.empty() ? Json() : Json({{"a", a}, {"b", b}});
}

Json vectorJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json sightJson(const ObstacleSight& sight) {
  Json document = {{"object", sight.object}, {"time", sight.time}};
  const auto place = [&](const robots::Pose& X_WO) {
    document["position"] = vectorJson(X_WO.translation);
    Json rows = Json::array();
    for (Eigen::Index i = 0; i < 3; ++i) rows.push_back(vectorJson(X_WO.rotation.row(i)));
    document["rotation"] = std::move(rows);
  };
  if (const auto* seen = std::get_if<SeenCloud>(&sight.seen)) {
    place(seen->X_WO);
    Json balls = Json::array();
    for (const PointCloud::Ball& ball : seen->cloud->balls) {
      const Eigen::Vector3d& p = ball.center;
      balls.push_back({p.x(), p.y(), p.z(), ball.radius});
    }
    document["balls"] = std::move(balls);
    document["speed_bound"] = sight.speed_bound;
    return document;
  }
  if (const auto* X_WO = std::get_if<robots::Pose>(&sight.seen)) {
    place(*X_WO);
    document["speed_bound"] = sight.speed_bound;
    document["turn_bound"] = sight.turn_bound;
    return document;
  }
  Json vertices = Json::array();
  for (const Eigen::Vector3d& v : std::get<0>(sight.seen)) vertices.push_back(vectorJson(v));
  document["vertices"] = std::move(vertices);
  document["speed_bound"] = sight.speed_bound;
  return document;
}

Json rowsJson(std::span<const TimedPoint> rows) {
  Json list = Json::array();
  for (const TimedPoint& row : rows)
    list.push_back({{"time", row.time}, {"position", row.position}});
  return list;
}

Json jointNames(const Problem& problem) {
  Json names = Json::array();
  for (const int v : problem.robot.variables)
    names.push_back(problem.robot.model->variables[at(v)].name);
  return names;
}

}  // namespace

std::string logLine(const Problem& problem, const ReplanStep& step) {
  Json obstacles = Json::array(), observed = Json::array();
  for (const ObstacleUpdate& o : step.obstacles)
    obstacles.push_back({{"name", o.object},
                         {"seen", o.seen},
                         {"predicted", o.predicted},
                         {"strategy", o.strategy},
                         {"reason", o.reason},
                         {"update_s", o.update_s}});
  for (const ObstacleSight& sight : step.observed) observed.push_back(sightJson(sight));
  return summedLine({{"version", kLogVersion},
                     {"step", step.index},
                     {"time", step.time},
                     {"decision", toString(step.decision)},
                     {"why", step.why},
                     {"certified", step.certified},
                     {"exposed", step.exposed},
                     {"clearance_lower", step.clearance.lower},
                     {"clearance_upper", step.clearance.upper},
                     {"closest", namesJson(step.closest_a, step.closest_b)},
                     {"look_ahead", step.look_ahead},
                     {"path_held", step.path_held},
                     {"broken", namesJson(step.broken_a, step.broken_b)},
                     {"remaining_s", step.remaining_s},
                     {"reached", step.reached},
                     {"joint_names", jointNames(problem)},
                     {"position", step.motion.back().position},
                     {"motion", rowsJson(step.motion)},
                     {"stop", step.keeps_stop ? Json() : rowsJson(step.stop)},
                     {"measured", step.measured ? Json(*step.measured) : Json()},
                     {"observed", std::move(observed)},
                     {"obstacles", std::move(obstacles)},
                     {"time_s",
                      {{"update", step.update_s},
                       {"certify", step.certify_s},
                       {"plan", step.plan_s},
                       {"clearance", step.clearance_s}}},
                     {"counts",
                      {{"looks", step.looks},
                       {"edges", step.edges},
                       {"distance_queries", step.distance_queries},
                       {"iterations", step.iterations}}}});
}

std::string logLine(const Problem& problem, const ReplanResult& result, double load_s) {
  return summedLine({{"version", kLogVersion},
                     {"status", toString(result.status)},
                     {"problem", problem.name},
                     {"seed", result.seed},
                     {"certified", result.certified},
                     {"not_checked", uncheckedJson(result.unchecked)},
                     {"clearance_lower", result.clearance.lower},
                     {"clearance_upper", result.clearance.upper},
                     {"duration", result.duration},
                     {"steps", result.steps},
                     {"plans", result.plans},
                     {"replans", result.replans},
                     {"follows", result.follows},
                     {"waits", result.waits},
                     {"evasions", result.evasions},
                     {"clouds", cloudsJson(problem)},
                     {"warnings", problemWarnings(problem)},
                     {"time_s",
                      {{"load", load_s},
                       {"compute", result.compute_s},
                       {"longest_step", result.longest_step_s}}}});
}

}  // namespace leeway::planner
