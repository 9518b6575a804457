#include <Eigen/Core>
#include <utility>

#include "collision/shapes/bounding_sphere.h"
#include "leeway/collision/shape.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

// Shape::mesh() is here because shapes/ does not know meshes.
Shape Shape::mesh(std::shared_ptr<const TriangleMesh> mesh) {
  if (!mesh || mesh->vertices().empty()) {
    throw InvalidShape("mesh: it has no triangles; at least one is needed");
  }
  const BoundingSphere sphere = sphereAround(mesh->vertices());
  Shape shape;
  shape.type_ = ShapeType::kMesh;
  shape.bounding_center_ = sphere.center;
  shape.setReach(sphere.radius, sphere.extent);
  shape.mesh_ = std::move(mesh);
  return shape;
}

}  // namespace leeway::collision
