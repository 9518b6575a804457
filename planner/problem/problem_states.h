#pragma once

#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/problem.h"
#include "planner/problem/yaml_reader.h"

namespace leeway::planner {

/// What is known of each variable of a model: a range, of no width for a single value. `given` is
/// false where nothing was said.
struct VariableRange {
  bool given = false;
  double lower = 0, upper = 0;
  int line = 0;  ///< of the file that said so; 0: none
};
using VariableRanges = std::vector<VariableRange>;

/// Position of a variable for messages: "joint 'elbow'".
std::string variableText(const robots::Model& model, int variable);

/// Puts `given` into problem.configuration. Throws unless every planned variable is there, single
/// and inside its limits. Variables that are not planned are taken as they are.
void takeStart(const std::string& file, int line, const VariableRanges& given, Problem& problem);

/// A goal of `given`. Throws unless every planned variable is there, inside its limits, and no
/// variable that is not planned.
Goal takeGoal(const std::string& file, int line, const std::string& name,
              const VariableRanges& given, const Problem& problem);

/// The values of a group state. Throws (naming file and line) when the model has none of that name
/// for the problem's variables.
VariableRanges groupStateRanges(const std::string& file, int line, const std::string& name,
                                const Problem& problem);

/// `start:` of a problem file: a group state, a list in group order, or a map by joint.
void readStart(const YamlReader& reader, Problem& problem);

/// One goal: the same forms; a pair [from, to] or `any` in place of a number makes a range.
Goal readGoal(const YamlReader& reader, const std::string& name, Problem& problem);

/// `joints:`, values of joints that are not planned.
void readPassiveJoints(const YamlReader& reader, Problem& problem);

}  // namespace leeway::planner
