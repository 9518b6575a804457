#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace leeway::planner {

/// Properties of a planner, for choosing one.
struct PlannerTraits {
  std::string name;           ///< as in a problem file: Connect, or OMPL's class name
  bool deterministic = true;  ///< the seed determines its result; false: it has its own threads, or
                              ///< (LBTRRT) reads memory that OMPL never set
  bool optimizing = false;    ///< improves its path until the limits are reached
  bool any_cost = true;  ///< it can maximise clearance; false: its search needs costs that add up,
                         ///< and clearance uses rising margins, see plan()
  bool costs = true;  ///< it can minimise a MinimumCost of integrals, as upper ends of edges' costs
                      ///< or by first paths; false: its arithmetic supports only lengths
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

/// Connect, our own planner, and the geometric planners of OMPL 1.5.2. Some are left out because
/// they need more than a space and a projection: TSRRT (a task space), VFRRT (a vector field), XXL
/// (a decomposition), QRRT (a sequence of spaces), LightningRetrieveRepair and
/// ThunderRetrieveRepair (a database of experience). LazyLBTRRT is left out because it aborts the
/// program (LPAstarOnGraph::removeEdge asserts that no edge leads to the root, which its own
/// roadmap has).
const std::vector<PlannerTraits>& plannerNames();

/// The planner of that name, in upper or lower case and with * for "star"; null if none has the
/// name.
const PlannerTraits* findPlanner(std::string_view name);

/// A planner's parameters in alphabetical order; empty for an unknown planner.
std::vector<PlannerParameter> plannerParameters(std::string_view name);

/// The error in a planner's name or its parameters, and what would be accepted; nullopt if they are
/// right.
std::optional<std::string> plannerError(const std::string& name,
                                        const std::map<std::string, std::string>& parameters);

}  // namespace leeway::planner
