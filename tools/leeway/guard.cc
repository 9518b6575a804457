#include "leeway/planner/guard.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <utility>

#include "leeway/planner/compiled_scene.h"
#include "leeway/robots/input_error.h"
#include "planner/base/did_you_mean.h"
#include "planner/base/tolerances.h"
#include "planner/execute/unchecked_json.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/plan_overrides.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/robot_state.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"
#include "tools/view/base/figures.h"

namespace leeway::tools {
namespace {

constexpr const char* kStandardInput = "standard input";
/// More lists and objects in each other than any line has [count].
constexpr int kDeepest = 16;
/// Longer lines are refused [B].
constexpr std::size_t kLongestLine = std::size_t{1} << 26U;

// Input and output, for --help. A test checks that all keys of the output are here.
constexpr const char* kGuardKeys =
    R"(Each line of standard input is a request, and is answered at once by one JSON document.
  1.0,0.2,...             a setpoint for each planned joint, in the order of the group, or in that
                          of a first line with their names; more numbers: the setpoints after it
  [[...], [...]]          setpoints, one a period
  {...}                   keys: setpoints; position, velocity: of the robot, measured; time;
                          polynomials and duration, in place of setpoints: the coefficients of
                          1, t, t^2, ... for each planned joint, t from 0 to a whole number of periods
  {"observe": {...}}      keys: object, vertices, time, speed_bound: a deforming obstacle was seen;
                          object, position, orientation (x y z w), time, speed_bound, turn_bound:
                          an object with a motion (`moving`) was seen;
                          object, time, speed_bound and points (x y z; null: not measured) with
                          radius, or balls (x y z radius), or cloud (a file) with radius: all of a
                          cloud with a motion was seen; position, orientation: its frame's, else
                          as before; thin, most_balls: as in problem files; carve (names
                          of links, objects at rest, or robot), with position and
                          orientation, state (of the robot then) and carve_margin:
                          points of these are left out
Empty lines, and lines that begin with #, are left out. Without a time, the robot
is assumed to have executed all setpoints that passed of the last request, and at
least one period. Chunks that overlap need a time.
JSON, a document a line (metres, radians, seconds; null: nothing, or nothing known):
  version                 of these documents (docs/json.md)
  line, seed              of the input, from 1; of the problem
  time                    when `motion` begins
  passed, setpoints       how many setpoints passed, of how many; periods of polynomials
  certified               `motion` is proven: what passed, and the stop after it
  not_checked             of the first answer alone: how many pairs no answer covers, with reasons
                          (docs/json.md)
  reason                  passed; or why the next setpoint did not: limit, not_free, not_certified,
                          work, stale, jumped, invalid
  in_stop                 it concerns the stop after that setpoint
  pair.a, pair.b          between these
  joint, limit, value, allowed
                          this limit would be broken: position, velocity, acceleration or jerk
  goes_on                 `motion` is what was left of the one before
  start, motion           where it begins; setpoints, one a period, of what passed and of the stop
  on_polynomials          to so many of these the robot follows polynomials
  counts                  edges, distance_queries and work that the answer took
  observation             the answer to a line that observes: taken, jumped, invalid, late
  cloud                   that it showed (docs/json.md: one of `clouds`)
  message                 what is wrong with the line, after which the robot stops
)";

struct GuardArguments {
  ProblemSource source;
  PlanOverrides limits;
  planner::GuardOptions options;
  std::string joint_errors;
  bool json = true;
};

/// A request as a line has it.
struct Line {
  std::vector<double> setpoints, polynomials, position, velocity;
  double duration = 0;  ///< of the polynomials
  std::optional<double> time;
  bool is_observation = false;
  std::string object;  ///< of an observation
  std::vector<Eigen::Vector3d> vertices;
  std::optional<collision::Pose> X_WO;               ///< in place of vertices
  std::shared_ptr<const planner::PointCloud> cloud;  ///< perhaps with a pose
  double speed_bound = 0, turn_bound = 0;
};

/// A fault of a line, in words.
struct LineFault {
  std::string message;
};

/// Reads lines of setpoints.
class LineReader {
 public:
  explicit LineReader(const planner::Problem& problem) : problem_(problem) {
    for (const int v : problem.robot.variables)
      names_.push_back(problem.robot.model->variables[static_cast<std::size_t>(v)].name);
    for (std::size_t i = 0; i < names_.size(); ++i) order_.push_back(i);
  }

