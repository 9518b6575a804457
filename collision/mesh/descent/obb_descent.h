#pragma once

#include "collision/mesh/descent/mesh_descent.h"

namespace leeway::collision {

/// As descend(), for bodies that do not move, over oriented boxes: closed forms of triangles, and
/// hulls where both bodies have convex parts. A pair of those answers alone where their excess does
/// not matter to the request; else their triangles are looked at. Surfaces that are proven to
/// overlap end it; only where both bodies consist of convex parts (and a depth is asked) deeper
/// pairs of them are looked for, for a while. The result's hull_lower holds for the bodies' hulls,
/// too.
DescentResult descendPair(const DescentSide& a, const DescentSide& b,
                          const DescentPlacement& placement, const DistanceRequest& request,
                          Scratch& scratch, PairCache* cache);

/// Whether descendPair() takes this pair: two meshes, or a mesh with convex pieces and a bounded
/// convex shape; sizes and distance within the range of single precision, with room.
bool takesPair(const DescentSide& a, const DescentSide& b, const DescentPlacement& placement);

/// Whether descendPair() looks for deeper pairs of these bodies.
bool deepensPair(const DescentSide& a, const DescentSide& b);

}  // namespace leeway::collision
