#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::tools::report {

/// The growing quantities of `report growth`: "boxes", "triangles" and "joints".
const std::vector<std::string>& growthFamilies();
/// The least and the largest count of a family, for messages; the family must exist.
std::pair<std::int64_t, std::int64_t> growthRange(const std::string& family);

/// A problem in which an arm turns from one side of a post to the other, with seven more boxes
/// around it. Only one quantity grows with `count`; it is one of growthFamilies() or "points":
/// - "boxes": their number; the additional boxes are out of the arm's reach;
/// - "triangles": approximate number of triangles of a wavy ring around the arm's foot, in addition
///   to the boxes;
/// - "joints": those of the arm, whose links become shorter in proportion;
/// - "points": approximate number of points on the boxes, which a sensor saw: one cloud with a
///   radius of 35 mm replaces them, and the arm's links may touch each other.
/// `count` is clamped to growthRange(). O(count).
planner::Problem growthProblem(const std::string& family, std::int64_t count);
inline constexpr double kSeenRadius = 0.035;  ///< covers the boxes from 2,000 points on [m]

}  // namespace leeway::tools::report
