#pragma once

// Private to the layers above: the visual shapes of a robot, for pictures. Planning never uses
// them.

#include <optional>
#include <string>
#include <vector>

#include "leeway/collision/shape.h"
#include "leeway/robots/model.h"
#include "robots/mesh/mesh_import.h"

namespace leeway::robots {

/// A visual shape: a <visual> of a URDF link, or a geom that MuJoCo draws.
struct VisualShape {
  int link = -1;                          ///< of the model
  Pose X_LV;                              ///< places it on the link
  std::optional<collision::Shape> shape;  ///< nothing: `mesh` has it
  IndexedMesh mesh;
};

struct VisualShapes {
  std::vector<VisualShape> shapes;    ///< in the order of the file
  std::vector<std::string> left_out;  ///< why one cannot be read, or why there is none
};

/// Reads the visual shapes from the file that a robot was read from, with all formats of meshes
/// that loadMesh() reads. A shape that cannot be read, and one of a link that the model does not
/// have, is left out; so is everything if the model has no file. Throws InputError for a file that
/// is no longer there or cannot be read any more, and Stopped. O(vertices).
VisualShapes loadVisualShapes(const RobotDescription& robot, const Stop& stop = {});

}  // namespace leeway::robots
