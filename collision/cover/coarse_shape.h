#pragma once

#include <Eigen/Core>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// A solid ball in some frame.
struct Ball {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  // [m]
  double radius = 0;                                 // [m]
};

/// An axis-aligned box in a shape's own frame [m].
struct AxisBox {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
};
/// The box around a hull (with its excess) or mesh, rounded outwards. O(vertices) of a hull, else
/// O(1).
AxisBox boxOf(const Shape& hull_or_mesh);

/// A stand-in for a placed shape that bounds the distance of a point in a few nanoseconds, which
/// decides most pairs without GJK. Spheres, capsules, boxes, cylinders and half-spaces stand for
/// themselves, a cylinder for a cone, a box for everything else.
class CoarseShape {
 public:
  CoarseShape() = default;
  /// The stand-in of `shape`, placed in frame F by X_FG. O(vertices).
  CoarseShape(const Shape& shape, const Pose& X_FG);

  /// A lower bound, rounding included, on the signed distance of the point to the shape [m];
  /// negative inside.
  double lower(const Eigen::Vector3d& p_F) const;
  /// An upper bound on the same distance; infinite where the stand-in is larger than the shape.
  double upper(const Eigen::Vector3d& p_F) const;

 private:
  enum class Kind : unsigned char { kBall, kSegment, kBox, kCylinder, kHalfSpace };
  double signedDistance(const Eigen::Vector3d& p_F) const;

  Kind kind_ = Kind::kBall;
  bool exact_ = false;
  Eigen::Matrix3d rotation_GF_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d center_F_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d half_ =
      Eigen::Vector3d::Zero();  // box; cylinder and segment: (radius, -, half length)
  double slack_ = 0;            // rounding at the shape [m]
};

/// Balls inside the shape, points where nothing larger is known, in frame F; a dozen or so at most.
/// They prove most collisions. Of solids the one in the middle comes first; of meshes they are
/// vertices far from each other. May be empty. O(vertices).
std::vector<Ball> innerBalls(const Shape& shape, const Pose& X_FG);

}  // namespace leeway::collision
