#pragma once

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/collision_geometry.h>

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::lab {

using FclGeometry = std::shared_ptr<fcl::CollisionGeometryd>;
using FclSurface = fcl::BVHModel<fcl::OBBRSSd>;

Eigen::Isometry3d isometry(const collision::Pose& X);

/// FCL's hierarchy over triangles. O(n log n).
template <typename Volume = fcl::OBBRSSd>
std::shared_ptr<fcl::BVHModel<Volume>> fclMesh(
    std::span<const Eigen::Vector3d> vertices,
    std::span<const std::array<std::int32_t, 3>> triangles) {
  auto model = std::make_shared<fcl::BVHModel<Volume>>();
  std::vector<fcl::Triangle> indices;
  for (const auto& t : triangles)
    indices.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                         static_cast<std::size_t>(t[2]));
  model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(vertices.size()));
  model->addSubModel(std::vector<Eigen::Vector3d>(vertices.begin(), vertices.end()), indices);
  model->endModel();
  return model;
}

/// FCL's form of a shape; hulls and meshes as triangles.
FclGeometry toFcl(const collision::Shape& shape);

}  // namespace leeway::lab