  /// Returns false for an empty line, a comment and the names of columns. Throws LineFault; `line`
  /// has the robot's state then, as far as the line gives one, with NaN for what was not read.
  bool read(const std::string& text, Line& line) {
    const std::size_t first = text.find_first_not_of(" \t\r");
    if (first == std::string::npos || text[first] == '#') return false;
    // A line that is not an observation may have had a position.
    if (text[first] == '{' && text.find("\"observe\"") != text.find('"', first))
      line.position = {std::nan("")};
    if (text.size() > kLongestLine)
      throw LineFault{fmt::format("{} bytes; at most {} are expected", text.size(), kLongestLine)};
    if (text[first] == '{' || text[first] == '[') {
      fromJson(text, line);
      return true;
    }
    const bool is_first = !has_begun_;
    has_begun_ = true;
    std::vector<std::string> fields = splitAt(',', text);
    for (std::string& field : fields) {
      const std::size_t begin = field.find_first_not_of(" \t\r\"");
      const std::size_t end = field.find_last_not_of(" \t\r\"");
      field = begin == std::string::npos ? "" : field.substr(begin, end - begin + 1);
    }
    if (is_first && std::none_of(fields.begin(), fields.end(),
                                 [&](const std::string& field) { return isLikeNumber(field); })) {
      is_header_bad_ = true;
      takeHeader(fields);
      is_header_bad_ = false;
      return false;
    }
    if (is_header_bad_)
      throw LineFault{
          "the first line names no order of the joints that is known; rows of numbers are not read "
          "after it"};
    line.setpoints = fromFields(fields);
    return true;
  }

  const std::vector<std::string>& names() const { return names_; }

 private:
  /// Whether a field of a first line belongs to numbers, right or not, and not to names.
  bool isLikeNumber(const std::string& field) const {
    double value = 0;
    if (std::from_chars(field.data(), field.data() + field.size(), value).ec ==
        std::errc::invalid_argument)
      return !field.empty() && std::string_view("+-.").find(field[0]) != std::string_view::npos;
    return std::find(names_.begin(), names_.end(), field) == names_.end();
  }

  /// Throws LineFault.
  static double numberOf(const std::string& text) {
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, value);
    if (rest != end || error == std::errc::invalid_argument)
      throw LineFault{fmt::format("'{}' is no number; one such as -0.5 or 1e-3 is expected", text)};
    if (error != std::errc())
      throw LineFault{
          fmt::format("'{}' is out of range; 0, or a size from {:.2g} to {:.2g}, is expected", text,
                      std::numeric_limits<double>::min(), std::numeric_limits<double>::max())};
    return value;
  }

  void takeHeader(const std::vector<std::string>& fields) {
    std::vector<std::size_t> order;
    for (const std::string& field : fields) {
      const auto name = std::find(names_.begin(), names_.end(), field);
      if (name == names_.end())
        throw LineFault{fmt::format("the column '{}' is no planned joint{}", field,
                                    planner::didYouMean(field, names_))};
      const auto i = static_cast<std::size_t>(name - names_.begin());
      if (std::find(order.begin(), order.end(), i) != order.end())
        throw LineFault{fmt::format("the column '{}' stands twice", field)};
      order.push_back(i);
    }
    if (order.size() != names_.size())
      throw LineFault{
          fmt::format("the names of {} stand there; {} are expected, one a planned joint",
                      counted(order.size(), "column"), names_.size())};
    order_ = order;
  }

  std::vector<double> fromFields(const std::vector<std::string>& fields) const {
    const std::size_t n = names_.size();
    for (const std::string& field : fields) numberOf(field);
    if (fields.size() % n != 0)
      throw LineFault{fmt::format("{}; {}, or a multiple of that, are expected",
                                  counted(fields.size(), "number"), n)};
    std::vector<double> setpoints(fields.size());
    for (std::size_t i = 0; i < fields.size(); ++i)
      setpoints[i / n * n + order_[i % n]] = numberOf(fields[i]);
    return setpoints;
  }

  static double number(const Json& value, const std::string& where) {
    if (!value.is_number())
      throw LineFault{fmt::format("{} is {}; a number is expected", where, jsonText(value))};
    return value.get<double>();
  }

  static std::vector<double> rowOf(const Json& value, std::size_t columns,
                                   const std::string& where) {
    if (!value.is_array() || value.size() != columns)
      throw LineFault{fmt::format("{} is {}; a list of {} is expected", where,
                                  jsonText(value).substr(0, 60), counted(columns, "number"))};
    std::vector<double> row;
    for (const Json& entry : value) row.push_back(number(entry, where));
    return row;
  }

  /// A list of lists.
  static std::vector<double> rowsOf(const Json& value, std::size_t columns,
                                    const std::string& where) {
    if (!value.is_array())
      throw LineFault{fmt::format("{} is {}; a list of rows of {} is expected", where,
                                  jsonText(value).substr(0, 60), counted(columns, "number"))};
    std::vector<double> rows;
    for (std::size_t i = 0; i < value.size(); ++i) {
      const std::vector<double> row = rowOf(value[i], columns, fmt::format("{}[{}]", where, i));
      rows.insert(rows.end(), row.begin(), row.end());
    }
    return rows;
  }

