#pragma once

// Ends of an interval where rounding to double is all that keeps it wide: the plane and the witness
// that a query ended on, evaluated once more in twice the precision, from the two world poses as
// they were given.

#include "collision/base/double_double.h"
#include "collision/convex/gjk/progress.h"
#include "collision/convex/gjk/simplex.h"

namespace leeway::collision {

/// ||R^T R - 1|| (Frobenius), in twice the precision and rounded outwards: a matrix that is not
/// quite a rotation is half of that, times (1 + itself), from the rotation next to it. O(1).
double departureOf(const Eigen::Matrix3d& R);

/// The farthest point of a core along a direction of its frame. O(vertices).
DoubleDoubleVector farthestOfCore(const ConvexView& view, const DoubleDoubleVector& direction);

/// The difference {b - a} of two cores in the world's axes, in twice the precision.
class SharpDifference {
 public:
  SharpDifference(const ConvexView& a, const Pose& X_WA, const ConvexView& b, const Pose& X_WB);

  const ConvexView& a() const { return a_; }
  const ConvexView& b() const { return b_; }
  const Pose& X_WA() const { return X_WA_; }
  const Pose& X_WB() const { return X_WB_; }

  /// The largest n . w over the difference, n of any length. O(vertices).
  DoubleDouble mostAlong(const DoubleDoubleVector& n) const;
  /// The member that was made of the same points; of round cores it is one next to it, which lies
  /// in the difference grown by memberDefect(). X_BA: the pose that s was made with.
  DoubleDoubleVector member(const SupportPoint& s, const Pose& X_BA) const;
  /// p_b - p_a of points in the bodies' frames.
  DoubleDoubleVector memberOf(const DoubleDoubleVector& p_a, const DoubleDoubleVector& p_b) const;
  /// A direction of B's frame in the world, and directions in the world in the bodies' frames.
  DoubleDoubleVector inWorld(const Vector& direction_b) const;
  DoubleDoubleVector inA(const DoubleDoubleVector& direction) const;
  DoubleDoubleVector inB(const DoubleDoubleVector& direction) const;
  double memberDefect() const { return member_defect_; }
  /// By how much a matrix that is not quite a rotation may move the bodies [m]: the sum of half the
  /// departures, ||R^T R - 1||, times the extents.
  double slack() const { return slack_; }
  /// The same for a query that has been answered in B's frame with the pose below [m].
  double poseSlack() const { return pose_slack_; }
  /// How far members that were made with X_BA, in B's frame, may be from those of the world, turned
  /// there, besides rounding [m]: where matrices depart from rotations.
  double moved() const { return moved_; }
  /// X_BA, correctly rounded.
  const Pose& X_BA() const { return X_BA_; }

 private:
  const ConvexView& a_;
  const ConvexView& b_;
  const Pose& X_WA_;
  const Pose& X_WB_;
  DoubleDoubleVector t_;  // T_A - T_B
  Pose X_BA_;
  double slack_ = 0, pose_slack_ = 0, member_defect_ = 0, moved_ = 0;
};

/// Offers the plane across n (a direction in the world, from A to B, of any length).
void offerSharpPlane(const SharpDifference& difference, const DoubleDoubleVector& n,
                     Progress& progress);

/// Offers a point of the difference at that distance from the origin; `distance` may be a depth,
/// negated. w and a as in Progress::offerWitness(), in B.
void offerSharpWitness(const SharpDifference& difference, const DoubleDouble& distance,
                       double defect, const Vector& w, const Vector& a, Progress& progress);

/// Both ends where A or B is a half-space: the other's lowest point decides, apart or overlapping.
/// The normal, witness and point of A are those that are known already. O(vertices).
void sharpenHalfSpace(const SharpDifference& difference, Progress& progress);

/// Both ends where A or B is a point, outside of the other at a distance from `nearest`, which may
/// stand out of it by 8 units of roundoff of its extent, along `normal`, both in its frame. The
/// lower end alone where it is not outside. As above.
void sharpenPoint(const SharpDifference& difference, bool outside, const Vector& nearest,
                  const Vector& normal, Progress& progress);

/// Both ends of a pair that is apart, from the simplex that GJK ended on.
void sharpenApart(const SharpDifference& difference, const Simplex& simplex, const Pose& X_BA,
                  Progress& progress);

}  // namespace leeway::collision
