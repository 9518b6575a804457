#pragma once

#include "collision/base/vector.h"

namespace leeway::collision {

/// Points of two triangles near to each other, and the plane between them.
struct TrianglePair {
  Vector p, q;    ///< points of the triangles
  Vector normal;  ///< unit, from P to Q
  double above;   ///< |q - p|, without any allowance for rounding: not less than the distance
  double below;   ///< what the plane proves: the least normal . (corner of Q - corner of P)
};

/// The distance of two triangles in the same frame, degenerate ones included: nearest points of the
/// nine pairs of edges and of each corner and the other triangle (E. Larsen, S. Gottschalk, M. C.
/// Lin, D. Manocha, "Fast distance queries with rectangular swept sphere volumes", 2000). Nothing
/// rests on the case found being the right one: `above` is the distance of two points that are
/// there, `below` that of two planes; where they do not agree (triangles that cross, slivers) the
/// caller has to ask a slower query. O(1).
TrianglePair trianglePair(const Vector* p, const Vector* q);

}  // namespace leeway::collision
