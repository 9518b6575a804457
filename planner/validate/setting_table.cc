// The table of settings.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "collision/base/numbers.h"
#include "leeway/planner/settings.h"
#include "planner/base/tolerances.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

using P = Problem;
using Range = NumberRange;

constexpr Range kZeroOrMore{.lower = 0, .expected = "zero or more"};
constexpr Range kZeroToEndless{.lower = 0, .upper = kInfinity, .expected = "zero or more"};
constexpr Range kAboveZero{.lower = 0, .expected = "a number above 0", .above = true};
constexpr Range kMotionLimit{kLeastLimit, kMostLimit, "a number from {} to {}"};

template <auto place>
constexpr WordSetting words(std::span<const WordSetting::Word> known) {
  using Word = std::remove_pointer_t<decltype(place(std::declval<P&>()))>;
  return {known,
          [](const P& p) {
            const Word* const word = settingValue<Word>(p, place);
            return word == nullptr ? -1 : static_cast<int>(*word);
          },
          [](P& p, int value) {
            if (Word* const word = place(p)) *word = static_cast<Word>(value);
          }};
}

template <class Enum>
constexpr int valueOf(Enum word) {
  return static_cast<int>(word);
}

constexpr WordSetting::Word kObjectiveWords[] = {{"length", 0}, {"clearance", 1}};
constexpr WordSetting::Word kPairsWords[] = {{"world", valueOf(Pairs::kWorld)},
                                             {"all", valueOf(Pairs::kAll)}};
constexpr WordSetting::Word kCornersWords[] = {{"stop", valueOf(Corners::kStop)},
                                               {"blend", valueOf(Corners::kBlend)}};
constexpr WordSetting::Word kForesightWords[] = {{"motion", valueOf(Foresight::kMotion)},
                                                 {"speed_bound", valueOf(Foresight::kSpeedBound)}};

MaximumClearance* clearanceOf(P& p) { return std::get_if<MaximumClearance>(&p.objective); }
Pairs* pairsOf(P& p) { return clearanceOf(p) == nullptr ? nullptr : &clearanceOf(p)->of; }
Corners* cornersOf(P& p) { return &p.execution.corners; }
Foresight* foresightOf(P& p) { return &p.execution.foresight; }

constexpr WordSetting kObjectiveChoice{
    kObjectiveWords, [](const P& p) { return static_cast<int>(p.objective.index()); },
    [](P& p, int index) {
      p.objective = index == 0 ? Objective(MinimumLength()) : Objective(MaximumClearance());
    },
    true};

