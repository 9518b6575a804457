#pragma once

#include <vector>

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// `frames:`, names of frames fixed to links. After the objects, whose names they must not have.
void readFrames(const YamlReader& reader, Problem& problem);

/// Whether a state's map gives poses: it has `pose` or `poses`, and the robot no joint of that
/// name.
bool givesPoses(const YamlReader& map, const robots::Model& model);

/// The poses of such a map, without looking up their names.
std::vector<FramePose> readFramePoses(const YamlReader& map, std::vector<std::string>& warnings);

/// The same, looked up: poseRegion(), errors with file and line.
std::vector<robots::PoseRegion> readPoseRegions(const YamlReader& map, Problem& problem);

/// `constraints:`, after the objects and frames that they name.
void readConstraints(const YamlReader& list, Problem& problem);

}  // namespace leeway::planner