  static void expectKeys(const Json& value, const std::vector<std::string>& known) {
    for (const auto& [key, entry] : value.items())
      if (std::find(known.begin(), known.end(), key) == known.end())
        throw LineFault{fmt::format("'{}' is no key{}", key, planner::didYouMean(key, known))};
  }

  /// The value of a line. A key that stands twice, of which only the last value would be left, and
  /// lists in lists without end are faults.
  static Json parsed(const std::string& text) {
    std::vector<std::set<std::string>> keys;  // of the objects that are open
    std::string last_key;
    const auto look = [&](int depth, Json::parse_event_t event, Json& value) {
      if (depth > kDeepest)
        throw LineFault{fmt::format("more than {} lists and objects in each other", kDeepest)};
      if (event == Json::parse_event_t::object_start) keys.emplace_back();
      if (event == Json::parse_event_t::object_end) keys.pop_back();
      if (event != Json::parse_event_t::key) return true;
      last_key = value.get<std::string>();
      if (!keys.back().insert(last_key).second)
        throw LineFault{fmt::format("the key '{}' stands twice", last_key)};
      return true;
    };
    try {
      return Json::parse(text, look);
    } catch (const Json::parse_error& error) {
      throw LineFault{notJson(text, error.byte)};
    } catch (const Json::exception& error) {  // a number that is too large for a double
      const std::string what = error.what();
      const std::size_t begin = std::min(what.find('\''), what.size());
      throw LineFault{fmt::format("{}{} is too large; a size of at most {:.2g} is expected",
                                  last_key.empty() ? "" : last_key + ": ", what.substr(begin),
                                  std::numeric_limits<double>::max())};
    }
  }

  /// The message about a line that is not JSON. `byte`: from 1.
  static std::string notJson(const std::string& text, std::size_t byte) {
    constexpr std::string_view kEnds = " \t\r,:[]{}";
    constexpr std::size_t kShown = 20;
    if (byte > text.size()) return "the line ends before its list or object does";
    std::size_t begin = std::max<std::size_t>(byte, 1) - 1, end = begin;
    while (begin > 0 && kEnds.find(text[begin - 1]) == std::string_view::npos) --begin;
    while (end < text.size() && kEnds.find(text[end]) == std::string_view::npos) ++end;
    return fmt::format(
        "byte {}: '{}' is not JSON there; numbers such as -0.5, lists and objects "
        "are expected, and null for points that were not measured",
        byte, text.substr(begin, std::clamp<std::size_t>(end - begin, 1, kShown)));
  }

  void fromJson(const std::string& text, Line& line) const {
    const Json value = parsed(text);
    const std::size_t n = names_.size();
    if (value.is_array()) {
      line.setpoints = rowsOf(value, n, "setpoints");
      return;
    }
    takeState(value, line);
    if (value.contains("observe")) {
      expectKeys(value, {"observe"});
      line = observationOf(value["observe"]);
      return;
    }
    expectKeys(value,
               {"setpoints", "polynomials", "duration", "position", "velocity", "time", "observe"});
    if (value.contains("setpoints")) line.setpoints = rowsOf(value["setpoints"], n, "setpoints");
    if (value.contains("polynomials") || value.contains("duration")) takePolynomials(value, line);
  }

  /// Takes the robot's state, which counts also where the rest of the line is wrong.
  void takeState(const Json& value, Line& line) const {
    const double unread = std::nan("");
    line.position.assign(value.count("position"), unread);
    line.velocity.assign(value.count("velocity"), unread);
    if (value.contains("time")) line.time = unread;
    const std::size_t n = names_.size();
    if (value.contains("position")) line.position = rowOf(value["position"], n, "position");
    if (value.contains("velocity")) line.velocity = rowOf(value["velocity"], n, "velocity");
    if (value.contains("time")) line.time = number(value["time"], "time");
  }

  void takePolynomials(const Json& value, Line& line) const {
    for (const char* const key : {"polynomials", "duration"})
      if (!value.contains(key)) throw LineFault{fmt::format("'{}' is missing", key)};
    if (value.contains("setpoints"))
      throw LineFault{"setpoints and polynomials are given; one of them is expected"};
    const Json& rows = value["polynomials"];
    if (!rows.is_array() || rows.size() != names_.size() || !rows[0].is_array() || rows[0].empty())
      throw LineFault{
          fmt::format("polynomials is {}; a list of {} lists of coefficients is expected",
                      jsonText(rows).substr(0, 60), names_.size())};
    line.polynomials = rowsOf(rows, rows[0].size(), "polynomials");
    line.duration = number(value["duration"], "duration");
  }

