#pragma once

#include <limits>
#include <memory>
#include <span>

#include "leeway/collision/pose.h"
#include "leeway/collision/scene.h"

namespace leeway::tools::report {

/// One engine's form of a scene, for a planner that looks at states.
class StateChecker {
 public:
  virtual ~StateChecker() = default;
  /// Whether no pair of the scene touches. X_WB: one pose a body; those that stand still keep
  /// theirs.
  virtual bool isFree(std::span<const collision::Pose> X_WB) = 0;
  /// The least distance of the scene's pairs, 0 or below where some touch [m]; NaN: the engine does
  /// not measure one of them.
  virtual double distance(std::span<const collision::Pose>) {
    return std::numeric_limits<double>::quiet_NaN();
  }
};

class StateEngine {
 public:
  virtual ~StateEngine() = default;
  virtual const char* name() const = 0;
  /// Null: the engine lacks one of the shapes. `scene` must outlive the checker.
  virtual std::unique_ptr<StateChecker> prepare(const collision::Scene& scene) const = 0;
};

}  // namespace leeway::tools::report
