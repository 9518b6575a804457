#include <Eigen/Core>
#include <utility>

#include "collision/shapes/bounding_sphere.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

// Defined here because shapes/ does not depend on deforming meshes.
Shape Shape::deformable(std::shared_ptr<const DeformableSnapshot> snapshot) {
  if (!snapshot) throw InvalidShape("deformable: there is no snapshot");
  const Eigen::Vector3d corners[2] = {snapshot->low(), snapshot->high()};
  const Eigen::Vector3d farthest = corners[0].cwiseAbs().cwiseMax(corners[1].cwiseAbs());
  const BoundingSphere sphere = sphereAround(corners);
  Shape shape;
  shape.type_ = ShapeType::kDeformable;
  shape.bounding_center_ = sphere.center;
  shape.setReach(sphere.radius, outwardNorm(farthest.x(), farthest.y(), farthest.z()));
  shape.deformable_ = std::move(snapshot);
  return shape;
}

}  // namespace leeway::collision
