#include "planner/problem/read_execution.h"

#include <fmt/format.h>

#include <algorithm>

#include "planner/base/did_you_mean.h"
#include "planner/base/tolerances.h"
#include "planner/yaml/format_keys.h"

namespace leeway::planner {
namespace {

/// One number for all planned variables, or a map by variable.
void readMotionLimits(const YamlReader& execution, const char* key, const Problem& problem,
                      std::map<std::string, double>& limits) {
  const auto given = execution.find(key);
  if (!given) return;
  const auto limitOf = [](const YamlReader& value) {
    const double limit = value.number();
    if (!(limit >= kLeastLimit && limit <= kMostLimit))
      value.fail(fmt::format("{} is {}; a number from {} to {} is expected", value.where(), limit,
                             kLeastLimit, kMostLimit));
    return limit;
  };
  std::vector<std::string> known;
  for (const int v : problem.robot.variables)
    known.push_back(problem.robot.model->variables[static_cast<std::size_t>(v)].name);
  if (!given->isMap()) {
    const double limit = limitOf(*given);
    for (const std::string& name : known) limits[name] = limit;
    return;
  }
  for (const auto& [name, value] : given->entries()) {
    if (std::find(known.begin(), known.end(), name) == known.end())
      value.fail(fmt::format("unknown planned variable '{}' in {}{}", name, given->where(),
                             didYouMean(name, known)));
    limits[name] = limitOf(value);
  }
}

}  // namespace

void readExecution(const YamlReader& reader, Problem& problem) {
  reader.expectKeys(keysOf("execution"));
  Execution& execution = problem.execution;
  const auto positive = [&](const char* key, double& value) {
    const auto given = reader.find(key);
    if (!given) return;
    value = given->number();
    if (!(value > 0))
      given->fail(fmt::format("{} is {}; a number above 0 is expected", given->where(), value));
  };
  const auto size = [&](const char* key, double& value) {
    if (const auto given = reader.find(key)) value = given->sizeNumber();
  };
  if (const auto start = reader.find("start")) execution.start = start->number();
  positive("step", execution.step);
  positive("duration", execution.duration);
  if (execution.duration < execution.step)
    reader.fail(fmt::format("{} lasts {} s, less than a step of {} s; at least one is expected",
                            reader.where(), execution.duration, execution.step));
  positive("speed", execution.speed);
  if (execution.speed > 1 || execution.speed < kLeastLimit)
    reader.at("speed", "")
        .fail(fmt::format(
            "execution.speed is {}; a share of the velocity limits, {} up to 1, is expected",
            execution.speed, kLeastLimit));
  size("look_ahead", execution.look_ahead);
  size("buffer", execution.buffer);
  size("patience", execution.patience);
  readMotionLimits(reader, "velocities", problem, execution.velocities);
  readMotionLimits(reader, "accelerations", problem, execution.accelerations);
  readMotionLimits(reader, "jerks", problem, execution.jerks);
  if (const auto corners = reader.find("corners")) {
    if (corners->text() == "stop")
      execution.corners = Corners::kStop;
    else if (corners->text() == "blend")
      execution.corners = Corners::kBlend;
    else
      corners->fail(
          fmt::format("{} is '{}'; stop or blend is expected", corners->where(), corners->text()));
  }
  if (execution.corners == Corners::kBlend && !execution.jerks.empty())
    problem.warnings.push_back(fmt::format("{}:{}: corners are not blended where jerks are limited",
                                           reader.file(), reader.line()));
  if (const auto foresight = reader.find("foresight")) {
    if (foresight->text() == "motion")
      execution.foresight = Foresight::kMotion;
    else if (foresight->text() == "speed_bound")
      execution.foresight = Foresight::kSpeedBound;
    else
      foresight->fail(fmt::format("{} is '{}'; motion or speed_bound is expected",
                                  foresight->where(), foresight->text()));
  }
}

}  // namespace leeway::planner
