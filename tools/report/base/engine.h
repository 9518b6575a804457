#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::tools::report {

/// What an engine says of the signed distance [m]. One that returns bare numbers has both ends
/// equal; NaN where it says that it failed.
struct PairAnswer {
  double lower = 0, upper = 0;
};

/// A convex shape as an engine may want it: the shape itself and, for a hull, the points it was
/// made from, duplicates included, which is what others are given.
struct ReportShape {
  collision::Shape shape;
  std::vector<Eigen::Vector3d> points;
};

/// A pair of placed shapes and what is known of it.
struct PairSpec {
  const ReportShape* a = nullptr;
  const ReportShape* b = nullptr;
  collision::Pose X_WA, X_WB;
  double size = 1;       ///< sum of the bounding radii [m]: what relative tolerances refer to
  double distance = 0;   ///< the true signed distance [m]
  bool overlap = false;  ///< engines with a query of its own for depth are to use that
};

/// One engine's form of one pair, made before the clock runs.
class PairQuery {
 public:
  virtual ~PairQuery() = default;
  /// `tolerance`: absolute [m]; NaN: what the engine does by default. May throw, abort or loop:
  /// that is what the report counts.
  virtual PairAnswer ask(double tolerance) = 0;
  /// Takes over what the query of the pair's previous placement left for a warm start; null: begins
  /// cold. Only called with queries of the same engine and pair.
  virtual void follow(const PairQuery* previous) { static_cast<void>(previous); }
};

class PairEngine {
 public:
  virtual ~PairEngine() = default;
  virtual const char* name() const = 0;
  /// False: ask() takes no notice of its argument, one row tells all.
  virtual bool hasTolerance() const = 0;
  /// True: answers are intervals that claim to hold the truth.
  virtual bool claimsBounds() const { return false; }
  /// False: answers only say on which side of a threshold the distance lies.
  virtual bool tellsDistance() const { return true; }
  /// Null: the engine has no such pair of types. `warm`: follow() will be called.
  virtual std::unique_ptr<PairQuery> prepare(const PairSpec& spec, bool warm) const = 0;
};

}  // namespace leeway::tools::report
