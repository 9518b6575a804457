#pragma once

#include <optional>
#include <string>
#include <vector>

#include "leeway/planner/configuration_space.h"
#include "leeway/planner/problem.h"

namespace leeway::tools {

/// Parses `--state TEXT` into a configuration of the whole robot, one number per variable. The text
/// is "start", a group state, all planned values (1,0,2) or the values of some variables
/// (elbow=1,wrist=2). Other variables are as at the problem's start. Throws robots::InputError.
std::vector<double> parseConfiguration(const planner::Problem& problem, const std::string& text);

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

/// The end of a message about an invalid `--state`: for a word, which of `words` or of the group
/// states may be meant. Empty for other texts, such as too few numbers.
std::string meantState(const robots::Model& model, const std::string& text,
                       std::vector<std::string> words);

/// Returns the group state of that name that gives all planned joints a value; nothing if there is
/// none of the name. Where all joints of the robot are planned, the only state of the name will do:
/// other joints are as at the start. Throws robots::InputError if the state lacks joints, or was
/// left out by the loader.
std::optional<robots::GroupState> findState(const planner::Problem& problem,
                                            const std::string& name);

std::vector<std::string> splitAt(char separator, const std::string& text);
/// Returns the values of a list: numbers that commas or blanks part ("1, 2", "1 2"), or values by
/// name that commas part ("elbow=1,wrist=2").
std::vector<std::string> listed(const std::string& text);

}  // namespace leeway::tools