constexpr Setting kSettings[] = {
    {.name = "", .key = "leeway"},
    {.name = "name",
     .key = "name",
     .value = [](P& p) { return &p.name; },
     .help = "Name of the problem in messages and results. A file's own name stands in for it"},
    {.name = "", .key = "robot"},
    {.name = "", .key = "body"},
    {.name = "world", .key = "", .help = "What surrounds the robot. Setting it copies"},
    {.name = "frames",
     .key = "frames",
     .help = "Frames fixed to links, for poses: {name: (link, pose)}, see FramePose"},
    {.name = "others",
     .key = "joints",
     .help = "Values of the joints that are not planned: {joint: value}"},
    {.name = "start",
     .key = "start",
     .help = "The planned joints' values at the start: (joints,) [rad or m], a group state's name, "
             "or a dict by joint. Poses become the valid values that are nearest to what the start "
             "was"},
    {.name = "goal",
     .key = "goal",
     .help = "The first goal: a group state's name, values, (from, to) or 'any' in place of a "
             "value, ranges (joints, 2), or FramePoses. Setting it replaces all goals"},
    {.name = "goals", .key = "goals", .help = "A list of goals; reaching any one will do"},
    {.name = "", .key = "objects"},
    {.name = "allowed",
     .key = "allowed",
     .help = "Pairs (a, b) that may touch, besides those of the SRDF; names as in `margins`, "
             "except 'world'. 'auto', in their place or among them, is the pairs of links that "
             "touch with all joints at zero (MJCF: qpos0), or at the nearest limit"},
    {.name = "checked",
     .key = "checked",
     .help = "Pairs (a, b) of links that are checked although a joint connects them, the SRDF "
             "disables them or they always touch. Not also in `allowed`"},
    {.name = "margin",
     .key = "margin",
     .unit = "m",
     .value = [](P& p) { return &p.margins.common; },
     .help = "All pairs stay farther apart than this. A negative margin allows that much overlap",
     .member = "margins.common"},
    {.name = "margins",
     .key = "margins",
     .help = "Pairs with a margin of their own: {(a, b): margin} [m]; a and b are names, tuples of "
             "names, 'robot', or 'world', which is all objects, also those that come later. The "
             "last entry that names a pair wins"},
    {.name = "wishes",
     .key = "margins",
     .help = "Clearances that pairs keep where that is not too dear: {(a, b): clearance} or {(a, "
             "b): (clearance, weight)} [m]; names as in `margins`. Missing one costs its weight, 1 "
             "by default, times the integral of 1 - d / clearance over the path's length, where "
             "the pair's clearance d is below it. Not with the objective clearance"},
    {.name = "steps",
     .key = "steps",
     .help = "A task in place of goals: TaskSteps, one after the other"},
    {.name = "", .key = "waypoints"},
    {.name = "constraints",
     .key = "constraints",
     .help = "What frames keep on all of a path, proven everywhere: Constraints"},
    {.name = "planner",
     .key = "planner.name",
     .option = "--planner",
     .value = [](P& p) { return &p.planner.name; },
     .help = "Planner by name; `leeway plan --planners` and planners() list them"},
    {.name = "parameters",
     .key = "planner.parameters",
     .value = [](P& p) { return &p.planner.parameters; },
     .help = "Parameters of the planner, by its names"},
    {.name = "workers",
     .key = "planner.parameters.workers",
     .option = "--workers",
     .value = PlannerParameterSetting{"workers"},
     .range = {.lower = 1, .upper = 64},
     .help = "Searches of Connect side by side, 1 by default. Their number decides the answer; the "
             "number of threads does not"},
    {.name = "objective",
     .key = "objective",
     .option = "--objective",
     .value = kObjectiveChoice,
     .help = "What is best: length, the shortest path; clearance, the path whose least clearance "
             "is largest. Files and programs may also give a map of what a path costs"},
    {.name = "improve",
     .key = "planner.parameters.improve",
     .option = "--improve",
     .unit = "s",
     .value = PlannerParameterSetting{"improve"},
     .range = {.lower = 0},
     .help = "How long Connect looks for shorter paths once it has one, within the time limit"},
    {.name = "keep",
     .key = "objective.length.clearance",
     .option = "--keep",
     .unit = "m",
     .value =
         [](P& p) {
           auto* const length = std::get_if<MinimumLength>(&p.objective);
           return length == nullptr ? nullptr : &length->clearance;
         },
     .range = {.lower = 0, .expected = "zero or more", .none = -kInfinity},
     .help = "With the objective length: the path keeps this clearance from the world, besides the "
             "margins",
     .member = "objective.clearance"},
    {.name = "clearance_of",
     .key = "objective.clearance.of",
     .value = words<pairsOf>(kPairsWords),
     .help = "With the objective clearance: which clearance is maximised. world: from the world; "
             "all: also of the robot from itself. Other pairs keep their margins"},
    {.name = "at_most_longer",
     .key = "objective.clearance.at_most_longer",
     .option = "--at-most-longer",
     .value = [](P& p) { return clearanceOf(p) ? &clearanceOf(p)->at_most_longer : nullptr; },
     .range = {.lower = 0, .expected = "zero or more", .none = kInfinity},
     .help = "With the objective clearance: how much longer than the shortest path found the path "
             "may be. 0.2 means 20 %",
     .member = "objective.at_most_longer"},
    {.name = "", .key = "moveit"},
    {.name = "", .key = "bounds"},
    {.name = "", .key = "deforming"},
    {.name = "", .key = "groups"},
    {.name = "", .key = "replace_srdf"},
    {.name = "", .key = "meshes"},
    {.name = "simplify",
     .key = "simplify",
     .value = [](P& p) { return &p.planner.simplify; },
     .help = "Shorten the path that is found"},
    {.name = "push",
     .key = "push",
     .option = "--no-push",
     .value = [](P& p) { return &p.planner.push; },
     .help = "Push a simplified path away from what it is close to, by up to 8 mm, for at most 3 % "
             "more length"},
    {.name = "time",
     .key = "limits.time",
     .option = "--time",
     .unit = "s",
     .value = [](P& p) { return &p.limits.time; },
     .range = kZeroToEndless,
     .help = "Time limit of the run; in files and programs 0 means none"},
    {.name = "iterations",
     .key = "limits.iterations",
     .option = "--iterations",
     .value = [](P& p) { return &p.limits.iterations; },
     .range = kZeroOrMore,
     .help = "Limit of the planner's iterations, 0 for none"},
    {.name = "seed",
     .key = "seed",
     .option = "--seed",
     .value = [](P& p) { return &p.seed; },
     .help = "Seed of the run. The same problem, seed and iteration limit give the same answer"},
    {.name = "start_time",
     .key = "execution.start",
     .unit = "s",
     .value = [](P& p) { return &p.execution.start; },
     .range = {.expected = "a finite number of seconds"},
     .help = "Time of the obstacles' motions at which execution begins. Plans, checks and proofs "
             "look at the world of this time"},
    {.name = "step",
     .key = "execution.step",
     .unit = "s",
     .value = [](P& p) { return &p.execution.step; },
     .range = kAboveZero,
     .help = "Time from one look at the world to the next"},
    {.name = "duration",
     .key = "execution.duration",
     .unit = "s",
     .value = [](P& p) { return &p.execution.duration; },
     .range = {.lower = 0, .upper = kInfinity, .expected = "", .above = true},  // executionFault()
     .help = "An execution that has not reached a goal within this has failed"},
    {.name = "speed",
     .key = "execution.speed",
     .option = "--speed",
     .value = [](P& p) { return &p.execution.speed; },
     .range = {kLeastLimit, 1, "a share of the velocity limits, {} up to {},"},
     .help = "Share of the velocity limits that is used"},
    {.name = "velocities",
     .key = "execution.velocities",
     .unit = "rad/s or m/s",
     .value = [](P& p) { return &p.execution.velocities; },
     .range = kMotionLimit,
     .help = "Velocity limits in place of the robot's, by joint, or one number for all. Where "
             "neither gives one, it is 1"},
    {.name = "accelerations",
     .key = "execution.accelerations",
     .unit = "rad/s^2 or m/s^2",
     .value = [](P& p) { return &p.execution.accelerations; },
     .range = kMotionLimit,
     .help = "Acceleration limits, by joint, or one number for all. By default the robot's "
             "(joint_limits), else the velocity limit is reached in half a second"},
    {.name = "jerks",
     .key = "execution.jerks",
     .unit = "rad/s^3 or m/s^3",
     .value = [](P& p) { return &p.execution.jerks; },
     .range = kMotionLimit,
     .help = "Jerk limits, by joint, or one number for all. By default the robot's "
             "(joint_limits), else there are none"},
    {.name = "acceleration_scale",
     .key = "execution.acceleration_scale",
     .option = "--acceleration-scale",
     .value = [](P& p) { return &p.execution.acceleration_scale; },
     .range = {kLeastLimit, 1, "a share of the acceleration limits, {} up to {},"},
     .help = "Share of the acceleration limits that is used"},
    {.name = "jerk_scale",
     .key = "execution.jerk_scale",
     .option = "--jerk-scale",
     .value = [](P& p) { return &p.execution.jerk_scale; },
     .range = {kLeastLimit, 1, "a share of the jerk limits, {} up to {},"},
     .help = "Share of the jerk limits that is used"},
    {.name = "corners",
     .key = "execution.corners",
     .option = "--corners",
     .value = words<cornersOf>(kCornersWords),
     .help = "What a timed path does at its corners: stop, or blend, which cuts them where the cut "
             "is proven to keep the margins"},
    {.name = "foresight",
     .key = "execution.foresight",
     .value = words<foresightOf>(kForesightWords),
     .help = "What is known about obstacles after the last look. motion: their motion; "
             "speed_bound: only a bound on their speed"},
    {.name = "look_ahead",
     .key = "execution.look_ahead",
     .unit = "s",
     .value = [](P& p) { return &p.execution.look_ahead; },
     .range = kZeroOrMore,
     .help = "The motion or rest that should be certified beyond each step"},
    {.name = "buffer",
     .key = "execution.buffer",
     .unit = "m",
     .value = [](P& p) { return &p.execution.buffer; },
     .range = kZeroOrMore,
     .help = "Distance that paths keep from deforming obstacles in addition to the margin, where "
             "possible"},
    {.name = "patience",
     .key = "execution.patience",
     .unit = "s",
     .value = [](P& p) { return &p.execution.patience; },
     .range = kZeroToEndless,
     .help = "How long to wait for a valid path that cannot be executed now, before planning "
             "another"},
};

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

}  // namespace

