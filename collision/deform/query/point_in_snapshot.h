#pragma once

#include "collision/deform/snapshot.h"
#include "collision/mesh/point_in_solid.h"
#include "leeway/collision/query.h"

namespace leeway::collision {

/// sideOf() for a closed component of a deforming mesh (its vertices' coordinates below
/// kSmallestExact taken for 0). O(log n) to O(n), where nodes are known.
Side sideOf(const DeformableSnapshotImpl& snapshot, int component, const Eigen::Vector3d& point,
            Scratch& scratch);

}  // namespace leeway::collision
