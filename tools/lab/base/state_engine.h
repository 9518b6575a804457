#pragma once

#include <limits>
#include <memory>
#include <span>

#include "leeway/collision/pose.h"
#include "leeway/collision/scene.h"

namespace leeway::tools::report {

/// One engine's form of a scene, for a planner that checks states.
class StateChecker {
 public:
  virtual ~StateChecker() = default;
  /// Whether no pair of the scene touches. X_WB: one pose for each body; fixed bodies keep theirs.
  virtual bool isFree(std::span<const collision::Pose> X_WB) = 0;
  /// The least distance of the scene's pairs, 0 or below if some touch [m]; NaN if the engine
  /// cannot measure one of them.
  virtual double distance(std::span<const collision::Pose>) {
    return std::numeric_limits<double>::quiet_NaN();
  }
};

class StateEngine {
 public:
  virtual ~StateEngine() = default;
  virtual const char* name() const = 0;
  /// Null if the engine lacks one of the shapes. `scene` must outlive the checker.
  virtual std::unique_ptr<StateChecker> prepare(const collision::Scene& scene) const = 0;
};

}  // namespace leeway::tools::report
