#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::tools::report {

/// An engine's signed distance [m]. An engine that returns a single number sets both ends to it;
/// NaN if it reported failure.
struct PairAnswer {
  double lower = 0, upper = 0;
};

/// A convex shape. A hull keeps the points it was made from, including duplicates, which rivals
/// receive.
struct ReportShape {
  collision::Shape shape;
  std::vector<Eigen::Vector3d> points;
};

/// A pair of placed shapes and its true distance.
struct PairSpec {
  const ReportShape* a = nullptr;
  const ReportShape* b = nullptr;
  collision::Pose X_WA, X_WB;
  double size = 1;       ///< sum of the bounding radii [m]; tolerances are relative to it
  double distance = 0;   ///< the true signed distance [m]
  bool overlap = false;  ///< true: engines with a separate depth query use it
};

/// One engine's form of one pair, prepared off the clock.
class PairQuery {
 public:
  virtual ~PairQuery() = default;
  /// `tolerance`: absolute [m]; NaN: the engine's default. May throw, abort or loop; the report
  /// counts that.
  virtual PairAnswer ask(double tolerance) = 0;
  /// Warm-starts from `previous`, this engine's query of the same pair in the previous placement;
  /// null: no warm start.
  virtual void follow(const PairQuery* previous) { static_cast<void>(previous); }
};

class PairEngine {
 public:
  virtual ~PairEngine() = default;
  virtual const char* name() const = 0;
  /// False: ask() ignores its argument, so one row suffices.
  virtual bool hasTolerance() const = 0;
  /// True: answers are intervals that claim to contain the truth.
  virtual bool claimsBounds() const { return false; }
  /// False: answers only place the distance on one side of a threshold.
  virtual bool tellsDistance() const { return true; }
  /// Null if the engine lacks this pair of types. `warm`: follow() will be called.
  virtual std::unique_ptr<PairQuery> prepare(const PairSpec& spec, bool warm) const = 0;
};

}  // namespace leeway::tools::report
