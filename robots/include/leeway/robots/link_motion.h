#pragma once

#include <memory>
#include <span>
#include <vector>

#include "leeway/collision/time_of_contact.h"
#include "leeway/collision/time_to_impact.h"
#include "leeway/robots/motion_bound.h"

namespace leeway::robots {

/// The motion of a link's frame along an edge q(t) = q0 + t dq, t in [0, 1], for
/// collision::timeOfContact(). Has buffers: one thread at a time.
class LinkMotion final : public collision::RigidMotion {
 public:
  /// q0 has one number a variable, dq is as for jointMotion(). Throws std::invalid_argument for
  /// another number of them, or a link that the model does not have. O(joints^2).
  LinkMotion(std::shared_ptr<const Model> model, int link, std::span<const double> q0,
             std::span<const double> dq);

  Pose pose(double t) const override;
  collision::FrameVelocity velocity(double t) const override;
  collision::FrameMotionBound bound(double t0, double t1) const override;
  double rounding(double reach) const override;

  /// The configuration at t, one number a variable. Floating joints turn from q0 by t times their
  /// rotation vector.
  void configuration(double t, std::span<double> q) const;

 private:
  void place(double t) const;

  std::shared_ptr<const Model> model_;
  int link_;
  std::vector<double> q0_, dq_, rates_;  // one a variable; rates: one a joint, mimics' too
  std::vector<int> path_;                // joints above the link, the root's first
  collision::FrameMotionBound bound_;
  double base_reach_ = 0;
  mutable std::vector<double> q_;
  mutable std::vector<Pose> X_WL_;
  mutable double placed_ = -1;  // the t of q_ and X_WL_
};

/// Limits on the variables' rates, one number a variable; infinite where unknown.
struct RateLimits {
  std::span<const double> velocity;      // [rad/s or m/s]
  std::span<const double> acceleration;  // [rad/s^2 or m/s^2]
};

/// Bounds on the speed of a body's points for collision::ImpactSchedule: now, with the variables at
/// the rates `velocity` (one a variable; floating: as in jointMotion()), and later, within the
/// limits; a joint that is faster than its limit now may stay so. `motion` is relativeMotion(model,
/// link, -1, sphere of the body). Acceleration includes the centripetal and Coriolis parts at these
/// velocities. Infinite where a limit that matters is. O(terms).
collision::PointMotion pointMotion(const Model& model, const RelativeMotion& motion,
                                   std::span<const double> velocity, const RateLimits& limits);

}  // namespace leeway::robots
