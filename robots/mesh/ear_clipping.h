#pragma once

// Private to robots/.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace leeway::robots {

/// A polygon cut into triangles.
struct CutPolygon {
  /// Places in the polygon's list of corners, in the polygon's orientation. As a chain, their edges
  /// are the polygon's, so neighbours along its edges match. They include triangles without area
  /// where the polygon turns back on itself.
  std::vector<std::array<std::int32_t, 3>> triangles;
  /// The length by which the polygon crosses itself; 0 if it does not. If it does, the triangles
  /// cover its inside and perhaps more.
  double crossing = 0;
};

/// Triangulates the polygon with the given corners, projected along the coordinate axis that is
/// closest to its normal. If it does not cross itself, the triangles cover exactly its inside by
/// the even-odd rule, each point once. This includes concave polygons, corners on straight edges,
/// and windows whose bridges the polygon traverses twice. Corners at one place are one corner.
///
/// Ears are clipped (G. H. Meisters, "Polygons have ears", 1975); whether something is inside an
/// ear is decided exactly. Let e be the polygon's indicator (for each point, how often the polygon
/// winds around it), and let triangles count +1 if they have the polygon's orientation, otherwise
/// -1. Clipping keeps e equal to the sum of the triangles' indicators. Everything that a polygon
/// winds around is therefore covered, whichever ears are clipped; if no triangle counts -1, nothing
/// else is covered.
///
/// O(n^2), with a small factor if ears are short.
CutPolygon cutPolygon(std::span<const Eigen::Vector3d> corners);

/// A normal of the polygon's plane, with the length of twice the polygon's area (Newell). If that
/// area is nearly 0, especially for lobes of opposite orientation, the normal has any length and
/// either direction. 0 for points on a line. O(n).
Eigen::Vector3d polygonNormal(std::span<const Eigen::Vector3d> corners);

}  // namespace leeway::robots
