#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>

#include "leeway/collision/distance.h"
#include "leeway/collision/scene.h"

namespace leeway::collision {

/// Velocity of a frame at one moment, per unit of the motion's parameter, in the world.
struct FrameVelocity {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< of the frame's origin [m]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< [rad]
};

/// What a frame's motion does not exceed over an interval of its parameter.
struct FrameMotionBound {
  double speed = 0;                 ///< of the origin [m]
  double acceleration = 0;          ///< of the origin [m]
  double angular_speed = 0;         ///< [rad]
  double angular_acceleration = 0;  ///< [rad]
};

/// A rigid motion X_WA(t), t in [0, 1]. Implementations are constant while queried.
class RigidMotion {
 public:
  virtual ~RigidMotion() = default;
  virtual Pose pose(double t) const = 0;
  virtual FrameVelocity velocity(double t) const = 0;
  /// Rounded outwards.
  virtual FrameMotionBound bound(double t0, double t1) const = 0;
  /// A bound on how far rounding in pose() moves a point within `reach` of the origin of A [m]; its
  /// rotations depart from orthogonality as pose(0)'s does, and by no more than such rounding.
  virtual double rounding(double reach) const = 0;
};

/// The rotation about one axis that is fixed in the world, at constant speed, from one orientation
/// to another; half turns and a bit go the shorter way. The turned matrix is linear in sine and
/// cosine of the angle.
class AxisTurn {
 public:
  AxisTurn(const Eigen::Matrix3d& R_WA0, const Eigen::Matrix3d& R_WA1);
  Eigen::Matrix3d at(double t) const;
  const Eigen::Vector3d& axis() const { return axis_W_; }  ///< unit
  double angle() const { return angle_; }                  ///< of all of it, 0 to pi [rad]

 private:
  Eigen::Vector3d axis_W_;
  double angle_;
  Eigen::Matrix3d along_, across_, turned_;
};

/// No motion.
class Still final : public RigidMotion {
 public:
  explicit Still(const Pose& X_WA) : X_WA_(X_WA) {}
  Pose pose(double) const override { return X_WA_; }
  FrameVelocity velocity(double) const override { return {}; }
  FrameMotionBound bound(double, double) const override { return {}; }
  double rounding(double) const override { return 0; }

 private:
  Pose X_WA_;
};

/// The origin of A travels on the straight line, the rotation about one axis, both at constant
/// speed: the geodesic of R^3 x SO(3). At t = 1 it is X_WA1 but for rounding.
class StraightMotion final : public RigidMotion {
 public:
  StraightMotion(const Pose& X_WA0, const Pose& X_WA1);
  Pose pose(double t) const override;
  FrameVelocity velocity(double t) const override;
  FrameMotionBound bound(double t0, double t1) const override;
  double rounding(double reach) const override;

 private:
  Eigen::Vector3d start_, travel_;  // of the origin [m]
  AxisTurn turn_;
};

/// A screw: rotation about a line that is fixed in the world and travel along it, both at constant
/// speed; the straight line where there is no rotation. Ends as StraightMotion.
class ScrewMotion final : public RigidMotion {
 public:
  ScrewMotion(const Pose& X_WA0, const Pose& X_WA1);
  Pose pose(double t) const override;
  FrameVelocity velocity(double t) const override;
  FrameMotionBound bound(double t0, double t1) const override;
  double rounding(double reach) const override;

 private:
  Eigen::Vector3d start_, along_, across_,
      turned_;  // of the origin; parts of its travel; axis x across [m]
  AxisTurn turn_;
  double cotangent_;  // of half the angle
};

/// The motion of a frame G that is fixed to a body B: a geometry's, from its body's. Borrows both.
class MountedMotion final : public RigidMotion {
 public:
  MountedMotion(const RigidMotion& body, const Pose& X_BG) : body_(body), X_BG_(X_BG) {}
  Pose pose(double t) const override { return body_.pose(t) * X_BG_; }
  FrameVelocity velocity(double t) const override;
  FrameMotionBound bound(double t0, double t1) const override;
  double rounding(double reach) const override;

