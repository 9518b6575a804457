#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/planner/path_io.h"
#include "leeway/robots/text.h"
#include "planner/base/cells.h"
#include "planner/base/did_you_mean.h"
#include "planner/base/tolerances.h"
#include "planner/timing/leg.h"
#include "planner/timing/trajectory_samples.h"
#include "planner/yaml/yaml_reader.h"
#include "robots/base/read_file.h"

namespace leeway::planner {
namespace {

using robots::InputError;

constexpr std::string_view kTimeColumn = "time";

/// The contents of a file: columns by name, or by order without names, and rows with their lines.
struct Table {
  std::vector<std::string> names;
  int names_line = 0;
  struct Row {
    std::vector<double> values;
    int line;
    std::optional<double> time = {};         ///< [s]
    std::vector<double> velocities = {};     ///< of the columns in `values`
    std::vector<double> accelerations = {};  ///< as velocities; empty: not given
  };
  std::vector<Row> rows;
  bool cubic = false;  ///< rows have times and velocities, with cubics between them
  std::optional<std::size_t> time_column;
  std::string interpolation;  ///< as the certificate names it; may be empty
  int interpolation_line = 0;
  int accelerations_line = 0;  ///< of the first accelerations without velocities; 0: none
  int conditions_line = 0;     ///< of a condition that the path was planned with; 0: none
  std::vector<PathStep> steps;
};

std::vector<std::string> plannedNames(const Problem& problem) {
  std::vector<std::string> names;
  for (const int v : problem.robot.variables)
    names.push_back(problem.robot.model->variables[at(v)].name);
  return names;
}

// ---- JSON and YAML ----

int readWaypoint(const YamlReader& reader, std::size_t count) {
  const std::int64_t number = reader.integer(0);
  if (number >= static_cast<std::int64_t>(count))
    reader.fail(fmt::format("{} is {}; a waypoint, 0 to {}, is expected", reader.where(), number,
                            static_cast<std::int64_t>(count) - 1));
  return static_cast<int>(number);
}

/// Fails if a file gives its path in two of these forms, since only one would be read.
void expectOneForm(const YamlReader& file, std::initializer_list<std::string_view> forms) {
  std::optional<std::string_view> first;
  for (const std::string_view form : forms) {
    const auto found = file.find(form);
    if (!found || found->isNull()) continue;
    if (first)
      found->fail(
          fmt::format("'{}' and '{}' each give a path; one of them is expected", *first, form));
    first = form;
  }
}

/// A duration: a number, or seconds and nanoseconds as ROS 1 and ROS 2 name them.
double readTime(const YamlReader& time) {
  if (!time.isMap()) return time.number();
  time.expectKeys(std::array<std::string_view, 4>{"sec", "nanosec", "secs", "nsecs"});
  double seconds = 0;
  for (const auto& [key, value] : time.entries())
    seconds += value.number() * (key.starts_with("n") ? 1e-9 : 1);
  return seconds;
}

// The keys that files of paths may have: the fields of ROS messages, and those that path_write.cc
// writes.
constexpr std::array<std::string_view, 3> kOuterKeys = {
    "joint_trajectory", "multi_dof_joint_trajectory", "certificate"};
constexpr std::array<std::string_view, 7> kPathKeys = {"header",
                                                       "joint_names",
                                                       "points",
                                                       "positions",
                                                       "steps",
                                                       "certificate",
                                                       "multi_dof_joint_trajectory"};
constexpr std::array<std::string_view, 5> kPointKeys = {"positions", "velocities", "accelerations",
                                                        "effort", "time_from_start"};
constexpr std::array<std::string_view, 6> kStepKeys = {"name",      "first", "last",
                                                       "deviation", "turn",  "places"};
constexpr std::array<std::string_view, 12> kCertificateKeys = {
    "certified",       "interpolation",   "margin",     "tracking_tolerance",
    "clearance_lower", "clearance_upper", "closest",    "segments",
    "not_checked",     "obstacles_at",    "conditions", "blended_corners"};

/// Whether any row states velocities.
bool hasVelocities(const YamlReader& rows) {
  const std::vector<YamlReader> items = rows.items();
  return std::any_of(items.begin(), items.end(), [](const YamlReader& item) {
    const auto velocities = item.isMap() ? item.find("velocities") : std::nullopt;
    return velocities && !velocities->isNull() && !velocities->items().empty();
  });
}

/// The line of the first accelerations of rows; 0: none has any.
int accelerationsLine(const YamlReader& rows) {
  for (const YamlReader& item : rows.items()) {
    const auto given = item.isMap() ? item.find("accelerations") : std::nullopt;
    if (given && !given->isNull() && !given->items().empty()) return given->line();
  }
  return 0;
}

/// Reads the velocities of rows, between which the motion is cubic.
void readVelocities(const YamlReader& rows, Table& table) {
  table.cubic = true;
  std::size_t i = 0;
  for (const YamlReader& item : rows.items()) {
    Table::Row& row = table.rows[i++];
    const YamlReader velocities =
        item.at("velocities", "a list of numbers, because the interpolation is cubic,");
    row.velocities = velocities.numbers();
    if (row.velocities.size() != row.values.size())
      velocities.fail(
          fmt::format("{} velocities; {} are expected", row.velocities.size(), row.values.size()));
    if (!row.time) item.fail("has no time_from_start, which cubics need");
    const auto accelerations = item.find("accelerations");
    if (!accelerations || accelerations->isNull()) continue;
    row.accelerations = accelerations->numbers();
    if (!row.accelerations.empty() && row.accelerations.size() != row.values.size())
      accelerations->fail(fmt::format("{} accelerations; {}, or none, are expected",
                                      row.accelerations.size(), row.values.size()));
  }
}

/// `outer`: what is around it in the file; may be null.
Table readTrajectory(const YamlReader& file, const YamlReader* outer = nullptr) {
  if (!file.isMap())
    file.fail("is no map; joint_names and points (trajectory_msgs/JointTrajectory) are expected");
  expectOneForm(file, {"joint_trajectory", "path", "positions", "points"});
  // A RobotTrajectory of MoveIt may move joints of several variables as well.
  if (const auto other = file.find("multi_dof_joint_trajectory"); other && !other->isNull()) {
    const auto points = other->isMap() ? other->find("points") : std::nullopt;
    if (!other->isMap() || (points && !points->isNull() && !points->items().empty()))
      other->fail(
          fmt::format("{} has motions that are not read; a joint_trajectory alone is expected",
                      other->where()));
  }
  if (const auto nested = file.find("joint_trajectory")) {
    file.expectKeys(kOuterKeys);
    return readTrajectory(*nested, &file);
  }
  const auto planned = file.find("path");
  const YamlReader& source = planned && planned->isMap() ? *planned : file;
  source.expectKeys(kPathKeys);
  expectOneForm(source, {"positions", "points"});
  Table table;
  const YamlReader names = source.at("joint_names", "a list of joint names");
  table.names_line = names.line();
  for (const YamlReader& name : names.items()) table.names.push_back(name.text());
  const bool plain = source.has("positions");
  const YamlReader rows = source.at(plain ? "positions" : "points", "a list of waypoints");
  if (table.names.empty())
    names.fail(fmt::format("{} is empty; the name of each column is expected", names.where()));
  for (const YamlReader& item : rows.items()) {
    if (item.isMap()) item.expectKeys(kPointKeys);
    const YamlReader row = plain ? item : item.at("positions", "a list of numbers");
    table.rows.push_back({row.numbers(), row.line()});
    const auto time = plain ? std::nullopt : item.find("time_from_start");
    if (time && !time->isNull()) table.rows.back().time = readTime(*time);
  }
  auto certificate = source.find("certificate");
  if (!certificate && outer != nullptr) certificate = outer->find("certificate");
  if (certificate && !certificate->isNull()) {
    if (!certificate->isMap()) certificate->fail("the certificate is no map; a map is expected");
    certificate->expectKeys(kCertificateKeys);
    if (const auto interpolation = certificate->find("interpolation")) {
      table.interpolation = interpolation->text();
      table.interpolation_line = interpolation->line();
    }
    if (const auto conditions = certificate->find("conditions"))
      table.conditions_line = conditions->line();
  }
  // A controller that gets velocities moves on cubics, which are lines where the motion stops at
  // its corners. Orientations alone do not move on cubics.
  const std::string& given = table.interpolation;
  const bool may_be = given.empty() || given == kJointLinear || given == kPlaneGeodesic;
  if (!plain && (given == kCubic || (may_be && hasVelocities(rows)))) readVelocities(rows, table);
  if (!plain && !hasVelocities(rows)) table.accelerations_line = accelerationsLine(rows);
  if (const auto steps = source.find("steps"))
    for (const YamlReader& step : steps->items()) {
      step.expectKeys(kStepKeys);
      PathStep read;
      read.name = step.at("name", "the step's name").text();
      read.first = readWaypoint(step.at("first", "a waypoint"), table.rows.size());
      read.last = readWaypoint(step.at("last", "a waypoint"), table.rows.size());
      if (const auto places = step.find("places")) read.places = places->numbers();
      table.steps.push_back(std::move(read));
    }
  return table;
}

// ---- CSV and .path ----

std::vector<std::string> csvFields(const std::string& file, int line_number,
                                   std::string_view line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += '"';
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  if (quoted)
    throw InputError(file, line_number, "a quoted field has no end; a closing quote is expected");
  return fields;
}

/// The fields of a line without commas.
std::vector<std::string> blankFields(std::string_view line) {
  const std::vector<std::string_view> cells = blankCells(line);
  return {cells.begin(), cells.end()};
}

/// Shortens a text for a message.
std::string elided(const std::string& text) {
  constexpr std::size_t kLongest = 60;
  return text.size() > kLongest ? text.substr(0, kLongest) + "..." : text;
}

double readField(const std::string& file, int line, const std::string& field) {
  const std::optional<double> value = robots::parseNumber(withoutBlanks(field));
  if (withoutBlanks(field).empty())
    throw InputError(file, line, "a field is empty; a finite number is expected");
  if (!value || !std::isfinite(*value))
    throw InputError(file, line,
                     fmt::format("'{}' stands where a finite number is expected", elided(field)));
  return *value;
}

/// Returns the lines that are not blank, with their numbers.
std::vector<std::pair<int, std::string>> readLines(const std::string& file,
                                                   std::vector<std::string>* warnings) {
  const std::string text = robots::readTextFile(file, "a path file");
  std::vector<std::pair<int, std::string>> lines;
  int number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    ++number;
    const std::string_view text_of = withoutBlanks(line);
    if (!text_of.empty() && text_of.front() != '#') lines.emplace_back(number, std::move(line));
  }
  if (warnings != nullptr && !robots::lastLineEnds(text))
    warnings->push_back(fmt::format("{}:{}: {}", file, number, robots::kLastLineOpen));
  return lines;
}

/// Whether a row has numbers and, apart from them, only empty fields. A header has a name.
bool areNumbers(const std::vector<std::string>& fields) {
  bool has_number = false;
  for (const std::string& field : fields) {
    const std::string_view text = withoutBlanks(field);
    const bool is_number = robots::parseNumber(text).has_value();
    if (!is_number && !text.empty()) return false;
    has_number = has_number || is_number;
  }
  return has_number;
}

/// Reads a header of names and rows, or only rows in the group's order with commas or blanks.
Table readCsv(const std::string& file, std::vector<std::string>* warnings) {
  Table table;
  for (const auto& [number, line] : readLines(file, warnings)) {
    std::vector<std::string> fields = csvFields(file, number, line);
    if (table.names.empty() && fields.size() == 1)
      if (std::vector<std::string> row = blankFields(line); areNumbers(row)) fields.swap(row);
    if (table.names.empty() && table.rows.empty() && !areNumbers(fields)) {
      if (fields.size() == 1 && line.find_first_of(";\t") != std::string::npos)
        throw InputError(file, number,
                         fmt::format("'{}' has no comma; names or numbers with commas between "
                                     "them are expected",
                                     elided(line)));
      for (const std::string& field : fields) table.names.emplace_back(withoutBlanks(field));
      table.names_line = number;
      continue;
    }
    Table::Row row{{}, number};
    for (const std::string& field : fields) row.values.push_back(readField(file, number, field));
    table.rows.push_back(std::move(row));
  }
  if (table.names.empty() && table.rows.empty())
    throw InputError(file, 0,
                     "is empty; a header of joint names and rows, or rows alone, are expected");
  return table;
}

/// Finds the column of times. If a planned joint has that name, too, it has the last such column.
void takeTimes(const Problem& problem, Table& table) {
  const auto& names = table.names;
  const std::vector<std::string> planned = plannedNames(problem);
  const bool is_joint = std::find(planned.begin(), planned.end(), kTimeColumn) != planned.end();
  const auto first = std::find(names.begin(), names.end(), kTimeColumn);
  if (first == names.end() ||
      (is_joint && std::find(first + 1, names.end(), kTimeColumn) == names.end()))
    return;
  table.time_column = static_cast<std::size_t>(first - names.begin());
  for (Table::Row& row : table.rows)
    if (*table.time_column < row.values.size()) row.time = row.values[*table.time_column];
}

/// Takes the velocities of a CSV file that has them. A column with the name of a joint is that
/// joint's, as where joints are called "a" and "a.velocity".
void takeVelocities(const std::string& file, const Problem& problem, Table& table,
                    std::vector<std::string>* warnings) {
  const auto column = [&](const std::string& name) {
    std::size_t i = 0;
    while (i < table.names.size() && (table.names[i] != name || i == table.time_column)) ++i;
    return i;
  };
  const auto rateColumn = [&](const std::string& name, std::string_view ending) {
    const std::string of = name + std::string(ending);
    return problem.robot.model->findVariable(of) < 0 ? column(of) : table.names.size();
  };
  std::vector<std::pair<std::size_t, std::size_t>> columns;  // of a position and its velocity
  for (const std::string& name : plannedNames(problem))
    columns.emplace_back(column(name), rateColumn(name, kVelocityEnding));
  const std::size_t count = table.names.size();
  if (std::all_of(columns.begin(), columns.end(),
                  [&](const auto& c) { return c.second == count; })) {
    for (const std::string& name : plannedNames(problem))
      if (rateColumn(name, kAccelerationEnding) < count)
        table.accelerations_line = table.names_line;
    return;
  }
  if (hasRotation(ConfigurationSpace(problem.robot.model, problem.robot.variables))) {
    if (warnings != nullptr)
      warnings->push_back(
          fmt::format("{}:{}: velocities of bodies that turn are not read; straight motions join "
                      "the rows",
                      file, table.names_line));
    return;
  }
  const auto require = [&](bool is_there, const std::string& name) {
    if (!is_there)
      throw InputError(file, table.names_line,
                       fmt::format("the column '{}' is missing; the time and the velocity of each "
                                   "planned joint, or no velocity, is expected",
                                   name));
  };
  require(table.time_column.has_value(), std::string(kTimeColumn));
  for (const std::string& name : plannedNames(problem)) {
    const std::string velocity = name + std::string(kVelocityEnding);
    require(rateColumn(name, kVelocityEnding) < count, velocity);
    if (column(name) == count) return;  // told below
  }
  if (!std::all_of(table.rows.begin(), table.rows.end(),
                   [&](const Table::Row& row) { return row.time && row.values.size() == count; }))
    return;  // told below
  table.cubic = true;
  for (Table::Row& row : table.rows) {
    row.velocities.assign(count, 0);
    for (const auto& [position, velocity] : columns)
      row.velocities[position] = row.values[velocity];
  }
}

/// Rows of numbers in the group's order, with blanks or commas between them.
Table readMatrix(const std::string& file, std::vector<std::string>* warnings) {
  Table table;
  for (const auto& [number, line] : readLines(file, warnings)) {
    Table::Row row{{}, number};
    const bool commas = line.find(',') != std::string::npos;
    for (const std::string& field : commas ? csvFields(file, number, line) : blankFields(line))
      row.values.push_back(readField(file, number, field));
    table.rows.push_back(std::move(row));
  }
  return table;
}

// ---- Matching to the problem ----

constexpr int kIgnored = -1;  // a column without a variable

/// Whether a column of writeTrajectory()'s CSV is a derivative, which a path does not use.
bool isDerivative(const std::string& name, const Problem& problem) {
  for (const std::string_view ending : {kVelocityEnding, kAccelerationEnding})
    if (name.ends_with(ending) &&
        problem.robot.model->findVariable(name.substr(0, name.size() - ending.size())) >= 0)
      return true;
  return false;
}

/// The model's variable of each column.
std::vector<int> columnVariables(const std::string& file, const Table& table,
                                 const Problem& problem) {
  std::vector<int> columns;
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    const std::string& name = table.names[i];
    const int v = i == table.time_column ? kIgnored : problem.robot.model->findVariable(name);
    if (v < 0 && name != kTimeColumn && !isDerivative(name, problem) &&
        problem.robot.model->findJoint(name) < 0)
      throw InputError(file, table.names_line,
                       fmt::format("unknown joint '{}'{}", elided(name),
                                   didYouMean(elided(name), plannedNames(problem))));
    if (v >= 0 && std::find(columns.begin(), columns.end(), v) != columns.end())
      throw InputError(file, table.names_line,
                       fmt::format("joint '{}' stands twice; once is expected", name));
    columns.push_back(v >= 0 ? v : kIgnored);
  }
  for (const int v : problem.robot.variables)
    if (std::find(columns.begin(), columns.end(), v) == columns.end())
      throw InputError(
          file, table.names_line,
          fmt::format("planned joint '{}' is missing; a column for each planned joint is expected",
                      problem.robot.model->variables[at(v)].name));
  return columns;
}

