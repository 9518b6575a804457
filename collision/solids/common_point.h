#pragma once

#include "collision/base/vector.h"
#include "collision/convex/gjk/convex_view.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// A point of two overlapping bodies.
struct CommonPoint {
  /// No translation shorter than this separates the bodies [m]; 0: no such point was found.
  double depth = 0;
  Vector point = Vector::Zero();  ///< in B's frame
};

/// Proves that two bodies overlap by a point: strictly inside both, or on one and strictly inside
/// the other. For bodies whose surfaces touch within rounding and nowhere cross, of which at least
/// one is a closed mesh. Looks near the triangles that the last descent of these bodies has kept in
/// the scratch (TouchingTriangles), and in the middle of a convex shape.
///
/// If the insides overlap and no triangle crosses another, then two triangles of one plane and side
/// share an area, or a triangle goes from one that it touches into the other solid, or one of the
/// bodies is convex and inside the other. So the search misses few, all of them where what the
/// solids share near the candidates is thin. At most 64 points; never throws or allocates.
CommonPoint commonPoint(const Shape& a, const Shape& b, const RelativePose& relative,
                        Scratch& scratch);

/// Where the surfaces of two bodies touch and neither an overlap nor the request is decided: takes
/// what commonPoint() proves as the upper end, and its point as both witnesses.
void offerCommonPoint(const Shape& a, const Shape& b, const RelativePose& relative,
                      const Pose& X_WB, const DistanceRequest& request, Scratch& scratch,
                      DistanceResult& result);

}  // namespace leeway::collision
