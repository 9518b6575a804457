#pragma once

#include <optional>
#include <span>
#include <string>

#include "leeway/robots/model.h"
#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

// An entry of an SRDF that is wrong is left out: it gets a warning, and an error that does not end
// the reading where errors are gathered. Groups, group states and virtual joints, which users name,
// are in the model's left_out, too.

/// The joint between world and root link that an SRDF asks for.
struct VirtualJoint {
  std::string name;
  JointType type = JointType::kFixed;
};

/// The virtual joint of the root link, if the SRDF has one. `joints`: the names of the URDF's.
std::optional<VirtualJoint> readVirtualJoint(XmlFile& srdf, const std::string& root_link,
                                             std::span<const std::string> joints,
                                             RobotDescription& model);

/// The parent_frame of the virtual joint in the SRDF that the robot was read from, which MoveIt
/// calls the world; empty: none. Reads the file again. Throws InputError, Stopped.
std::string parentFrame(const RobotDescription& robot, const Stop& stop);

/// Adds groups, group states, disabled pairs and the file's warnings to a model whose links, joints
/// and variables are complete. Throws InputError for a file that is no SRDF.
void readSrdf(XmlFile& srdf, RobotDescription& model);

}  // namespace leeway::robots
