// The first contact of two rigid bodies.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/convex/convex_distance.h"
#include "collision/convex/gjk/support.h"
#include "collision/time/conservative_advancement.h"
#include "collision/time/relative_motion.h"
#include "collision/time/separating_plane_tracker.h"
#include "leeway/collision/time_of_contact.h"

namespace leeway::collision {
namespace {

/// Two rigid bodies. If A is a half-space, B is one, too.
struct RigidPair {
  const Shape& a;
  const RigidMotion& motion_a;
  const Shape& b;
  const RigidMotion& motion_b;
  const ContactRequest& request;
  Scratch& scratch;
  PairCache* cache;
  ConvexView view_a, view_b;
  bool flat;    ///< B is a half-space: its plane is the only one
  bool planes;  ///< separating planes hold over time: bodies are convex, and no half-space turns
  Pose X_WA_start, X_WB_start;  ///< at t = 0
  bool valid;                   ///< both are poses
  double departure;             ///< of the rotations from orthogonality, as RelativePose::slack
  int hint_a = 0, hint_b = 0;

  RigidPair(const Shape& a_, const RigidMotion& motion_a_, const Shape& b_,
            const RigidMotion& motion_b_, const ContactRequest& request_, Scratch& scratch_,
            PairCache* cache_)
      : a(a_),
        motion_a(motion_a_),
        b(b_),
        motion_b(motion_b_),
        request(request_),
        scratch(scratch_),
        cache(cache_),
        flat(b_.type() == ShapeType::kHalfSpace) {
    planes = a.isConvex() && b.isConvex() && a.type() != ShapeType::kHalfSpace &&
             !(flat && motion_b.bound(0, request.end).angular_speed > 0);
    if (a.isConvex()) view_a = viewOf(a);
    if (b.isConvex()) view_b = viewOf(b);
    X_WA_start = motion_a.pose(0);
    X_WB_start = motion_b.pose(0);
    const RelativePose X = relativePose(X_WA_start, X_WB_start);
    valid = X.valid;
    departure = X.slack;
  }

  /// Rounding of both poses where the bodies are near each other; for a half-space, where A can
  /// touch it [m].
  double rounding(const Pose& X_WA, const Pose& X_WB) const {
    const double between = (X_WA.translation - X_WB.translation).norm() + a.extent();
    return motion_a.rounding(a.extent()) + motion_b.rounding(std::min(b.extent(), between));
  }

  /// Rounding of separationAlong() and of the plane of a sample [m].
  double planeRounding(const Pose& X_WA, const Pose& X_WB) const {
    const double between = (X_WB.translation - X_WA.translation).norm();
    const double size = a.extent() + (flat ? 0 : b.extent()) + between;
    return kSupportRounding * kUnitRoundoff * (size + view_a.radius + view_b.radius) +
           departure * size + rounding(X_WA, X_WB);
  }

  double accelerationAlong(const Eigen::Vector3d& n, double t) const {
    return (collision::accelerationAlong(a, motion_a, n, t, request.end) +
            collision::accelerationAlong(b, motion_b, n, t, request.end)) *
           (1 + 16 * kUnitRoundoff);
  }

  double separationAlong(const Eigen::Vector3d& n, double t) {
    return separationAlong(n, motion_a.pose(t), motion_b.pose(t));
  }
  double separationAlong(const Eigen::Vector3d& n, const Pose& X_WA, const Pose& X_WB) {
    const Eigen::Vector3d m = flat ? Eigen::Vector3d(-X_WB.rotation.col(2)) : n;
    const Eigen::Vector3d down_a = rotatedBack(X_WA.rotation, m);
    double apart =
        m.dot(X_WB.translation - X_WA.translation) - down_a.dot(farthest(view_a, down_a, hint_a));
    if (!flat) {
      const Eigen::Vector3d up_b = -rotatedBack(X_WB.rotation, m);
      apart -= up_b.dot(farthest(view_b, up_b, hint_b));
    }
    return apart - view_a.radius - view_b.radius - view_a.excess - view_b.excess -
           planeRounding(X_WA, X_WB);
  }

  bool hasDepth() const { return a.isConvex() && b.isConvex(); }

