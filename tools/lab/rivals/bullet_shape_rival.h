#pragma once

#include <BulletCollision/CollisionShapes/btConvexShape.h>

#include <memory>

#include "tools/lab/base/engine.h"

namespace leeway::tools::report {

/// Bullet's form of a convex shape, with margin 0 unless the margin is the radius. Null for
/// ellipsoids, half-spaces and meshes, which Bullet lacks.
std::unique_ptr<btConvexShape> makeBulletShape(const ReportShape& shape);
btVector3 toBullet(const Eigen::Vector3d& v);
btTransform toBullet(const collision::Pose& pose);

}  // namespace leeway::tools::report
