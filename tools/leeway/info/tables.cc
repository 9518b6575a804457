#include "tools/leeway/info/tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "tools/leeway/support/terminal.h"
#include "tools/view/base/figures.h"

namespace leeway::tools::info {
namespace {

std::string limitText(const Json& value) {
  return value.is_null() ? "-" : fmt::format("{:.4f}", value.get<double>());
}

void printClouds(const Json& problem) {
  for (const auto& cloud : problem["clouds"]) {
    fmt::print("cloud {}: {} balls of up to {} mm; unseen space is {}\n",
               cloud["name"].get<std::string>(), cloud["balls"].get<std::size_t>(),
               formatUpper(cloud["largest_radius"].get<double>() * 1e3, 3),
               cloud["unseen"].get<std::string>());
    for (const auto& filter : cloud["filters"]) {
      fmt::print("  {}: {} removed, {}\n", filter["name"].get<std::string>(),
                 filter["removed"].get<std::size_t>(), filter["what"].get<std::string>());
    }
  }
  if (!problem["clouds"].empty()) {
    fmt::print("\n");
  }
}

/// When verbs see obstacles that move.
void printExecution(const Json& problem) {
  const Json& e = problem["execution"];
  fmt::print(
      "{}\n",
      wrapped(fmt::format(
          "everything but replan and guard sees them as they are at {} s; replan looks every "
          "{} s, for {} s at most, and knows their {}\n",
          e["start"].get<double>(), e["step"].get<double>(), e["duration"].get<double>(),
          e["foresight"] == "motion" ? "motion" : "speed bound")));
}

/// A bound on a speed, without the rounding that it has added.
std::string speedText(double speed) { return formatUpper(speed * (1 - 1e-9), 3); }

void printMoving(const Json& problem) {
  if (problem["moving"].empty()) {
    return;
  }
  std::vector<std::vector<std::string>> rows;
  for (const auto& o : problem["moving"]) {
    const Json& speed = o["speed_bound"];
    const std::string motion = o["motion"];
    rows.push_back({o["name"],
                    motion == "seen"   ? fmt::format("seen {:g} s before", o["age"].get<double>())
                    : motion == "keys" ? counted(o["keys"].get<std::size_t>(), "key")
                                       : motion,
                    speed.is_null() ? "-" : speedText(speed.get<double>())});
  }
  fmt::print("{}", formatTable({"moving", "motion", "points at most [m/s]"}, rows, {2}));
  if (problem["deforming"].empty()) {
    printExecution(problem);
  }
}

void printDeforming(const Json& problem) {
  if (problem["deforming"].empty()) {
    return;
  }
  std::vector<std::vector<std::string>> rows;
  for (const auto& o : problem["deforming"]) {
    const Json& speed = o["speed_bound"];
    rows.push_back(
        {o["name"], o["motion"], o["triangles"].dump(),
         speed.is_null() ? "-" : speedText(speed.get<double>()),
         o["strategy"].get<std::string>() + " (" + o["reason"].get<std::string>() + ")"});
  }
  fmt::print("{}", formatTable({"deforming", "motion", "triangles", "at most [m/s]", "strategy"},
                               rows, {1, 4}));
  printExecution(problem);
}

/// The number of rows of tables that fit on a screen of 24 lines beside all else.
constexpr std::size_t kRows = 9;

/// The edges of a shape's box in mm: "120 x 80 x 300".
std::string sizeText(const Json& size) {
  std::string text;
  for (const Json& edge : size)
    text += fmt::format("{}{:.4g}", text.empty() ? "" : " x ", edge.get<double>() * 1e3);
  return text;
}

/// How many of `rows` are not shown.
std::size_t moreThanShown(std::size_t rows, bool all) {
  return all || rows <= kRows + 1 ? 0 : rows - kRows;
}

/// Prints the first of many rows, and the number of the others.
void printRows(const std::vector<std::string>& heading, std::vector<std::vector<std::string>> rows,
               const std::vector<std::size_t>& left, bool all) {
  const std::size_t more = moreThanShown(rows.size(), all);
  rows.resize(rows.size() - more);
  fmt::print("{}", formatTable(heading, rows, left));
  if (more > 0) fmt::print("and {} more (--all)\n", more);
}

void printPairs(const char* text, const Json& pairs, bool all) {
  if (pairs.empty()) {
    return;
  }
  if (!all) {
    fmt::print("{}: {} (--all)\n", text, counted(pairs.size(), "pair"));
    return;
  }
  fmt::print("{}:\n", text);
  std::map<std::string, std::string> partners;
  for (const auto& pair : pairs) {
    partners[pair[0].get<std::string>()] += " " + pair[1].get<std::string>();
  }
  for (const auto& [name, others] : partners) {
    fmt::print("{}", wrapped(fmt::format("  {} with{}\n", name, others)));
  }
}

}  // namespace

void printRobot(const Json& robot, bool all) {
  std::string joints;
  for (const auto& [type, count] : robot["joints"].items()) {
    joints += fmt::format("{}{} {}", joints.empty() ? "" : ", ", count.get<int>(), type);
  }
  const std::size_t mimic = robot["mimic_joints"];
  fmt::print("{}",
             wrapped(fmt::format("robot {}: {}; joints: {}{}\n", robot["name"].get<std::string>(),
                                 counted(robot["links"].get<std::size_t>(), "link"), joints,
                                 mimic == 0 ? ""
                                            : fmt::format("; {} of them {}", mimic,
                                                          mimic == 1 ? "mimics" : "mimic"))));
  std::vector<std::vector<std::string>> rows;
  for (const auto& variable : robot["variables"]) {
    rows.push_back({variable["name"], limitText(variable["lower"]), limitText(variable["upper"]),
                    variable["velocity"].is_null() ? "none" : limitText(variable["velocity"])});
  }
  printRows({"variable", "lower", "upper", "velocity"}, rows, {}, all);
  for (const auto& variable : robot["variables"]) {
    const std::string by = variable["narrowed_by"];
    if (!by.empty()) fmt::print("{}: narrowed by {}\n", variable["name"].get<std::string>(), by);
    const std::string wider = variable["widened_by"];
    if (!wider.empty())
      fmt::print("{}: widened by {}\n", variable["name"].get<std::string>(), wider);
  }
  for (const auto& group : robot["groups"]) {
    std::string states;
    for (const auto& state : robot["group_states"]) {
      if (state["group"] == group["name"]) {
        states += (states.empty() ? "; states " : ", ") + state["name"].get<std::string>();
      }
    }
    fmt::print("{}", wrapped(fmt::format("group {}: {}{}\n", group["name"].get<std::string>(),
                                         counted(group["variables"].size(), "variable"), states)));
  }
  fmt::print("pairs of links that the SRDF, MJCF or SDF lets touch: {}\n",
             robot["disabled_pairs"].get<int>());
}

void printProblem(const Json& problem) {
  fmt::print(
      "{}\n",
      wrapped(fmt::format(
          "problem {}: {}, {}, {}, {} attached, margin {:g} mm, {} for {}, {} s, seed {}\n",
          problem["name"].get<std::string>(),
          counted(problem["planned"].size(), "planned variable"),
          counted(problem["goals"].size(), "goal"), counted(problem["objects"].size(), "object"),
          problem["attached"].size(), problem["margin"].get<double>() * 1e3,
          problem["planner"].get<std::string>(), problem["objective"].get<std::string>(),
          problem["time_limit"].get<double>(), problem["seed"].get<std::uint64_t>())));
  printClouds(problem);
  printMoving(problem);
  printDeforming(problem);
}

/// Joins runs of equal rows, such as the boxes of an octree, into one row with their number.
std::vector<std::vector<std::string>> joined(const std::vector<std::vector<std::string>>& rows) {
  constexpr std::size_t kMostAlike = 16;
  std::vector<std::vector<std::string>> shown;
  for (std::size_t i = 0; i < rows.size();) {
    std::size_t alike = 1;
    while (i + alike < rows.size() && rows[i + alike] == rows[i]) ++alike;
    if (alike <= kMostAlike) {
      shown.insert(shown.end(), alike, rows[i]);
    } else {
      shown.push_back(rows[i]);
      shown.back()[1] += fmt::format(", {} times", alike);
    }
    i += alike;
  }
  return shown;
}

/// "8 cylinders, 12 spheres", and the longest edge of a shape's box.
std::string shapesText(const Json& geometries) {
  std::map<std::string, std::size_t> counts;
  double longest = 0;
  std::string owner;
  for (const auto& geometry : geometries) {
    ++counts[geometry["type"].get<std::string>()];
    for (const Json& edge : geometry["size"]) {
      if (edge.get<double>() <= longest) continue;
      longest = edge.get<double>();
      owner = geometry["of"];
    }
  }
  std::string text;
  for (const auto& [type, count] : counts)
    text += fmt::format("{}{} {}{}", text.empty() ? "" : ", ", count, type,
                        count == 1                                   ? ""
                        : type.ends_with('x') || type.ends_with('h') ? "es"
                                                                     : "s");
  if (longest > 0) text += fmt::format("; longest {:.4g} mm ({})", longest * 1e3, owner);
  return text;
}

void printGeometries(const Json& geometries, bool all, bool is_short) {
  std::vector<std::vector<std::string>> rows;
  std::string pieces;
  std::vector<std::string> open;
  const auto field = [](const Json& json, const char* key) {
    return json.contains(key) ? json[key].dump() : std::string();
  };
  for (const auto& geometry : geometries) {
    const std::string owner = geometry["of"];
    const bool mesh = geometry.contains("hull_excess");
    const std::string excess = mesh && !geometry["hull_excess"].is_null()
                                   ? formatUpper(geometry["hull_excess"].get<double>() * 1e3, 3)
                                   : std::string();
    rows.push_back({owner, geometry["type"], field(geometry, "vertices"),
                    field(geometry, "triangles"), excess,
                    mesh ? fmt::format("{} of {}", field(geometry, "closed_components"),
                                       field(geometry, "components"))
                         : "",
                    sizeText(geometry["size"])});
    if (!mesh) {
      continue;
    }
    const std::string name =
        geometry["name"].get<std::string>().empty() ? "mesh" : geometry["name"].get<std::string>();
    for (const auto& component : geometry["open"]) {
      open.push_back(fmt::format("  {} of {}: component {}, {} triangles\n", name, owner,
                                 component["component"].get<int>(),
                                 component["triangles"].get<int>()));
    }
    const Json& parts = geometry["convex_pieces"];
    pieces += fmt::format("  {} of {}: ", name, owner);
    pieces +=
        parts["used"].get<bool>()
            ? fmt::format("{} convex pieces and {} triangles, excess {} mm\n",
                          parts["pieces"].get<int>(), parts["loose_triangles"].get<int>(),
                          formatUpper(parts["excess"].get<double>() * 1e3, 6))
            : fmt::format("triangles, no convex pieces ({})\n", parts["reason"].get<std::string>());
  }
  if (!is_short)
    printRows({"of", "shape", "vertices", "triangles", "hull excess [mm]", "closed", "size [mm]"},
              joined(rows), {1}, all);
  fmt::print("{}", wrapped(fmt::format("{}: {}{}\n", counted(geometries.size(), "shape"),
                                       shapesText(geometries), is_short ? " (--all)" : "")));
  if (!pieces.empty() && all) {
    fmt::print("\nqueries of meshes use\n{}", pieces);
  }
  if (!open.empty()) {
    const std::size_t more = moreThanShown(open.size(), all);
    fmt::print("\nnot closed, so surfaces without an inside:\n{}{}",
               fmt::join(open.begin(), open.end() - static_cast<std::ptrdiff_t>(more), ""),
               more > 0 ? fmt::format("and {} more (--all)\n", more) : "");
  }
}

void printCompiled(const Json& compiled, bool all) {
  fmt::print("compiled: {} moving and {} static bodies, {} pairs of shapes kept, {} left out\n",
             compiled["moving_bodies"].get<int>(), compiled["static_bodies"].get<int>(),
             compiled["pairs_kept"].get<int>(), compiled["pairs_dropped"].get<int>());
  for (const auto& [reason, count] : compiled["dropped_by_reason"].items()) {
    fmt::print("  {} left out: {}\n", count.get<int>(), reason);
    // Lists these pairs by name, because they are only assumed to touch.
    if (reason != toString(planner::Unchecked::kTouchSampled)) continue;
    for (const Json& pair : compiled["dropped"])
      if (pair["reason"] == reason)
        fmt::print("    {} with {}\n", pair["a"].get<std::string>(), pair["b"].get<std::string>());
  }
  if (!compiled["nothing_checked"].is_null())
    fmt::print("nothing is checked: {}\n", compiled["nothing_checked"].get<std::string>());
  const std::string samples = compiled["samples"].dump();
  printPairs(("touching at all of " + samples + " random configurations, still checked").c_str(),
             compiled["sampled_always_touching"], all);
  printPairs(("touching at none of " + samples + " random configurations, still checked").c_str(),
             compiled["sampled_never_touching"], all);
}

}  // namespace leeway::tools::info
