#pragma once

#include "collision/convex/epa/polytope_surface.h"
#include "collision/convex/gjk/progress.h"
#include "collision/convex/gjk/simplex.h"

namespace leeway::collision {

/// Both ends of the signed separation near and below contact, from where runGjk() ended (one to
/// four points). Goes on until the request is met, the iterations are used up or rounding stops it.
/// Never throws or allocates.
///
/// The expanding polytope of van den Bergen (2001) grows inside the difference where its surface is
/// nearest to the origin. Its claims do not rest on convexity. The surface is closed and oriented
/// by construction: facets are only ever replaced by a fan over the loop that bounds them. While it
/// winds around the origin, every point nearer to the origin than all triangles is in the hull of
/// the vertices, hence in the difference, however rounding bends the surface. So -(distance of the
/// nearest triangle) is an upper end; any support plane gives a lower end. An origin slightly
/// outside (GJK stagnated near contact) is no exception: the facets that see it come first.
void growPolytope(Difference<false>& difference, const Simplex& start, PolytopeBuffers& buffers,
                  Progress& progress);

}  // namespace leeway::collision
