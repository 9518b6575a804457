#include <cmath>

#include "collision/base/numbers.h"
#include "collision/base/status.h"
#include "collision/convex/gjk/support.h"
#include "collision/deform/query/descent_state.h"
#include "collision/mesh/descent/touching_triangles.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

// A deforming triangle in the form in which mesh_descent.cc takes a convex shape.
DescentSide triangleSide(const ConvexView& view) {
  DescentSide side;
  side.view = view;
  side.center = view.center;
  side.low = side.high = view.points[0];
  for (int i = 0; i < view.count; ++i) {
    side.low = side.low.cwiseMin(view.points[i]);
    side.high = side.high.cwiseMax(view.points[i]);
    side.radius = std::max(side.radius, (view.points[i] - view.center).norm());
  }
  side.radius = side.radius * (1 + kRelativeRounding) + kRelativeRounding * view.extent;
  side.extent = view.extent;
  return side;
}

// Whether a piece's corners, if it has any, are finite: x - x is then 0.
bool isFinite(const DeformSide& side, const Vector3d* corners) {
  if (isRigid(side)) return true;
  const double sum = corners[0].sum() + corners[1].sum() + corners[2].sum();
  return sum - sum == 0;
}

int triangleOf(const DeformSide& side, int slot) {
  return slot == kWholeBody ? -1 : side.snapshot->tree->triangleOf(slot);
}

}  // namespace

ConvexView pieceOf(const DeformSide& side, int slot, Vector3d* corners) {
  if (side.snapshot == nullptr) return side.rigid.view;
  const DeformTree::Triangle& t = side.snapshot->tree->corners(slot);
  for (std::size_t k = 0; k < 3; ++k)
    corners[k] = side.snapshot->vertices[static_cast<std::size_t>(t[k])];
  return viewOfPoints(corners, 3, 0);
}

// A rigid mesh and one triangle.
DistanceResult DescentState::compareWithMesh(const DescentSide& side_a, const DescentSide& side_b,
                                             double threshold, bool depth) {
  DistanceRequest own = request;
  own.threshold = threshold;
  own.depth = depth;
  own.node_limit = nodesLeft();
  visit();
  const DescentResult found = descend(side_a, side_b, placement, own, scratch, &cache);
  reduceLimit(found.visited);
  result.iterations += found.iterations;
  DistanceResult r = found.witness;
  r.distance = {std::max(found.lower, found.hull_lower), found.upper};
  // Below zero, swept pieces prove nothing about the whole.
  if (placement.swept && !(found.lower > 0)) r.distance.lower = found.hull_lower;
  r.status = statusOf(r.distance, own);
  cache.triangle_a = r.triangle_a >= 0 ? r.triangle_a : cache.triangle_a;
  cache.triangle_b = r.triangle_b >= 0 ? r.triangle_b : cache.triangle_b;
  return r;
}

DistanceResult DescentState::compareConvex(const ConvexView& piece_a, const ConvexView& piece_b,
                                           double threshold, bool depth) {
  DistanceRequest own;
  own.threshold = threshold;
  own.tolerance = request.tolerance;
  own.depth = depth;
  own.iteration_limit = request.iteration_limit;
  visit();
  const DistanceResult r = pieceDistance(piece_a, piece_b, placement, own, scratch, &cache);
  result.iterations += r.iterations;
  return r;
}

void DescentState::comparePieces(int slot_a, int slot_b) {
  Vector3d corners_a[3], corners_b[3];
  const ConvexView piece_a = pieceOf(a, slot_a, corners_a), piece_b = pieceOf(b, slot_b, corners_b);
  if (!isFinite(a, corners_a) || !isFinite(b, corners_b)) {
    // The caller guaranteed that this vertex is finite. It may be anywhere, also outside the box of
    // the mesh.
    settle(-kInfinity);
    result.hull_lower = -kInfinity;
    result.misplaced = true;
    return;
  }
  const bool depth = request.depth && !placement.swept;
  const DistanceResult r = askOfPieces(bar(), request, depth, [&](double threshold) {
    if (a.rigid.tree != nullptr)
      return compareWithMesh(a.rigid, triangleSide(piece_b), threshold, depth);
    if (b.rigid.tree != nullptr)
      return compareWithMesh(triangleSide(piece_a), b.rigid, threshold, depth);
    return compareConvex(piece_a, piece_b, threshold, depth);
  });
  settle(r.distance.lower);
  // (descend() has stored those of a rigid mesh.)
  if (!placement.swept && a.snapshot != nullptr && b.snapshot != nullptr && r.distance.upper > 0 &&
      r.distance.lower <= scratch.impl().touching.near()) {
    for (Vector3d& p : corners_a) p = placement.X_BA0 * p;
    scratch.impl().touching.add(corners_a, corners_b);
  }
  // (The triangles of a rigid mesh are in `r` already.)
  const int triangle_a = a.rigid.tree == nullptr ? triangleOf(a, slot_a) : r.triangle_a,
            triangle_b = b.rigid.tree == nullptr ? triangleOf(b, slot_b) : r.triangle_b;
  if (offer(r, r.distance.upper, triangle_a, triangle_b)) rememberPlane(r);
}

