#pragma once

// Private to collision/: the farthest vertex of a hull, by a scan or by hill climbing on its edges.

#include "collision/base/vector.h"
#include "leeway/collision/convex_hull.h"

namespace leeway::collision {

/// Index of the point with the largest dot product; the lowest index if there are several.
/// O(count).
inline int scanFarthest(const Vector* points, int count, const Vector& direction) {
  int best = 0;
  double best_value = direction.dot(points[0]);
  for (int i = 1; i < count; ++i) {
    const double value = direction.dot(points[i]);
    if (value > best_value) {
      best_value = value;
      best = i;
    }
  }
  return best;
}

/// A farthest vertex, by steepest ascent along the edges of a hull from `start`; rounding does not
/// distinguish values within `doubt` of each other. The result is as good as that of a scan: on a
/// convex polytope, the vertices above any level are connected by edges. If neither the climb's end
/// nor any vertex connected to it through vertices within `doubt` has a better neighbour, no vertex
/// is better. (The hull is exactly convex, see HullBuilder.)
int climbFarthest(const ConvexHull& hull, const Vector* points, int count, const Vector& direction,
                  int start, double doubt);

}  // namespace leeway::collision
