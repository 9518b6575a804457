#pragma once

#include <Eigen/Core>
#include <vector>

#include "leeway/collision/ball.h"
#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// An axis-aligned box in a shape's own frame [m].
struct AxisBox {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
};
/// The box around a hull (with its excess) or mesh, rounded outwards. O(vertices) for a hull, O(1)
/// for a mesh.
AxisBox boxOf(const Shape& hull_or_mesh);

/// A replacement for a placed shape that bounds the distance of a point in a few nanoseconds, which
/// decides most pairs without GJK. Spheres, capsules, boxes, cylinders and half-spaces are replaced
/// by themselves, a cone by a cylinder, and everything else by a box.
class CoarseShape {
 public:
  CoarseShape() = default;
  /// Makes the replacement for `shape`, placed in frame F by X_FG. O(vertices).
  CoarseShape(const Shape& shape, const Pose& X_FG);
  /// The same for a sphere that is placed in F.
  explicit CoarseShape(const Ball& ball_F);

  /// A lower bound, rounding included, on the signed distance of the point to the shape [m];
  /// negative inside.
  double lower(const Eigen::Vector3d& p_F) const;
  /// An upper bound on the same distance; infinite if the replacement is larger than the shape.
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

/// Balls inside the shape, or points if nothing larger is known, in frame F; about a dozen at most.
/// They prove most collisions. For solids the ball in the middle is the first one; for meshes the
/// balls are vertices far from each other. May be empty. O(vertices).
std::vector<Ball> innerBalls(const Shape& shape, const Pose& X_FG);

}  // namespace leeway::collision
