// The table of settings, and what is made from it: each setting is read from its place in a file,
// and numbers out of range are refused alike in files and programs.
#include "leeway/planner/settings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <type_traits>
#include <variant>

#include "leeway/robots/input_error.h"
#include "planner/validate/checks.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"

namespace leeway::planner {
namespace {

/// A problem file with one setting.
std::string fileWith(const Setting& setting, const std::string& value) {
  std::string text = value, key(setting.key);
  for (std::size_t dot = key.rfind('.'); dot != std::string::npos; dot = key.rfind('.')) {
    text = "{" + key.substr(dot + 1) + ": " + text + "}";
    key.resize(dot);
  }
  const std::string robot = sourceFolder() + "/robots/arm6/arm6";
  return "leeway: 1\nrobot: {urdf: " + robot + ".urdf, srdf: " + robot +
         ".srdf, group: arm}\nstart: home\ngoal: home\n" + key + ": " + text + "\n";
}

Problem load(const Setting& setting, const std::string& value) {
  const Folder folder;
  return loadProblem(folder.write("problem.yaml", fileWith(setting, value)));
}

std::string refusal(const Setting& setting, const std::string& value) {
  try {
    load(setting, value);
  } catch (const robots::InputError& error) {
    return error.what();
  }
  return "accepted";
}

/// Another value than the default.
double otherNumber(const Setting& setting) {
  const Problem plain;
  const double* const value = settingValue(plain, std::get<SettingPlace<double>>(setting.value));
  if (value == nullptr || !std::isfinite(*value) || *value == 0) return 0.25;
  return 1.25 * *value <= setting.range.upper ? 1.25 * *value : 0.5 * *value;
}

/// Loads a file with another value than the default, and expects it at its place.
struct ExpectRead {
  const Setting& setting;

