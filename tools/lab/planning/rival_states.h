#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/robots/kinematics.h"
#include "tools/lab/base/state_engine.h"

namespace leeway::tools::report {

/// Points of our space, checked by a rival's checker. Both must outlive this object.
class RivalStates {
 public:
  RivalStates(const planner::CompiledScene& scene, StateChecker& checker)
      : scene_(scene),
        checker_(checker),
        q_(scene.model().variables.size()),
        X_WL_(scene.model().links.size()),
        X_WB_(scene.scene().bodies().size()) {
    for (std::size_t b = 0; b < X_WB_.size(); ++b)
      if (const int link = scene.bodyLink(static_cast<int>(b)); link >= 0)
        links_.emplace_back(b, static_cast<std::size_t>(link));
  }

  /// Whether the robot, with the planned variables at `point`, is free of contact.
  bool isFree(std::span<const double> point) {
    place(point);
    return checker_.isFree(X_WB_);
  }
  /// Its least distance there, see StateChecker::distance() [m].
  double distance(std::span<const double> point) {
    place(point);
    return checker_.distance(X_WB_);
  }

 private:
  void place(std::span<const double> point) {
    scene_.expand(point, q_);
    robots::forwardKinematics(scene_.model(), q_, X_WL_);
    for (const auto& [body, link] : links_) X_WB_[body] = X_WL_[link];
  }

  const planner::CompiledScene& scene_;
  StateChecker& checker_;
  std::vector<std::pair<std::size_t, std::size_t>> links_;  ///< bodies and their links
  std::vector<double> q_;
  std::vector<robots::Pose> X_WL_, X_WB_;
};

}  // namespace leeway::tools::report