std::span<const Setting> settings() { return kSettings; }

const Setting* findSetting(std::string_view name) {
  const auto* const found =
      std::find_if(std::begin(kSettings), std::end(kSettings),
                   [&](const Setting& s) { return !name.empty() && s.name == name; });
  return found == std::end(kSettings) ? nullptr : found;
}

std::string_view Setting::objective() const {
  constexpr std::string_view kHead = "objective.";
  if (!key.starts_with(kHead)) return {};
  const std::string_view rest = key.substr(kHead.size());
  return rest.substr(0, rest.find('.'));
}

bool Setting::isOptional() const { return range.none.has_value() || !objective().empty(); }

std::string settingDefault(const Setting& setting) {
  const Problem plain;
  if (setting.isOptional()) return {};
  return std::visit(
      Overloaded{
          [&](SettingPlace<bool> place) { return fmt::format("{}", *settingValue(plain, place)); },
          [&](SettingPlace<double> place) {
            return fmt::format("{}", *settingValue(plain, place));
          },
          [&](SettingPlace<std::int64_t> place) {
            return fmt::format("{}", *settingValue(plain, place));
          },
          [&](SettingPlace<std::uint64_t> place) {
            return fmt::format("{}", *settingValue(plain, place));
          },
          [&](SettingPlace<std::string> place) { return *settingValue(plain, place); },
          [&](const WordSetting& choice) {
            for (const WordSetting::Word& word : choice.words)
              if (word.value == choice.get(plain)) return std::string(word.text);
            return std::string();
          },
          [](const auto&) { return std::string(); }},
      setting.value);
}

