#pragma once

// Private to planner/: the readers of other programs' formats, for loadProblem().

#include <map>
#include <memory>
#include <string>

#include "leeway/planner/problem.h"

namespace leeway::planner {

/// Reads an OMPL.app problem (.cfg) of one rigid body in SE(2) or SE(3). Throws robots::InputError,
/// robots::Stopped.
Problem loadOmplApp(const std::string& path, const ProblemOptions& options);

/// Distances from the world that links and their attached objects keep in MoveIt's scenes, by name
/// [m]. All are above 0. They become margins after all objects are known, because margins name
/// pairs.
using LinkPadding = std::map<std::string, double>;

/// loadMoveit() without applyLinkPadding(), because more objects may follow.
Problem loadMoveitUnpadded(std::shared_ptr<const robots::Model> model,
                           const std::string& scene_path, const std::string& request_path,
                           const ProblemOptions& options, LinkPadding& padding);

/// Adds margins for the pairs with all objects where the padding exceeds the common margin.
void applyLinkPadding(const LinkPadding& padding, Problem& problem);

}  // namespace leeway::planner
