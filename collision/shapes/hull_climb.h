#pragma once

// Private to collision/: the farthest vertex of a hull, by a plain scan or by climbing its edges.

#include "collision/base/vector.h"
#include "leeway/collision/convex_hull.h"

namespace leeway::collision {

/// Index of the point with the largest dot product; the lowest index of several. O(count).
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

/// As scanFarthest(), by steepest ascent along the edges of a hull from `start`; values within
/// `doubt` of each other are not told apart by rounding. The answer is as good as a scan's: on the
/// surface of a convex polytope the vertices above any level hang together by edges, so if the
/// climb's end and all that is connected with it by vertices within `doubt` of it have no better
/// neighbour, there is none anywhere. (The hull's facets are convex exactly, see HullBuilder.)
int climbFarthest(const ConvexHull& hull, const Vector* points, int count, const Vector& direction,
                  int start, double doubt);

}  // namespace leeway::collision
