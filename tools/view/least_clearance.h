#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "leeway/planner/plan.h"
#include "tools/view/stages.h"

namespace leeway::tools::view {

/// Width of the intervals of single moments [m].
inline constexpr double kMomentTolerance = 1e-6;

/// The least clearances of a path as people see them: of all pairs, of the pairs with the world,
/// and of the robot with itself.
struct LeastClearance {
  planner::PathClearance all, world, self;
};

/// Widths of intervals, tried in turn until both ends round to the same figure [m]. After the last
/// one, a value between two figures is shown as the lower one.
inline constexpr double kFigureWidths[] = {2e-6, 1e-7, 5e-9};
inline constexpr std::int64_t kFigureWork = 1'000'000'000;  ///< of one edge: about a second

/// Refines the least clearances until both ends of each interval round to the same figure
/// (figureOf() in base/figures.h), within a work limit of about ten seconds. `stages`: those of
/// `edges.path`. The result depends only on path and problem, so that all verbs show the same
/// figures. `stop` may return true to accept wider intervals. Segments and t are those of the path
/// from which `edges` were made.
LeastClearance leastClearance(const std::vector<Stage>& stages, const planner::PathEdges& edges,
                              const std::function<bool()>& stop = {});

/// The same for a path from a file or a plan. Compiles the problem. Throws robots::InputError for a
/// path that does not have the problem's steps.
LeastClearance leastClearance(const planner::Problem& problem, const planner::Path& path,
                              const std::function<bool()>& stop = {});

/// Intersects the intervals with other intervals of the same path.
void narrow(LeastClearance& least, const planner::PathClearance& all,
            const planner::PathClearance& world, const planner::PathClearance& self);

/// Sentences, one per line: where the path is nearest to the world and to itself.
std::string nearestText(const LeastClearance& least);
/// The edges of a plan's path and its length: "5 edges, length 3.6338".
std::string lengthText(const planner::PlanResult& result);
/// The clearance for the first line of text: "least clearance 10.57 mm", or that nothing is near.
std::string leastText(const LeastClearance& least);

}  // namespace leeway::tools::view
