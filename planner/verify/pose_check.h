#pragma once

#include <span>

#include "leeway/robots/model.h"
#include "leeway/robots/pose_region.h"

namespace leeway::planner::verification {

/// Whether the region's frame is in it, to within its tolerances and kVerifyPose. True is sure up
/// to rounding: roll, pitch and yaw inside the ranges were found whose rotation is that near.
/// Shares nothing with robots/inverse_kinematics. O(1).
bool isInRegion(const robots::PoseRegion& region, std::span<const robots::Pose> X_WL);

}  // namespace leeway::planner::verification
