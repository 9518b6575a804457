#pragma once

#include <optional>
#include <string>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// The joint between world and root link that an SRDF asks for.
struct VirtualJoint {
  std::string name;
  std::string child_link;
  JointType type = JointType::kFixed;
  int line = 0;
};

/// The SRDF's virtual joint: nothing when it has none. Throws InputError, and Stopped while
/// xacro is at work; does not look at links.
std::optional<VirtualJoint> readVirtualJoint(const std::string& srdf_path,
                                             const LoadOptions& options);

/// Adds groups, group states and disabled pairs to a model whose links, joints and variables are
/// complete. Throws InputError.
void readSrdf(const std::string& srdf_path, RobotDescription& model, const LoadOptions& options);

}  // namespace leeway::robots