  /// The keys that an observation has.
  static std::vector<std::string> keysOf(const Json& value) {
    const bool is_placed = value.contains("position") || value.contains("orientation");
    for (const char* const kind : {"points", "balls", "cloud"}) {
      if (!value.contains(kind)) continue;
      std::vector<std::string> keys = {"object", kind, "time", "speed_bound"};
      if (kind != std::string_view("balls")) keys.emplace_back("radius");
      if (is_placed) keys.insert(keys.end(), {"position", "orientation"});
      return keys;
    }
    if (is_placed)
      return {"object", "position", "orientation", "time", "speed_bound", "turn_bound"};
    return {"object", "vertices", "time", "speed_bound"};
  }

  Line observationOf(const Json& value) const {
    if (!value.is_object()) throw LineFault{"observe is no object with keys"};
    const std::vector<std::string> keys = keysOf(value);
    std::vector<std::string> known = keys;
    if (value.contains("points") || value.contains("balls") || value.contains("cloud")) {
      known.insert(known.end(), {"carve", "carve_margin", "state", "thin", "most_balls"});
      if (value.contains("crop"))
        throw LineFault{
            "observe.crop: what was cropped could come near; a cloud that is not cropped is "
            "expected"};
    }
    expectKeys(value, known);
    for (const std::string& key : keys)
      if (!value.contains(key)) throw LineFault{fmt::format("observe has no '{}'", key)};
    if (!value["object"].is_string()) throw LineFault{"observe.object is no text"};
    Line line;
    line.is_observation = true;
    line.object = value["object"].get<std::string>();
    line.time = number(value["time"], "observe.time");
    line.speed_bound = number(value["speed_bound"], "observe.speed_bound");
    if (value.contains("position")) line.X_WO = poseOf(value);
    if (value.contains("turn_bound")) {
      line.turn_bound = number(value["turn_bound"], "observe.turn_bound");
      return line;
    }
    if (!value.contains("vertices")) {
      try {
        line.cloud = std::make_shared<const planner::PointCloud>(
            planner::filteredScan(problem_, cloudOf(value), line.X_WO, filtersOf(value)));
      } catch (const std::invalid_argument& error) {
        throw LineFault{fmt::format("observe: {}", error.what())};
      }
      return line;
    }
    const std::vector<double> numbers = rowsOf(value["vertices"], 3, "observe.vertices");
    for (std::size_t i = 0; i < numbers.size(); i += 3)
      line.vertices.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
    return line;
  }

  static planner::PointCloud cloudOf(const Json& value) {
    planner::PointCloud cloud;
    if (value.contains("balls")) {
      const std::vector<double> numbers = rowsOf(value["balls"], 4, "observe.balls");
      for (std::size_t i = 0; i < numbers.size(); i += 4)
        cloud.balls.push_back({{numbers[i], numbers[i + 1], numbers[i + 2]}, numbers[i + 3]});
      if (cloud.balls.empty()) return cloud;
      if (const std::string fault = planner::cloudFault(cloud); !fault.empty())
        throw LineFault{"observe.balls: " + fault};
      return cloud;
    }
    const double radius = number(value["radius"], "observe.radius");
    if (value.contains("points")) {
      Json points = value["points"];
      if (points.is_array())
        for (Json& point : points)
          for (Json& coordinate : point)
            if (coordinate.is_null()) coordinate = std::nan("");
      const std::vector<double> numbers = rowsOf(points, 3, "observe.points");
      return planner::makeCloud(
          {numbers.data(), numbers.size() / 3, 0, planner::PointArray::Number::kDouble}, radius);
    }
    if (!value["cloud"].is_string()) throw LineFault{"observe.cloud is no name of a file"};
    std::vector<std::string> warnings;
    try {
      cloud = planner::loadCloud(value["cloud"].get<std::string>(), radius, warnings);
    } catch (const robots::InputError& error) {
      throw LineFault{fmt::format("observe: {}", error.what())};
    }
    printWarnings(warnings);
    return cloud;
  }