/// Refuses rows in which a fixed or mimic joint is not where the others put it. Recorded states
/// have columns of these joints, too.
void requireFollowers(const std::string& file, const Table& table, const Problem& problem,
                      const Path& path) {
  const robots::Model& model = *problem.robot.model;
  std::vector<double> q = problem.start;
  for (std::size_t c = 0; c < table.names.size(); ++c) {
    const int j = model.findVariable(table.names[c]) < 0 ? model.findJoint(table.names[c]) : -1;
    if (j < 0) continue;
    const robots::KinematicStep& step = model.steps[at(j)];
    const bool follows = model.joints[at(j)].mimic >= 0;
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      for (std::size_t i = 0; i < path.names.size(); ++i)
        q[at(problem.robot.variables[i])] = path.positions[r][i];
      const double expected = follows ? step.multiplier * q[at(step.variable)] + step.offset : 0;
      const double value = table.rows[r].values[c];
      if (!(std::abs(value - expected) <= kPassiveJointSlack))
        throw InputError(
            file, table.rows[r].line,
            fmt::format("joint '{}' is at {}, but {}; {} is expected", table.names[c], value,
                        follows ? "follows '" + model.variables[at(step.variable)].name + "'"
                                : "does not move",
                        expected));
    }
  }
}

void requirePassive(const std::string& file, int line, double value, int variable,
                    const Problem& problem) {
  const double expected = problem.start[at(variable)];
  if (std::abs(value - expected) > kPassiveJointSlack)
    throw InputError(
        file, line,
        fmt::format("joint '{}' is at {}, but not planned; the problem's {} is expected",
                    problem.robot.model->variables[at(variable)].name, value, expected));
}

