#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::planner {

/// A thing in the world that does not move, or that is attached to a link.
struct Object {
  std::string name;
  std::vector<robots::Geometry> geometries;
  robots::Pose X_WO;
};

/// An object held by a link from the start: it moves with the link and may touch only `touch_links` (and the link itself).
struct Attachment {
  Object object;  ///< X_WO is unused
  int link = -1;
  robots::Pose X_LO;
  std::vector<int> touch_links;
};

/// A goal: a range for every planned variable; a single value is a range of no width.
struct Goal {
  std::string name;  ///< group state, or "goal", "goal 2", ...
  std::vector<std::pair<double, double>> ranges;  ///< in group order
};

/// Everything that a planner needs to know, checked and complete. Made by a loader below or by a program.
struct Problem {
  std::string name;
  std::shared_ptr<const robots::Model> model;
  std::vector<int> variables;             ///< planned variables, in group order
  std::vector<double> configuration;      ///< all variables of the model: the start, passive ones included
  std::vector<Goal> goals;                ///< at least one
  std::vector<Object> objects;
  std::vector<Attachment> attachments;
  /// Names (links, objects, attached objects) that may touch, beyond what the SRDF disables.
  std::vector<std::pair<std::string, std::string>> allowed;
  /// Names that are checked although the SRDF disables them (MoveIt's matrix: false).
  bool replace_srdf_pairs = false;        ///< `allowed` stands in for the SRDF's pairs (MoveIt's matrix)
  double margin = 0;                      ///< [m]
  struct PairMargin { std::string a, b; double margin; };
  std::vector<PairMargin> margins;

  std::string planner = "RRTConnect";
  std::map<std::string, std::string> planner_parameters;  ///< by OMPL's names
  std::string objective = "length";       ///< "length" or "clearance"
  bool simplify = true;
  double time_limit = 5;                  ///< [s]
  std::int64_t iteration_limit = 0;       ///< 0: none
  std::uint64_t seed = 1;
  std::vector<std::string> warnings;
};

struct ProblemOptions {
  robots::LoadOptions load;
};

/// The project's own YAML (problems/README.md, problems/schema.json). Throws robots::InputError.
Problem loadProblem(const std::string& yaml_path, const ProblemOptions& options = {});

/// MoveIt planning scene and motion plan request, as MotionBenchMaker writes them. The model may be shared between calls.
Problem loadMoveit(std::shared_ptr<const robots::Model> model, const std::string& scene_path, const std::string& request_path);

/// A problem without a YAML file: start and goal are group states.
Problem problemFromStates(std::shared_ptr<const robots::Model> model, const std::string& group, const std::string& start,
                          const std::string& goal);

}  // namespace leeway::planner
