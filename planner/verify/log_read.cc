#include "planner/verify/log_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "leeway/robots/input_error.h"
#include "planner/base/did_you_mean.h"
#include "planner/execute/log_line.h"
#include "planner/validate/checks.h"
#include "planner/yaml/yaml_reader.h"
#include "robots/base/read_file.h"

namespace leeway::planner::verification {
namespace {

using robots::InputError;

constexpr std::array<std::string_view, 5> kDecisions = {"plan", "follow", "wait", "evade",
                                                        "unsafe"};
constexpr std::array<std::string_view, 6> kStatuses = {"reached", "exposed", "unsafe",
                                                       "timeout", "stopped", "nothing_checked"};

/// Whether a name in a log is this one. Logs are UTF-8: what is not has the replacement character.
bool isName(const std::string& logged, const std::string& name) {
  using Json = nlohmann::json;
  return logged == name ||
         logged == Json::parse(Json(name).dump(-1, ' ', false, Json::error_handler_t::replace))
                       .get<std::string>();
}

/// Refuses a line that does not end with the sum of its text.
void requireSum(const std::string& file, int line, std::string_view text) {
  constexpr std::size_t kDigits = 16;
  const std::size_t ending = kBeforeSum.size() + kDigits + kAfterSum.size();
  const std::size_t body = text.size() >= ending ? text.size() - ending : 0;
  if (text.size() < ending || text.substr(body, kBeforeSum.size()) != kBeforeSum ||
      !text.ends_with(kAfterSum))
    throw InputError(file, line,
                     "the line has no sum at its end: it was cut or changed, or it is no line of a "
                     "log; a line as `leeway replan` writes it is expected");
  const std::string sum = fmt::format("{:016x}", lineSum(text.substr(0, body)));
  const std::string_view given = text.substr(body + kBeforeSum.size(), kDigits);
  if (given != sum)
    throw InputError(file, line,
                     fmt::format("the line was changed after it was written: its sum is {}; {} is "
                                 "expected",
                                 sum, given));
}

class LineReader {
 public:
  LineReader(const Problem& problem, const YamlReader& line) : problem_(problem), line_(line) {
    if (!line.isMap()) line.fail("the line is no JSON object; one document a line is expected");
    const YamlReader version = at("version");
    if (version.integer(0) != kLogVersion)
      version.fail(
          fmt::format("version is {}; {}, as `leeway replan` of this version writes it, is "
                      "expected",
                      version.integer(0), kLogVersion));
  }

  bool isEnd() const { return line_.has("status"); }

  LoggedEnd end() const {
    LoggedEnd end;
    end.line = line_.line();
    end.status = word("status", kStatuses);
    const YamlReader problem = at("problem");
    // A problem without a name has an empty text.
    const std::string name = problem.isEmpty() ? "" : problem.text();
    if (!isName(name, problem_.name))
      problem.fail(fmt::format("the log is one of the problem '{}'; one of '{}' is expected", name,
                               problem_.name));
    end.certified = at("certified").boolean();
    end.duration = at("duration").number();
    end.steps = at("steps").integer(0);
    end.plans = at("plans").integer(0);
    end.follows = at("follows").integer(0);
    end.waits = at("waits").integer(0);
    end.evasions = at("evasions").integer(0);
    return end;
  }

  LoggedStep step() const {
    LoggedStep step;
    step.line = line_.line();
    step.step = at("step").integer(0);
    step.time = at("time").number();
    step.decision = word("decision", kDecisions);
    step.certified = at("certified").boolean();
    step.exposed = at("exposed").boolean();
    step.reached = at("reached").boolean();
    requireNames();
    step.position = row(at("position"));
    const YamlReader motion = at("motion");
    readRows(motion, step.times, step.rows);
    const YamlReader stop = at("stop");
    step.keeps_stop = stop.isNull();
    if (!step.keeps_stop) readRows(stop, step.stop_times, step.stop_rows);
    if (step.rows.size() < 2)
      motion.fail(fmt::format("motion has {} rows; at least 2 are expected", step.rows.size()));
    if (const YamlReader measured = at("measured"); !measured.isNull())
      step.measured = row(measured);
    for (const YamlReader& item : at("observed").items()) step.observed.push_back(sight(item));
    for (const YamlReader& item : at("obstacles").items())
      step.obstacles.push_back({item.at("name", "the obstacle's name").text(),
                                item.at("seen", "a time [s]").number(),
                                item.at("predicted", "true or false").boolean()});
    return step;
  }

 private:
  YamlReader at(std::string_view key) const { return line_.at(key, "a line of a log"); }

  std::string word(std::string_view key, std::span<const std::string_view> words) const {
    const YamlReader value = at(key);
    const std::string text = value.text();
    if (std::find(words.begin(), words.end(), text) == words.end())
      value.fail(
          fmt::format("{} is '{}'{}", key, text,
                      didYouMean(text, std::vector<std::string>(words.begin(), words.end()))));
    return text;
  }

  std::vector<double> row(const YamlReader& reader) const {
    std::vector<double> values = reader.numbers();
    if (values.size() != problem_.robot.variables.size())
      reader.fail(fmt::format("{} has {} numbers; {}, one a planned joint, are expected",
                              reader.where(), values.size(), problem_.robot.variables.size()));
    return values;
  }

  void readRows(const YamlReader& list, std::vector<double>& times,
                std::vector<std::vector<double>>& rows) const {
    for (const YamlReader& item : list.items()) {
      times.push_back(item.at("time", "a time [s]").number());
      rows.push_back(row(item.at("position", "the joints' values")));
    }
  }

