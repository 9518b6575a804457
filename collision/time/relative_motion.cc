#include "collision/time/relative_motion.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "collision/base/tolerances.h"

namespace leeway::collision {

double accelerationAlong(const Shape& shape, const RigidMotion& motion, const Eigen::Vector3d& n,
                         double t, double end) {
  const FrameMotionBound m = motion.bound(t, end);
  double turning = turningAcceleration(m);
  // At constant angular velocity the acceleration is centripetal: across the axis. Along n it is at
  // most w^2 times the part of n across the axis.
  if (m.angular_acceleration == 0 && m.angular_speed > 0)
    turning = std::min(
        turning, (n.cross(motion.velocity(t).angular).norm() + kMotionRounding * m.angular_speed) *
                     m.angular_speed);
  return m.acceleration + times(turning, shape.extent());
}

}  // namespace leeway::collision
