#include "collision/distance/deform_distance.h"

#include <algorithm>
#include <array>
#include <utility>

#include "collision/base/scratch.h"
#include "collision/base/status.h"
#include "collision/deform/query/deform_descent.h"
#include "collision/distance/mesh_distance.h"
#include "collision/distance/mesh_separation.h"
#include "collision/distance/round_distance.h"
#include "collision/mesh/descent/descent_answer.h"
#include "collision/mesh/descent/touching_triangles.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

// A convex body around a body: the body itself, or the corners of its box, which contains a mesh's
// hull.
ConvexView outerOf(const DeformSide& side, std::array<Vector3d, 8>& corners) {
  if (side.snapshot == nullptr && side.rigid.tree == nullptr) return side.rigid.view;
  for (std::size_t i = 0; i < 8; ++i) {
    for (int k = 0; k < 3; ++k) corners[i][k] = (i >> k & 1) != 0 ? side.high[k] : side.low[k];
  }
  return viewOfPoints(corners.data(), 8, 0);
}

// Prefetches the corners of a triangle.
void fetchSlot(const DeformableSnapshot& snapshot, int triangle) {
  const DeformTree& tree = *snapshot.impl().tree;
  if (triangle >= 0 && triangle < tree.triangleCount())
    __builtin_prefetch(&tree.corners(tree.slotOf(triangle)));
}

// The answer with the bodies swapped.
DistanceResult exchanged(DistanceResult result) {
  std::swap(result.point_a, result.point_b);
  std::swap(result.triangle_a, result.triangle_b);
  result.normal = -result.normal;
  return result;
}

DistanceResult descentDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                               const DistanceRequest& request, Scratch& scratch, PairCache& cache) {
  // Boxes are compared in B's frame, because the boxes of a deforming mesh are axis-aligned there.
  if (b.type() != ShapeType::kDeformable) {
    std::swap(cache.triangle_a, cache.triangle_b);
    const DistanceResult result =
        exchanged(descentDistance(b, X_WB, a, X_WA, request, scratch, cache));
    std::swap(cache.triangle_a, cache.triangle_b);
    return result;
  }
  // The last nearest triangle is tried first; its corners are probably out of cache.
  fetchSlot(*b.deformable(), cache.triangle_b);
  const RelativePose relative = relativePose(X_WA, X_WB);
  if (!relative.valid) return {};
  const DeformSide side_a = deformSide(a), side_b = deformSide(b);
  const DescentPlacement placement = placementOf(relative, side_a, side_b);
  scratch.impl().touching.start(touchingWithin(placement, side_a, side_b));
  const DescentResult found = deformDescend(side_a, side_b, placement, request, scratch, &cache);
  remember(found, cache);

  DistanceResult result = surfaceDistance(found, X_WB);
  if (!(found.hull_lower > 0) && !found.misplaced) {
    std::array<Vector3d, 8> corners_a, corners_b;
    const ConvexView outer_a = outerOf(side_a, corners_a), outer_b = outerOf(side_b, corners_b);
    decideOverlap({a, X_WA, b, X_WB, relative, outer_a, outer_b, placement.slack}, found.lower,
                  found.hull_lower, request, scratch, result);
  }
  result.status = statusOf(result.distance, request);
  return result;
}

bool isRound(const Shape& shape) {
  return shape.type() == ShapeType::kSphere || shape.type() == ShapeType::kCapsule;
}

DistanceResult cachedDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                              const DistanceRequest& request, Scratch& scratch, PairCache& cache) {
  DistanceResult result;
  int visited = 0;
  if (isRound(b) ? roundDistance(b, X_WB, a, X_WA, request, scratch, cache, true, result, visited)
                 : isRound(a) && roundDistance(a, X_WA, b, X_WB, request, scratch, cache, false,
                                               result, visited))
    return result;
  if (visited == 0) return descentDistance(a, X_WA, b, X_WB, request, scratch, cache);
  DistanceRequest rest = request;
  rest.node_limit -= visited;
  return descentDistance(a, X_WA, b, X_WB, rest, scratch, cache);
}

}  // namespace

DistanceResult deformDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                              const DistanceRequest& request, Scratch& scratch, PairCache* cache) {
  if (cache != nullptr) return cachedDistance(a, X_WA, b, X_WB, request, scratch, *cache);
  PairCache none;
  return cachedDistance(a, X_WA, b, X_WB, request, scratch, none);
}

DistanceResult deformSweptDistance(const Shape& a, const Pose& X_BA0, const Pose& X_BA1,
                                   double growth, const Shape& b, const DistanceRequest& request,
                                   Scratch& scratch, PairCache* cache) {
  return sweptByDescent(a, X_BA0, X_BA1, growth, b, request, scratch, cache, deformSide,
                        deformDescend);
}

}  // namespace leeway::collision
