#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "leeway/robots/inverse_kinematics.h"
#include "planner/constraint/constraint_proof.h"
#include "planner/search/goals.h"

namespace leeway::planner {

/// Draws points of the goals, batch by batch: the same calls give the same points, independent of
/// time. Has buffers; use it in one thread at a time.
class GoalSampler {
 public:
  /// All must outlive it. Throws robots::InputError for a goal that no configuration can satisfy.
  GoalSampler(EdgeCertifier& certifier, const Problem& problem, std::uint64_t seed);

  /// Valid points of the goals: the point of a goal of one point; up to kGoalSamples of a range;
  /// for poses the first solution found, and among a few solutions the nearest to the start. `stop`
  /// ends the search for a goal's first point.
  GoalPoints first(const std::function<bool()>& stop);
  /// Adds valid points of one of the goals that are poses, in turn. False if no more are expected.
  bool more(GoalPoints& points);
  /// The points drawn for the k-th goal of poses, valid or not.
  const std::vector<std::vector<double>>& found(std::size_t k) const {
    return pose_goals_[k].found;
  }
  bool hasPoses() const { return !pose_goals_.empty(); }
  /// Checks points with another certifier from now on. It must outlive the sampler, or its use.
  void use(EdgeCertifier& certifier) { certifier_ = &certifier; }

 private:
  struct PoseGoal {
    std::size_t goal;
    std::vector<robots::PoseRegion> poses;  ///< of the goal, and of the constraints
    bool evenly;  ///< drawn from the regions; otherwise from solutions nearest to any configuration
    std::uint64_t draws = 0;
    bool complete = false;                         ///< found and pending are all solutions
    int idle = 0;                                  ///< draws since the last new solution
    std::vector<robots::IkSolution> pending = {};  ///< known, but not yet checked
    std::vector<std::vector<double>> found = {};   ///< valid or not
    int breaking = 0;                              ///< solutions that break a constraint
    std::string broken = {};                       ///< which one the first of them breaks
  };
  /// Whether the constraints hold at a point.
  bool keepsConstraints(std::span<const double> point) {
    return !constraints_ || constraints_->holds(point);
  }
  void drawJoints(std::size_t g, GoalPoints& result, const std::function<bool()>& stop);
  void drawPoses(PoseGoal& drawn, GoalPoints& result, const std::function<bool()>& stop);
  void drawBatch(PoseGoal& drawn, GoalPoints& points);
  /// Checks pending solutions up to the first valid one. False if there is none.
  bool takePending(PoseGoal& drawn, GoalPoints& points);
  /// Adds the new ones among the solutions, and adds the valid ones to the points.
  void take(PoseGoal& drawn, std::span<const robots::IkSolution> solutions, GoalPoints& points);
  std::vector<double> anyConfiguration(PoseGoal& drawn) const;
  static bool isExhausted(const PoseGoal& drawn);
  bool isKnown(const PoseGoal& drawn, const std::vector<double>& point) const;

  EdgeCertifier* certifier_;
  const Problem& problem_;
  std::uint64_t seed_;
  std::unique_ptr<robots::InverseKinematics> kinematics_;  ///< null without poses
  std::optional<ConstraintProof> constraints_;
  std::vector<PoseGoal> pose_goals_;
  std::size_t turn_ = 0;
  mutable std::vector<double> difference_;
};

}  // namespace leeway::planner
