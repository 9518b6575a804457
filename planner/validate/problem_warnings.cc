// Warnings about a problem, whether it was loaded or made by a program.

#include <algorithm>

#include "planner/validate/checks.h"
#include "robots/mesh/mesh_treatment.h"

namespace leeway::planner {

std::string openMeshes(const Problem& problem) {
  const std::vector<std::string>& of_robot = problem.robot.model->warnings;
  robots::OpenMeshes open;
  const auto add = [&](const std::string& owner, const std::vector<robots::Geometry>& of) {
    const auto namesIt = [&](const std::string& warning) {
      return warning.find("not closed: ") != std::string::npos &&
             (warning.find(": " + owner + " (") != std::string::npos ||
              warning.find(", " + owner + " (") != std::string::npos);
    };
    if (std::none_of(of_robot.begin(), of_robot.end(), namesIt) &&
        std::none_of(problem.warnings.begin(), problem.warnings.end(), namesIt))
      open.add(owner, of);
  };
  for (const robots::Link& link : problem.robot.model->links) add(link.name, link.geometries);
  for (const Object& object : problem.world.objects) add(object.name, object.geometries);
  for (const Attachment& held : problem.robot.attachments)
    add(held.object.name, held.object.geometries);
  for (const DeformingObstacle& o : problem.world.deforming)
    add(o.object.name, o.object.geometries);
  return open.text();
}

std::vector<std::string> problemWarnings(const Problem& problem) {
  std::vector<std::string> warnings = problem.robot.model->warnings;
  warnings.insert(warnings.end(), problem.warnings.begin(), problem.warnings.end());
  for (std::size_t v = 0; v < problem.start.size(); ++v) {
    const auto off = passiveWarning(problem, static_cast<int>(v));
    const auto is_it = [&](const std::string& w) { return w.ends_with(*off); };  // with its line
    if (off && std::none_of(warnings.begin(), warnings.end(), is_it))
      warnings.push_back("start has " + *off);
  }
  if (std::string open = openMeshes(problem); !open.empty()) warnings.push_back(std::move(open));
  return warnings;
}

}  // namespace leeway::planner
