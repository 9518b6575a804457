#pragma once

#include <Eigen/Core>

#include "collision/convex/gjk/convex_view.h"
#include "collision/mesh/mesh_tree.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// One of the two bodies of a descent: a hierarchy, or a convex shape as a whole (tree is null).
struct DescentSide {
  const MeshTree* tree = nullptr;
  ConvexView view;            ///< of a convex shape
  Eigen::Vector3d center;     ///< of a sphere that contains the body, in its own frame [m]
  double radius = 0;          ///< of that sphere; may be infinite [m]
  Eigen::Vector3d low, high;  ///< a box that contains the body, in its own frame; may be infinite
                              ///< [m]
  double hull_excess = 0;     ///< of a mesh, as TriangleMesh::hullExcess() [m]
  bool has_solid_pieces = false;  ///< of a mesh: each convex piece is a whole component
  double extent =
      0;  ///< no point is farther from the frame's origin; infinite for a half-space [m]
};

/// The side of a rigid mesh or a convex shape. O(1).
DescentSide descentSide(const Shape& shape);

/// The pose of A in B's frame; for a sweep, at its start and at its end.
struct DescentPlacement {
  Pose X_BA0, X_BA1;
  bool swept = false;
  double growth = 0;  ///< of the swept body [m], see convexSweptDistance()
  double slack = 0;   ///< rounding of the poses [m], see convexDistance()
};

}  // namespace leeway::collision
