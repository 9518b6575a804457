#pragma once

// Private to robots/: what a body sweeps when it turns about an axis through a whole turn.

#include <optional>
#include <span>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// True when all geometries are meshes or convex hulls.
bool areTriangles(std::span<const Geometry> geometries);

/// Cylinders about the z axis that together hold everything that the geometries' triangles pass
/// through in a whole turn about it, and everything that they enclose. Nothing when one has no
/// triangles or is farther off than shapes are large. O(triangles).
std::optional<std::vector<Geometry>> revolutionCover(std::span<const Geometry> geometries);

/// Bound on the distance of a geometry's points from the z axis [m].
double axisReach(const Geometry& g);

}  // namespace leeway::robots
