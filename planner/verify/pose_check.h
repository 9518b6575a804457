#pragma once

#include <span>

#include "leeway/robots/model.h"
#include "leeway/robots/pose_region.h"

namespace leeway::planner::verification {

/// Whether the region's frame is in the region, within its tolerances and kVerifyPose. True is
/// certain up to rounding: the check found a rotation with roll, pitch and yaw inside the ranges
/// that is within the angle tolerance. Shares nothing with robots/inverse_kinematics. O(1).
bool isInRegion(const robots::PoseRegion& region, std::span<const robots::Pose> X_WL);

}  // namespace leeway::planner::verification
