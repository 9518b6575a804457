#pragma once

#include <vector>

#include "collision/mesh/mesh_tree.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

/// Pieces are used if there are at least this many triangles for each piece or loose triangle, or
/// if whole components are convex. Measured with bench_meshes: at 8, queries cost up to 2.7 times
/// as much as with triangles alone; at 20, they cost a quarter to a half for distances and about
/// the same for thresholds; from 100 on, a twentieth and a third.
inline constexpr double kPieceTriangles = 16;
/// A decomposition is given up after this much work for each triangle [units of about 0.2 us].
inline constexpr double kPieceWork = 100;

struct ConvexPieces {
  std::vector<ConvexPiece> pieces;  ///< disjoint; triangles in none of them are tested separately
  PieceSummary summary;
};

/// Greedily partitions the surface of the closed components into convex patches (S. A. Ehmann, M.
/// C. Lin, "Accurate and fast proximity queries between polyhedra using convex surface
/// decomposition", 2001, section 3): from a seed, triangles are added across edges while the hull
/// of all stays in the solid; faces that close a patch's hull are virtual. Two things differ:
/// - A hull may protrude from the solid by a small length, because faces with rounded corners are
///   not convex; see HullProof.
/// - Triangles are added in batches that double and are halved back, so that a piece of k triangles
///   costs O(k log k) and not O(k^2). The obstacle of a rejected batch is stored and excludes later
///   triangles that would intersect it.
/// A small component that is convex is one piece, whose excess is rounding. Needs mesh.tree().
/// Returns no pieces if they are not worthwhile (kPieceTriangles) or cost too much to find
/// (kPieceWork). O(n log n), deterministic.
ConvexPieces convexPieces(const TriangleMesh& mesh);

}  // namespace leeway::collision
