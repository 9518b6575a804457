#pragma once

#include "collision/base/vector.h"
#include "collision/convex/gjk/convex_view.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// A point of two overlapping bodies.
struct CommonPoint {
  /// No translation shorter than this separates the bodies [m]; 0 if no such point was found.
  double depth = 0;
  Vector point = Vector::Zero();  ///< in B's frame
};

/// Proves that two bodies overlap by finding a point that is strictly inside both, or on one and
/// strictly inside the other. It is for bodies whose surfaces touch within rounding but do not
/// cross, and at least one of which is a closed mesh. It searches near the triangles that the last
/// descent of these bodies stored in the scratch (TouchingTriangles), and in the middle of a convex
/// shape.
///
/// If the insides overlap and no triangle crosses another, there are three cases: two triangles of
/// one plane and side share an area; a triangle enters the other solid from a triangle that it
/// touches; or one of the bodies is convex and inside the other. The search therefore misses few
/// overlaps, all of them with a thin intersection near the candidates. At most 64 points; never
/// throws or allocates.
CommonPoint commonPoint(const Shape& a, const Shape& b, const RelativePose& relative,
                        Scratch& scratch);

/// For bodies whose surfaces touch, if neither an overlap nor the request is decided: uses the
/// depth that commonPoint() proves as the upper end, and its point as both witnesses.
void offerCommonPoint(const Shape& a, const Shape& b, const RelativePose& relative,
                      const Pose& X_WB, const DistanceRequest& request, Scratch& scratch,
                      DistanceResult& result);

}  // namespace leeway::collision
