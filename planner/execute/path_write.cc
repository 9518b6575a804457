#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/planner/path_io.h"
#include "leeway/planner/trajectory.h"
#include "leeway/robots/input_error.h"
#include "planner/base/tolerances.h"
#include "planner/execute/unchecked_json.h"
#include "planner/timing/trajectory_samples.h"
#include "planner/validate/checks.h"
#include "robots/base/read_file.h"

namespace leeway::planner {
namespace {

using robots::InputError;

/// 17 digits, so that every double is read back exactly. JSON has only finite numbers.
std::string numberText(double x) { return std::isfinite(x) ? fmt::format("{:.17g}", x) : "null"; }

/// The text of a JSON value, which is also YAML.
std::string dumped(const nlohmann::ordered_json& value) {
  return value.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}
std::string quotedText(const std::string& text) { return dumped(text); }

std::string rowText(const std::vector<double>& row) {
  std::string text = "[";
  for (std::size_t i = 0; i < row.size(); ++i) text += (i > 0 ? ", " : "") + numberText(row[i]);
  return text + "]";
}

std::string namesText(const std::vector<std::string>& names) {
  std::string text = "[";
  for (std::size_t i = 0; i < names.size(); ++i) text += (i > 0 ? ", " : "") + quotedText(names[i]);
  return text + "]";
}

/// Refuses durations beyond the range of time stamps, and periods that give too many rows.
void checkTimes(const std::string& file, double duration, double period) {
  if (!(duration <= kLatestStamp))
    throw InputError(file, 0,
                     fmt::format("cannot be written: the motion takes {} s; no more than {} s, by "
                                 "faster limits, are expected",
                                 duration, kLatestStamp));
  if (period > 0 && period < kLeastRow)
    throw InputError(file, 0,
                     fmt::format("cannot be written: the period is {} s; at least {} s is expected",
                                 period, kLeastRow));
  if (period > 0 && !(duration / period <= kMostRows))
    throw InputError(file, 0,
                     fmt::format("cannot be written: {} s have more than {} rows {} s apart; a "
                                 "longer period is expected",
                                 duration, kMostRows, period));
}

/// The time at which a trajectory that stops at the corners passes each row [s].
std::vector<double> rowTimes(const std::string& file, const Problem& problem,
                             const ConfigurationSpace& space, const Path& path) {
  if (path.positions.empty()) return {};
  const PathEdges edges = edgesOf(space, path);
  Problem stopping = problem;
  stopping.execution.corners = Corners::kStop;
  const Trajectory trajectory = trajectoryOf(stopping, path);
  checkTimes(file, trajectory.duration(), 0);
  std::vector<double> times = {0};
  for (std::size_t e = 0; e < edges.places.size(); ++e)
    if (edges.places[e].t1 == 1) times.push_back(trajectory.times()[e + 1]);
  return times;
}

std::string timeText(double seconds) {
  const std::int64_t whole = nanoseconds(seconds);
  return fmt::format("{{\"sec\": {}, \"nanosec\": {}}}", whole / 1'000'000'000,
                     whole % 1'000'000'000);
}

/// How far every point of the robot may depart from the path while margins hold [m]. It is half of
/// the clearance above the largest margin, because two links may depart towards each other.
double trackingTolerance(const Problem& problem, const Certificate& certificate) {
  double margin = std::max(problem.margins.common, keptClearance(problem));
  for (const PairMargin& pair : problem.margins.pairs) margin = std::max(margin, pair.margin);
  return certificate.certified ? std::max(0.0, (certificate.clearance.lower - margin) / 2) : 0;
}

/// The steps of a task's path, as JSON.
std::string stepsText(const std::vector<PathStep>& steps) {
  std::string text = "[";
  for (const PathStep& step : steps)
    text += fmt::format(
        "{}{{\"name\": {}, \"first\": {}, \"last\": {}, \"deviation\": {}, \"turn\": {}, "
        "\"places\": {}}}",
        text.size() > 1 ? ", " : "", quotedText(step.name), step.first, step.last,
        numberText(step.deviation), numberText(step.turn), rowText(step.places));
  return text + "]";
}

/// Keys and values of a certificate in their order in files. The values are JSON.
std::vector<std::pair<std::string, std::string>> certificateEntries(
    const Problem& problem, std::string_view interpolation, const Certificate& certificate) {
  std::string closest = "null", segments = "[";
  if (certificate.closest_segment >= 0)
    closest = fmt::format("{{\"a\": {}, \"b\": {}, \"segment\": {}, \"t\": {}}}",
                          quotedText(certificate.closest_a), quotedText(certificate.closest_b),
                          certificate.closest_segment, numberText(certificate.closest_t));
  for (std::size_t i = 0; i < certificate.segments.size(); ++i)
    segments += fmt::format("{}{{\"clearance_lower\": {}}}", i > 0 ? ", " : "",
                            numberText(certificate.segments[i].lower));
  std::vector<std::pair<std::string, std::string>> entries = {
      {"certified", certificate.certified ? "true" : "false"},
      {"interpolation", quotedText(std::string(interpolation))},
      {"margin", numberText(problem.margins.common)},
      {"tracking_tolerance", numberText(trackingTolerance(problem, certificate))},
      {"clearance_lower", numberText(certificate.clearance.lower)},
      {"clearance_upper", numberText(certificate.clearance.upper)},
      {"closest", closest},
      {"segments", segments + "]"},
      {"not_checked", dumped(uncheckedJson(certificate.unchecked))}};
  if (const auto time = obstaclesAt(problem))
    entries.emplace_back("obstacles_at", numberText(*time));
  if (!certificate.conditions.empty())
    entries.emplace_back("conditions", quotedText(certificate.conditions));
  return entries;
}

std::string jsonHead(const Problem& problem, const std::vector<std::string>& names) {
  return fmt::format(
      "{{\n  \"header\": {{\"frame_id\": {}}},\n  \"joint_names\": {},\n  \"points\": [\n",
      quotedText(problem.robot.model->links[0].name), namesText(names));
}

std::string yamlHead(const Problem& problem, const std::vector<std::string>& names) {
  return fmt::format("header: {{frame_id: {}}}\njoint_names: {}\npoints:\n",
                     quotedText(problem.robot.model->links[0].name), namesText(names));
}

using Entries = std::vector<std::pair<std::string, std::string>>;

std::string jsonTail(const Entries& certificate, const std::vector<PathStep>& steps = {}) {
  std::string text = "  ],\n";
  if (!steps.empty()) text += fmt::format("  \"steps\": {},\n", stepsText(steps));
  text += "  \"certificate\": {\n";
  for (std::size_t i = 0; i < certificate.size(); ++i)
    text += fmt::format("    \"{}\": {}{}\n", certificate[i].first, certificate[i].second,
                        i + 1 < certificate.size() ? "," : "");
  return text + "  }\n}\n";
}

std::string yamlTail(const Entries& certificate, const std::vector<PathStep>& steps = {}) {
  std::string text = steps.empty() ? "" : fmt::format("steps: {}\n", stepsText(steps));
  text += "certificate:\n";
  for (const auto& [key, value] : certificate) text += fmt::format("  {}: {}\n", key, value);
  return text;
}

std::string jsonText(const std::string& file, const Problem& problem,
                     const ConfigurationSpace& space, const PlanResult& result) {
  const auto& rows = result.path.positions;
  const std::vector<double> times = rowTimes(file, problem, space, result.path);
  std::string text = jsonHead(problem, result.path.names);
  for (std::size_t i = 0; i < rows.size(); ++i)
    text += fmt::format("    {{\"positions\": {}, \"time_from_start\": {}}}{}\n", rowText(rows[i]),
                        timeText(times[i]), i + 1 < rows.size() ? "," : "");
  return text + jsonTail(certificateEntries(problem, space.interpolation(), result.certificate),
                         result.path.steps);
}

std::string yamlText(const std::string& file, const Problem& problem,
                     const ConfigurationSpace& space, const PlanResult& result) {
  const auto& rows = result.path.positions;
  const std::vector<double> times = rowTimes(file, problem, space, result.path);
  std::string text = yamlHead(problem, result.path.names);
  for (std::size_t i = 0; i < rows.size(); ++i)
    text += fmt::format("  - positions: {}\n    time_from_start: {}\n", rowText(rows[i]),
                        timeText(times[i]));
  return text + yamlTail(certificateEntries(problem, space.interpolation(), result.certificate),
                         result.path.steps);
}

/// The certificate of the timed motion. Cuts are proven to keep their clearance and the margins,
/// which bound it from below. A cut may leave out the closest place of the path, and then nothing
/// bounds it from above.
Entries trajectoryEntries(const Problem& problem, const Trajectory& trajectory,
                          Certificate certificate) {
  const std::vector<int> cut = trajectory.cutCorners();
  std::string corners = "[";
  for (const int corner : cut)
    corners += fmt::format("{}{}", corners.size() > 1 ? ", " : "", corner);
  if (!cut.empty()) {
    double least = problem.margins.common;
    for (const PairMargin& pair : problem.margins.pairs) least = std::min(least, pair.margin);
    certificate.clearance.lower =
        std::min(certificate.clearance.lower, std::max(least, trajectory.cuts().clearance));
  }
  if (certificate.closest_segment >= 0 &&
      !trajectory.passes(certificate.closest_segment, certificate.closest_t))
    certificate.clearance.upper = std::numeric_limits<double>::infinity();
  Entries entries;
  const std::string_view interpolation =
      trajectory.cuts().blends.empty() ? trajectory.space().interpolation() : kCubic;
  for (auto& entry : certificateEntries(problem, interpolation, certificate))
    if (entry.first != "closest" && entry.first != "segments") entries.push_back(std::move(entry));
  entries.emplace_back("blended_corners", corners + "]");
  return entries;
}

/// RFC 4180: a field with a comma, a quote or a line end is quoted, and its quotes are doubled.
std::string csvField(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + "\"";
}

std::string csvText(const std::vector<std::string>& names, const std::vector<double>& times,
                    const std::vector<std::vector<double>>& rows) {
  std::string text = "time";
  for (const std::string& name : names) text += "," + csvField(name);
  text += "\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    text += numberText(times[i]);
    for (const double x : rows[i]) text += "," + numberText(x);
    text += "\n";
  }
  return text;
}

/// Columns: time, positions, velocities, accelerations.
std::string trajectoryCsv(const std::vector<std::string>& names, const Samples& samples) {
  std::vector<std::string> columns = names;
  for (const std::string_view ending : {kVelocityEnding, kAccelerationEnding})
    for (const std::string& name : names) columns.push_back(name + std::string(ending));
  std::vector<std::vector<double>> rows = samples.positions;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].insert(rows[i].end(), samples.velocities[i].begin(), samples.velocities[i].end());
    rows[i].insert(rows[i].end(), samples.accelerations[i].begin(), samples.accelerations[i].end());
  }
  return csvText(columns, samples.times, rows);
}

