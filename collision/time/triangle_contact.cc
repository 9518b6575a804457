// The first contact of a triangle with moving corners, with another such triangle or a rigid body.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>

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

using Corners = std::array<Eigen::Vector3d, 3>;

Corners cornersAt(const MovingTriangle& m, double t) {
  Corners p;
  for (std::size_t i = 0; i < 3; ++i) p[i] = (1 - t) * m.from[i] + t * m.to[i];
  return p;
}

/// Largest distance of a corner from the origin [m].
double extentOf(const MovingTriangle& m) {
  double extent = 0;
  for (std::size_t i = 0; i < 3; ++i) extent = std::max({extent, m.from[i].norm(), m.to[i].norm()});
  return extent;
}

/// Speed of the fastest corner, rounded up. Corners move at constant velocities, which bound those
/// of all points.
double speedOf(const MovingTriangle& m) {
  double most = 0;
  for (std::size_t i = 0; i < 3; ++i) most = std::max(most, (m.to[i] - m.from[i]).norm());
  return most * (1 + 16 * kUnitRoundoff);
}

/// Velocity of the triangle's point that is at `point` while the corners are at p; if the corners
/// are on one line, that of the longest edge's point.
Eigen::Vector3d velocityAt(const MovingTriangle& m, const Corners& p,
                           const Eigen::Vector3d& point) {
  const auto velocity = [&](std::size_t i) { return Eigen::Vector3d(m.to[i] - m.from[i]); };
  const Eigen::Vector3d e = p[1] - p[0], f = p[2] - p[0], d = point - p[0];
  const double ee = e.squaredNorm(), ff = f.squaredNorm(), ef = e.dot(f);
  const double area = ee * ff - ef * ef;
  if (area > kParallelEdgesSquared * ee * ff) {
    const double u = (ff * e.dot(d) - ef * f.dot(d)) / area,
                 w = (ee * f.dot(d) - ef * e.dot(d)) / area;
    return (1 - u - w) * velocity(0) + u * velocity(1) + w * velocity(2);
  }
  std::size_t first = 0;
  double longest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double squared = (p[(i + 1) % 3] - p[i]).squaredNorm();
    if (!(squared > longest)) continue;
    longest = squared;
    first = i;
  }
  if (!(longest > 0)) return velocity(0);
  const std::size_t second = (first + 1) % 3;
  const double s = (p[second] - p[first]).dot(point - p[first]) / longest;
  return (1 - s) * velocity(first) + s * velocity(second);
}

/// The triangle's support along n at t.
double supportAlong(const MovingTriangle& m, const Eigen::Vector3d& n, double t) {
  double most = -kInfinity;
  for (const Eigen::Vector3d& p : cornersAt(m, t)) most = std::max(most, n.dot(p));
  return most;
}

bool isFinite(const MovingTriangle& m) {
  for (std::size_t i = 0; i < 3; ++i)
    if (!m.from[i].allFinite() || !m.to[i].allFinite()) return false;
  return true;
}

/// Two triangles with moving corners.
struct MovingTriangles {
  const MovingTriangle& a;
  const MovingTriangle& b;
  const ContactRequest& request;
  Scratch& scratch;
  double rounding;  ///< of corners at any time [m]
  double speed;     ///< of any point against any other
  PairCache cache;

  static bool hasDepth() { return true; }

  ContactSample sample(double t, double tolerance, bool depth) {
    const Corners pa = cornersAt(a, t), pb = cornersAt(b, t);
    ContactSample s;
    s.t = t;
    s.distance =
        convexDistance(viewOfPoints(pa.data(), 3, 0), Pose{}, viewOfPoints(pb.data(), 3, 0),
                       sampleRequest(request, tolerance, depth), scratch, &cache, rounding);
    const Eigen::Vector3d& n = s.distance.normal;
    s.closing =
        n.dot(velocityAt(a, pa, s.distance.point_a) - velocityAt(b, pb, s.distance.point_b));
    s.speed = speed;
    s.plane = s.distance.distance.lower - rounding;
    return s;
  }

  /// No start plane, because the query of two triangles is as cheap.
  static ContactSample startPlane() { return {}; }

  double separationAlong(const Eigen::Vector3d& n, double t) const {
    return -supportAlong(a, n, t) - supportAlong(b, -n, t) - rounding;
  }

  static double accelerationAlong(const Eigen::Vector3d&, double) { return 0; }
};

/// A triangle with moving corners, and a convex rigid body.
struct TriangleAndBody {
  const MovingTriangle& a;
  const Shape& b;
  const RigidMotion& motion;
  const ContactRequest& request;
  Scratch& scratch;
  ConvexView view;
  bool flat;      ///< B is a half-space: its plane is the only one
  bool planes;    ///< separating planes hold over time, unless B is a half-space that turns
  double extent;  ///< of the triangle's coordinates [m]
  double departure = 0;
  PairCache cache;
  int hint = 0;

  TriangleAndBody(const MovingTriangle& a_, const Shape& b_, const RigidMotion& motion_,
                  const ContactRequest& request_, Scratch& scratch_)
      : a(a_),
        b(b_),
        motion(motion_),
        request(request_),
        scratch(scratch_),
        view(viewOf(b_)),
        flat(b_.type() == ShapeType::kHalfSpace),
        planes(!flat || !(motion_.bound(0, request_.end).angular_speed > 0)),
        extent(extentOf(a_)),
        departure(relativePose(Pose{}, motion_.pose(0)).slack) {}

