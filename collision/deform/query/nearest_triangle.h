#pragma once

// Private to collision/: the triangle of a deforming mesh that is nearest to a point or a segment,
// the core of a sphere or a capsule.

#include <Eigen/Core>
#include <cstdint>
#include <limits>

#include "collision/deform/snapshot.h"

namespace leeway::collision {

/// The parameters of a search. Distances are those of the core, a point or a segment [m].
struct NearestSearch {
  Eigen::Vector3d middle;  ///< of the core, in the mesh's frame; finite
  Eigen::Vector3d half;    ///< from there to one of a segment's ends; 0 for a point
  double reach = std::numeric_limits<double>::infinity();  ///< triangles farther than this are
                                                           ///< ignored
  double enough = 0;                                       ///< a triangle within this distance ends
                                                           ///< the search
  double tolerance = 0;     ///< triangles that are closer by less than this are ignored
  double size = 0;          ///< sum of the magnitudes of coordinates; rounding is proportional to
                            ///< it
  double slack = 0;         ///< the core's own error, included in all bounds
  std::int32_t first = -1;  ///< slot of the triangle to compare first; -1: none
  int limit = 0;            ///< of nodes and leaves [count]
};

struct NearestFound {
  std::int32_t slot = -1;  ///< of the nearest triangle; -1: none within reach
  double upper = std::numeric_limits<double>::infinity();  ///< of its distance
  double own_lower = 0;                                    ///< of its distance
  /// The nearest point of the core relative to its middle, and the vector from there to the
  /// triangle; rounded.
  Eigen::Vector3d from, way;
  double lower = 0;  ///< no other triangle is closer; 0 if `enough` ended the search
  int visited = 0;   ///< nodes and leaves [count]
};

/// Branch and bound, nearer nodes first. Several triangles are compared at a time by closed forms
/// (C. Ericson, "Real-Time Collision Detection", 2005, sections 5.1.5 and 5.1.9): the ends of a
/// segment and the triangle, the segment and the edges. The lower bound is that of the plane
/// perpendicular to the vector between the two points, so neither their rounding nor a segment that
/// crosses the triangle can make it wrong. Every instruction set yields the same bytes.
NearestFound findNearest(const NearestSearch& search, const DeformableSnapshotImpl& snapshot,
                         const BoxSource& source);

/// Prefetches the code of findNearest() for a point.
void fetchNearestCode();

}  // namespace leeway::collision