std::string matrixText(const PlanResult& result) {
  std::string text;
  for (const std::vector<double>& row : result.path.positions) {
    for (std::size_t i = 0; i < row.size(); ++i) text += (i > 0 ? " " : "") + numberText(row[i]);
    text += "\n";
  }
  return text;
}

/// Refuses a result whose variables are not the planned variables of the problem.
void requireResultOf(const Problem& problem, const PlanResult& result) {
  validate(problem);
  const std::vector<int>& variables = problem.robot.variables;
  bool is_same = result.path.names.size() == variables.size();
  for (std::size_t i = 0; is_same && i < variables.size(); ++i)
    is_same = result.path.names[i] ==
              problem.robot.model->variables[static_cast<std::size_t>(variables[i])].name;
  for (const std::vector<double>& row : result.path.positions)
    is_same = is_same && row.size() == variables.size() &&
              std::all_of(row.begin(), row.end(), [](double x) { return std::isfinite(x); });
  if (!is_same)
    throw std::invalid_argument(
        "the path's columns are not the problem's planned variables, or a number is not finite; a "
        "result of this problem is expected");
  if (result.certificate.certified && !areSameMargins(result.certificate.margins, problem.margins))
    throw std::invalid_argument(fmt::format(
        "the result is certified for other margins (Certificate::margins, {} m) than the problem's "
        "({} m); a result of this problem is expected",
        result.certificate.margins.common, problem.margins.common));
}

}  // namespace

