#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::tools::report {

/// An engine's signed distance [m]. Both ends are equal where it returns a bare number, NaN where
/// it reports failure.
struct PairAnswer {
  double lower = 0, upper = 0;
};

/// A convex shape and, for a hull, the points it was made from, duplicates included: rivals are
/// given those.
struct ReportShape {
  collision::Shape shape;
  std::vector<Eigen::Vector3d> points;
};

/// A pair of placed shapes and its true distance.
struct PairSpec {
  const ReportShape* a = nullptr;
  const ReportShape* b = nullptr;
  collision::Pose X_WA, X_WB;
  double size = 1;       ///< sum of the bounding radii [m]: what relative tolerances refer to
  double distance = 0;   ///< the true signed distance [m]
  bool overlap = false;  ///< asks engines with a separate depth query for that
};

/// One engine's form of one pair, made off the clock.
class PairQuery {
 public:
  virtual ~PairQuery() = default;
  /// `tolerance`: absolute [m]; NaN: the engine's default. May throw, abort or loop: the report
  /// counts that.
  virtual PairAnswer ask(double tolerance) = 0;
  /// Warm start from the query of the pair's previous placement, of the same engine and pair; null:
  /// cold.
  virtual void follow(const PairQuery* previous) { static_cast<void>(previous); }
};

class PairEngine {
 public:
  virtual ~PairEngine() = default;
  virtual const char* name() const = 0;
  /// False: ask() ignores its argument, so one row is enough.
  virtual bool hasTolerance() const = 0;
  /// True: answers are intervals that claim to contain the truth.
  virtual bool claimsBounds() const { return false; }
  /// False: answers only say on which side of a threshold the distance lies.
  virtual bool tellsDistance() const { return true; }
  /// Null: the engine has no such pair of types. `warm`: follow() will be called.
  virtual std::unique_ptr<PairQuery> prepare(const PairSpec& spec, bool warm) const = 0;
};

}  // namespace leeway::tools::report
