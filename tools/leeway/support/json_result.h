#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "leeway/planner/plan.h"
#include "leeway/planner/trajectory.h"
#include "leeway/planner/verify.h"

namespace leeway::tools {

using Json = nlohmann::ordered_json;

/// Infinity and NaN become null: where there is nothing to be near, there is no clearance.
Json jsonNumber(double value);
Json jsonVector(const Eigen::Vector3d& v);

/// The clouds of the world, with the number of balls that each filter removed: an answer holds for
/// the rest.
Json cloudsJson(const planner::Problem& problem);

/// The document of `plan --json`. `trajectory`: of a solved problem. `load_s`: what reading the
/// files took [s].
Json toJson(const planner::Problem& problem, const planner::PlanResult& result,
            const std::optional<planner::Trajectory>& trajectory, double load_s);
/// The document of `verify --json`.
Json toJson(const planner::VerifyResult& result);
const char* toString(planner::VerifyStatus status);  ///< "certified", "refuted", ...

/// As text: `indent` -1 for one line. Names and paths that are not UTF-8 are shown with the
/// replacement character, as JSON has no other way.
std::string jsonText(const Json& document, int indent = -1);

/// Of all documents that the command prints (docs/json.md); rises when a key goes or changes its
/// meaning, not when one is added.
constexpr int kJsonVersion = 1;
/// The object with `version` before its keys.
Json versioned(const Json& document);

/// versioned(), one line with a line break, to stdout, or an indented document for people's eyes
/// when stdout is a terminal.
void printJson(const Json& document);

}  // namespace leeway::tools
