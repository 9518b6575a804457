#pragma once

#include <optional>
#include <string>

#include "leeway/planner/plan.h"
#include "leeway/planner/trajectory.h"
#include "leeway/planner/verify.h"
#include "planner/execute/unchecked_json.h"
#include "tools/view/base/json_text.h"

namespace leeway::tools {

/// The bounds that are proven for constraints along a path.
Json constraintsJson(const std::vector<planner::ConstraintResult>& results);
/// The document of `plan --json`. `trajectory`: for a solved problem. `load_s`: the time in which
/// the files were read [s].
Json toJson(const planner::Problem& problem, const planner::PlanResult& result,
            const std::optional<planner::Trajectory>& trajectory, double load_s);
/// The document of `verify --json`.
Json toJson(const planner::VerifyResult& result);
const char* toString(planner::VerifyStatus status);  ///< "certified", "refuted", ...

/// The version of all documents that the command prints (docs/json.md). It rises when a key is
/// removed or changes its meaning, not when a key is added.
constexpr int kJsonVersion = 1;
/// The object with `version` as its first key.
Json versioned(const Json& document);

/// Prints versioned() to stdout: one line, or an indented document if stdout is a terminal.
void printJson(const Json& document);

}  // namespace leeway::tools