  void operator()(SettingPlace<bool> place) const {
    const Problem plain;
    const bool other = !*settingValue(plain, place);
    const Problem problem = load(setting, other ? "true" : "false");
    EXPECT_EQ(*settingValue(problem, place), other);
  }
  void operator()(SettingPlace<double> place) const {
    const double other = otherNumber(setting);
    const Problem problem = load(setting, std::to_string(other));
    ASSERT_NE(settingValue(problem, place), nullptr);
    EXPECT_EQ(*settingValue(problem, place), other);
  }
  void operator()(SettingPlace<std::int64_t> place) const {
    const Problem problem = load(setting, "7");
    EXPECT_EQ(*settingValue(problem, place), 7);
  }
  void operator()(SettingPlace<std::uint64_t> place) const {
    const Problem problem = load(setting, "18446744073709551615");
    EXPECT_EQ(*settingValue(problem, place), 18446744073709551615U);
  }
  void operator()(SettingPlace<std::string> place) const {
    const std::string other = setting.name == "planner" ? "RRTConnect" : "another";
    const Problem problem = load(setting, other);
    EXPECT_EQ(*settingValue(problem, place), other);
  }
  void operator()(SettingPlace<std::map<std::string, std::string>> place) const {
    const Problem problem = load(setting, "{range: 0.5}");
    EXPECT_EQ(*settingValue(problem, place),
              (std::map<std::string, std::string>{{"range", "0.5"}}));
  }
  void operator()(SettingPlace<std::map<std::string, double>> place) const {
    const Problem all = load(setting, "0.5");
    EXPECT_EQ(settingValue(all, place)->size(), all.robot.variables.size());
    for (const auto& [name, value] : *settingValue(all, place)) EXPECT_EQ(value, 0.5) << name;
    const std::string joint = all.robot.model->variables[0].name;
    const Problem one = load(setting, "{" + joint + ": 0.5}");
    EXPECT_EQ(*settingValue(one, place), (std::map<std::string, double>{{joint, 0.5}}));
  }
  void operator()(const WordSetting& choice) const {
    for (const WordSetting::Word& word : choice.words) {
      const Problem problem = load(setting, std::string(word.text));
      EXPECT_EQ(choice.get(problem), word.value) << word.text;
    }
    EXPECT_NE(refusal(setting, "sideways").find("'sideways'"), std::string::npos);
  }
  void operator()(PlannerParameterSetting of) const {
    const Problem problem = load(setting, "1");
    EXPECT_EQ(problem.planner.parameters.at(std::string(of.parameter)), "1");
  }
  void operator()(std::monostate) const {}
};

TEST(Settings, EachIsReadFromItsPlaceInAFile) {
  for (const Setting& setting : settings()) {
    SCOPED_TRACE(setting.key);
    std::visit(ExpectRead{setting}, setting.value);
  }
}

TEST(Settings, HaveNamesKeysAndOptionsOfTheirOwn) {
  std::set<std::string_view> names, keys, options;
  for (const Setting& setting : settings()) {
    SCOPED_TRACE(setting.key);
    if (!setting.name.empty()) {
      EXPECT_TRUE(names.insert(setting.name).second);
      EXPECT_EQ(findSetting(setting.name), &setting);
      ASSERT_FALSE(setting.help.empty());
      EXPECT_NE(setting.help.back(), '.') << "where it ends says the reader";
    }
    if (!std::holds_alternative<std::monostate>(setting.value)) {
      EXPECT_TRUE(keys.insert(setting.key).second);
    }
    if (!setting.option.empty()) {
      EXPECT_TRUE(options.insert(setting.option).second);
      EXPECT_FALSE(setting.name.empty());
    }
    if (std::holds_alternative<SettingPlace<std::int64_t>>(setting.value)) {
      EXPECT_GE(setting.range.lower, -1e18) << "the readers need a whole number";
    }
  }
  EXPECT_EQ(findSetting(""), nullptr);
  EXPECT_EQ(findSetting("margn"), nullptr);
}

/// Files and comparisons know only members that a setting names. A new member does not compile here
/// until its setting is counted.
TEST(Settings, NameEveryMember) {
  const auto countOf = [](std::string_view head) {
    return std::count_if(settings().begin(), settings().end(),
                         [&](const Setting& setting) { return setting.key.starts_with(head); });
  };
  [[maybe_unused]] const auto& [start, step, duration, speed, velocities, accelerations, jerks,
                                acceleration_scale, jerk_scale, corners, foresight, look_ahead,
                                buffer, patience] = Execution();
  EXPECT_EQ(countOf("execution."), 14);
  [[maybe_unused]] const auto& [time, iterations] = PlanningLimits();
  EXPECT_EQ(countOf("limits."), 2);
}

/// The words of the range are the same wherever a number comes from.
TEST(Settings, NumbersOutOfRangeAreRefusedAlike) {
  int refused = 0;
  for (const Setting& setting : settings()) {
    SCOPED_TRACE(setting.key);
    const auto* place = std::get_if<SettingPlace<double>>(&setting.value);
    if (place == nullptr || setting.range.expected.empty()) continue;
    const std::string words = expectedNumber(setting) + " is expected";
    Problem problem = load(setting, std::to_string(otherNumber(setting)));
    *(*place)(problem) = std::nan("");
    try {
      validate(problem);
      ADD_FAILURE() << "NaN is accepted";
    } catch (const robots::InputError& error) {
      EXPECT_NE(std::string(error.what()).find("is nan; " + words), std::string::npos)
          << error.what();
    }
    if (setting.range.lower < -1e300) continue;
    ++refused;
    EXPECT_NE(refusal(setting, "-1").find("is -1; " + words), std::string::npos)
        << refusal(setting, "-1");
    if (setting.range.above) {
      EXPECT_NE(refusal(setting, "0").find("is 0; " + words), std::string::npos);
    }
  }
  EXPECT_GE(refused, 7);
}

TEST(Settings, DefaultsAreThoseOfAProblem) {
  const std::pair<const char*, const char*> defaults[] = {
      {"planner", "Connect"}, {"time", "5"},      {"iterations", "0"},  {"seed", "1"},
      {"push", "true"},       {"step", "0.05"},   {"corners", "blend"}, {"objective", "length"},
      {"keep", ""},           {"velocities", ""}, {"start", ""},        {"clearance_of", ""}};
  for (const auto& [name, value] : defaults)
    EXPECT_EQ(settingDefault(*findSetting(name)), value) << name;
}

}  // namespace
}  // namespace leeway::planner
