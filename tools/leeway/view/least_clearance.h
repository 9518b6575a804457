#pragma once

#include <functional>
#include <string>
#include <vector>

#include "leeway/planner/plan.h"
#include "tools/leeway/view/stages.h"

namespace leeway::tools::view {

/// The least clearances of a path, as they are shown to people: of all pairs, of those with the
/// world, and of the robot with itself.
struct LeastClearance {
  planner::PathClearance all, world, self;
};

/// Refines the least clearances until both ends of each interval round to the same figure
/// (figureOf() in terminal.h), as far as ten seconds of counted work go. `stages`: of `edges.path`.
/// Depends on path and problem alone, so that all verbs show the same figures. `stop`: true ends it
/// with wider intervals. Segments and t are those of the path that `edges` were made of.
LeastClearance leastClearance(const std::vector<Stage>& stages, const planner::PathEdges& edges,
                              const std::function<bool()>& stop = {});

/// The same of a path from a file or a plan. Compiles the problem. Throws robots::InputError for a
/// path that does not have the problem's steps.
LeastClearance leastClearance(const planner::Problem& problem, const planner::Path& path,
                              const std::function<bool()>& stop = {});

/// Intersects the intervals with others of the same path: of all pairs, the world and itself.
void narrow(LeastClearance& least, const planner::PathClearance& all,
            const planner::PathClearance& world, const planner::PathClearance& self);

/// Sentences, a line each: where the path is nearest to the world, and to itself.
std::string nearestText(const LeastClearance& least);
/// The figure of the first line of text: "least clearance 10.57 mm"; or that nothing is near.
std::string leastText(const LeastClearance& least);

}  // namespace leeway::tools::view