  /// Rounding of the corners and of the pose; for a half-space, where the triangle can touch it
  /// [m].
  double rounding(const Pose& X_WB) const {
    const double between = X_WB.translation.norm() + extent;
    const double reach = std::min(b.extent(), between);
    return kMotionRounding * extent + motion.rounding(reach) +
           kSupportRounding * kUnitRoundoff * (between + reach + view.radius) +
           departure * (between + reach);
  }

  static bool hasDepth() { return true; }

  ContactSample sample(double t, double tolerance, bool depth) {
    const Pose X_WB = motion.pose(t);
    const RelativePose X = relativePose(Pose{}, X_WB);
    const Corners pa = cornersAt(a, t);
    const double slack = rounding(X_WB);
    ContactSample s;
    s.t = t;
    if (!X.valid) return s;
    s.distance = convexDistance(viewOfPoints(pa.data(), 3, 0), X.X_BA, view,
                                sampleRequest(request, tolerance, depth), scratch, &cache, slack);
    s.distance.point_a = X_WB * s.distance.point_a;
    s.distance.point_b = X_WB * s.distance.point_b;
    s.distance.normal = X_WB.rotation * s.distance.normal;
    const Eigen::Vector3d& n = s.distance.normal;
    const FrameVelocity v = motion.velocity(t);
    const Eigen::Vector3d arm = s.distance.point_b - X_WB.translation;
    s.closing = n.dot(velocityAt(a, pa, s.distance.point_a) - v.linear - v.angular.cross(arm));
    s.plane = s.distance.distance.lower - slack;
    s.speed = pointSpeed(b, motion.bound(t, request.end)) + speedOf(a);
    return s;
  }

  /// No start plane, because nothing is cheaper than the query.
  static ContactSample startPlane() { return {}; }

  double separationAlong(const Eigen::Vector3d& n, double t) {
    const Pose X_WB = motion.pose(t);
    const Eigen::Vector3d m = flat ? Eigen::Vector3d(-X_WB.rotation.col(2)) : n;
    double lowest = m.dot(X_WB.translation);
    if (!flat) {
      const Eigen::Vector3d up = -rotatedBack(X_WB.rotation, m);
      lowest -= up.dot(farthest(view, up, hint));
    }
    return lowest - view.radius - view.excess - supportAlong(a, m, t) - rounding(X_WB);
  }

  double accelerationAlong(const Eigen::Vector3d& n, double t) const {
    return collision::accelerationAlong(b, motion, n, t, request.end) * (1 + 16 * kUnitRoundoff);
  }

  /// The hull of the triangle at both ends against B, in B's frame, where a turning half-space is
  /// fixed.
  bool isFreeOver(double t, double step) {
    const Pose X_WB0 = motion.pose(t), X_WB1 = motion.pose(t + step);
    const Corners a0 = cornersAt(a, t), a1 = cornersAt(a, t + step);
    const FrameMotionBound m = motion.bound(t, t + step);
    std::array<Eigen::Vector3d, 6> hull;
    const double speed = speedOf(a) + m.speed;
    double reach = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      hull[i] = rotatedBack(X_WB0.rotation, a0[i] - X_WB0.translation);
      hull[3 + i] = rotatedBack(X_WB1.rotation, a1[i] - X_WB1.translation);
      reach = std::max(reach, hull[i].norm());
    }
    const double bent =
        accelerationSeenFrom(m, m.acceleration, speed, reach + step * speed) * step * step / 8;
    const double slack =
        bent * kGrowthOutwards + std::max(rounding(X_WB0), rounding(X_WB1)) +
        kTransferRounding * (extent + X_WB0.translation.norm() + X_WB1.translation.norm());
    if (!(slack < kInfinity)) return false;
    return convexDistance(viewOfPoints(hull.data(), 6, 0), Pose{}, view, sweepRequest(request),
                          scratch, nullptr, slack)
               .distance.lower > request.margin;
  }
};

}  // namespace

ContactResult timeOfContact(const MovingTriangle& a, const MovingTriangle& b,
                            const ContactRequest& request, Scratch& scratch) {
  if (!isFinite(a) || !isFinite(b)) return {};
  const double rounding = kMotionRounding * (extentOf(a) + extentOf(b));
  MovingTriangles pair{a, b, request, scratch, rounding, speedOf(a) + speedOf(b), {}};
  return SeparatingPlaneTracker(pair, request).run();
}

ContactResult timeOfContact(const MovingTriangle& a, const Shape& b, const RigidMotion& motion_b,
                            const ContactRequest& request, Scratch& scratch) {
  if (!isFinite(a) || !b.isConvex()) return {};
  TriangleAndBody pair(a, b, motion_b, request, scratch);
  return pair.planes ? SeparatingPlaneTracker(pair, request).run()
                     : advanceConservatively(pair, request);
}

ContactResult timeOfContact(const MovingTriangle& a, const Shape& b, const Pose& X_WB,
                            const ContactRequest& request, Scratch& scratch) {
  return timeOfContact(a, b, Still(X_WB), request, scratch);
}

}  // namespace leeway::collision
