#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
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

/// An object held by a link from the start: it moves with the link and may touch only `touch_links`
/// (and the link itself).
struct Attachment {
  Object object;  ///< X_WO is unused
  int link = -1;
  robots::Pose X_LO;
  std::vector<int> touch_links;
};

/// A goal: a range for every planned variable; a single value is a range of no width.
struct Goal {
  std::string name;                               ///< group state, or "goal", "goal 2", ...
  std::vector<std::pair<double, double>> ranges;  ///< in group order
};

/// Everything that a planner needs to know, checked and complete. Made by a loader below or by a
/// program.
struct Problem {
  std::string name;
  std::shared_ptr<const robots::Model> model;
  std::vector<int> variables;  ///< planned variables, in group order
  std::vector<double>
      configuration;        ///< all variables of the model: the start, passive ones included
  std::vector<Goal> goals;  ///< at least one
  std::vector<Object> objects;
  std::vector<Attachment> attachments;
  /// Names (links, objects, attached objects) that may touch, beyond what the SRDF disables.
  std::vector<std::pair<std::string, std::string>> allowed;
  /// True: `allowed` stands in for the SRDF's pairs; what it leaves out is checked although the
  /// SRDF disables it (MoveIt's matrix: false).
  bool replace_srdf_pairs = false;
  double margin = 0;  ///< [m]
  struct PairMargin {
    std::string a, b;
    double margin;
  };
  std::vector<PairMargin> margins;

  std::string planner = "RRTConnect";
  std::map<std::string, std::string> planner_parameters;  ///< by OMPL's names
  std::string objective = "length";                       ///< "length" or "clearance"
  bool simplify = true;
  double time_limit = 5;             ///< [s]
  std::int64_t iteration_limit = 0;  ///< 0: none
  std::uint64_t seed = 1;
  std::vector<std::string> warnings;  ///< of this problem's own files, each with file and line; the
                                      ///< robot's are in model->warnings
};

struct ProblemOptions {
  robots::LoadOptions load;
};

/// The project's own YAML (problems/README.md, problems/schema.json). Throws robots::InputError.
Problem loadProblem(const std::string& yaml_path, const ProblemOptions& options = {});

/// MoveIt planning scene and motion plan request, as MotionBenchMaker writes them. The model may be
/// shared between calls.
Problem loadMoveit(std::shared_ptr<const robots::Model> model, const std::string& scene_path,
                   const std::string& request_path);

/// A problem without a YAML file: start and goal are group states. Throws robots::InputError
/// (without a file) for unknown names.
Problem problemFromStates(std::shared_ptr<const robots::Model> model, const std::string& group,
                          const std::string& start, const std::string& goal);

/// The problem with `object` (one of problem.objects) held by `link` from now on, where it is while
/// the robot stands at `configuration` (all variables of the model; empty: the problem's start). It
/// then moves with the link and may touch it and `touch_links`. Names in `allowed` and `margins` go
/// on to mean it. Throws std::invalid_argument for unknown names.
Problem attachObject(const Problem& problem, const std::string& object, const std::string& link,
                     const std::vector<std::string>& touch_links = {},
                     std::span<const double> configuration = {});

/// The problem with an attached object put down where it is while the robot stands at
/// `configuration`: attachObject() undone.
Problem detachObject(const Problem& problem, const std::string& object,
                     std::span<const double> configuration = {});

}  // namespace leeway::planner
