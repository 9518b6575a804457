#pragma once

#include "collision/base/vector.h"

namespace leeway::collision {

/// Nearest points of two triangles and a plane between them.
struct TrianglePair {
  Vector p, q;    ///< points of the triangles
  Vector normal;  ///< unit, from P to Q
  double above;   ///< |q - p|: at least the distance, up to rounding [m]
  double below;   ///< proven by the plane, up to rounding: least normal . (q_i - p_j) [m]
};

/// The distance of two triangles in the same frame, degenerate ones included: nearest points of the
/// nine pairs of edges and of each corner and the other triangle (E. Larsen, S. Gottschalk, M. C.
/// Lin, D. Manocha, "Fast distance queries with rectangular swept sphere volumes", 2000). Both ends
/// hold whichever case was selected: `above` is the distance of two points of the triangles,
/// `below` that of two planes around them. If they disagree (triangles that cross, slivers), the
/// caller needs a slower query. O(1).
TrianglePair trianglePair(const Vector* p, const Vector* q);

}  // namespace leeway::collision
