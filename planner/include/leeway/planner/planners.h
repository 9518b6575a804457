#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace leeway::planner {

/// What a planner is, for those who choose one.
struct PlannerTraits {
  std::string name;           ///< as in a problem file: Connect, or OMPL's class name
  bool deterministic = true;  ///< a seed fixes its result; false: it keeps threads of its own, or
                              ///< (LBTRRT) reads memory that OMPL never set
  bool optimizing = false;    ///< improves its path until the limits are reached
  bool any_cost = true;       ///< it can maximise clearance; false: its search needs costs that add
                              ///< up, and clearance takes rising margins, see plan()
  bool costs = true;        ///< it can minimise a MinimumCost of integrals, as upper ends of edges'
                            ///< costs or by first paths; false: its arithmetic knows lengths alone
  bool projection = false;  ///< explores cells of the space's default projection
  bool exact = true;        ///< reaches goals; false: it only comes near, and plan() adds an edge
  std::string summary;      ///< half a line
};

/// A parameter that a problem file may set.
struct PlannerParameter {
  std::string name;
  std::string value;       ///< default; "0" for a range: derived from the space's extent
  std::string suggestion;  ///< OMPL's notation: "first:step:last" or "0,1"; may be empty
};

/// Connect, our own, and the geometric planners of OMPL 1.5.2. Left out, as they need more than a
/// space and a projection: TSRRT (a task space), VFRRT (a vector field), XXL (a decomposition),
/// QRRT (a sequence of spaces), LightningRetrieveRepair and ThunderRetrieveRepair (a database of
/// experience). Left out, as it aborts the program: LazyLBTRRT (LPAstarOnGraph::removeEdge asserts
/// that no edge leads to the root, which its own roadmap has).
const std::vector<PlannerTraits>& plannerNames();

/// The planner of that name, in any capitals and with * for "star"; null when there is none.
const PlannerTraits* findPlanner(std::string_view name);

/// A planner's parameters in alphabetical order; empty for an unknown planner.
std::vector<PlannerParameter> plannerParameters(std::string_view name);

/// What is wrong with a planner's name or its parameters, and what would be accepted; nothing when
/// they are right.
std::optional<std::string> plannerError(const std::string& name,
                                        const std::map<std::string, std::string>& parameters);

}  // namespace leeway::planner
