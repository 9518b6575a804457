#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "leeway/robots/model.h"
#include "leeway/robots/pose_region.h"

namespace leeway::robots {

/// Limits of a search, by counted work: the same answers on every machine.
struct IkOptions {
  std::uint64_t seed = 1;
  int starts = 200;            ///< searches from different configurations, the given one first
  int max_solutions = 1;       ///< the search ends with as many
  bool closed_form = true;     ///< where there is one; false: numeric search alone
  bool prove = true;           ///< without a solution, try to prove that there is none
  int proof_boxes = 100'000;   ///< boxes of configurations examined by that proof
  std::function<bool()> stop;  ///< ends the search early when true; may be empty
};

struct IkSolution {
  std::vector<double> values;  ///< of the solver's variables, within their limits
  PoseError error;             ///< the largest over all regions, by forwardKinematics()
};

enum class IkStatus {
  kFound,
  kNone,        ///< none was found; there may be one
  kUnreachable  ///< proven: no configuration within the limits has all frames in their regions
};

struct IkResult {
  IkStatus status = IkStatus::kNone;
  /// By a closed form: the solutions are all that there are.
  bool complete = false;
  /// No two are the same up to whole turns; the nearest to the given configuration first.
  std::vector<IkSolution> solutions;
  /// Without a solution: the configuration found whose frames are nearest to their regions.
  IkSolution nearest;
  int starts = 0;               ///< searches made
  std::int64_t iterations = 0;  ///< of the numeric search, over all starts
  std::int64_t proof_boxes = 0;
};

/// Inverse kinematics of a model: revolute, continuous, prismatic, planar, floating and mimic
/// joints, branching trees. Constant after construction; threads share it.
///
/// Numeric: damped least squares (Levenberg-Marquardt) with the damping proportional to the error
/// (Sugihara, Solvability-Unconcerned Inverse Kinematics by the Levenberg-Marquardt Method, IEEE
/// Trans. Robotics 27(5), 2011), joints at a limit held there while the step points outwards, from
/// starts of a low-discrepancy sequence. Every solution is checked by forwardKinematics().
///
/// Closed forms (robots/inverse/closed_form.h) for one exact pose, where the geometry of six or
/// seven revolute joints has one: of six joints the first start gives all solutions, nearest first,
/// and but for singular poses no other start is made; of seven each start gives those with one
/// joint at its value there. The numeric search polishes them, and does what they leave.
class InverseKinematics {
 public:
  /// Solves for `variables`, indices of the model's. Throws std::invalid_argument for one that the
  /// model does not have or that is listed twice.
  InverseKinematics(std::shared_ptr<const Model> model, std::vector<int> variables);

  const std::vector<int>& variables() const { return variables_; }
  const Model& model() const { return *model_; }

  /// Configurations that have every frame in its region at once. `configuration` has one number a
  /// variable of the model: those not solved for keep theirs, the others are the first start. An
  /// angle without other turns in its joint's limits stays within half a turn of the configuration.
  /// Throws std::invalid_argument for numbers that are not finite, frames that are no rotations,
  /// ranges whose ends are exchanged, tolerances below kLeastPoseTolerance, a link that does not
  /// exist, or a configuration of another size.
  IkResult solve(std::span<const PoseRegion> regions, std::span<const double> configuration,
                 const IkOptions& options = {}) const;

  /// Draw number `index` of an endless sequence: poses drawn evenly from the regions, solved from a
  /// start of their own; empty when that start fails. The same for equal arguments, so that draws
  /// may be made when needed and by any thread. Errors as solve().
  std::optional<IkSolution> sample(std::span<const PoseRegion> regions,
                                   std::span<const double> configuration, std::uint64_t index,
                                   std::uint64_t seed = 1) const;

 private:
  std::shared_ptr<const Model> model_;
  std::vector<int> variables_;
  std::vector<char> periodic_;  // one a solved variable: whole turns change no link's pose
};

}  // namespace leeway::robots
