#pragma once

#include <vector>

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// Reads `frames:`, names of frames fixed to links. Call it after reading the objects, because
/// frames must not have their names.
void readFrames(const YamlReader& reader, Problem& problem);

/// Whether a state's map gives poses: it has `pose` or `poses`, and no joint of the robot has that
/// name, or the map of a group inside it has.
bool givesPoses(const YamlReader& map, const robots::Model& model);

/// Reads the poses of such a map without looking up their names.
std::vector<FramePose> readFramePoses(const YamlReader& map, const robots::Model& model,
                                      std::vector<std::string>& warnings);

/// The same with poseRegion() of each pose. Errors have file and line.
std::vector<robots::PoseRegion> readPoseRegions(const YamlReader& map, Problem& problem);

/// Reads `constraints:`. Call it after reading the objects and frames that they name.
void readConstraints(const YamlReader& list, Problem& problem);

}  // namespace leeway::planner