 private:
  const RigidMotion& body_;
  const Pose& X_BG_;
};

struct ContactRequest {
  /// Contact is a separation of this or less [m]; may be negative (allowed depth).
  double margin = 0;
  /// How wide the interval of the time of contact may be [of the motion's parameter].
  double time_tolerance = 1e-6;
  /// How well distances on the way are known [m].
  double tolerance = 1e-9;
  /// The motion is followed up to here, in [0, 1].
  double end = 1;
  /// Distance and sweep queries. Reaching it leaves the rest of the motion undecided.
  int query_limit = 10'000;
};

enum class ContactStatus : unsigned char {
  kFree,       ///< certified: the separation exceeds the margin over [0, end]
  kContact,    ///< proven: it does so before time.lower and does not at time.upper
  kUndecided,  ///< certified before time.lower; beyond, a limit or rounding left it open
  kInvalid,    ///< what distance() calls so, or a request that makes no sense
};

struct ContactResult {
  ContactStatus status = ContactStatus::kInvalid;
  /// The first time of contact lies in it; (infinity, infinity) when free.
  Interval time{0, 0};
  /// At time.upper of a contact, else at the last time that was looked at; world coordinates. Of
  /// bodies that are far from each other only a lower end may be known.
  DistanceResult distance;
  int queries = 0;
  int pair = -1;  ///< of the scene, where one was asked
};

/// The first contact of two shapes that move. Convex ones are looked at where Newton's method or a
/// secant expects the contact, and what lies between two looks is certified from their planes with
/// second-order bounds; meshes advance conservatively (compare B. Mirtich 1996, section 2.3.2;
/// X. Zhang, M. Lee, Y. J. Kim, "Interactive continuous collision detection for non-convex
/// polyhedra", 2006) and by sweeps (sweptDistance()). In contact at the start: contact at [0, 0].
/// Never throws, allocates or loops without end. `cache` may be null.
ContactResult timeOfContact(const Shape& a, const RigidMotion& motion_a, const Shape& b,
                            const RigidMotion& motion_b, const ContactRequest& request,
                            Scratch& scratch, PairCache* cache = nullptr);

/// A triangle whose corners travel on straight lines from `from` to `to` (t in [0, 1]), as those of
/// a deforming mesh between two of its states.
struct MovingTriangle {
  std::array<Eigen::Vector3d, 3> from, to;  // [m]
};

/// The same for two such triangles, and for one and a convex shape that moves or stands (kInvalid
/// for a mesh).
ContactResult timeOfContact(const MovingTriangle& a, const MovingTriangle& b,
                            const ContactRequest& request, Scratch& scratch);
ContactResult timeOfContact(const MovingTriangle& a, const Shape& b, const RigidMotion& motion_b,
                            const ContactRequest& request, Scratch& scratch);
ContactResult timeOfContact(const MovingTriangle& a, const Shape& b, const Pose& X_WB,
                            const ContactRequest& request, Scratch& scratch);

/// The same for a whole deforming mesh whose vertices travel on straight lines from those of one
/// snapshot (t = 0) to those of another of the same mesh (t = 1), and a convex shape that moves in
/// the mesh's frame. At the start the mesh's closed components are solids; later nothing comes into
/// them but through their triangles. The hierarchy of `from` is followed into what the body may
/// meet, earliest parts first: the boxes of a node at both ends bound it at all times between. A
/// strategy without a hierarchy costs O(triangles). `distance.triangle_a` is the triangle that was
/// met. kInvalid also for snapshots of different meshes and margins below 0.
ContactResult timeOfContact(const std::shared_ptr<const DeformableSnapshot>& from,
                            const std::shared_ptr<const DeformableSnapshot>& to, const Shape& b,
                            const RigidMotion& motion_b, const ContactRequest& request,
                            Scratch& scratch);

/// The first contact (separation at or below the pair's own margin, plus request.margin) of any
/// pair of a scene of which every body moves as told: one motion a body, null for bodies that do
/// not move. O(pairs) contact queries; later pairs are followed only to the first contact found.
ContactResult timeOfContact(const Scene& scene, std::span<const RigidMotion* const> motions,
                            const ContactRequest& request, Workspace& workspace);

}  // namespace leeway::collision
