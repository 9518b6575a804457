#pragma once

#include "collision/mesh/descent/mesh_descent.h"

namespace leeway::collision {

/// descend() for bodies at rest, over oriented boxes, with closed forms for triangles, and hulls if
/// both bodies consist of convex parts. A pair of hulls suffices if their excess does not matter to
/// the request; otherwise their triangles are visited. Overlap of surfaces ends the descent, unless
/// both bodies consist of convex parts and a depth is requested. In that case it searches for
/// deeper pairs with limited effort (kDeeperNodes). hull_lower of the result also holds for the
/// bodies' hulls.
DescentResult descendPair(const DescentSide& a, const DescentSide& b,
                          const DescentPlacement& placement, const DistanceRequest& request,
                          Scratch& scratch, PairCache* cache);

/// Whether descendPair() accepts this pair: two meshes, or a mesh and a bounded convex shape, with
/// sizes and distance well within the range of single precision.
bool takesPair(const DescentSide& a, const DescentSide& b, const DescentPlacement& placement);

/// Whether descendPair() searches for deeper pairs of these bodies.
bool deepensPair(const DescentSide& a, const DescentSide& b);

}  // namespace leeway::collision
