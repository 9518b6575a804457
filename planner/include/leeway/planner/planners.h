#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace leeway::planner {

/// What a caller wants to know of a planner before he names it in a problem.
struct PlannerTraits {
  std::string name;           ///< as in a problem file: OMPL's class name
  bool deterministic = true;  ///< false: keeps threads of its own, or (LBTRRT) reads memory that
                              ///< OMPL never set, so that a seed does not fix its result
  bool optimizing = false;    ///< improves its path until the limits are reached
  bool widens = true;         ///< false: its search needs costs that add up; clearance by rising
                              ///< margins, as for planners that do not optimise
  bool projection = false;    ///< explores cells of the space's default projection
  bool exact = true;    ///< false: only comes near a goal; a certified edge then leads into it
  std::string summary;  ///< half a line
};

/// A parameter that a problem file may set.
struct PlannerParameter {
  std::string name;
  std::string value;  ///< default; "0" for a range means that it is derived from the space's extent
  std::string suggestion;  ///< OMPL's notation: "first:step:last" or "0,1"; may be empty
};

/// Every geometric planner of OMPL 1.5.2 that can be built from a space information (and a
/// projection), by name. Left out, as they need more: TSRRT (a task space), VFRRT (a vector field),
/// XXL (a decomposition), QRRT (a sequence of spaces), LightningRetrieveRepair and
/// ThunderRetrieveRepair (a database of experience). Left out, as it aborts the program: LazyLBTRRT
/// (LPAstarOnGraph::removeEdge asserts that no edge leads to the root, which its own roadmap has).
const std::vector<PlannerTraits>& plannerNames();

/// The planner of that name (capitals do not matter, a star may be written *), null when there is
/// none.
const PlannerTraits* findPlanner(std::string_view name);

/// Its parameters in alphabetical order; empty for an unknown planner.
std::vector<PlannerParameter> plannerParameters(std::string_view name);

/// What is wrong with a planner's name or its parameters, with what would be accepted; nothing when
/// all is well.
std::optional<std::string> plannerError(const std::string& name,
                                        const std::map<std::string, std::string>& parameters);

}  // namespace leeway::planner
