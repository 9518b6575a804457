#include "planner/problem/read_execution.h"

#include <fmt/format.h>

#include <utility>

#include "planner/problem/fail_at.h"
#include "planner/yaml/format_keys.h"

namespace leeway::planner {
namespace {

/// One number for all planned variables, or a map by variable.
void readMotionLimits(const YamlReader& execution, const char* key, const Problem& problem,
                      std::map<std::string, double>& limits) {
  const auto given = execution.find(key);
  if (!given) return;
  if (given->isMap()) {
    for (const auto& [name, value] : given->entries()) limits[name] = value.number();
    return;
  }
  const double limit = given->number();
  for (const int v : problem.robot.variables)
    limits[problem.robot.model->variables[static_cast<std::size_t>(v)].name] = limit;
}

}  // namespace

void readExecution(const YamlReader& reader, Problem& problem) {
  reader.expectKeys(keysOf("execution"));
  Execution& execution = problem.execution;
  for (const auto& [key, value] : {std::pair("start", &execution.start),
                                   {"step", &execution.step},
                                   {"duration", &execution.duration},
                                   {"speed", &execution.speed},
                                   {"look_ahead", &execution.look_ahead},
                                   {"buffer", &execution.buffer},
                                   {"patience", &execution.patience}})
    if (const auto given = reader.find(key)) *value = given->number();
  readMotionLimits(reader, "velocities", problem, execution.velocities);
  readMotionLimits(reader, "accelerations", problem, execution.accelerations);
  readMotionLimits(reader, "jerks", problem, execution.jerks);
  if (const auto fault = executionFault(problem)) failAt(reader, *fault);
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
