#pragma once

// Private to collision/: branch and bound for two bodies, at least one of which is a deforming
// mesh.

#include "collision/deform/query/deform_side.h"
#include "collision/mesh/descent/mesh_descent.h"

namespace leeway::collision {

/// descend() for deforming meshes: at least one of the two is a snapshot; `hull_lower` is the bound
/// that the boxes around the bodies prove. Each stage has its own file: pair_descent.cc (two
/// deforming meshes), rigid_descent.cc, round_descent.cc, octree_descent.cc, piece_pairs.cc.
DescentResult deformDescend(const DeformSide& a, const DeformSide& b,
                            const DescentPlacement& placement, const DistanceRequest& request,
                            Scratch& scratch, PairCache* cache);

}  // namespace leeway::collision
