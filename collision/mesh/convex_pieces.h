#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

/// A patch of a closed component's triangles and a convex hull that holds all of them. The solid
/// has a convex part K with K within the hull and no point of the hull farther than `excess` from
/// K: so the distance d of a convex body from the hull, and its depth in it (negative), says that
/// it is at least d from the patch and at most d + excess from the solid.
struct ConvexPiece {
  std::vector<std::int32_t> triangles;  ///< ascending
  std::shared_ptr<const ConvexHull> hull;
  double excess = 0;  ///< [m]
};

struct ConvexPieces {
  std::vector<ConvexPiece> pieces;  ///< disjoint; triangles in none of them stand for themselves
  PieceSummary summary;
};

/// Parts the surface of the closed components into such patches, greedily (S. A. Ehmann, M. C. Lin,
/// "Accurate and fast proximity queries between polyhedra using convex surface decomposition",
/// 2001, section 3): from a seed, triangles are added across edges while the hull of all stays in
/// the solid; faces that close a patch's hull are virtual. Two things differ. A hull may leave the
/// solid by a little, since faces whose corners were rounded are not convex: it is proven that no
/// triangle reaches deeper than some length into the hull, and shrinking the hull about a point
/// inside by the share that this needs gives K, at a proven distance. And triangles are added in
/// batches that double and are halved back, so that a piece of k triangles costs O(k log k) and not
/// O(k^2). What stands in the way of a batch is remembered and keeps later ones out. Needs
/// mesh.tree(). No pieces where they do not pay, see kPieceTriangles, or cost too much to find, see
/// kPieceWork: O(n log n), deterministic.
ConvexPieces convexPieces(const TriangleMesh& mesh);

}  // namespace leeway::collision