  void requireNames() const {
    const YamlReader names = at("joint_names");
    const std::vector<YamlReader> items = names.items();
    const std::vector<int>& variables = problem_.robot.variables;
    if (items.size() != variables.size())
      names.fail(fmt::format("{} joints are named; {}, those that the problem plans, are expected",
                             items.size(), variables.size()));
    for (std::size_t i = 0; i < items.size(); ++i) {
      const std::string& expected = problem_.robot.model->variables[leeway::at(variables[i])].name;
      if (const std::string name = items[i].text(); !isName(name, expected))
        items[i].fail(fmt::format("joint_names[{}] is '{}'; the problem's '{}' is expected", i,
                                  name, expected));
    }
  }

  /// null is infinite, because JSON has no infinity.
  static double bound(const YamlReader& reader) {
    return reader.isNull() ? kInfinity : reader.sizeNumber();
  }

  LoggedSight sight(const YamlReader& item) const {
    LoggedSight sight;
    const YamlReader object = item.at("object", "an obstacle's name");
    const std::string name = object.text();
    sight.time = item.at("time", "a time [s]").number();
    sight.speed_bound = bound(item.at("speed_bound", "a speed [m/s]"));
    sight.is_rigid = item.has("position");
    const auto balls = item.find("balls");
    std::vector<std::string> names;
    if (sight.is_rigid) {
      for (const Object& o : problem_.world.objects)
        if (o.motion && (!balls || o.cloud)) names.push_back(o.name);
      if (balls)
        sight.cloud = cloud(*balls);
      else
        sight.turn_bound = bound(item.at("turn_bound", "a speed of turning [rad/s]"));
      sight.X_WO = pose(item);
    } else {
      for (const DeformingObstacle& o : problem_.world.deforming) names.push_back(o.object.name);
    }
    const auto found = std::find_if(names.begin(), names.end(),
                                    [&](const std::string& n) { return isName(name, n); });
    if (found == names.end())
      object.fail(fmt::format("the problem has no {} '{}'{}",
                              balls            ? "cloud with a motion"
                              : sight.is_rigid ? "object with a motion"
                                               : "deforming obstacle",
                              name, didYouMean(name, names)));
    sight.object = *found;
    if (!sight.is_rigid)
      sight.vertices =
          vertices(item, problem_.world.deforming[static_cast<std::size_t>(found - names.begin())]);
    return sight;
  }

  /// The balls of a cloud. No ball is left where all were carved out.
  static std::shared_ptr<const PointCloud> cloud(const YamlReader& list) {
    auto read = std::make_shared<PointCloud>();
    for (const YamlReader& item : list.items()) {
      const std::vector<double> v = item.numbers();
      if (v.size() != 4)
        item.fail(fmt::format("{} has {} numbers; [x, y, z, radius] in m is expected", item.where(),
                              v.size()));
      read->balls.push_back({{v[0], v[1], v[2]}, v[3]});
    }
    if (read->balls.empty()) return read;
    if (const std::string fault = cloudFault(*read); !fault.empty())
      list.fail(fmt::format("{}: {}", list.where(), fault));
    return read;
  }

  static robots::Pose pose(const YamlReader& item) {
    robots::Pose X_WO;
    X_WO.translation = item.at("position", "a list of three numbers").vector3();
    const YamlReader rotation = item.at("rotation", "three rows of a matrix");
    const std::vector<YamlReader> rows = rotation.items();
    if (rows.size() != 3)
      rotation.fail(fmt::format("{} has {} rows; 3 are expected", rotation.where(), rows.size()));
    for (std::size_t i = 0; i < 3; ++i)
      X_WO.rotation.row(static_cast<Eigen::Index>(i)) = rows[i].vector3();
    if (const std::string fault = poseFault(X_WO); !fault.empty())
      rotation.fail(fmt::format("the pose {}", fault));
    return X_WO;
  }

  static std::vector<Eigen::Vector3d> vertices(const YamlReader& item,
                                               const DeformingObstacle& obstacle) {
    const YamlReader list = item.at("vertices", "a list of points");
    std::vector<Eigen::Vector3d> vertices;
    for (const YamlReader& vertex : list.items()) {
      vertices.push_back(vertex.vector3());
      if (!(vertices.back().cwiseAbs().maxCoeff() <= collision::kLargestSize))
        vertex.fail(fmt::format("{} has a coordinate beyond {} m; smaller ones are expected",
                                vertex.where(), collision::kLargestSize));
    }
    if (static_cast<int>(vertices.size()) != obstacle.mesh->vertexCount())
      list.fail(fmt::format("{} vertices of '{}'; {} are expected", vertices.size(),
                            obstacle.object.name, obstacle.mesh->vertexCount()));
    return vertices;
  }

  const Problem& problem_;
  const YamlReader& line_;
};

}  // namespace

Log readLog(const std::string& file, const Problem& problem) {
  const std::string text = robots::readTextFile(file, "the log of an execution");
  Log log;
  int number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    ++number;
    if (log.end)
      throw InputError(file, number,
                       fmt::format("the line follows the end of the execution, line {}; none is "
                                   "expected there",
                                   log.end->line));
    requireSum(file, number, line);
    const YamlReader document = YamlReader::ofJson(file, std::move(line), number);
    const LineReader reader(problem, document);
    if (reader.isEnd())
      log.end = reader.end();
    else
      log.steps.push_back(reader.step());
  }
  if (number == 0)
    throw InputError(file, 0, "is empty; a log, one JSON document a line, is expected");
  return log;
}

}  // namespace leeway::planner::verification
