#pragma once

// Private to planner/: cuts of a path that keeps more than margins.

#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "leeway/planner/trajectory.h"
#include "planner/constraint/frame_motion.h"

namespace leeway::planner {

struct CutRules {
  bool leaves_out = true;  ///< whether waypoints may be left out
  /// Whether the motion may depart from the edges beside a corner by up to this difference. Empty:
  /// wherever margins are kept.
  std::function<bool(int corner, std::span<const double> departure)> allows = {};
  /// The highest speed along a direction that a blend may have. Empty: that of the limits.
  std::function<double(std::span<const double> direction)> speed = {};
  std::span<const double> least_times = {};  ///< as for Trajectory
};

/// certifiedCuts() under rules.
Cuts chooseCuts(const std::shared_ptr<const CompiledScene>& scene,
                std::span<const std::vector<double>> waypoints, const MotionLimits& limits,
                const CutRules& rules);

}  // namespace leeway::planner
