#pragma once

#include <BulletCollision/CollisionShapes/btConvexShape.h>

#include <memory>

#include "tools/report/base/engine.h"

namespace leeway::tools::report {

/// Bullet's form of a convex shape, its margin 0 where that is not its radius; null for ellipsoids,
/// half-spaces and meshes, which it does not have.
std::unique_ptr<btConvexShape> makeBulletShape(const ReportShape& shape);
btVector3 toBullet(const Eigen::Vector3d& v);
btTransform toBullet(const collision::Pose& pose);

}  // namespace leeway::tools::report
