#pragma once

// Private to collision/: branch and bound over pairs of nodes when a deforming mesh is one of the
// bodies.

#include "collision/deform/snapshot.h"
#include "collision/mesh/descent/mesh_descent.h"

namespace leeway::collision {

/// One of the two bodies: a snapshot, or what DescentSide holds.
struct DeformSide {
  const DeformableSnapshotImpl* snapshot = nullptr;
  DescentSide rigid;          ///< when there is no snapshot
  Eigen::Vector3d low, high;  ///< a box that holds the body, in its own frame; may be infinite
  double extent = 0;          ///< no point is farther from its frame's origin; may be infinite
};

DeformSide deformSide(const Shape& shape);

/// As descend(); at least one of the two is a snapshot. `hull_lower` is what boxes around the
/// bodies prove.
DescentResult deformDescend(const DeformSide& a, const DeformSide& b,
                            const DescentPlacement& placement, const DistanceRequest& request,
                            Scratch& scratch, PairCache* cache);

}  // namespace leeway::collision
