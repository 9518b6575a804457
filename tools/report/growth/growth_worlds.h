#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::tools::report {

/// What grows: "boxes", "triangles" or "joints".
const std::vector<std::string>& growthFamilies();
/// The least and the largest count of a family, for messages; the family must be one.
std::pair<std::int64_t, std::int64_t> growthRange(const std::string& family);

/// An arm that turns from one side of a post to the other, with seven more boxes around it. Only
/// one thing grows with `count`:
/// - "boxes": how many there are; the others stand out of the arm's reach;
/// - "triangles": of a wavy ring around the arm's foot, besides the boxes, about so many;
/// - "joints": of the arm, whose links are as much shorter.
/// `count` is held to growthRange(). O(count).
planner::Problem growthProblem(const std::string& family, std::int64_t count);

}  // namespace leeway::tools::report
