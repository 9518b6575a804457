#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::tools::report {

/// The growing quantities: "boxes", "triangles", "joints" or "points".
const std::vector<std::string>& growthFamilies();
/// The least and the largest count of a family, for messages; the family must exist.
std::pair<std::int64_t, std::int64_t> growthRange(const std::string& family);

/// A problem in which an arm turns from one side of a post to the other, with seven more boxes
/// around it. Only one quantity grows with `count`:
/// - "boxes": their number; the additional boxes are out of the arm's reach;
/// - "triangles": approximate number of triangles of a wavy ring around the arm's foot, in addition
///   to the boxes;
/// - "joints": those of the arm, whose links become shorter in proportion;
/// - "points": approximate number of points of such a ring, in ten clouds with a radius of 30 mm.
/// `count` is clamped to growthRange(). O(count).
planner::Problem growthProblem(const std::string& family, std::int64_t count);

}  // namespace leeway::tools::report
