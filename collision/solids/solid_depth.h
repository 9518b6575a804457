#pragma once

#include <span>

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// A lower bound on the depth of two overlapping solids.
struct SolidDepth {
  double depth = 0;  ///< [m]; 0 if none is found
  /// A direction in which B might be moved out, in W; of any length.
  Eigen::Vector3d way_out = Eigen::Vector3d::Zero();
};

/// Limit on the steps of the search for a point deep in both solids. More steps improve the bound
/// and cost time.
inline constexpr int kDeepestPointSteps = 20;

/// Searches for a point deep in both solids. A ball in A and a ball in B around the same point are
/// separated only if one is moved by the sum of their radii. The sum of a point's distances from
/// the two surfaces is therefore a lower bound on the length of every translation that separates
/// the solids. Solids are convex shapes and the closed components of meshes, including deforming
/// ones. The search evaluates the given points (in W) and ascends from the best one, by at most
/// kDeepestPointSteps steps, each with `node_limit` nodes of either hierarchy.
SolidDepth solidDepth(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                      std::span<const Eigen::Vector3d> starts, int node_limit, Scratch& scratch);

/// Lowers the upper end of an overlap by solidDepth() from the deepest pair of triangles, the
/// middle of each body, `middle` (in W) and, if a body deforms, the points of a grid. Does nothing
/// if a body has no inside. Returns way_out of SolidDepth.
Eigen::Vector3d deepen(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                       const Eigen::Vector3d& middle, const DistanceRequest& request,
                       Scratch& scratch, DistanceResult& result);

}  // namespace leeway::collision