  ContactSample sample(double t, double tolerance, bool depth) {
    const Pose X_WA = motion_a.pose(t), X_WB = motion_b.pose(t);
    ContactSample s;
    s.t = t;
    s.distance =
        distance(a, X_WA, b, X_WB, sampleRequest(request, tolerance, depth), scratch, cache);
    widen(s.distance, rounding(X_WA, X_WB));
    const Eigen::Vector3d& n = s.distance.normal;
    const FrameVelocity va = motion_a.velocity(t), vb = motion_b.velocity(t);
    const auto at = [](const FrameVelocity& v, const Pose& X, const Eigen::Vector3d& p) {
      return Eigen::Vector3d(v.linear + v.angular.cross(p - X.translation));
    };
    s.closing = n.dot(at(va, X_WA, s.distance.point_a) - at(vb, X_WB, s.distance.point_b));
    s.speed = pointSpeed(a, motion_a.bound(t, request.end)) +
              pointSpeed(b, motion_b.bound(t, request.end));
    s.plane = s.distance.distance.lower - planeRounding(X_WA, X_WB);
    return s;
  }

  /// The plane across the line of the bounding spheres' centres, if the spheres are apart.
  ContactSample startPlane() {
    ContactSample s;
    if (!valid) return s;
    const Eigen::Vector3d from = X_WA_start * a.boundingCenter(),
                          to = X_WB_start * b.boundingCenter();
    const double apart = (to - from).norm();
    if (!(apart - a.boundingRadius() - b.boundingRadius() > request.margin) || !(apart < kInfinity))
      return s;
    s.distance.normal = (to - from) / apart;
    s.distance.point_a = from;
    s.distance.point_b = to;
    s.plane = separationAlong(s.distance.normal, X_WA_start, X_WB_start);
    s.distance.distance = {s.plane, kInfinity};
    s.distance.status = DistanceStatus::kAboveThreshold;
    return s;
  }

  /// Sweeps A over [t, t + step] in B's frame: points leave chords by step^2 / 8 times the
  /// acceleration in that frame.
  bool isFreeOver(double t, double step) {
    const Pose X_WB0 = motion_b.pose(t), X_WB1 = motion_b.pose(t + step);
    const Pose X_WA0 = motion_a.pose(t), X_WA1 = motion_a.pose(t + step);
    const Pose X_BA0 = X_WB0.inverse() * X_WA0, X_BA1 = X_WB1.inverse() * X_WA1;
    const FrameMotionBound ma = motion_a.bound(t, t + step), mb = motion_b.bound(t, t + step);
    const double speed = pointSpeed(a, ma) + mb.speed;
    const double reach = X_BA0.translation.norm() + times(1, a.extent()) + step * speed;
    const double acceleration =
        accelerationSeenFrom(mb, pointAcceleration(a, ma) + mb.acceleration, speed, reach);
    const double coordinates = X_WB0.translation.norm() + X_WB1.translation.norm() +
                               X_BA0.translation.norm() + X_BA1.translation.norm() + a.extent();
    const double growth = step * step * acceleration / 8 * kGrowthOutwards +
                          std::max(rounding(X_WA0, X_WB0), rounding(X_WA1, X_WB1)) +
                          kTransferRounding * 2 * coordinates;
    if (!(growth < kInfinity)) return false;
    return sweptDistance(a, X_BA0, X_BA1, growth, b, sweepRequest(request), scratch, cache)
               .distance.lower > request.margin;
  }
};

}  // namespace

ContactResult timeOfContact(const Shape& a, const RigidMotion& motion_a, const Shape& b,
                            const RigidMotion& motion_b, const ContactRequest& request,
                            Scratch& scratch, PairCache* cache) {
  // A is the swept body, so a half-space, which is unbounded, must be B.
  if (a.type() == ShapeType::kHalfSpace && b.type() != ShapeType::kHalfSpace) {
    ContactResult result = timeOfContact(b, motion_b, a, motion_a, request, scratch, cache);
    std::swap(result.distance.point_a, result.distance.point_b);
    std::swap(result.distance.triangle_a, result.distance.triangle_b);
    result.distance.normal = -result.distance.normal;
    return result;
  }
  PairCache own;
  RigidPair pair(a, motion_a, b, motion_b, request, scratch, cache != nullptr ? cache : &own);
  return pair.planes ? SeparatingPlaneTracker(pair, request).run()
                     : advanceConservatively(pair, request);
}

}  // namespace leeway::collision
