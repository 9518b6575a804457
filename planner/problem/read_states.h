#pragma once

#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// The values of a variable in a file: a range, which has no width for a single value.
struct VariableRange {
  bool given = false;  ///< the file names the variable
  double lower = 0, upper = 0;
  int line = 0;  ///< in the file; 0 without one
};
using VariableRanges = std::vector<VariableRange>;

/// Sets problem.start. Throws unless every planned variable has a single value within its limits.
/// Does not check other variables.
void takeStart(const std::string& file, int line, const VariableRanges& given, Problem& problem);

/// Returns a goal. Throws unless exactly the planned variables are given, within their limits.
Goal takeGoal(const std::string& file, int line, const std::string& name,
              const VariableRanges& given, const Problem& problem);

/// Returns the values of a group state. Throws, with file and line, if no state of that name has a
/// value for every planned variable.
VariableRanges groupStateRanges(const std::string& file, int line, const std::string& name,
                                const Problem& problem);

/// Returns the values of a group state, or of numbers such as "0 1.5" or "0, 1.5", one for each
/// planned variable. Throws InputError without a file. `what` names the text in messages.
VariableRanges statedRanges(const std::string& what, const std::string& text,
                            const Problem& problem);

/// Reads `start:` of a problem file: a group state, a list in group order, a map by joint, or
/// poses.
void readStart(const YamlReader& reader, Problem& problem);

/// Reads one goal in the forms of readStart(), after objects and frames. A pair [from, to] or `any`
/// in place of a number is a range.
Goal readGoal(const YamlReader& reader, const std::string& name, Problem& problem);

/// Reads `joints:`, values of joints that are not planned: a map by joint, or the name of a state
/// of robots::namedStates() that has some of them.
void readPassiveJoints(const YamlReader& reader, Problem& problem);

}  // namespace leeway::planner