  planner::ScanFilters filtersOf(const Json& value) const {
    for (const char* const key : {"carve_margin", "state"})
      if (value.contains(key) && !value.contains("carve"))
        throw LineFault{fmt::format("observe.{} stands without carve; both are expected", key)};
    planner::ScanFilters filters;
    if (value.contains("carve")) {
      filters.carve.emplace();
      for (const Json& name : value["carve"]) {
        if (!value["carve"].is_array() || !name.is_string())
          throw LineFault{"observe.carve is no list of names; [robot], for example, is expected"};
        filters.carve->push_back(name.get<std::string>());
      }
    }
    if (value.contains("state"))
      filters.state = rowOf(value["state"], names_.size(), "observe.state");
    if (value.contains("carve_margin"))
      filters.carve_margin = number(value["carve_margin"], "observe.carve_margin");
    if (value.contains("thin")) filters.thin = number(value["thin"], "observe.thin");
    if (value.contains("most_balls")) {
      const Json& most = value["most_balls"];
      if (!most.is_number_unsigned())
        throw LineFault{fmt::format("observe.most_balls is {}; a whole number from 1 is expected",
                                    jsonText(most))};
      filters.most_balls = most.get<std::size_t>();
    }
    return filters;
  }

  static collision::Pose poseOf(const Json& value) {
    const std::vector<double> p = rowOf(value["position"], 3, "observe.position");
    const std::vector<double> q = rowOf(value["orientation"], 4, "observe.orientation");
    const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
    if (!(std::abs(turn.norm() - 1) <= planner::kMendableQuaternion))
      throw LineFault{
          fmt::format("observe.orientation has length {}; a unit quaternion x y z w is "
                      "expected",
                      turn.norm())};
    return {turn.normalized().toRotationMatrix(), {p[0], p[1], p[2]}};
  }

  const planner::Problem& problem_;
  std::vector<std::string> names_;
  std::vector<std::size_t> order_;  // of the columns: which joint
  bool has_begun_ = false;
  bool is_header_bad_ = false;  // the first line is neither numbers nor the names of columns
};

Json rowJson(std::span<const double> row) {
  return Json(std::vector<double>(row.begin(), row.end()));
}

Json answerJson(const planner::GuardAnswer& answer, const std::vector<std::string>& names) {
  Json motion = Json::array();
  for (std::size_t i = 0; i < answer.motion.size(); i += names.size())
    motion.push_back(rowJson(answer.motion.subspan(i, names.size())));
  const bool is_limit = answer.variable >= 0;
  return {{"time", answer.time},
          {"passed", answer.passed},
          {"certified", answer.certified},
          {"reason", planner::toString(answer.reason)},
          {"in_stop", answer.in_stop},
          {"pair", answer.a.empty() ? Json()
                                    : Json({{"a", answer.a},
                                            {"b", answer.b.empty() ? Json() : Json(answer.b)}})},
          {"joint", is_limit ? Json(names[static_cast<std::size_t>(answer.variable)]) : Json()},
          {"limit", is_limit ? Json(planner::toString(answer.limit)) : Json()},
          {"value", is_limit ? jsonNumber(answer.value) : Json()},
          {"allowed", is_limit ? jsonNumber(answer.allowed) : Json()},
          {"goes_on", answer.goes_on},
          {"start", rowJson(answer.start)},
          {"motion", motion},
          {"on_polynomials", answer.on_polynomials},
          {"counts",
           {{"edges", answer.edges},
            {"distance_queries", answer.distance_queries},
            {"work", answer.work}}}};
}

/// Numbers for all planned joints: one for each, or joint=number, ...
std::vector<double> jointErrors(const std::string& text, const std::vector<std::string>& names) {
  if (text.empty()) return {};
  std::vector<double> errors(names.size(), -1);  // -1: not given
  const std::vector<std::string> parts = splitAt(',', text);
  if (parts.size() == 1 && text.find('=') == std::string::npos) {
    const double error = parseNumber("--joint-error", text);
    if (!(error >= 0)) badUsage(fmt::format("--joint-error is {}; 0 or more is expected", text));
    return std::vector<double>(names.size(), error);
  }
  for (const std::string& part : parts) {
    const std::size_t equals = part.find('=');
    const std::string name = part.substr(0, equals);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end() && equals == std::string::npos)
      badUsage(
          fmt::format("--joint-error {}: '{}' names no joint; a number for all, or "
                      "JOINT=NUMBER,... is expected",
                      text, name));
    if (found == names.end())
      badUsage(fmt::format("--joint-error {}: no planned joint '{}'{}", text, name,
                           planner::didYouMean(name, names)));
    if (equals == std::string::npos)
      badUsage(fmt::format("--joint-error {}: '{}' has no number; {}=NUMBER is expected", text,
                           name, name));
    double& error = errors[static_cast<std::size_t>(found - names.begin())];
    if (error != -1)
      badUsage(fmt::format("--joint-error {}: names '{}' twice; once is expected", text, name));
    error = parseNumber("--joint-error", part.substr(equals + 1));
    if (error < 0)
      badUsage(
          fmt::format("--joint-error {}: '{}' is {}; 0 or more is expected", text, name, error));
  }
  std::string exact;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (errors[i] >= 0) continue;
    errors[i] = 0;
    exact += (exact.empty() ? "'" : ", '") + names[i] + "'";
  }
  if (!exact.empty() && !isQuiet())
    printMessage("note: --joint-error says nothing of " + exact + ", which counts as exact");
  return errors;
}

