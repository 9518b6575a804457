#pragma once

#include "collision/mesh_descent.h"

namespace leeway::collision {

/// As descend(), for two meshes that do not move, over their oriented boxes and closed forms of
/// triangles. Once they are proven to overlap it ends: no deeper pairs are looked for. The result's
/// hull_lower holds for the bodies' hulls, too.
DescentResult descendPair(const DescentSide& a, const DescentSide& b,
                          const DescentPlacement& placement, const DistanceRequest& request,
                          Scratch& scratch, PairCache* cache);

/// Whether descendPair() takes this pair: sizes and distance within the range of single precision,
/// with room.
bool takesPair(const DescentSide& a, const DescentSide& b, const DescentPlacement& placement);

}  // namespace leeway::collision
