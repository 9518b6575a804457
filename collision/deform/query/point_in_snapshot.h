#pragma once

#include "collision/deform/snapshot.h"
#include "collision/mesh/point_in_solid.h"
#include "leeway/collision/query.h"

namespace leeway::collision {

/// The side of a closed component of a deforming mesh on which a point lies. Coordinates of
/// vertices below kSmallestExact count as 0. O(log n) to O(n) if nodes are known.
Side sideOf(const DeformableSnapshotImpl& snapshot, int component, const Eigen::Vector3d& point,
            Scratch& scratch);

}  // namespace leeway::collision
