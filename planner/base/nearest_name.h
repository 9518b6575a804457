#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace leeway::planner {

/// What a message says to who mistyped a name: "; did you mean 'NAME'?" when one of `known` is
/// near, otherwise "; known: a, b, c" (the first twelve), or "; there is none" for an empty list.
/// O(known x length^2).
std::string nearestName(std::string_view name, const std::vector<std::string>& known);

}  // namespace leeway::planner
