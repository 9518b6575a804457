#include "robots/load/visual_shapes.h"

#include "leeway/robots/input_error.h"
#include "robots/load/fit_primitive.h"
#include "robots/load/read_document.h"
#include "robots/mesh/mesh_path.h"
#include "robots/urdf/urdf_document.h"
#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

VisualShapes loadVisualShapes(const RobotDescription& robot, const Stop& stop) {
  VisualShapes result;
  if (robot.urdf_file.empty()) {
    result.left_out.push_back("robot '" + robot.name +
                              "' was not read from a file, and has no visual shapes");
    return result;
  }
  LoadOptions options;
  for (const auto& [name, folder] : robot.read_with.packages)
    options.packages.emplace_back(name, robot.placeOf(folder));
  options.xacro = robot.read_with.xacro;
  options.visual_as_collision = robot.read_with.visual_as_collision;
  options.kinematics_only = true;  // a collision mesh that is missing does not matter here
  options.stop = stop;
  XmlFile file(robot.placeOf(robot.urdf_file), "URDF", options);
  const UrdfDocument document = readDocument(file, options, true);
  result.left_out = document.unread_visuals;
  for (const UrdfLink& link : document.links) {
    const int number = robot.findLink(link.name);
    for (const UrdfCollision& visual : link.visuals) {
      throwIfStopped(stop, "visual shapes were read");
      try {
        if (number < 0)
          throw InputError(visual.file, visual.line,
                           "the robot was read before it had link " + inQuotes(link.name));
        VisualShape shape{number, visual.X_LG, {}, {}};
        const auto meshOf = [&](const Eigen::Vector3d& scale) {
          const std::string from =
              robot.placeOf(visual.mesh_from.empty() ? robot.urdf_file : visual.mesh_from);
          return importTriangles(resolveMesh(visual.mesh_file, from, visual.line, options), scale,
                                 visual.file, visual.line, stop);
        };
        if (visual.kind == UrdfCollision::Kind::kMesh) {
          shape.mesh = meshOf(visual.mesh_scale);
        } else {
          const UrdfCollision primitive =
              visual.fit ? fittedPrimitive(visual, meshOf(Eigen::Vector3d::Ones())) : visual;
          shape.shape = primitiveOf(primitive);
          shape.X_LV = primitive.X_LG;
        }
        result.shapes.push_back(std::move(shape));
      } catch (const InputError& error) {
        result.left_out.emplace_back(error.what());
      }
    }
  }
  if (result.shapes.empty() && result.left_out.empty())
    result.left_out.push_back(robot.urdf_file + ": the robot has no visual shapes");
  return result;
}

}  // namespace leeway::robots
