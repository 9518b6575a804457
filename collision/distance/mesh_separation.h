#pragma once

#include <span>

#include "collision/convex/gjk/convex_view.h"
#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Searches the shortest translation t of B that is proven to separate two overlapping meshes;
/// raises the lower end of `result` to -|t| and makes its direction the normal. `result` is in W:
/// its upper end is a lower bound on the length, and its lower end and normal are a translation
/// that is known to separate (that of the hulls). `tries`: additional directions, of any length. At
/// most kSeparationQueries queries.
void separateMeshes(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    std::span<const Eigen::Vector3d> tries, const DistanceRequest& request,
                    Scratch& scratch, DistanceResult& result);

/// Two bodies, at least one of them a mesh, with convex bodies around both that are not apart.
struct MeetingBodies {
  const Shape& a;
  const Pose& X_WA;
  const Shape& b;
  const Pose& X_WB;
  const RelativePose& relative;
  ConvexView outer_a, outer_b;  ///< hulls or boxes
  double slack;                 ///< of convexDistance() between them
};
/// Their surfaces are apart by at least `surface_lower`, with one body inside the other or not, or
/// overlap if that is not positive. Completes `result`, in W, which has the distance of the
/// surfaces: decides whether one body is inside the other and, with DistanceRequest::depth, bounds
/// the depth. `hull_lower`: a lower bound on the signed separation.
void decideOverlap(const MeetingBodies& bodies, double surface_lower, double hull_lower,
                   const DistanceRequest& request, Scratch& scratch, DistanceResult& result);

}  // namespace leeway::collision
