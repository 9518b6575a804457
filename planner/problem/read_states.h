#pragma once

#include <span>
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

std::vector<std::string> groupNames(const robots::Model& model);

/// The groups of "left, right", or the one group of that name.
std::vector<std::string> namedGroups(const robots::Model& model, const std::string& text);

/// Plans the joints of the groups (robots::isGroup()) together, one group after the other. Throws
/// for unknown names and groups that are not planned together (robots::groupsFault()).
void takeGroups(const std::string& file, int line, std::span<const std::string> names,
                Problem& problem);

/// Plans the joints between two links. Throws for unknown names, and where none of them moves.
void takeChain(const std::string& file, int line, const std::string& base, const std::string& tip,
               Problem& problem);

/// Sets start and goal from a group state or values each, as statedRanges() reads them.
void takeStates(const std::string& start, const std::string& goal, Problem& problem);

/// Sets problem.start. Throws unless every planned variable is given, single and inside its limits.
/// Values of other variables must be inside the problem's bounds.
void takeStart(const std::string& file, int line, const VariableRanges& given, Problem& problem);

/// Returns a goal. Throws unless exactly the planned variables are given, within their limits.
Goal takeGoal(const std::string& file, int line, const std::string& name,
              const VariableRanges& given, const Problem& problem);

/// The values of a group state, or of "0 1.5" or "0, 1.5": one of each planned variable; or those
/// of groups, "left=up, right=0 1.5"; of a goal also "left=any". Throws InputError without a file;
/// `what` names the text in messages.
VariableRanges statedRanges(const std::string& what, const std::string& text,
                            const Problem& problem);

/// Warns of values that a group state gives to joints that are not planned and stand elsewhere.
/// `where`: who names it.
void warnOfOthers(const std::string& state, const std::string& where, Problem& problem);

/// Whether statedRanges() reads a text as the name of a state: it is not numbers, nor has a "=".
bool namesState(const std::string& text);

/// Reads `start:` of a problem file: a group state, a list in group order, a map by joint or group,
/// or poses. It must not give again what `passive` has, the result of readPassiveJoints().
void readStart(const YamlReader& reader, const VariableRanges& passive, Problem& problem);

/// Reads one goal in the forms of readStart(), after objects and frames. A pair [from, to] or `any`
/// in place of a number is a range.
Goal readGoal(const YamlReader& reader, const std::string& name, Problem& problem);

/// Reads `joints:`, values of joints that are not planned: a map by joint, or the name of a state
/// of robots::namedStates() that has some of them. Returns them.
VariableRanges readPassiveJoints(const YamlReader& reader, Problem& problem);

}  // namespace leeway::planner
