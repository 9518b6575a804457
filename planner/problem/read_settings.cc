#include "planner/problem/read_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <variant>

#include "collision/base/numbers.h"
#include "leeway/planner/settings.h"
#include "planner/problem/fail_at.h"
#include "planner/validate/format_keys.h"

namespace leeway::planner {
namespace {

double readNumber(const YamlReader& value, const Setting& setting) {
  const double number = value.number();
  if (const auto fault = numberFault(setting, value.where(), number)) value.fail(*fault);
  return number;
}

/// Reads the value of one setting.
struct Read {
  const YamlReader& value;
  const Setting& setting;
  Problem& problem;

  void operator()(SettingPlace<bool> place) const { *place(problem) = value.boolean(); }
  void operator()(SettingPlace<double> place) const {
    *place(problem) = readNumber(value, setting);
  }
  void operator()(SettingPlace<std::int64_t> place) const {
    *place(problem) = value.integer(static_cast<std::int64_t>(setting.range.lower));
    if (const auto fault =
            numberFault(setting, value.where(), static_cast<double>(*place(problem))))
      value.fail(*fault);
  }
  void operator()(SettingPlace<std::uint64_t> place) const { *place(problem) = value.seed(); }
  void operator()(SettingPlace<std::string> place) const { *place(problem) = value.text(); }
  void operator()(SettingPlace<std::map<std::string, double>> place) const {
    std::map<std::string, double>& values = *place(problem);
    if (value.isMap()) {
      for (const auto& [name, entry] : value.entries()) values[name] = readNumber(entry, setting);
      return;
    }
    const double all = readNumber(value, setting);
    for (const int v : problem.robot.variables)
      values[problem.robot.model->variables[at(v)].name] = all;
  }
  void operator()(const WordSetting& choice) const {
    std::string expected;
    for (const WordSetting::Word& word : choice.words) {
      if (value.text() == word.text) return choice.set(problem, word.value);
      expected += (expected.empty() ? "" : " or ") + std::string(word.text);
    }
    value.fail(fmt::format("{} is '{}'; {} is expected", value.where(), value.text(), expected));
  }
  /// readPlannerOf() and others read these.
  void operator()(SettingPlace<std::map<std::string, std::string>>) const {}
  void operator()(PlannerParameterSetting) const {}
  void operator()(std::monostate) const {}
};

}  // namespace

void readSettings(const YamlReader& map, std::string_view place, Problem& problem) {
  for (const Setting& setting : settings()) {
    const std::string_view key = keyIn(place, setting);
    const auto* const choice = std::get_if<WordSetting>(&setting.value);
    if (key.empty() || key.find('.') != std::string_view::npos || (choice && choice->or_map))
      continue;
    if (const auto value = map.find(key))
      value->readOn([&] { std::visit(Read{*value, setting, problem}, setting.value); });
  }
}

void readExecution(const YamlReader& reader, Problem& problem) {
  reader.expectKeys(keysOf("execution"));
  readSettings(reader, "execution", problem);
  if (const auto fault = executionFault(problem)) failAt(reader, *fault);
}

}  // namespace leeway::planner
