#pragma once

// Private to planner/: padding of links in MoveIt's scenes. Margins name pairs, so they wait until
// all objects are known.

#include <map>
#include <memory>
#include <string>

#include "leeway/planner/problem.h"

namespace leeway::planner {

/// Distances that links, and what they hold, keep from the world: by name [m], above 0.
using LinkPadding = std::map<std::string, double>;

/// loadMoveit() without applyLinkPadding(): objects may follow.
Problem loadMoveitUnpadded(std::shared_ptr<const robots::Model> model,
                           const std::string& scene_path, const std::string& request_path,
                           LinkPadding& padding);

/// Adds margins of the pairs with all objects there are, where they are above the common one.
void applyLinkPadding(const LinkPadding& padding, Problem& problem);

}  // namespace leeway::planner