/// Answers each line; a wrong one stops the robot, and the next ones are read.
class Session {
 public:
  Session(const planner::Problem& problem, const planner::GuardOptions& options, Json not_checked)
      : guard_(problem, options),
        reader_(problem),
        not_checked_(std::move(not_checked)),
        seed_(problem.seed),
        most_setpoints_(options.most_setpoints) {
    for (const planner::DeformingObstacle& o : problem.world.deforming) {
      objects_.push_back(o.object.name);
      vertices_[o.object.name] = static_cast<std::size_t>(o.mesh->vertexCount());
    }
    for (const planner::Object& o : problem.world.objects)
      (!o.motion ? still_ : o.cloud ? clouds_ : rigid_).push_back(o.name);
    rigid_.insert(rigid_.end(), clouds_.begin(), clouds_.end());  // a cloud has a pose, too
  }

  void answer(const std::string& text) {
    ++number_;
    Json document = {{"line", number_}, {"seed", seed_}};
    const auto tell = [&](const std::string& message) {
      document["message"] = message.empty() ? Json() : Json(message);
      fmt::print("{}\n", jsonText(versioned(document)));
      std::fflush(stdout);
    };
    std::string message;
    std::size_t setpoints = 0;
    Line line;
    try {
      if (!reader_.read(text, line)) return;
      if (line.is_observation) {
        const planner::Observation result = observe(line);
        document["observation"] = planner::toString(result);
        document["cloud"] =
            line.cloud ? planner::cloudJson({line.object, {}, {}, line.cloud}) : Json();
        if (result == planner::Observation::kInvalid) tellFault(message = refusalOfSight(line));
        return tell(message);
      }
      setpoints = setpointsOf(line);
      check(line);
      message = refusalOf(line);
    } catch (const LineFault& fault) {
      message = fault.message;
      tellFault(message);
      if (line.is_observation) line = {};
      look(line.time);
      const double nothing[] = {std::nan("")};  // the robot stops
      guard_.check({.setpoints = nothing,
                    .position = line.position,
                    .velocity = line.velocity,
                    .time = line.time});
    }
    document.update(answerJson(guard_.answer(), reader_.names()));
    document["setpoints"] = setpoints;
    if (!not_checked_.is_null()) document["not_checked"] = std::exchange(not_checked_, nullptr);
    is_certified_ = is_certified_ && guard_.answer().certified;
    tell(message);
  }

  int status() const { return is_bad_ ? kBadInput : is_certified_ ? kYes : kNo; }

 private:
  void tellFault(const std::string& message) {
    is_bad_ = true;
    printMessage(fmt::format("{}:{}: {}", kStandardInput, number_, message));
  }

  /// How many setpoints a line has, or periods of polynomials.
  std::size_t setpointsOf(const Line& line) const {
    if (line.polynomials.empty()) return line.setpoints.size() / reader_.names().size();
    const double periods = line.duration / guard_.options().period;
    return periods >= 0 && periods <= 1e9 ? static_cast<std::size_t>(std::round(periods)) : 0;
  }

  /// Returns the fault of polynomials that the guard refused; empty: none.
  std::string faultOfPolynomials(const Line& line) const {
    const std::size_t n = reader_.names().size(), terms = line.polynomials.size() / n;
    if (terms > static_cast<std::size_t>(planner::GuardRequest::kMostTerms))
      return fmt::format("polynomials have {} coefficients; at most {} are expected", terms,
                         planner::GuardRequest::kMostTerms);
    for (std::size_t i = 0; i < n * terms; ++i)
      if (!std::isfinite(line.polynomials[i]))
        return fmt::format("polynomials have {} for '{}'; a finite number is expected",
                           line.polynomials[i], reader_.names()[i / terms]);
    const double period = guard_.options().period, periods = line.duration / period;
    if (periods > most_setpoints_ + 0.5)
      return fmt::format(
          "duration is {} s; at most {} periods (--most-setpoints) of {} s are expected",
          line.duration, most_setpoints_, period);
    if (!(periods >= 0.5) || !(std::abs(periods - std::round(periods)) <= planner::kGuardSameTime))
      return fmt::format("duration is {} s; a whole number of periods of {} s is expected",
                         line.duration, period);
    const std::span<const double> start = guard_.answer().start;
    for (std::size_t i = 0; i < n; ++i)
      if (!(std::abs(line.polynomials[i * terms] - start[i]) <= planner::kVerifyWaypoint))
        return fmt::format(
            "the polynomial of '{}' begins at {}; {}, where the motion does, is "
            "expected",
            reader_.names()[i], line.polynomials[i * terms], start[i]);
    return {};
  }

