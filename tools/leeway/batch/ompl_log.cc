#include "tools/leeway/batch/ompl_log.h"

#include <fmt/format.h>
#include <ompl/base/PlannerStatus.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

namespace leeway::tools {
namespace {

using ompl::base::PlannerStatus;

PlannerStatus::StatusType statusOf(const Json& line) {
  const std::string status = line.at("status");
  if (status == "solved") return PlannerStatus::EXACT_SOLUTION;
  if (status == "unsolved") return PlannerStatus::TIMEOUT;
  if (status == "invalid_start") return PlannerStatus::INVALID_START;
  if (status == "invalid_goal") return PlannerStatus::INVALID_GOAL;
  return PlannerStatus::UNKNOWN;
}

std::string statusWords() {
  std::string words;
  for (int i = 0; i < PlannerStatus::TYPE_COUNT; ++i)
    words += "|" + PlannerStatus(static_cast<PlannerStatus::StatusType>(i)).asString();
  return words;
}

bool isSolved(const Json& line) { return statusOf(line) == PlannerStatus::EXACT_SOLUTION; }

/// The value below two keys; null if it is missing.
Json at(const Json& line, const char* group, const char* key) {
  if (!line.contains(group) || !line[group].is_object()) return {};
  return line[group].value(key, Json());
}

struct Property {
  const char* name;  ///< and type
  Json (*value)(const Json& line);
};

// Names from OMPL's own benchmarks mean the same here. `time` is what OMPL measures: the time until
// the planner has its path.
const Property kProperties[] = {
    {"time REAL", [](const Json& l) { return at(l, "time_s", "plan"); }},
    {"solved BOOLEAN", [](const Json& l) { return Json(isSolved(l) ? 1 : 0); }},
    {"approximate solution BOOLEAN", [](const Json&) { return Json(0); }},
    {"correct solution BOOLEAN",
     [](const Json& l) { return Json(at(l, "certificate", "certified") == Json(true) ? 1 : 0); }},
    {"status ENUM", [](const Json& l) { return Json(static_cast<int>(statusOf(l))); }},
    {"solution length REAL", [](const Json& l) { return l.value("length", Json()); }},
    {"solution segments INTEGER",
     [](const Json& l) {
       const Json segments = at(l, "certificate", "segments");
       return segments.is_array() ? Json(segments.size()) : Json();
     }},
    {"minimum clearance REAL",
     [](const Json& l) { return at(l, "certificate", "clearance_lower"); }},
    {"simplification time REAL", [](const Json& l) { return at(l, "time_s", "simplify"); }},
    {"improvement time REAL", [](const Json& l) { return at(l, "time_s", "improve"); }},
    {"push time REAL", [](const Json& l) { return at(l, "time_s", "push"); }},
    {"certification time REAL", [](const Json& l) { return at(l, "time_s", "certify"); }},
    {"compile time REAL", [](const Json& l) { return at(l, "time_s", "compile"); }},
    {"iterations INTEGER", [](const Json& l) { return at(l, "counts", "iterations"); }},
    {"graph states INTEGER", [](const Json& l) { return at(l, "counts", "states"); }},
    {"checked edges INTEGER", [](const Json& l) { return at(l, "counts", "edges"); }},
    {"distance queries INTEGER", [](const Json& l) { return at(l, "counts", "distance_queries"); }},
};

/// The log's line of one run. OMPL's script reads empty fields as null.
std::string runOf(const Json& line) {
  std::string text;
  for (const Property& property : kProperties) {
    const Json value = property.value(line);
    text += (value.is_null() ? std::string() : value.dump()) + "; ";
  }
  return text + "\n";
}

std::string hostName() {
  char name[256] = "";
  if (::gethostname(name, sizeof name - 1) != 0 || name[0] == '\0') return "unknown";
  return name;
}

}  // namespace

std::string omplLog(const OmplLogHead& head, const std::vector<Json>& lines) {
  std::vector<std::pair<std::string, std::vector<const Json*>>> planners;
  std::uint64_t seed = 0;
  for (const Json& line : lines) {
    if (!line.contains("planner")) continue;
    const std::string name = line["planner"];
    auto entry = std::find_if(planners.begin(), planners.end(),
                              [&](const auto& other) { return other.first == name; });
    if (entry == planners.end()) {
      if (planners.empty()) seed = line.value("seed", seed);
      entry = planners.insert(entry, {name, {}});
    }
    entry->second.push_back(&line);
  }
  std::size_t runs = 0;
  for (const auto& planner : planners) runs = std::max(runs, planner.second.size());

  std::string text = fmt::format(
      "Leeway version {}\nExperiment {}\nRunning on {}\nStarting at {}\n<<<|\n{}|>>>\n"
      "{} is the random seed\n{} seconds per run\n-1 MB per run\n{} runs per planner\n"
      "{} seconds spent to collect the data\n1 enum type\nstatus{}\n{} planners\n",
      LEEWAY_VERSION, head.experiment, hostName(), head.started, head.setup, seed, head.time_limit,
      runs, head.total_s, statusWords(), planners.size());
  for (const auto& [name, own] : planners) {
    text += fmt::format("{}\n0 common properties\n{} properties for each run\n", name,
                        std::size(kProperties));
    for (const Property& property : kProperties) text += fmt::format("{}\n", property.name);
    text += fmt::format("{} runs\n", own.size());
    for (const Json* line : own) text += runOf(*line);
    text += ".\n";
  }
  return text;
}

}  // namespace leeway::tools
