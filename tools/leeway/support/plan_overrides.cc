#include "tools/leeway/support/plan_overrides.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <variant>
#include <vector>

#include "leeway/planner/planners.h"
#include "leeway/planner/settings.h"
#include "leeway/robots/text.h"
#include "planner/space/ompl_planners.h"
#include "planner/validate/checks.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/terminal.h"

namespace leeway::tools {
namespace {

// Limits of --time [s]: about a clock tick, and thirty years.
constexpr double kLeastTime = 1e-6;
constexpr double kMostTime = 1e9;

/// Returns the fault of a seed's text; else empty. CLI11 alone would accept -1 as the largest seed.
std::string seedError(const std::string& text) {
  std::uint64_t seed = 0;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, seed);
  return read.ec == std::errc() && read.ptr == end
             ? ""
             : fmt::format("'{}' is not a whole number from 0 to 18446744073709551615", text);
}

}  // namespace

void addSeed(CLI::App& app, const char* help, std::uint64_t& seed) {
  app.add_option("--seed", seed, help)->check(seedError)->type_name("N")->capture_default_str();
}

void addSamples(CLI::App& app, const char* help, int& samples, std::uint64_t& seed) {
  app.add_option("--samples", samples, help)
      ->type_name("N")
      ->check(countFrom(0, 1'000'000'000))
      ->capture_default_str();
  addSeed(app, "seed of the samples", seed);
}

CLI::Validator numberFrom(double lower, double upper) {
  return {[lower, upper](const std::string& text) {
            const std::optional<double> value = robots::parseFinite(text);
            return value && *value >= lower && *value <= upper
                       ? std::string()
                       : fmt::format("{} is not a number from {} to {}", text, lower, upper);
          },
          ""};
}

CLI::Validator countFrom(std::int64_t lower, std::int64_t upper) {
  return {[lower, upper](const std::string& text) {
            std::int64_t value = 0;
            const char* end = text.data() + text.size();
            const auto read = std::from_chars(text.data(), end, value);
            return read.ec == std::errc() && read.ptr == end && value >= lower && value <= upper
                       ? std::string()
                       : fmt::format("{} is not a whole number from {} to {}", text, lower, upper);
          },
          ""};
}

namespace {

/// The placeholder of an option's value in the help: "METRES".
std::string valueName(const planner::Setting& setting) {
  if (setting.unit == "m") return "METRES";
  if (setting.unit == "s") return "SECONDS";
  if (std::holds_alternative<planner::SettingPlace<double>>(setting.value)) return "SHARE";
  if (!std::holds_alternative<planner::SettingPlace<std::string>>(setting.value)) return "N";
  std::string name(setting.name);  // PLANNER, which completions use
  for (char& c : name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

std::string numberError(const std::string& text) {
  return robots::parseNumber(text) ? "" : fmt::format("{} is not a number", text);
}

/// Checks the text of an option before the problem is known.
CLI::Validator validatorOf(const planner::Setting& setting) {
  if (setting.name == "time") return numberFrom(kLeastTime, kMostTime);
  if (const auto* choice = std::get_if<planner::WordSetting>(&setting.value)) {
    std::vector<std::string> words;
    for (const planner::WordSetting::Word& word : choice->words) words.emplace_back(word.text);
    return CLI::IsMember(words);
  }
  if (std::holds_alternative<planner::SettingPlace<std::uint64_t>>(setting.value))
    return {seedError, ""};
  if (std::holds_alternative<planner::SettingPlace<std::int64_t>>(setting.value))
    return countFrom(static_cast<std::int64_t>(setting.range.lower));
  if (std::holds_alternative<planner::SettingPlace<double>>(setting.value))
    return {numberError, ""};
  return {[](const std::string&) { return std::string(); }, ""};
}

/// Adds the option of a setting. `more`: a further sentence of its help.
void addSetting(CLI::App& app, const planner::Setting& setting, PlanOverrides& overrides,
                const std::string& more = "") {
  const std::string option(setting.option), name(setting.name);
  std::string help(setting.help);
  help[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(help[0])));
  if (!setting.unit.empty())  // after the first sentence
    help.insert(std::min(help.find(". "), help.size()), fmt::format(" [{}]", setting.unit));
  help += more;
  if (std::holds_alternative<planner::SettingPlace<bool>>(setting.value)) {
    const bool is_on = !option.starts_with("--no-");
    app.add_flag_callback(
        option, [&overrides, name, is_on] { overrides.given[name] = is_on ? "true" : "false"; },
        is_on ? help : "do not " + help);
    return;
  }
  CLI::Option* const added = app.add_option_function<std::string>(
      option, [&overrides, name](const std::string& text) { overrides.given[name] = text; }, help);
  if (!std::holds_alternative<planner::WordSetting>(setting.value))
    added->type_name(valueName(setting));
  added->check(validatorOf(setting));
}

}  // namespace

void addUpright(CLI::App& app, PlanOverrides& overrides) {
  app.add_option("--upright", overrides.upright,
                 "constraint: on the whole path, AXIS (x, y, z, or the opposite nx, ny, nz) of a "
                 "frame, link or held object points up to within RADIANS")
      ->type_name("FRAME AXIS RADIANS")
      ->expected(3);
}

void addRunLimits(CLI::App& app, PlanOverrides& overrides) {
  addSetting(app, *planner::findSetting("seed"), overrides);
  addSetting(app, *planner::findSetting("time"), overrides,
             "; reading may take as long before it, and ten seconds at least");
}

void addTerms(CLI::App& app, PlanOverrides& overrides) {
  for (const char* const name : {"keep", "speed", "acceleration_scale", "jerk_scale"})
    addSetting(app, *planner::findSetting(name), overrides);
  addUpright(app, overrides);
}

void addPlanOverrides(CLI::App& app, PlanOverrides& overrides) {
  addRunLimits(app, overrides);
  for (const planner::Setting& setting : planner::settings())
    if (!setting.option.empty() && setting.name != "seed" && setting.name != "time")
      addSetting(app, setting, overrides);
  app.add_option("--hinge", overrides.hinge,
                 "minimise the integral of 1 - d / M over the part of the path whose clearance d "
                 "from the world is below M [m]")
      ->type_name("M")
      ->check(numberFrom(1e-9, 1e9));
  app.add_option("--inverse", overrides.inverse,
                 "minimise the integral of M / d, limited to 1, over the whole path")
      ->type_name("M")
      ->check(numberFrom(1e-9, 1e9));
  app.add_option("--length-weight", overrides.length_weight,
                 "weight of the path's length in addition to --hinge or --inverse; 0 by default")
      ->type_name("W")
      ->check(numberFrom(0, 1e9));
  addUpright(app, overrides);
  app.add_option(
         "--certificate", overrides.certificate,
         "accuracy of the clearance; every edge is proven in both cases. path: the least clearance "
         "of the path, to 30 %; full: that of each edge, to 0.1 mm, which may take longer")
      ->check(CLI::IsMember({"path", "full"}));
}

planner::PlanOptions planOptions(const PlanOverrides& overrides, const planner::Problem& problem) {
  planner::PlanOptions options = interactivePlanOptions({}, problem.limits.time);
  if (overrides.certificate == "full") options.detail = planner::CertificateDetail::kEveryEdge;
  return options;
}

namespace {

bool hasObjectiveOption(const PlanOverrides& overrides) {
  return std::any_of(overrides.given.begin(), overrides.given.end(), [](const auto& given) {
    return planner::findSetting(given.first)->key.starts_with("objective");
  });
}

/// Applies --hinge, --inverse and --length-weight, which form an objective.
void applyCost(const PlanOverrides& overrides, planner::Problem& problem) {
  if (!overrides.hinge && !overrides.inverse) {
    if (overrides.length_weight)
      badUsage(fmt::format("--length-weight {}: --hinge or --inverse is expected beside it",
                           *overrides.length_weight));
    return;
  }
  if ((overrides.hinge && overrides.inverse) || hasObjectiveOption(overrides))
    badUsage(
        "--hinge and --inverse are objectives of their own: one of them is expected, and none of "
        "--objective, --keep and --at-most-longer");
  planner::CostTerm term;
  if (overrides.inverse) term.nearness.kind = planner::Nearness::Kind::kInverse;
  term.nearness.distance = overrides.inverse ? *overrides.inverse : *overrides.hinge;
  problem.objective = planner::MinimumCost{overrides.length_weight.value_or(0), {term}};
}

/// Applies --upright, a constraint in addition to the problem's.
void applyUpright(const PlanOverrides& overrides, planner::Problem& problem) {
  if (overrides.upright.empty()) return;
  const std::string &axis = overrides.upright[1], text = overrides.upright[2];
  const auto refuse = [&](const std::string& why) {
    badUsage(fmt::format("--upright {}: {}", fmt::join(overrides.upright, " "), why));
  };
  const std::size_t sign = axis.starts_with('n') ? 1 : 0;
  const std::size_t place = std::string_view("xyz").find(axis.substr(sign));
  if (axis.size() != sign + 1 || place == std::string_view::npos)
    refuse(fmt::format("'{}' is no axis; x, y, z, nx, ny or nz is expected", axis));
  const std::optional<double> angle = robots::parseFinite(text);
  if (!angle) refuse(fmt::format("'{}' is no number; an angle in radians is expected", text));
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  up[static_cast<Eigen::Index>(place)] = sign == 1 ? -1 : 1;
  problem.constraints.push_back(planner::upright(overrides.upright[0], up, *angle));
  problem.constraints.back().name = "--upright";
  if (const auto fault =
          planner::constraintFault(problem, problem.constraints.back(), "the constraint"))
    refuse(fault->message);
  if (const auto fault = planner::constraintsFault(problem)) refuse(*fault);
}

/// Leaves --improve out where it has no effect, with a warning, because a batch may mix problems.
void leaveOutImprove(const PlanOverrides& overrides, planner::Problem& problem) {
  const auto improve = overrides.given.find("improve");
  if (improve == overrides.given.end() || planner::parameterNumber(improve->second) == 0.0) return;
  std::string why;
  if (planner::findPlanner(problem.planner.name) != planner::findPlanner("Connect"))
    why = fmt::format(
        "{} has no such time; Connect has, and planners that optimise go on for all of --time",
        problem.planner.name);
  else if (planner::improveFault(problem))
    why =
        "only paths of the objective length, without wishes, become shorter; others take all of "
        "--time";
  else if (planner::isConstrained(problem) || !overrides.upright.empty())
    why = "it keeps no constraints";
  if (why.empty()) return;
  problem.planner.parameters.erase("improve");
  problem.warnings.push_back(fmt::format("--improve {} is left out: {}", improve->second, why));
}

/// The value of a text that the option's validator has accepted.
template <class Integer>
Integer wholeNumber(const std::string& text) {
  Integer value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// Puts the text of a setting, which the option's validator has accepted, into a problem.
struct Apply {
  const planner::Setting& setting;
  const std::string& text;
  planner::Problem& problem;

  void operator()(planner::SettingPlace<bool> place) const { *place(problem) = text == "true"; }
  void operator()(planner::SettingPlace<double> place) const {
    double* const value = place(problem);
    const double number = robots::parseNumber(text).value();
    if (value == nullptr || planner::numberFault(setting, "", number))
      badUsage(fmt::format(
          "{} {}: {} is expected{}", setting.option, number, planner::expectedNumber(setting),
          setting.objective().empty()
              ? ""
              : fmt::format(", beside the objective {} alone", setting.objective())));
    *value = number;
  }
  void operator()(planner::SettingPlace<std::int64_t> place) const {
    *place(problem) = wholeNumber<std::int64_t>(text);
  }
  void operator()(planner::SettingPlace<std::uint64_t> place) const {
    *place(problem) = wholeNumber<std::uint64_t>(text);
  }
  void operator()(planner::SettingPlace<std::string> place) const { *place(problem) = text; }
  void operator()(const planner::WordSetting& choice) const {
    for (const planner::WordSetting::Word& word : choice.words)
      if (word.text == text) choice.set(problem, word.value);
  }
  void operator()(planner::PlannerParameterSetting of) const {
    problem.planner.parameters[std::string(of.parameter)] = text;
  }
  template <class Other>
  void operator()(const Other&) const {
    throw std::logic_error(fmt::format("{}: no option can give such a setting", setting.option));
  }
};

}  // namespace

std::optional<double> PlanOverrides::timeLimit() const {
  const auto time = given.find("time");
  return time == given.end() ? std::nullopt : robots::parseNumber(time->second);
}

Json PlanOverrides::json() const {
  Json json = Json::object();
  for (const planner::Setting& setting : planner::settings()) {
    const auto found = given.find(setting.name);
    if (found == given.end()) continue;
    Json& value = json[found->first];
    const std::string& text = found->second;
    if (std::holds_alternative<planner::SettingPlace<bool>>(setting.value))
      value = text == "true";
    else if (std::holds_alternative<planner::SettingPlace<double>>(setting.value))
      value = robots::parseNumber(text).value();
    else if (std::holds_alternative<planner::SettingPlace<std::int64_t>>(setting.value))
      value = wholeNumber<std::int64_t>(text);
    else if (std::holds_alternative<planner::SettingPlace<std::uint64_t>>(setting.value))
      value = wholeNumber<std::uint64_t>(text);
    else
      value = text;
  }
  if (hinge) json["hinge"] = *hinge;
  if (inverse) json["inverse"] = *inverse;
  if (length_weight) json["length_weight"] = *length_weight;
  if (!upright.empty()) json["upright"] = upright;
  if (certificate != "path") json["certificate"] = certificate;
  return json;
}

void apply(const PlanOverrides& overrides, planner::Problem& problem) {
  for (const planner::Setting& setting : planner::settings()) {
    const auto given = overrides.given.find(setting.name);
    if (given == overrides.given.end()) continue;
    // The file's parameters belong to the file's planner.
    if (setting.name == "planner" && given->second != problem.planner.name)
      problem.planner.parameters.clear();
    // --at-most-longer alone implies the objective clearance. --keep alone does not imply length,
    // which is the default: beside another objective in the file, it contradicts the file.
    if (setting.objective() == "clearance" && !overrides.given.contains("objective") &&
        !overrides.given.contains("keep") &&
        !std::holds_alternative<planner::MaximumClearance>(problem.objective))
      problem.objective = planner::MaximumClearance{};
    std::visit(Apply{setting, given->second, problem}, setting.value);
  }
  applyCost(overrides, problem);
  leaveOutImprove(overrides, problem);
  applyUpright(overrides, problem);
}

planner::Problem loadProblem(const ProblemSource& source, const PlanOverrides& overrides) {
  return loadProblem(source, overrides.timeLimit(),
                     [&](planner::Problem& problem) { apply(overrides, problem); });
}

}  // namespace leeway::tools
