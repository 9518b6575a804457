#pragma once

// Private to planner/: a robot that follows a motion with a tracking error.

#include <span>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::planner {

/// The problem whose margins, kept by the motion as it is commanded, are those of the given one for
/// a robot that is beside it: each planned variable by its error [rad or m], and each point by
/// `point_error` besides [m]. Empty errors become zeros. Throws robots::InputError, which begins
/// with `who`, for another number of errors, one that is not 0 or more, planned joints that float,
/// and errors without a bound on how far points are off.
Problem withErrors(const Problem& problem, std::vector<double>& joint_errors, double point_error,
                   const std::string& who);

/// Whether differences from the motion are within the errors, up to rounding of their numbers.
bool isWithin(std::span<const double> differences, std::span<const double> joint_errors);

}  // namespace leeway::planner
