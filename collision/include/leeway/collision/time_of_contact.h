#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>

#include "leeway/collision/distance.h"
#include "leeway/collision/scene.h"

namespace leeway::collision {

/// Velocity of a frame at one moment, per unit of the motion's parameter t, in the world.
struct FrameVelocity {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< of the frame's origin [m]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< [rad]
};

/// Upper bounds on a frame's motion over an interval of its parameter t.
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
  /// The bound over [t0, t1], rounded outwards.
  virtual FrameMotionBound bound(double t0, double t1) const = 0;
  /// A bound on how far rounding in pose() moves a point within `reach` of the origin of A [m]. The
  /// rotation of pose(t) may depart from orthogonality by as much as that of pose(0), plus this
  /// rounding.
  virtual double rounding(double reach) const = 0;
};

/// Rotation from one orientation to another about an axis fixed in the world, at constant speed,
/// the shorter way (at most half a turn).
class AxisTurn {
 public:
  AxisTurn(const Eigen::Matrix3d& R_WA0, const Eigen::Matrix3d& R_WA1);
  /// The turn about a unit axis by `angle` [rad], which may be of any size.
  AxisTurn(const Eigen::Matrix3d& R_WA0, const Eigen::Vector3d& axis_W, double angle);
  Eigen::Matrix3d at(double t) const;
  const Eigen::Vector3d& axis() const { return axis_W_; }  ///< unit
  /// The angle of the whole turn [rad]; 0 to pi between two orientations.
  double angle() const { return angle_; }

 private:
  Eigen::Vector3d axis_W_;
  double angle_;
  // R_WA(t) = along + cos(angle t) across + sin(angle t) turned.
  Eigen::Matrix3d along_, across_, turned_;
};

/// A fixed body.
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

/// Straight motion: the origin of A moves along a straight line while A turns about an axis, both
/// at constant speed. This is the geodesic of R^3 x SO(3). At t = 1 the pose is X_WA1 up to
/// rounding.
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

/// A screw: rotation about a line fixed in the world and travel along it, both at constant speed.
/// Without rotation it is a straight line. At t = 1 the pose is X_WA1 up to rounding.
class ScrewMotion final : public RigidMotion {
 public:
  ScrewMotion(const Pose& X_WA0, const Pose& X_WA1);
  Pose pose(double t) const override;
  FrameVelocity velocity(double t) const override;
  FrameMotionBound bound(double t0, double t1) const override;
  double rounding(double reach) const override;

 private:
  Eigen::Vector3d start_;           // of the origin [m]
  Eigen::Vector3d along_, across_;  // parts of its travel along the axis and across it [m]
  Eigen::Vector3d turned_;          // axis x across [m]
  AxisTurn turn_;
  double cotangent_;  // of half the angle
};

/// The motion of a frame G (of a geometry) that is fixed to a moving body B. Borrows both
/// arguments.
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
  /// Allowed width of the interval of the time of contact [of the motion's parameter].
  double time_tolerance = 1e-6;
  /// Allowed width of distances on the way [m].
  double tolerance = 1e-9;
  /// The motion is followed over [0, end]; in [0, 1].
  double end = 1;
  /// Limit on distance and sweep queries. Reaching it leaves the rest of the motion undecided.
  int query_limit = 10'000;
};

enum class ContactStatus : unsigned char {
  kFree,       ///< certified: the separation exceeds the margin over [0, end]
  kContact,    ///< proven: above the margin before time.lower, at or below it at time.upper
  kUndecided,  ///< certified before time.lower; after that a limit or rounding left it open
  kInvalid,    ///< kInvalid of distance(), or a request out of its range
};

struct ContactResult {
  ContactStatus status = ContactStatus::kInvalid;
  /// Contains the first time of contact; (infinity, infinity) when free.
  Interval time{0, 0};
  /// At time.upper of a contact, otherwise at the last time that was queried; world coordinates.
  /// For bodies that are far apart only a lower end may be known. The normal is that of the bodies
  /// while they are apart: if they overlap at time.upper, it is the normal just before the contact.
  /// If two convex bodies are in contact at the start, it is the normal of the depth. With a margin
  /// below 0 it is the normal of the depth at time.upper. It is 0 if no normal is known.
  DistanceResult distance;
  int queries = 0;
  int pair = -1;  ///< index of Scene::pairs(), if a scene was queried
};

/// The first contact of two moving shapes. If they touch at the start, the time of contact is [0,
/// 0].
///
/// Convex shapes: distances are queried where Newton's method or a secant predicts the contact; the
/// time between two queries is certified from their separating planes with second-order bounds.
/// Meshes: conservative advancement (compare B. Mirtich, "Impulse-based dynamic simulation of rigid
/// body systems", 1996, section 2.3.2; X. Zhang, M. Lee, Y. J. Kim, "Interactive continuous
/// collision detection for non-convex polyhedra", 2006) and sweeps (sweptDistance()).
///
/// Never throws or allocates and always terminates; O(request.query_limit) distance queries.
/// `cache` may be null.
ContactResult timeOfContact(const Shape& a, const RigidMotion& motion_a, const Shape& b,
                            const RigidMotion& motion_b, const ContactRequest& request,
                            Scratch& scratch, PairCache* cache = nullptr);

/// A triangle whose corners move on straight lines from `from` to `to` (t in [0, 1]), like those of
/// a deforming mesh between two of its states.
struct MovingTriangle {
  std::array<Eigen::Vector3d, 3> from, to;  // [m]
};

/// The first contact of two such triangles, and of one and a convex shape that moves or is fixed
/// (kInvalid for a mesh). Equal corners make a triangle an edge or a point. Edges and points pass
/// through each other in an instant, so rounding proves no contact at a margin of 0: the answer is
/// kUndecided, with time.lower within the time tolerance. A margin of 1e-12 of the coordinates is
/// enough.
ContactResult timeOfContact(const MovingTriangle& a, const MovingTriangle& b,
                            const ContactRequest& request, Scratch& scratch);
ContactResult timeOfContact(const MovingTriangle& a, const Shape& b, const RigidMotion& motion_b,
                            const ContactRequest& request, Scratch& scratch);
ContactResult timeOfContact(const MovingTriangle& a, const Shape& b, const Pose& X_WB,
                            const ContactRequest& request, Scratch& scratch);

/// The first contact of a deforming mesh and a convex shape that moves in the mesh's frame. The
/// mesh's vertices move on straight lines from one snapshot (t = 0) to another snapshot of the same
/// mesh (t = 1). At the start its closed components are solids; later the shape can only enter them
/// through their triangles. `distance.triangle_a` is the triangle of the contact. kInvalid also for
/// snapshots of different meshes and for margins below 0.
///
/// Descends the hierarchy of `from` into the nodes that the shape may meet, earliest first. At any
/// time in between, a node lies in the blend of its boxes at both ends. A strategy without a
/// hierarchy costs O(triangles).
ContactResult timeOfContact(const std::shared_ptr<const DeformableSnapshot>& from,
                            const std::shared_ptr<const DeformableSnapshot>& to, const Shape& b,
                            const RigidMotion& motion_b, const ContactRequest& request,
                            Scratch& scratch);

/// The first contact of any pair of a scene: separation at or below the pair's margin plus
/// request.margin. `motions` has one entry for each body, null for a fixed body; kInvalid for
/// another number of entries. O(pairs) contact queries, each followed only up to the first contact
/// found.
ContactResult timeOfContact(const Scene& scene, std::span<const RigidMotion* const> motions,
                            const ContactRequest& request, Workspace& workspace);

}  // namespace leeway::collision