  /// Why the guard refused a line whose sizes are right; empty if it did not.
  std::string refusalOf(const Line& line) {
    if (guard_.answer().reason != planner::GuardReason::kInvalid) return {};
    const std::size_t n = reader_.names().size(), setpoints = setpointsOf(line);
    std::string message = fmt::format(
        "time is {} s; seconds that do not go back, and near which numbers are at most 0.001 "
        "periods apart, are expected",
        line.time.value_or(guard_.nextTime()));
    if (!line.polynomials.empty())
      if (const std::string fault = faultOfPolynomials(line); !fault.empty()) message = fault;
    if (line.polynomials.empty() && setpoints > static_cast<std::size_t>(most_setpoints_))
      message = fmt::format("{}; at most {} (--most-setpoints) are expected",
                            counted(setpoints, "setpoint"), most_setpoints_);
    const auto wrong = std::find_if(line.setpoints.begin(), line.setpoints.end(),
                                    [](double x) { return !std::isfinite(x); });
    if (wrong != line.setpoints.end()) {
      const auto i = static_cast<std::size_t>(wrong - line.setpoints.begin());
      message = fmt::format("setpoints[{}] has {} for '{}'; a finite number is expected", i / n,
                            *wrong, reader_.names()[i % n]);
    }
    tellFault(message);
    return message;
  }

  /// Looks at the world at the time of the answer; returns what is wrong, after which nothing is
  /// proven. A stop that follows a wrong line is proven against what is seen now, too.
  std::string look(const std::optional<double>& asked) {
    const double time = asked && guard_.takesTime(*asked) ? *asked : guard_.nextTime();
    try {
      guard_.look(time);
    } catch (const robots::InputError& error) {
      return error.what();
    }
    return {};
  }

  void check(const Line& line) {
    if (const std::string fault = look(line.time); !fault.empty()) throw LineFault{fault};
    guard_.check({.setpoints = line.setpoints,
                  .polynomials = line.polynomials,
                  .duration = line.duration,
                  .position = line.position,
                  .velocity = line.velocity,
                  .time = line.time});
  }

  /// The message about an observation with an unknown object, or with keys of another kind of
  /// object.
  std::string strangeObject(const Line& line, const std::vector<std::string>& known) const {
    const std::string& name = line.object;
    const auto isIn = [&](const std::vector<std::string>& list) {
      return std::find(list.begin(), list.end(), name) != list.end();
    };
    if (isIn(objects_)) return fmt::format("'{}' deforms; its vertices are expected", name);
    if (isIn(rigid_))
      return fmt::format("'{}' is {}", name,
                         isIn(clouds_) ? "a cloud; its points, its balls or its pose are expected"
                                       : "rigid; its position and orientation are expected");
    if (isIn(still_))
      return fmt::format("'{}' has no motion (`moving`) in the problem, and counts as at rest",
                         name);
    const std::string kind = line.cloud  ? "cloud with a motion"
                             : line.X_WO ? "object with a motion"
                                         : "deforming obstacle";
    return known.empty()
               ? fmt::format("the problem has no {}; one named '{}' was seen", kind, name)
               : fmt::format("there is no {} '{}'{}", kind, name, planner::didYouMean(name, known));
  }

  /// Why the guard refused an observation.
  std::string refusalOfSight(const Line& line) const {
    if (line.cloud)
      return fmt::format(
          "observe: the cloud of '{}' has {}, and is refused: it is empty, its "
          "numbers are too large, or it was carved at another pose",
          line.object, counted(line.cloud->balls.size(), "ball"));
    if (line.X_WO) {
      const bool has_cloud =
          std::find(clouds_.begin(), clouds_.end(), line.object) != clouds_.end();
      return fmt::format("observe: the pose of '{}' is refused: its numbers are too large{}",
                         line.object, has_cloud ? ", or its cloud was carved at another one" : "");
    }
    const std::size_t vertices = vertices_.at(line.object);
    return line.vertices.size() == vertices
               ? std::string("observe.vertices: their numbers are too large")
               : fmt::format("observe.vertices has {}; {} are expected, as '{}' has",
                             counted(line.vertices.size(), "row"), vertices, line.object);
  }

