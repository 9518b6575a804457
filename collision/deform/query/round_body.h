#pragma once

// Private to collision/: spheres and capsules close to a deforming mesh.

#include <Eigen/Core>

#include "collision/deform/query/nearest_triangle.h"
#include "collision/deform/snapshot.h"
#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// A sphere or a capsule: all points within `radius` of its core, a point or a segment.
struct RoundBody {
  Eigen::Vector3d middle, half;  ///< of the core, see NearestSearch; in the mesh's frame [m]
  double radius;                 // [m]
};

/// A sphere (half_length 0) or a capsule along z of its frame A, in the mesh's frame B.
RoundBody roundBody(double radius, double half_length, const Pose& X_BA);

/// Whether findNearest() accepts such a body. False for a segment so short that its direction is
/// lost in single precision, and for meshes without nodes or with volumes other than boxes.
bool hasNearest(bool is_segment, double half_length, const DeformableSnapshotImpl& mesh);

/// The search for a request, without its limit and first triangle. `slack` as in convexDistance().
NearestSearch nearestSearch(const RoundBody& body, const DeformableSnapshotImpl& mesh, double slack,
                            const DistanceRequest& request);

/// A lower bound of the distance by the box around the mesh [m]; it proves nothing if it is 0 or
/// less.
double boxLower(const RoundBody& body, const DeformableSnapshotImpl& mesh,
                const NearestSearch& search);

/// Computes the distance to the triangle that is nearest to the core, with witnesses in the mesh's
/// frame. False in contact, and if the interval is wider than the requested tolerance.
bool answerNearest(const RoundBody& body, const NearestFound& found, const DeformTree& tree,
                   const DistanceRequest& request, DistanceResult& result);

}  // namespace leeway::collision
