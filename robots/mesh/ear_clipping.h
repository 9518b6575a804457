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
  /// Places in the polygon's list of corners, in the polygon's turn. As a chain, their edges are
  /// the polygon's: neighbours along its edges match. Triangles without area are among them where
  /// the polygon turns back on itself.
  std::vector<std::array<std::int32_t, 3>> triangles;
  /// The polygon crosses itself by this length, 0 where it does not. The triangles then cover its
  /// inside and perhaps more.
  double crossing = 0;
};

/// Cuts the polygon of the given corners, seen along the axis of coordinates that is nearest to its
/// normal. Where it does not cross itself, the triangles cover exactly its inside by the even-odd
/// rule, each point once: concave polygons, corners on straight edges, and windows whose bridges
/// the polygon walks twice, included. Corners of one place are one corner.
///
/// Ears are clipped (G. H. Meisters, "Polygons have ears", 1975); whether something is inside of an
/// ear is decided exactly. If e is the polygon's indicator (each point with how often the polygon
/// winds about it), and triangles are counted +1 where they turn as the polygon does, else -1, then
/// clipping keeps e equal to the sum of the triangles' indicators. So all that a polygon winds
/// about is covered whatever is clipped; where no triangle counts -1 nothing else is.
///
/// O(n^2), of which the factor is small where ears are short.
CutPolygon cutPolygon(std::span<const Eigen::Vector3d> corners);

/// A normal of the plane that a polygon stands in, of twice the polygon's area (Newell). Where that
/// is hardly any, for lobes of opposite turn above all, of any length and either direction. 0 for
/// points on a line. O(n).
Eigen::Vector3d polygonNormal(std::span<const Eigen::Vector3d> corners);

}  // namespace leeway::robots
