#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// Where a frame F, fixed to a link, may be: a box of positions and of roll, pitch and yaw of F in
/// a reference frame R. The rotation is Rz(yaw) Ry(pitch) Rx(roll), as URDF's rpy. A range of no
/// width is an exact value; one of 2 pi or more is any angle.
struct PoseRegion {
  int link = -1;
  Pose X_LF;
  Pose X_WR;
  std::array<std::pair<double, double>, 3> position;  ///< least and greatest x, y, z [m]
  std::array<std::pair<double, double>, 3> rpy;       ///< roll, pitch, yaw [rad]
  /// How far outside of the region an answer may be. At least kLeastPoseTolerance.
  double position_tolerance = 1e-9, angle_tolerance = 1e-9;  // [m], [rad]

  /// The region that holds X_RF alone.
  static PoseRegion exact(int link, const Pose& X_LF, const Pose& X_WR, const Pose& X_RF);
};

/// Tolerances below this are refused: kinematics of a robot of some metres round by 1e-14.
inline constexpr double kLeastPoseTolerance = 1e-12;

/// How far a frame is outside of its region.
struct PoseError {
  double position = 0;  ///< the distance to the box [m]
  double angle = 0;     ///< of the rotation to the nearest one allowed [rad]
};

/// The error of F when its link is at X_WL. Where two or three of the angles have a width, the
/// nearest rotation is searched and may be missed: never less than the true error. O(1).
PoseError poseError(const PoseRegion& region, const Pose& X_WL);

/// Roll, pitch, yaw of a rotation, |pitch| <= pi/2; roll 0 where only their sum or difference is
/// determined. The same bytes with every C library. O(1).
Eigen::Vector3d rollPitchYaw(const Eigen::Matrix3d& R);

/// Rz(yaw) Ry(pitch) Rx(roll). O(1).
Eigen::Matrix3d rotationOf(const Eigen::Vector3d& roll_pitch_yaw);

/// Limits of a search, by counted work: the same answers on every machine.
struct IkOptions {
  std::uint64_t seed = 1;
  int starts = 200;            ///< searches from different configurations, the given one first
  int max_solutions = 1;       ///< the search ends with as many; those listed are nearest
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
