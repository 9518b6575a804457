#pragma once

#include <string>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::tools {

/// A configuration of the whole robot, one number a variable, from `--state TEXT`: "start", a group
/// state, all planned values (1,0,2) or some variables' (elbow=1,wrist=2). What it does not name is
/// as at the problem's start. Throws robots::InputError.
std::vector<double> parseConfiguration(const planner::Problem& problem, const std::string& text);

/// The link of that name. Throws robots::InputError, which names those that there are.
int parseLink(const robots::Model& model, const std::string& name);

/// Like std::stod() of a whole text, and finite. Throws robots::InputError that names `option`.
double parseNumber(const std::string& option, const std::string& text);

/// Throws robots::InputError about `--state TEXT`.
[[noreturn]] void badState(const std::string& text, const std::string& message);

/// The end of a message about a `--state` that is no state: where it is a word, which of `words`
/// and of the group states may be meant. Empty for anything else, such as too few numbers.
std::string meantState(const robots::Model& model, const std::string& text,
                       std::vector<std::string> words);

/// Throws robots::InputError where `text` names a group state that is left out, of a group that has
/// the planned joints.
void refuseLeftOut(const planner::Problem& problem, const std::string& text);

std::vector<std::string> splitAt(char separator, const std::string& text);

}  // namespace leeway::tools
