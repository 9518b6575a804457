#pragma once

// Private to collision/: spheres and capsules near a deforming mesh.

#include <Eigen/Core>

#include "collision/deform/query/nearest_triangle.h"
#include "collision/deform/snapshot.h"
#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// A sphere or a capsule, which is as far away as its core is, less its radius.
struct RoundBody {
  Eigen::Vector3d middle, half;  ///< of the core, as NearestSearch has them
  double radius;
};

/// Seen from a mesh.
RoundBody roundBody(double radius, double half_length, const Pose& X_BA);

/// Whether the triangle nearest to such a body can be looked for. False for a segment that is
/// hardly one, whose direction would not survive single precision, and where single precision ends.
bool hasNearest(bool is_segment, double half_length, const Pose& X_BA,
                const DeformableSnapshotImpl& mesh);

/// What is asked of the search, but for its limit and its first triangle. `slack` as
/// convexDistance().
NearestSearch nearestSearch(const RoundBody& body, const DeformableSnapshotImpl& mesh, double slack,
                            const DistanceRequest& request);

/// What the box around the mesh proves of the distance [m]; 0 or less says nothing of how deep.
double boxLower(const RoundBody& body, const DeformableSnapshotImpl& mesh,
                const NearestSearch& search);

/// The body and the triangle that is nearest to its core: the distance, and witnesses in the mesh's
/// frame. False where the way has no direction, or is not known as well as is asked.
bool answerNearest(const RoundBody& body, const NearestFound& found, const DeformTree& tree,
                   const DistanceRequest& request, DistanceResult& result);

}  // namespace leeway::collision
