#pragma once

#include <vector>

#include "collision/convex/epa/polytope_fan.h"
#include "collision/convex/gjk/progress.h"
#include "collision/convex/gjk/sharp.h"

namespace leeway::collision {

/// Memory of one sharpPolytope(); sized once.
struct SharpPolytopeBuffers {
  SharpPolytopeBuffers();

  struct Corner {
    DoubleDoubleVector w;  ///< b - a, in the world's axes
    Vector a;              ///< the point of A, in B's frame
  };
  struct Facet {
    int corner[3];
    int neighbour[3];            ///< across edge i, from corner[i] to the next
    DoubleDoubleVector outward;  ///< unit
    DoubleDouble height;         ///< no corner is less far along it
    /// Where the origin is not behind it: how far its nearest point is.
    DoubleDouble nearest;
    int mark;
    bool alive;
  };
  std::vector<Corner> corners;
  std::vector<Facet> facets;
  std::vector<int> free, visible;
  std::vector<HorizonEdge> rim;  ///< the edges around those that are seen, in order
};

/// Both ends near contact, apart or overlapping, where rounding to double ended other searches: an
/// expanding polytope (van den Bergen 2001) in the difference of the bodies at their world poses,
/// all in twice the precision, from its own start: six directions along and across
/// progress.normal(). As growPolytope() it claims a depth only where the closed surface is proven
/// to wind around the origin. Some hundred supports at the most, each O(vertices);
/// progress.iterations counts them.
void growSharpPolytope(const SharpDifference& difference, SharpPolytopeBuffers& buffers,
                       Progress& progress);

}  // namespace leeway::collision
