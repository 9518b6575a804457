#include <stdexcept>

#include "leeway/robots/input_error.h"
#include "robots/urdf/urdf_document.h"

namespace leeway::robots {

collision::Shape primitiveOf(const UrdfCollision& geometry) {
  using collision::Shape;
  using Kind = UrdfCollision::Kind;
  try {
    switch (geometry.kind) {
      case Kind::kBox:
        return Shape::box(geometry.size / 2);
      case Kind::kSphere:
        return Shape::sphere(geometry.radius);
      case Kind::kCylinder:
        return Shape::cylinder(geometry.radius, geometry.length / 2);
      case Kind::kCapsule:
        return Shape::capsule(geometry.radius, geometry.length / 2);
      case Kind::kEllipsoid:
        return Shape::ellipsoid(geometry.size / 2);
      case Kind::kPlane:
        return Shape::halfSpace();
      case Kind::kMesh:
        break;
    }
  } catch (const collision::InvalidShape& invalid) {
    throw InputError(geometry.file, geometry.line, invalid.what());
  }
  throw std::invalid_argument("a mesh is no primitive");
}

}  // namespace leeway::robots
