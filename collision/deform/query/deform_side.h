#pragma once

// Private to collision/: a body in a query that involves a deforming mesh.

#include "collision/deform/snapshot.h"
#include "collision/mesh/descent/mesh_descent.h"

namespace leeway::collision {

/// One of the two bodies: a snapshot, or a rigid body.
struct DeformSide {
  const DeformableSnapshotImpl* snapshot = nullptr;
  DescentSide rigid;          ///< used when there is no snapshot
  Eigen::Vector3d low, high;  ///< a box that contains the body, in its own frame; may be infinite
  double extent = 0;  ///< greatest distance of a point from the frame's origin [m]; may be infinite
};

DeformSide deformSide(const Shape& shape);

}  // namespace leeway::collision
