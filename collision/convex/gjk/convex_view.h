#pragma once

// Private to collision/: a convex shape as a core with a radius, and the pose of one shape in the
// frame of another.

#include <Eigen/Core>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

class HullSupport;  // hull_support.h

/// The core of a convex shape, in the shape's own frame.
enum class Core : unsigned char {
  kPoint,      ///< the origin (sphere)
  kSegment,    ///< (0, 0, -size.z) to (0, 0, size.z) (capsule)
  kPoints,     ///< the hull of points[0 .. count)
  kBox,        ///< |x| <= size
  kCylinder,   ///< radius size.x, half length size.z, axis z
  kCone,       ///< base radius size.x at z = -size.z, apex at z = size.z
  kEllipsoid,  ///< semi-axes size
  kHalfSpace,  ///< z <= 0
};

/// A convex shape as a core grown by a radius: all that support functions need. Borrows points and
/// hull.
struct ConvexView {
  Core core = Core::kPoint;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  const Eigen::Vector3d* points = nullptr;
  int count = 0;
  const ConvexHull* hull = nullptr;                  ///< neighbour lists of `points`; may be null
  const HullSupport* support = nullptr;              ///< of `points`; may be null
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< roughly its middle: the start of a search
  double radius = 0;                                 ///< the shape is the core grown by this [m]
  /// No point of the core is farther from the frame's origin; rounding is proportional to it [m].
  double extent = 0;
  double excess = 0;  ///< the true shape may protrude from core + radius by this much [m]
};

/// The view of a convex shape (not of a mesh). O(1).
ConvexView viewOf(const Shape& shape);

/// The hull of `count` >= 1 points, grown by radius: for triangles, boxes of a hierarchy and
/// similar sets. O(count).
ConvexView viewOfPoints(const Eigen::Vector3d* points, int count, double radius);

/// X_BA of two poses in a common frame and its error. Translations are subtracted first.
struct RelativePose {
  Pose X_BA;
  /// Frames are within kFarthest of each other, and rotations are orthogonal within
  /// kRotationTolerance.
  bool valid = false;
  /// Rounding and departure from orthogonality, as a fraction: true distances differ from those
  /// under X_BA by at most slack * (extent of A + extent of B + |X_BA.translation|).
  double slack = 0;
};
RelativePose relativePose(const Pose& X_WA, const Pose& X_WB);

}  // namespace leeway::collision
