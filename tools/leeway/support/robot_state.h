#pragma once

#include <string>
#include <vector>

#include "leeway/planner/configuration_space.h"
#include "leeway/planner/problem.h"

namespace leeway::tools {

/// Parses `--state TEXT` into a configuration of the whole robot, one number per variable. The text
/// is "start", a group state, or values as of `--start` (planner::statedRanges()). Other variables
/// are as at the problem's start. `words`: what else the caller accepts, for messages. Throws
/// robots::InputError.
std::vector<double> parseConfiguration(const planner::Problem& problem, const std::string& text,
                                       const std::vector<std::string>& words = {"start"});

/// The link of that name. Throws robots::InputError with the names of all links.
int parseLink(const robots::Model& model, const std::string& name);

/// Parses a whole text as std::stod() does, as a finite number. Throws robots::InputError that
/// names `option`.
double parseNumber(const std::string& option, const std::string& text);

/// Which value of a point is outside the limits, in words: "elbow = 3 is outside -2 to 2"; empty if
/// none is.
std::string brokenLimit(const planner::ConfigurationSpace& space, const std::vector<double>& point);

/// Throws robots::InputError about `--state TEXT`.
[[noreturn]] void badState(const std::string& text, const std::string& message);

std::vector<std::string> splitAt(char separator, const std::string& text);

}  // namespace leeway::tools
