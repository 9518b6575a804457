#pragma once

#include <string>
#include <vector>

#include "leeway/planner/plan.h"

namespace CLI {
class App;
}

namespace leeway::tools {

/// Adds --shortest, for verbs that read a path.
void addShortest(CLI::App& app, bool& shortest);

/// Moves start and goal of the problem to the ends of `path` where they are within 1e-6 [rad or m,
/// in the space's distance], because paths in single precision miss their ends by about 1e-8. The
/// path itself is judged unchanged. Returns a warning for each end that was moved. Leaves a path
/// whose rows do not have the length of the group to the verifier.
std::vector<std::string> takeNearEnds(const planner::Path& path, planner::Problem& problem);

/// Returns a message for each end of `path` that is farther than that from the problem's start, or
/// from all of its goals. Of a task only the start is looked at.
std::vector<std::string> strayEnds(const planner::Path& path, const planner::Problem& problem);

}  // namespace leeway::tools
