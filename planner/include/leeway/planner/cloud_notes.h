#pragma once

#include <string>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::planner {

/// Returns what every answer about the problem assumes of its point clouds, in sentences without a
/// full stop: how many points filters removed and which, and whether space that was not seen counts
/// as free. Empty without clouds. O(clouds).
std::vector<std::string> cloudNotes(const Problem& problem);

/// Whether space that the camera of the object's cloud did not see is occupied.
bool isUnseenOccupied(const Object& object);

}  // namespace leeway::planner
