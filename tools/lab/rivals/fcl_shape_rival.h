#pragma once

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/collision_geometry.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tools/lab/base/engine.h"

namespace leeway::tools::report {

/// FCL's form of a convex shape. Null for meshes and half-spaces (FCL answers contacts with those,
/// no distances).
std::shared_ptr<fcl::CollisionGeometryd> makeFclShape(const ReportShape& shape);
fcl::Transform3d toFcl(const collision::Pose& pose);
std::vector<fcl::Triangle> toFcl(std::span<const std::array<std::int32_t, 3>> triangles);

/// A bounding volume hierarchy over triangles.
template <typename Volume>
std::shared_ptr<fcl::BVHModel<Volume>> makeFclModel(
    std::span<const Eigen::Vector3d> vertices,
    std::span<const std::array<std::int32_t, 3>> triangles) {
  auto model = std::make_shared<fcl::BVHModel<Volume>>();
  model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(vertices.size()));
  model->addSubModel(std::vector<fcl::Vector3d>(vertices.begin(), vertices.end()),
                     toFcl(triangles));
  model->endModel();
  return model;
}

}  // namespace leeway::tools::report
