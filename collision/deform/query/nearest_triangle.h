#pragma once

// Private to collision/: the triangle of a deforming mesh that is nearest to a point or a segment,
// which is what spheres and capsules ask for.

#include <Eigen/Core>
#include <cstdint>
#include <limits>

#include "collision/deform/snapshot.h"

namespace leeway::collision {

/// What is asked of a search; distances are those of the core, a point or a segment [m].
struct NearestSearch {
  Eigen::Vector3d middle;  ///< of the core, in the mesh's frame; finite
  Eigen::Vector3d half;    ///< from there to one of a segment's ends; 0 for a point
  double reach = std::numeric_limits<double>::infinity();  ///< what is farther is not looked for
  double enough = 0;        ///< a triangle that is as near ends the search
  double tolerance = 0;     ///< what is nearer than the nearest so far by less is not looked for
  double size = 0;          ///< of all coordinates at play, which rounding grows with
  double slack = 0;         ///< the core's own error, which both ends are to hold
  std::int32_t first = -1;  ///< slot of a triangle that is looked at first; -1: none
  int limit = 0;            ///< nodes and leaves
};

struct NearestFound {
  std::int32_t slot = -1;  ///< of the nearest triangle; -1: none is within reach
  double upper = std::numeric_limits<double>::infinity();  ///< it is no farther
  double own_lower = 0;                                    ///< nor is it nearer
  /// The core's point that is nearest to it, from the core's middle, and the way from there to it,
  /// as rounding left them.
  Eigen::Vector3d from, way;
  /// No other triangle is nearer; 0 when the search has ended before it knew.
  double lower = 0;
  int visited = 0;  ///< nodes and leaves
};

/// Branch and bound, nearer nodes first. Triangles are looked at several at a time, by closed
/// forms: ends of a segment and the triangle, the segment and its edges (C. Ericson, "Real-Time
/// Collision Detection", 2005, sections 5.1.5 and 5.1.9). The plane across the way proves the lower
/// end, whatever rounding did to the two points and though a segment may cross the triangle. Every
/// instruction set yields the same bytes.
NearestFound findNearest(const NearestSearch& search, const DeformableSnapshotImpl& snapshot,
                         const BoxSource& source);

/// Starts to bring near its code, for a point.
void fetchNearestCode();

}  // namespace leeway::collision
