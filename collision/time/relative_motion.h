#pragma once

// Bounds on the motion of bodies' points, from those of their frames.

#include "leeway/collision/shape.h"
#include "leeway/collision/time_of_contact.h"

namespace leeway::collision {

/// rate * reach, and 0 without rotation: an unbounded body (half-space) may still slide.
inline double times(double rate, double reach) { return rate == 0 ? 0 : rate * reach; }

/// Rate at which rotation accelerates points, divided by their distance from the origin [rad^2]:
/// tangential and centripetal.
inline double turningAcceleration(const FrameMotionBound& m) {
  return m.angular_acceleration + m.angular_speed * m.angular_speed;
}

/// Speed and acceleration of any point of a body, in the world [m].
inline double pointSpeed(const Shape& shape, const FrameMotionBound& m) {
  return m.speed + times(m.angular_speed, shape.extent());
}
inline double pointAcceleration(const Shape& shape, const FrameMotionBound& m) {
  return m.acceleration + times(turningAcceleration(m), shape.extent());
}

/// Acceleration along the world's n of any point of a body, over [t, end] [m]. O(1).
double accelerationAlong(const Shape& shape, const RigidMotion& motion, const Eigen::Vector3d& n,
                         double t, double end);

/// Acceleration of a point relative to a body B that moves within `m` [m]. With u = p - o_B within
/// `reach`, |u'| within `speed` and |u''| within `acceleration`, p_B = R^T u gives |p_B''| <= |u''|
/// + 2 w |u'| + (alpha + w^2) |u|.
inline double accelerationSeenFrom(const FrameMotionBound& m, double acceleration, double speed,
                                   double reach) {
  return acceleration + times(2 * m.angular_speed, speed) + times(turningAcceleration(m), reach);
}

}  // namespace leeway::collision