void writePath(const std::string& file, const Problem& problem, const PlanResult& result) {
  requireResultOf(problem, result);
  const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  const std::string ending = robots::endingOf(file);
  if (ending == ".json") return writeFileWhole(file, jsonText(file, problem, space, result));
  if (ending == ".yaml" || ending == ".yml")
    return writeFileWhole(file, yamlText(file, problem, space, result));
  if (ending == ".csv") {
    return writeFileWhole(file,
                          csvText(result.path.names, rowTimes(file, problem, space, result.path),
                                  result.path.positions));
  }
  if (ending == ".path") return writeFileWhole(file, matrixText(result));
  throw InputError(
      file, 0,
      fmt::format("the ending '{}' names no format; .json, .yaml, .csv or .path is expected",
                  ending));
}

void writeTrajectory(const std::string& file, const Problem& problem, const PlanResult& result,
                     const Trajectory& trajectory, double period) {
  requireResultOf(problem, result);
  const std::string ending = robots::endingOf(file);
  const bool json = ending == ".json", yaml = ending == ".yaml" || ending == ".yml";
  if (!json && !yaml && ending != ".csv")
    throw InputError(
        file, 0,
        fmt::format("the ending '{}' names no format of trajectories; .json, .yaml or .csv is "
                    "expected",
                    ending));
  const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  const Waypoints along = unwrapped(space, edgesOf(space, result.path).path.positions);
  if (!std::equal(along.begin(), along.end(), trajectory.waypoints().begin(),
                  trajectory.waypoints().end()))
    throw std::invalid_argument(
        "the trajectory passes other waypoints than the result's path; trajectoryOf() that path is "
        "expected");
  checkTimes(file, trajectory.duration(), period);
  const Samples samples = sample(trajectory, period);
  const std::vector<std::string>& names = result.path.names;
  if (ending == ".csv") return writeFileWhole(file, trajectoryCsv(names, samples));
  std::string text = json ? jsonHead(problem, names) : yamlHead(problem, names);
  // A controller that gets accelerations follows quintics, and cubics alone are certified.
  const bool accelerates = areQuinticsCubic(samples);
  for (std::size_t i = 0; i < samples.times.size(); ++i) {
    Entries point = {{"positions", rowText(samples.positions[i])},
                     {"velocities", rowText(samples.velocities[i])}};
    if (accelerates) point.emplace_back("accelerations", rowText(samples.accelerations[i]));
    point.emplace_back("time_from_start", timeText(samples.times[i]));
    const std::string_view first = json ? "    {" : "  - ", between = json ? ", " : "\n    ";
    for (const auto& [key, value] : point)
      text += fmt::format("{}{}: {}", &key == &point[0].first ? first : between,
                          json ? quotedText(key) : key, value);
    text += !json ? "\n" : i + 1 < samples.times.size() ? "},\n" : "}\n";
  }
  const Entries entries = trajectoryEntries(problem, trajectory, result.certificate);
  writeFileWhole(
      file, text + (json ? jsonTail(entries, samples.steps) : yamlTail(entries, samples.steps)));
}

}  // namespace leeway::planner
