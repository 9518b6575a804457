#pragma once

#include "collision/convex/gjk/progress.h"

namespace leeway::collision {

// Candidate points of a segment (the core of a capsule) and another core, and the plane across the
// vector between them. Planes and points are certified like any others, so poor candidates only
// widen the interval. All functions return true if the request is met; otherwise the pair (nearly)
// touches, and the offered ends stay. O(1).

/// Two segments.
bool offerSegments(const ConvexView& a, const Pose& X_BA, const ConvexView& b, Progress& progress);

/// A segment and a box, in the box's frame.
bool offerSegmentAndBox(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                        Progress& progress);

/// A point or a segment and a triangle (three points), in the triangle's frame. Tried in turn: an
/// end and the triangle, the segment and each edge, the other end.
bool offerTriangle(const ConvexView& a, const Pose& X_BA, const ConvexView& b, Progress& progress);

}  // namespace leeway::collision
