#pragma once

// Private to planner/: what loadProblem() needs of those who read the formats of other programs.

#include <map>
#include <memory>
#include <string>

#include "leeway/planner/problem.h"

namespace leeway::planner {

/// An OMPL.app problem (.cfg) of one rigid body in SE(2) or SE(3). Throws robots::InputError,
/// robots::Stopped.
Problem loadOmplApp(const std::string& path, const ProblemOptions& options);

/// Distances that links, and what they hold, keep from the world in MoveIt's scenes: by name [m],
/// above 0. Margins name pairs, so they wait until all objects are known.
using LinkPadding = std::map<std::string, double>;

/// loadMoveit() without applyLinkPadding(): objects may follow.
Problem loadMoveitUnpadded(std::shared_ptr<const robots::Model> model,
                           const std::string& scene_path, const std::string& request_path,
                           const ProblemOptions& options, LinkPadding& padding);

/// Adds margins of the pairs with all objects there are, where they are above the common one.
void applyLinkPadding(const LinkPadding& padding, Problem& problem);

}  // namespace leeway::planner
