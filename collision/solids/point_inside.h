#pragma once

// Private to collision/: one point against a mesh, rigid or deforming, in the mesh's frame.

#include "collision/base/vector.h"
#include "collision/mesh/descent/mesh_descent.h"
#include "collision/mesh/point_in_solid.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Whether a shape is a mesh with a closed component.
bool isSolidMesh(const Shape& shape);

/// kInside if the point is inside a closed component of the mesh; kOutside if it is outside all of
/// them. As sideOf().
Side sideOfMesh(const Shape& mesh, const Vector& point, Scratch& scratch);

/// The distance between the point and the mesh's surface. Witness points are in no common frame;
/// `towards` receives the vector from the point to the surface.
DescentResult surfaceAbout(const Shape& mesh, const Vector& point, const DistanceRequest& request,
                           Scratch& scratch, Vector& towards);

/// A lower bound on the distance between the point and the mesh's surface [m]. It is above
/// `threshold` if the distance is well above it.
double distanceFromSurface(const Shape& mesh, const Vector& point, double threshold,
                           Scratch& scratch);

/// Whether the point may be inside the mesh's box grown by `error` [m]. O(1).
bool isInBox(const Shape& mesh, const Vector& point, double error);

/// The radius of a ball around the point that is proven to be inside a closed component of the mesh
/// [m], or up to a few times less; 0 if none is proven. Radii far above `wanted` are not
/// distinguished.
double ballInside(const Shape& mesh, const Vector& point, double wanted, Scratch& scratch);

}  // namespace leeway::collision
