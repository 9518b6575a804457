#pragma once

#include <fcl/fcl.h>

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <span>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::dense {

using FclGeometry = std::shared_ptr<fcl::CollisionGeometryd>;
using FclSurface = fcl::BVHModel<fcl::OBBRSSd>;

Eigen::Isometry3d isometry(const collision::Pose& X);

/// FCL's hierarchy over these triangles. O(n log n).
std::shared_ptr<FclSurface> fclMesh(std::span<const Eigen::Vector3d> vertices,
                                    std::span<const std::array<std::int32_t, 3>> triangles);

/// FCL's form of a shape; hulls and meshes as triangles.
FclGeometry toFcl(const collision::Shape& shape);

}  // namespace leeway::dense