void normaliseRotations(const std::string& file, int line, const ConfigurationSpace& space,
                        std::vector<double>& point) {
  for (const ConfigurationSpace::Part& part : space.parts()) {
    if (part.kind != ConfigurationSpace::Kind::kRotation) continue;
    double* q = &point[at(part.first)];
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(std::abs(norm - 1) <= kMendableQuaternion))
      throw InputError(file, line,
                       fmt::format("a quaternion of length {}; unit length is expected", norm));
    if (std::abs(norm - 1) > kSilentQuaternion)  // our own files read back to the bit
      for (int i = 0; i < 4; ++i) q[i] /= norm;
  }
}

/// Refuses a file whose rows are joined in a way that is not read.
void expectInterpolation(const std::string& file, const Table& table,
                         const ConfigurationSpace& space) {
  const std::string& given = table.interpolation;
  if (given.empty() || given == space.interpolation() || (table.cubic && given == kCubic)) return;
  throw InputError(file, table.interpolation_line,
                   fmt::format("the interpolation is '{}'; {}, or {} for rows with times and "
                               "velocities, is expected",
                               elided(given), space.interpolation(), kCubic));
}

/// Refuses times that run backwards, or stand still while a joint moves: rows are in the order of
/// the motion.
void expectTimes(const std::string& file, const Table& table, const Path& path) {
  std::optional<std::size_t> last;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const std::optional<double> time = table.rows[i].time;
    if (!time) continue;
    if (const std::size_t k = last.value_or(i); *table.rows[k].time >= *time && k != i) {
      const std::vector<double>&from = path.positions[k], &to = path.positions[i];
      const bool moves = !std::equal(from.begin(), from.end(), to.begin(), [](double x, double y) {
        return std::abs(x - y) <= kPassiveJointSlack;
      });
      if (*table.rows[k].time > *time || moves)
        throw InputError(file, table.rows[i].line,
                         fmt::format("the row's time is {} s, {} {} s of line {}; times that rise "
                                     "are expected",
                                     *time, moves ? "no later than the" : "before the",
                                     *table.rows[k].time, table.rows[k].line));
    }
    last = i;
  }
}