std::string expectedNumber(const Setting& setting) {
  const NumberRange& range = setting.range;
  return fmt::format(fmt::runtime(range.expected), range.lower, range.upper);
}

std::optional<std::string> numberFault(const Setting& setting, std::string_view where,
                                       double value) {
  const NumberRange& range = setting.range;
  if (range.expected.empty()) return std::nullopt;
  if (value >= range.lower && value <= range.upper && !(range.above && value <= range.lower))
    return std::nullopt;
  return fmt::format("{} is {}; {} is expected", where, value, expectedNumber(setting));
}

std::optional<std::string> numbersFault(const Problem& problem) {
  for (const Setting& setting : kSettings) {
    const std::string_view where = setting.member.empty() ? setting.key : setting.member;
    std::optional<std::string> fault;
    if (const auto* place = std::get_if<SettingPlace<double>>(&setting.value)) {
      const double* const value = settingValue(problem, *place);
      if (value != nullptr && *value != setting.range.none)
        fault = numberFault(setting, where, *value);
    } else if (const auto* whole = std::get_if<SettingPlace<std::int64_t>>(&setting.value)) {
      fault = numberFault(setting, where, static_cast<double>(*settingValue(problem, *whole)));
    }
    if (fault) return fault;
  }
  return std::nullopt;
}

}  // namespace leeway::planner
