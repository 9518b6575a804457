#pragma once

#include <span>

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

struct SolidDepth {
  double depth = 0;                                   ///< [m]; 0 when nothing is found
  Eigen::Vector3d way_out = Eigen::Vector3d::Zero();  ///< of B, in W: worth a try; any length
};

/// A length that every translation that separates two overlapping solids must have [m]; 0 when
/// nothing is found. A ball in A and a ball in B around the same point stay apart only when moved
/// by the sum of their radii: so for any point inside both, the sum of its distances from the two
/// surfaces is one. Solids are convex shapes and the closed components of meshes, deforming ones,
/// too. The search looks at the given points (in W) and takes kDeepestPointSteps steps from the
/// best one at the most, each with `node_limit` nodes of either hierarchy.
SolidDepth solidDepth(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                      std::span<const Eigen::Vector3d> starts, int node_limit, Scratch& scratch);

/// Lowers the upper end of an overlap by such points: near the deepest pair of triangles, in the
/// middle of either body, `middle`, in W, and, where a body deforms, on a grid. Nothing where
/// either body has no inside. Returns a way out, of B and in W, that is worth a try.
Eigen::Vector3d deepen(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                       const Eigen::Vector3d& middle, const DistanceRequest& request,
                       Scratch& scratch, DistanceResult& result);

}  // namespace leeway::collision