/// Refuses cubics that take no time.
void expectDurations(const std::string& file, const Table& table, const Path& path) {
  for (std::size_t i = 1; i < path.times.size(); ++i)
    if (!(path.times[i] > path.times[i - 1]))
      throw InputError(
          file, table.rows[i].line,
          fmt::format("the row's time is {} s, as that of line {}; times that rise are "
                      "expected, because the interpolation is cubic",
                      path.times[i], table.rows[i - 1].line));
}

/// Names accelerations that the cubics between rows do not have. `accelerations`: one row a row of
/// the path; empty where none are given.
void nameAccelerations(const std::string& file, const Table& table, const Path& path,
                       const std::vector<std::vector<double>>& accelerations,
                       std::vector<std::string>& warnings) {
  double most = kQuinticSlack;
  std::size_t row = 0, joint = 0;
  for (std::size_t k = 1; k < accelerations.size(); ++k) {
    if (accelerations[k - 1].empty() || accelerations[k].empty()) continue;
    const auto motion = [&](std::size_t r, std::size_t i) -> RowMotion {
      return {path.positions[r][i], path.velocities[r][i], accelerations[r][i]};
    };
    for (std::size_t i = 0; i < path.names.size(); ++i) {
      const double departure =
          quinticDeparture(path.times[k] - path.times[k - 1], motion(k - 1, i), motion(k, i));
      if (departure > most) {
        most = departure;
        row = k;
        joint = i;
      }
    }
  }
  if (row > 0)
    warnings.push_back(fmt::format(
        "{}:{}: with these accelerations a controller may follow quintics, which depart from the "
        "cubics that are looked at here by up to {:.2g} rad or m at '{}'; rows without "
        "accelerations, or a margin for that, are expected",
        file, table.rows[row].line, most, path.names[joint]));
}