void DescentState::compareWithLeaf(int slot_a, int begin_b, int end_b, double lower,
                                   WideBounds& bounds) {
  const int count = end_b - begin_b;
  for (int round = 0; round < count; ++round) {
    int next = -1;
    for (int i = 0; i < count; ++i) {
      // NaN marks finished entries, and fails.
      if (bounds.lower[i] == bounds.lower[i] && (next < 0 || bounds.lower[i] < bounds.lower[next]))
        next = i;
    }
    const double least = std::max(lower, static_cast<double>(bounds.lower[next]));
    if (isPruned(least)) {
      settle(least);  // a bound for all others
      return;
    }
    bounds.lower[next] = std::numeric_limits<float>::quiet_NaN();
    if (slot_a == warm_a_ && begin_b + next == warm_b_) {
      settle(warm_lower_);
      continue;
    }
    if (slot_a == kWholeBody && begin_b >= 0 &&
        isBeyondPlane(b.snapshot->tree->corners(begin_b + next)))
      continue;
    comparePieces(slot_a, begin_b + next);
    if (isDone()) return;
  }
}

void DescentState::warmStart() {
  const auto slotOf = [](const DeformSide& side, int triangle) {
    if (isRigid(side)) return kWholeBody;
    const DeformTree& tree = *side.snapshot->tree;
    return triangle >= 0 && triangle < tree.triangleCount() ? tree.slotOf(triangle) : kNoSlot;
  };
  const int slot_a = slotOf(a, cache.triangle_a), slot_b = slotOf(b, cache.triangle_b);
  if (slot_a == kNoSlot || slot_b == kNoSlot) return;
  compareFirst([&] {
    comparePieces(slot_a, slot_b);
    if (!placement.swept) rememberWarm(slot_a, slot_b);
  });
}

void DescentState::rememberWarm(int slot_a, int slot_b) {
  if (!(result.upper > 0 && result.upper - result.lower <= request.tolerance)) return;
  warm_a_ = slot_a;
  warm_b_ = slot_b;
  warm_lower_ = result.lower;
}

void DescentState::rememberPlane(const DistanceResult& nearest) {
  has_plane_ = isRigid(a) && a.rigid.tree == nullptr && b.snapshot != nullptr && !half_space &&
               !placement.swept && nearest.distance.upper > 0;
  if (!has_plane_) return;
  plane_normal_ = nearest.normal.normalized();
  int hint = 0;
  const ConvexView& view = a.rigid.view;
  const Vector3d last =
      placement.X_BA0 * farthest(view, placement.X_BA0.rotation.transpose() * plane_normal_, hint);
  // Rounding of two scalar products, their difference and the length of the normal: about ten
  // operations on numbers no larger than this.
  const double size =
      extent_b + view.extent + view.radius + placement.X_BA0.translation.lpNorm<1>();
  plane_offset_ = plane_normal_.dot(last) + view.radius + view.excess + placement.slack +
                  kRelativeRounding * size;
}

bool DescentState::areBeyondPlane(std::span<const std::int32_t> vertices) {
  double least = 0;
  if (!kernels.leastAlong(plane_normal_.data(), b.snapshot->vertices.data(), vertices, least))
    return false;
  const double lower = least - plane_offset_;
  if (!isPruned(lower)) return false;
  settle(lower);
  return true;
}

}  // namespace leeway::collision
