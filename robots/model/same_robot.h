#pragma once

// Whether robots are the same, bit by bit. Shapes that do not share their vertices are not the
// same.

#include <span>

#include "leeway/robots/model.h"

namespace leeway::robots {

bool isSamePose(const Pose& a, const Pose& b);
/// Compares names, shapes and poses. O(geometries).
bool areSameGeometries(std::span<const Geometry> a, std::span<const Geometry> b);
/// Whether links move alike and have the same geometries. O(joints + geometries).
bool areSameBodies(const RobotDescription& a, const RobotDescription& b);
/// areSameBodies(), and the rules on which pairs are checked are the same. Limits are not compared.
/// O(joints + geometries + pairs).
bool isSameRobot(const RobotDescription& a, const RobotDescription& b);
/// Whether Model::steps are those of its joints, as they are unless a program has changed one of
/// both. O(joints).
bool hasStepsOfItsJoints(const Model& model);

}  // namespace leeway::robots