/// Refuses turns that no certifier accepts.
void expectEdges(const std::string& file, const Table& table, const ConfigurationSpace& space,
                 const Path& path) {
  for (std::size_t i = 1; i < path.positions.size(); ++i)
    if (space.edgesAlongLine(path.positions[i - 1], path.positions[i]) == 0)
      throw InputError(file, table.rows[i].line,
                       fmt::format("a continuous joint turns by more than half a turn, beyond {} "
                                   "rad; values within {} rad are expected",
                                   kLargestAngle, kLargestAngle));
}

Path matched(const std::string& file, const Table& table, const Problem& problem,
             const PathReading& options) {
  const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  const std::vector<int> columns =
      table.names.empty() ? problem.robot.variables : columnVariables(file, table, problem);
  expectInterpolation(file, table, space);
  Path path;
  path.names = plannedNames(problem);
  path.steps = table.steps;
  if (table.cubic && !options.cubics && options.warnings != nullptr)
    options.warnings->push_back(
        file + ": lines join its rows here, and cubics in its motion, which 'verify' proves");
  if (table.conditions_line > 0 && !problem.condition.accept && options.warnings != nullptr)
    options.warnings->push_back(
        fmt::format("{}:{}: the path was planned with a condition of a program, at sampled states; "
                    "the problem does not have it, and no answer covers it",
                    file, table.conditions_line));
  if (table.accelerations_line > 0 && options.warnings != nullptr)
    options.warnings->push_back(
        fmt::format("{}:{}: accelerations without velocities are not read; straight motions join "
                    "the rows",
                    file, table.accelerations_line));
  const bool cubic = table.cubic && options.cubics;
  if (table.rows.empty()) throw InputError(file, 0, "holds no waypoint; at least one is expected");
  std::vector<std::vector<double>> accelerations;
  for (const Table::Row& row : table.rows) {
    if (row.values.size() != columns.size())
      throw InputError(
          file, row.line,
          fmt::format("a row of {} numbers; {} are expected", row.values.size(), columns.size()));
    if (row.time && !(std::abs(*row.time) <= kLatestTime))
      throw InputError(file, row.line,
                       fmt::format("the row's time is {} s; a number from {} to {} is expected",
                                   *row.time, -kLatestTime, kLatestTime));
    std::vector<double> point(problem.robot.variables.size()), velocity(cubic ? point.size() : 0),
        acceleration(row.accelerations.empty() ? 0 : velocity.size());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (columns[c] == kIgnored) continue;
      const auto place =
          std::find(problem.robot.variables.begin(), problem.robot.variables.end(), columns[c]);
      if (place == problem.robot.variables.end())
        requirePassive(file, row.line, row.values[c], columns[c], problem);
      else
        point[static_cast<std::size_t>(place - problem.robot.variables.begin())] = row.values[c];
      if (!cubic || place == problem.robot.variables.end()) continue;
      const auto i = static_cast<std::size_t>(place - problem.robot.variables.begin());
      velocity[i] = row.velocities[c];
      if (!acceleration.empty()) acceleration[i] = row.accelerations[c];
    }
    if (cubic) {
      path.times.push_back(*row.time);
      path.velocities.push_back(std::move(velocity));
      accelerations.push_back(std::move(acceleration));
    }
    normaliseRotations(file, row.line, space, point);
    path.positions.push_back(std::move(point));
  }
  requireFollowers(file, table, problem, path);
  if (options.shortest) path.positions = unwrapped(space, std::move(path.positions));
  expectTimes(file, table, path);
  expectDurations(file, table, path);
  if (options.warnings != nullptr)
    nameAccelerations(file, table, path, accelerations, *options.warnings);
  expectEdges(file, table, space, path);
  return path;
}

}  // namespace

Path readPath(const std::string& file, const Problem& problem, const PathReading& options) {
  validate(problem);
  const std::string ending = robots::endingOf(file);
  if (ending == ".json" || ending == ".yaml" || ending == ".yml")
    return matched(file, readTrajectory(YamlReader::load(file)), problem, options);
  if (ending == ".csv") {
    Table table = readCsv(file, options.warnings);
    takeTimes(problem, table);
    takeVelocities(file, problem, table, options.warnings);
    return matched(file, table, problem, options);
  }
  if (ending == ".path" || ending == ".txt")
    return matched(file, readMatrix(file, options.warnings), problem, options);
  throw InputError(
      file, 0,
      fmt::format("the ending '{}' names no format; .json, .yaml, .csv, .path or .txt is expected",
                  ending));
}

}  // namespace leeway::planner
