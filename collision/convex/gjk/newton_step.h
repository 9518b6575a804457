#pragma once

#include "collision/convex/gjk/simplex.h"

namespace leeway::collision {

// Newton steps in place of GJK's, for cores with curved surfaces.
//
// The lower end phi(n) = min of n . w over the difference is concave. Near its maximum over unit
// vectors it falls by 1/2 d . (K + phi) d for a turn d, where K is the curvature of the cores at
// their support points. Each point of the simplex adds a plane above phi. GJK's next direction is
// the maximum of these planes minus 1/2 phi |d|^2: it ignores K, overshoots, and converges slowly
// where phi is small compared with the radii. Scale space by T, with T^T T = phi (K + phi)^-1
// across n and 1 along it. The nearest point of T (simplex) then gives the maximum including K.

/// Computes the rows of T at the direction n; false if there is no T (phi <= 0, or a singular
/// form).
bool newtonScaling(const Difference<false>& difference, const Vector& n, double phi,
                   Vector rows[3]);

/// Updates the planes of a Newton step: each point of the simplex moves to where its pieces of the
/// two surfaces are farthest along n. A point that becomes the newest one is dropped.
void followPieces(const Difference<false>& difference, const Vector& n, Simplex& simplex);

}  // namespace leeway::collision
