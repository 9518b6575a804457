#pragma once

#include <string>
#include <vector>

#include "leeway/planner/plan.h"

namespace CLI {
class App;
}

namespace leeway::tools {

/// --shortest, for verbs that read a path.
void addShortest(CLI::App& app, bool& shortest);

/// Paths in single precision miss their ends by some 1e-8. Where an end of `path` is within 1e-6
/// [rad or m, in the space's distance] of start or goal, the problem's becomes that of the path,
/// so that the path is judged as it stands. Returns a warning for each end that was moved. A path
/// whose rows are not as long as the group is left to the verifier.
std::vector<std::string> takeNearEnds(const planner::Path& path, planner::Problem& problem);

}  // namespace leeway::tools