  planner::Observation observe(const Line& line) {
    const std::vector<std::string>& known = line.cloud ? clouds_ : line.X_WO ? rigid_ : objects_;
    if (std::find(known.begin(), known.end(), line.object) == known.end())
      throw LineFault{"observe.object: " + strangeObject(line, known)};
    if (!(line.speed_bound >= 0))
      throw LineFault{
          fmt::format("observe.speed_bound is {}; at least 0 m/s is expected", line.speed_bound)};
    if (!(line.turn_bound >= 0))
      throw LineFault{
          fmt::format("observe.turn_bound is {}; at least 0 rad/s is expected", line.turn_bound)};
    if (line.cloud)
      return guard_.setCloud(line.object, line.cloud, *line.time, line.speed_bound, line.X_WO);
    return line.X_WO ? guard_.setPose(line.object, *line.X_WO, *line.time, line.speed_bound,
                                      line.turn_bound)
                     : guard_.setVertices(line.object, line.vertices, *line.time, line.speed_bound);
  }

  planner::Guard guard_;
  LineReader reader_;
  Json not_checked_;  // until the first answer
  std::uint64_t seed_;
  int most_setpoints_;
  // That deform; with a motion; clouds of it; at rest.
  std::vector<std::string> objects_, rigid_, clouds_, still_;
  std::map<std::string, std::size_t> vertices_;  // of objects_
  std::size_t number_ = 0;
  bool is_bad_ = false, is_certified_ = true;
};

int runGuard(const GuardArguments& arguments) {
  const planner::Problem problem = [&] {
    ProblemSource source = arguments.source;
    source.needs_goal = false;
    planner::Problem loaded = loadProblem(source, arguments.limits);
    refuseSteps(loaded, "guard");
    return loaded;
  }();
  std::vector<std::string> names;
  for (const int v : problem.robot.variables)
    names.push_back(problem.robot.model->variables[static_cast<std::size_t>(v)].name);
  planner::GuardOptions options = arguments.options;
  options.joint_errors = jointErrors(arguments.joint_errors, names);
  const planner::CompiledScene scene(problem);
  printWarnings(scene.warnings());
  Session session(problem, options,
                  planner::uncheckedJson(planner::countUnchecked(scene.dropped())));
  bool is_first = true;
  for (std::string line; std::getline(std::cin, line); is_first = false) {
    if (is_first && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
    session.answer(line);
  }
  if (std::cin.bad()) throw robots::InputError(kStandardInput, 0, "cannot be read");
  return session.status();
}

}  // namespace

Verb addGuard(CLI::App& command) {
  auto arguments = std::make_shared<GuardArguments>();
  CLI::App* app = command.add_subcommand(
      "guard",
      "pass on the setpoints of a policy that are proven free, with a proven stop after them");
  addProblemArguments(*app, arguments->source);
  for (const char* const unused : {"--frame", "--waypoints", "--goal-pose"})
    app->remove_option(app->get_option(unused));
  addRunLimits(*app, arguments->limits);
  planner::GuardOptions& options = arguments->options;
  app->add_option("--period", options.period, "from one setpoint to the next [s]")
      ->type_name("S")
      ->check(numberFrom(planner::GuardOptions::kLeastPeriod, 10))
      ->capture_default_str();
  app->add_option("--joint-error", arguments->joint_errors,
                  "how far joints are from their motion at most [rad or m]: a number for all, or "
                  "JOINT=NUMBER,...")
      ->type_name("E");
  app->add_option("--point-error", options.point_error,
                  "how far any point of the robot may be off, besides [m]")
      ->type_name("M")
      ->check(numberFrom(0, 1e3))
      ->capture_default_str();
  app->add_option("--most-setpoints", options.most_setpoints, "most setpoints of one line")
      ->type_name("N")
      ->check(countFrom(1, planner::GuardOptions::kMostSetpoints))
      ->capture_default_str();
  app->add_option("--work", options.work,
                  "work limit of one answer, about 1,000 per microsecond; setpoints that are not "
                  "proven within it do not pass")
      ->type_name("N")
      ->check(countFrom(1))
      ->capture_default_str();
  app->add_option("--horizon", options.horizon,
                  "for how long after a line obstacles that move are bounded [s]")
      ->type_name("S")
      ->check(numberFrom(1e-3, 1e6))
      ->capture_default_str();
  app->add_flag("--json", arguments->json, "no effect: answers are always JSON");
  app->footer(std::string(kGuardKeys) +
              "\nA line that is wrong stops the robot, and the next ones are read. An observation "
              "that is invalid counts as wrong, but only ages the last one. Exit status 0: "
              "every answer was certified; 1: one was not; 2: a line was wrong.\n"
              "Example:\n  leeway guard problems/moving/wall.yaml <problems/moving/wall.jsonl");
  return {app, [arguments] { return runGuard(*arguments); }};
}

}  // namespace leeway::tools
