#pragma once

#include "collision/convex/epa/polytope_surface.h"
#include "collision/convex/gjk/progress.h"
#include "collision/convex/gjk/simplex.h"

namespace leeway::collision {

/// Finds both ends of the signed separation near and below contact, from the end of runGjk() (one
/// to four points). Continues until the request is met, the iterations are used up or rounding
/// stops it. Never throws or allocates.
///
/// The expanding polytope of van den Bergen (2001) grows inside the difference where its surface is
/// nearest to the origin. Its claims do not depend on convexity. The surface is closed and oriented
/// by construction, because facets are only ever replaced by a fan over the loop that bounds them.
/// While it winds around the origin, every point that is closer to the origin than all triangles
/// lies in the hull of the vertices, and so in the difference, however rounding bends the surface.
/// Therefore -(distance of the nearest triangle) is an upper end, and any support plane gives a
/// lower end. This also holds for an origin slightly outside (GJK stagnated near contact): the
/// facets that see it are processed first.
void growPolytope(Difference<false>& difference, const Simplex& start, PolytopeBuffers& buffers,
                  Progress& progress);

}  // namespace leeway::collision
